// Tables, notes, the list of events (a click moves the motion there), and the commands that
// reproduce the results.

function tableOf(head, rows, className) {
  const table = element('table', className), body = element('tbody');
  if (head.length) {
    const top = element('thead'), row = element('tr');
    for (const cell of head) row.append(element('th', '', cell));
    top.append(row);
    table.append(top);
  }
  for (const cells of rows) {
    const row = element('tr');
    for (const cell of cells) row.append(element('td', '', cell === null ? '–' : cell));
    body.append(row);
  }
  table.append(body);
  return table;
}

function card(title, ...parts) {
  const box = element('section', 'card');
  if (title) box.append(element('h2', '', title));
  box.append(...parts);
  return box;
}

function scrolled(table) {
  const box = element('div', 'scroll');
  box.tabIndex = 0;
  box.append(table);
  return box;
}

function makeNotes(section) {
  if (data.verdict) section.append(element('p', 'note', data.verdict));
  for (const note of data.notes || []) section.append(element('p', note.doubtful ? 'note doubtful' : 'note', note.text));
  section.hidden = !section.childElementCount;
}

/** Figures of the folder, which the page contains as PNG. */
function makePictures(section) {
  for (const { title, png } of data.pictures || []) {
    const picture = element('img', 'picture');
    picture.alt = title;
    picture.src = `data:image/png;base64,${png}`;
    section.append(card(title, picture));
  }
}

function makeTables(section) {
  if (data.comparison) {
    const box = card('Comparison');
    box.classList.add('wide');
    for (const part of data.comparison)
      box.append(part.text !== undefined ? element('p', 'said', part.text) : scrolled(tableOf(part.head, part.rows)));
    section.append(box);
  }
  for (const table of data.tables || []) {
    const box = card(table.title, scrolled(tableOf(table.head, table.rows)));
    box.classList.toggle('wide', !!table.wide);
    section.append(box);
  }
}

const eventRows = 500;  // per page of the list
function makeEvents(section) {
  if (!events.length) return;
  section.hidden = false;
  const title = element('h2', '', 'Events'), choice = element('select', 'controls'), note = element('p', 'small');
  choice.setAttribute('aria-label', 'which events');
  const kinds = [...new Set(runs.flatMap((run) => run.events.kinds))];
  for (const [value, text] of [['', 'all kinds'], ...kinds.map((k) => [k, k])]) {
    const option = element('option', '', text);
    option.value = value;
    choice.append(option);
  }
  const top = element('div', 'row'), body = element('tbody'), table = tableOf(['t, s', 'run', 'joint', 'kind', 'approach, m/s', 'impulse, N s', 'duration, s'], []);
  table.querySelector('tbody').replaceWith(body);
  top.append(title, choice);
  const cut = runs.map((run) => [run.name, run.events.t.length, run.events.all]).filter(([, kept, all]) => all > kept);
  section.append(top, scrolled(table), note);
  let at = 0, first = -1, listed = [];
  const fill = () => {
    const from = Math.max(0, Math.min(at - 20, listed.length - eventRows));
    body.replaceChildren();
    first = from;
    for (const event of listed.slice(from, from + eventRows)) {
      const e = runs[event.run].events, i = event.i, row = element('tr', 'click');
      for (const cell of [shown(event.t, 8), runs[event.run].name, e.joints[e.joint[i]], e.kinds[e.kind[i]], shown(e.v[i]), shown(e.p[i]), shown(e.d[i])])
        row.append(element('td', '', cell));
      row.tabIndex = -1;
      row.addEventListener('click', () => { play(false); seek(event.t); });
      event.row = row;
      body.append(row);
    }
    note.textContent = (listed.length > eventRows ? `Rows ${first + 1} to ${Math.min(first + eventRows, listed.length)} of ${listed.length.toLocaleString('en')}; the list follows the time cursor. ` : '') +
      cut.map(([name, kept, all]) => `${name}: the ${kept.toLocaleString('en')} strongest of ${all.toLocaleString('en')} events. `).join('');
  };
  const choose = () => {
    listed = events.filter((event) => !choice.value || runs[event.run].events.kinds[runs[event.run].events.kind[event.i]] === choice.value);
    listed.forEach((event) => { event.row = null; });
    fill();
  };
  choice.addEventListener('change', choose);
  choose();
  let marked = null;
  watch(() => {
    if (!listed.length) return;
    at = before(listed.map((event) => event.t), state.t + 1e-12);
    if (!state.playing && listed.length > eventRows && (at < first || at >= first + eventRows)) fill();
    const row = listed[at].t <= state.t + 1e-12 ? listed[at].row : null;
    if (marked) marked.classList.remove('now');
    marked = row;
    if (row) row.classList.add('now');
  });
}

function makeAgain(section) {
  section.append(element('h2', '', 'How to repeat'));
  if (data.commands) section.append(element('pre', '', data.commands.join('\n')));
  if (data.provenance) section.append(scrolled(tableOf(data.provenance.head, data.provenance.rows)));
  if (data.scene) {
    const details = element('details'), summary = element('summary', '', ['bifurcation', 'basin', 'continue'].includes(data.kind) ? 'study and scene, as read' : 'the scene, as read');
    details.append(summary, element('pre', '', data.scene));
    section.append(details);
  }
}
