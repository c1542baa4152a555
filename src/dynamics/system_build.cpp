// Construction of a System from a Mechanism: the pattern of the rows, and which entries are
// constant.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "dynamics/argument.hpp"
#include "dynamics/builder.hpp"
#include "dynamics/elements.hpp"
#include "dynamics/point_bodies.hpp"

namespace freeplay {

Link Builder::link(const std::array<int, 2>& between, const std::array<Vec2, 2>& at) {
  for (const int end : {0, 1})
    if (between[end] != ground) s_.longest_arm_ = std::max(s_.longest_arm_, at[end].norm());
  return free_link(between, at);
}

double Builder::span() const {
  const auto& m = mechanism_;
  const auto position = [&](int body) {
    return body == ground ? Vec2{0, 0}
                          : m.bodies[static_cast<std::size_t>(body)].position.value_or(Vec2{0, 0});
  };
  double most = 0;
  const auto consider = [&](const auto& elements) {
    for (const auto& element : elements)
      std::visit(
          [&](const auto& e) {
            using Element = std::decay_t<decltype(e)>;
            Vec2 apart{0, 0};
            if constexpr (requires { e.between; }) apart = position(e.between[1]) - position(e.between[0]);
            if constexpr (requires { apart += e.at[1] - e.at[0]; }) apart += e.at[1] - e.at[0];
            // A place along a plane is no length of the motion.
            if constexpr (std::is_same_v<Element, PlaneContact>)
              most = std::max(most, std::abs(e.axis.x() * apart.y() - e.axis.y() * apart.x()));
            else
              most = std::max(most, apart.norm());
          },
          element);
  };
  consider(m.joints);
  consider(m.contacts);
  consider(m.loads);
  if (most > 0) return most;
  for (const auto& b : m.bodies) most = std::max(most, std::sqrt(b.inertia / b.mass));
  return most > 0 ? most : 1;
}

int Builder::entry(int column, double constant) {
  s_.rows_.pattern.column.push_back(column);
  s_.rows_.constants.push_back(constant);
  return static_cast<int>(s_.rows_.constants.size()) - 1;
}

void Builder::end_row(const std::string& name, bool angle) {
  s_.rows_.pattern.end_row();
  s_.rows_.names.push_back(name);
  s_.rows_.angles.push_back(angle);
}

void Builder::points(const Link& link, const std::string& name) {
  PointRows rows{link, s_.rows_.pattern.rows};
  for (const int axis : {0, 1}) {
    if (link.i != ground) {
      entry(3 * link.i + axis, -1);
      if (!link.si.is_zero()) rows.theta_i[axis] = entry(3 * link.i + 2, 0);
    }
    if (link.j != ground) {
      entry(3 * link.j + axis, 1);
      if (!link.sj.is_zero()) rows.theta_j[axis] = entry(3 * link.j + 2, 0);
    }
    end_row(name, false);
  }
  std::get<std::vector<PointRows>>(s_.rows_.kinds).push_back(rows);
}

void Builder::slide(const Link& link, const Vec2& axis, const std::string& name) {
  // Between the ground and a body the normal is constant: zero entries are omitted.
  SlideRow slide{link, axis, s_.rows_.pattern.rows, link.i != ground || axis.y() != 0,
                 link.i != ground || axis.x() != 0};
  slide.first = static_cast<int>(s_.rows_.constants.size());
  for (const int b : {link.i, link.j}) {
    if (b == ground) continue;
    if (b == link.i || slide.x) entry(3 * b, 0);
    if (b == link.i || slide.y) entry(3 * b + 1, 0);
    if (b == link.i || !link.sj.is_zero()) entry(3 * b + 2, 0);
  }
  slide.last = static_cast<int>(s_.rows_.constants.size());
  end_row(name, false);
  std::get<std::vector<SlideRow>>(s_.rows_.kinds).push_back(slide);
}

void Builder::distance(const Link& link, double length, const std::string& name) {
  s_.rows_.rare = true;
  DistanceRow row{link, length, s_.rows_.pattern.rows};
  const int bodies[] = {link.i, link.j};
  const Vec2 arms[] = {link.si, link.sj};
  for (std::size_t k = 0; k < 2; ++k) {
    if (bodies[k] == ground) continue;
    row.first[k] = entry(3 * bodies[k], 0);
    entry(3 * bodies[k] + 1, 0);
    if (!arms[k].is_zero()) row.theta[k] = entry(3 * bodies[k] + 2, 0);
  }
  std::get<std::vector<DistanceRow>>(s_.rows_.kinds).push_back(row);
  end_row(name, false);
}

void Builder::reduced_beam(const BeamChord& beam, const std::vector<double>& weights, int modes,
                           const std::string& name) {
  s_.rows_.rare = true;
  const ReducedBeamRows rows{beam, s_.rows_.pattern.rows, static_cast<int>(s_.rows_.constants.size()), modes,
                             weights};
  const auto entries = [&](int body, int coordinates) {
    for (int c = 0; body != ground && c < coordinates; ++c) entry(3 * body + c, 0);
  };
  const auto ends = [&] { entries(beam.link.i, 3), entries(beam.link.j, 3); };
  for (int k = 0; k < beam.pieces; ++k) {
    ends();
    entries(beam.first + k, 2);
    end_row(name, false);
  }
  for (int k = 0; k < rows.transverse() + beam.pieces; ++k) {
    const int turned = k - rows.transverse();
    ends();
    for (int p = 0; p < beam.pieces; ++p) entries(beam.first + p, 2);
    if (turned >= 0) entry(3 * (beam.first + turned) + 2, 1);
    end_row(name, turned >= 0);
  }
  std::get<std::vector<ReducedBeamRows>>(s_.rows_.kinds).push_back(rows);
}

void Builder::turn_entries(const Link& link) {
  if (link.i != ground) entry(3 * link.i + 2, -1);
  if (link.j != ground) entry(3 * link.j + 2, 1);
}

void Builder::angle(const Link& link, double angle, const std::string& name) {
  std::get<std::vector<AngleRow>>(s_.rows_.kinds).push_back({link, s_.rows_.pattern.rows, angle});
  turn_entries(link);
  end_row(name, true);
}

void Builder::prescribed(const Link& link, double angle, double speed, const std::string& name) {
  auto& drives = std::get<std::vector<SpeedRow>>(s_.rows_.kinds);
  drives.push_back({link, s_.rows_.pattern.rows, angle, speed});
  turn_entries(link);
  end_row(name, true);
}

MotionRow Builder::motion_row(const Link& link, const Piecewise& course, const Vec2* axis, int of) {
  s_.rows_.rare = true;
  MotionRow m{link, s_.rows_.pattern.rows, s_.motion_rows(), course};
  const auto turn = [&](int body) {
    const double none = 0;
    if (body == ground) return -1;
    if (body == link.i) {
      if (m.of_i[2] < 0) m.of_i[2] = entry(3 * body + 2, none);
      return m.of_i[2];
    }
    if (body == link.j) {
      if (m.of_j[2] < 0) m.of_j[2] = entry(3 * body + 2, none);
      return m.of_j[2];
    }
    return entry(3 * body + 2, none);
  };
  if (axis) {
    m.slides = true;
    m.axis = *axis;
    // Between the ground and a body the axis is constant: zero entries are omitted.
    const bool still = link.i == ground;
    for (const int c : {0, 1}) {
      if (!still) m.of_i[c] = entry(3 * link.i + c, 0);
      if (link.j != ground && (!still || (c == 0 ? axis->x() : axis->y()) != 0))
        m.of_j[c] = entry(3 * link.j + c, 0);
    }
    if (!still) turn(link.i);
    if (!still || !link.sj.is_zero()) turn(link.j);
  } else {
    turn(link.i);
    turn(link.j);
  }
  if (of >= 0) {
    m.follows = true;
    m.other = joint_link(of);
    m.other_i = turn(m.other.i);
    m.other_j = turn(m.other.j);
  }
  return m;
}

void Builder::ratio(const Link& link, double ratio, double offset, const Vec2* axis, int of,
                    const std::string& name) {
  Piecewise::Stretch line;
  line.c[0] = offset;
  line.c[1] = ratio;
  if (axis) reach(std::abs(ratio));  // the radius of a pinion may be the only length of the mechanism
  std::get<std::vector<RatioRow>>(s_.rows_.kinds).push_back({motion_row(link, Piecewise({line}), axis, of)});
  end_row(name, !axis);
}

void Builder::motion(const Link& link, const Piecewise& course, const Vec2* axis, int of,
                     const std::string& name) {
  auto m = motion_row(link, course, axis, of);
  if (m.follows) {
    if (axis) reach(course.greatest().value);  // a lift may be the only length of the mechanism
    // No step passes a knot: a narrow rise is between two of them.
    if (auto knots = course.knots(); !knots.empty()) {
      m.phase = s_.phases();
      s_.curves_.phases.push_back(
          {m.other, std::move(knots), course.period(), Phase::Of::angle, {1, 0}, true});
    }
  }
  const auto x = m.follows ? Argument::angle : Argument::time;
  if (auto reader = reader_of(name, course, x, m.follows ? m.other : link))
    s_.curves_.readers.push_back(std::move(*reader));
  std::get<std::vector<MotionRow>>(s_.rows_.kinds).push_back(m);
  end_row(name, !axis);
}

ContactFacts Builder::facts(const std::string& name, const std::array<int, 2>& between, int surface) const {
  ContactFacts facts;
  facts.name = name;
  facts.bodies = between;
  facts.surface = mechanism_.surfaces[surface];
  return facts;
}

void Builder::pair(const Pair& pair, const ContactFacts& facts) {
  s_.pairs_.push_back(pair);
  s_.contact_facts_.push_back(facts);
}

void Builder::profiled(const Link& link, const OutOfRound& surfaces, ContactFacts facts) {
  // No step passes a wave, or the angle of 0.02 rad if points are closer.
  const double wave = std::min(surfaces.bearing.narrowest(), surfaces.journal.narrowest());
  limit_turn(std::max(0.5 * wave, 0.02));
  facts.out_of_round = true;
  const auto name = facts.name;
  const auto shared = std::make_shared<const OutOfRound>(surfaces);
  for (std::size_t k = 0; k < surfaces.arcs.size(); ++k) {
    if (surfaces.arcs.size() > 1) facts.name = fmt::format("{}.{}", name, k + 1);
    pair(ProfilePair{link, facts.clearance, facts.radius_bearing, shared, surfaces.arcs[k]}, facts);
  }
}

void Builder::friction(const FrictionRow& row, FrictionFacts facts) {
  if (facts.reaction) s_.reactive_.push_back(s_.frictions());
  s_.slidings_.push_back(row);
  s_.friction_facts_.push_back(std::move(facts));
}

ReactionBound Builder::mesh_bound(double along, double against) const {
  ReactionBound bound;
  bound.of = ReactionBound::Of::mesh;
  bound.row = s_.rows_.pattern.rows - 1;
  bound.friction = 1;
  bound.ways = {along, against};
  return bound;
}

double Builder::gyration(const Link& link) const {
  double mass = 0, inertia = 0;  // reciprocals
  for (const int body : {link.i, link.j})
    if (body != ground) {
      const auto& b = mechanism_.bodies[static_cast<std::size_t>(body)];
      mass += 1 / b.mass;
      inertia += 1 / b.inertia;
    }
  return std::sqrt(mass / inertia);
}

ReactionBound Builder::reaction_bound(int joint) const {
  ReactionBound bound;
  for (const auto& r : s_.report_.reactions)
    if (r.element == joint) bound.row = r.begin;
  bound.element = joint;
  if (std::holds_alternative<RevoluteJoint>(mechanism_.joints[joint])) bound.of = ReactionBound::Of::pin;
  return bound;
}

/// Adds a joint, contact, reduced beam, drive or load: its rows, and the numbers it adds to the solver.
template <class Element>
void System::add(Builder& builder, const Element& element, const Dynamics<Element>& dynamics, int joint) {
  const int rows = rows_.pattern.rows, contacts = this->contacts(), frictions = this->frictions();
  if constexpr (requires { dynamics.build(builder); }) dynamics.build(builder);
  Carried carried{element.name, word_of<Element>(), rows_.pattern.rows - rows, this->contacts() - contacts,
                  this->frictions() - frictions};
  if constexpr (requires { element.between, element.at; }) {
    if (carried.rows > 0 && joint >= 0)  // an ideal joint
      report_.reactions.push_back(
          {builder.free_link(element.between, element.at), rows, rows_.pattern.rows, joint});
  }
  if constexpr (Acts<Element>) carried.force = true;
  if constexpr (requires { dynamics.has_state(); }) carried.states = dynamics.has_state();
  if constexpr (requires { dynamics.states(); }) carried.states = dynamics.states();
  contact_joints_.resize(pairs_.size(), joint);
  carried_.push_back(std::move(carried));
}

template <class Element>
void System::place_load(Builder& builder, const Element& element) {
  const Dynamics<Element> dynamics{element};
  if constexpr (requires { dynamics.build(builder), Element::reports; }) {
    if constexpr (Element::reports == ForceElement::Kind::drive)
      report_.reactions.push_back({dynamics.link(builder), rows_.pattern.rows, rows_.pattern.rows + 1, -1});
  }
  add(builder, element, dynamics, -1);
  if constexpr (Acts<Element>) {
    Placed<Element> placed{dynamics, dynamics.link(builder), -1, -1};
    auto& facts = placed.facts;
    if constexpr (requires { facts.prepare(builder.mechanism()); }) facts.prepare(builder.mechanism());
    if constexpr (requires { facts.read.link; })
      if (facts.read.of >= 0) facts.read.link = builder.joint_link(facts.read.of);
    acts_ = true;
    loads_work_ |= facts.does_work();
    if constexpr (requires { facts.needs_velocity(); }) velocity_forces_ |= facts.needs_velocity();
    if constexpr (requires { facts.has_state(); })
      if (facts.has_state()) {
        placed.state = states();
        state_scales_.push_back(facts.state_scale());
        if constexpr (requires { facts.needs_velocity(); }) velocity_flows_ = true;
      }
    if constexpr (requires { facts.states(); })
      if (facts.states() > 0) {
        placed.state = states();
        for (int k = 0; k < facts.states(); ++k) state_scales_.push_back(facts.state_scale(k));
        velocity_flows_ |= facts.needs_velocity();
      }
    if constexpr (requires { facts.sampled(); })
      if (facts.sampled() && sampled_.empty()) sampled_ = facts.name;
    if constexpr (requires { facts.limiters(); }) limiters_ += facts.limiters();
    const auto hold = [&](Phase phase) {
      placed.phase = phases();
      if (!phase.speed) (phase.swept ? curves_.sweeps : curves_.spring_kinks) = true;
      curves_.phases.push_back(std::move(phase));
    };
    if constexpr (requires { facts.angle_kinks(); })
      if (auto kinks = facts.angle_kinks(); !kinks.empty())
        hold({placed.link, std::move(kinks), Phase::turn, Phase::Of::angle, {1, 0}, true});
    if constexpr (requires { facts.kinks(); })
      if (auto kinks = facts.kinks(); !kinks.empty())
        hold({placed.link, std::move(kinks), 0, Dynamics<Element>::kinks_of});
    if constexpr (requires { facts.phase(placed.link); })
      if (auto phase = facts.phase(placed.link)) hold(std::move(*phase));
    if constexpr (requires { facts.reader(placed.link); })
      if (auto reader = facts.reader(placed.link)) curves_.readers.push_back(std::move(*reader));
    if constexpr (requires { facts.bump; }) {
      Phase phase{placed.link, {}};
      for (const auto& limit : {facts.bump.lower, facts.bump.upper})
        if (limit) phase.kinks.push_back(*limit);
      if constexpr (requires { facts.axis; }) {
        phase.of = Phase::Of::travel;
        phase.axis = facts.axis;
        // The limits may be the only lengths of the mechanism.
        for (const double limit : phase.kinks) builder.reach(std::abs(limit));
      }
      hold(std::move(phase));
    }
    std::get<std::vector<Placed<Element>>>(placed_->lists).push_back(placed);
  }
}

System::System(const Mechanism& m) : placed_(std::make_shared<PlacedElements>()), gravity_(m.gravity) {
  check_point_bodies(m);
  rows_.pattern.columns = elastic_.pattern.columns = 3 * static_cast<int>(m.bodies.size());
  for (const auto& b : m.bodies) {
    // The angle of a point body is fixed: the value in place of its inertia has no effect.
    mass_.insert(mass_.end(), {b.mass, b.mass, b.point ? b.mass : b.inertia});
    constant_force_.insert(constant_force_.end(), {b.mass * gravity_.x(), b.mass * gravity_.y(), 0.0});
  }
  Builder builder(*this, m);
  const auto each = [](const auto& elements, auto f) {
    for (std::size_t i = 0; i < elements.size(); ++i)
      std::visit([&](const auto& element) { f(element, static_cast<int>(i)); }, elements[i]);
  };
  for (int b = 0; b < bodies(); ++b)
    if (m.bodies[static_cast<std::size_t>(b)].point) {
      builder.angle({ground, b}, 0, m.bodies[static_cast<std::size_t>(b)].name);
      ++points_;
    }
  each(m.joints, [&](const auto& joint, int j) {
    add(builder, joint, Dynamics<std::decay_t<decltype(joint)>>{joint}, j);
  });
  // All arms are found before walls use them as scales, so that the order of contacts does not
  // matter.
  each(m.contacts, [&](const auto& contact, int) {
    if constexpr (requires { contact.at; }) builder.link(contact.between, contact.at);
    const Dynamics<std::decay_t<decltype(contact)>> dynamics{contact};
    if constexpr (requires { dynamics.reserve(builder); }) dynamics.reserve(builder);
  });
  each(m.contacts, [&](const auto& contact, int) {
    add(builder, contact, Dynamics<std::decay_t<decltype(contact)>>{contact}, -1);
  });
  add_groups(builder, m);
  for (const auto& beam : m.beams)
    if (beam.is_reduced()) place_load(builder, beam);
  each(m.drives, [&](const auto& drive, int) { place_load(builder, drive); });
  if (const int joint = crank_joint(m); joint >= 0) crank_ = builder.joint_link(joint);
  each(m.loads, [&](const auto& load, int) { place_load(builder, load); });
  // In the order of elastic_rows().
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.stiffness(); })
      for (const double k : x.facts.stiffness()) {
        elastic_.stiffness.push_back(k);
        elastic_.damping.push_back(x.facts.damping);
        for (const auto& [body, coordinates] : x.facts.strain_columns())
          for (int c = 0; body != ground && c < coordinates; ++c)
            elastic_.pattern.column.push_back(3 * body + c);
        elastic_.pattern.end_row();
      }
  });
  add_families();
  list_elements(m);
  size_ = longest_arm_;
  if (!(size_ > 0)) {
    for (int k = 0; k < contacts(); ++k) size_ = std::max(size_, contact_facts(k).radius);
    for (const auto& family : families_) size_ = std::max(size_, family.facts.radius);
  }
  if (!(size_ > 0)) size_ = builder.span();
}

/// Pairs of small groups become contacts; those of other groups become families.
void System::add_groups(Builder& builder, const Mechanism& m) {
  std::vector<std::string> bodies;
  for (const auto& group : m.groups) {
    auto families = families_of(m, group, longest_arm_);
    if (families.empty()) continue;
    Carried carried{group.name, "group"};
    if (found_near(group, families)) {
      carried.families = static_cast<int>(families.size());
      std::ranges::move(families, std::back_inserter(families_));
    } else {
      if (bodies.empty())
        for (const auto& b : m.bodies) bodies.push_back(b.name);
      const int before = contacts();
      for (const auto& family : families)
        family.each([&](int i, int j) {
          auto facts = family.facts;
          facts.name = pair_name(family.name, bodies, i, j);
          facts.bodies = {i, j};
          builder.pair(family.pair(i, j), facts);
        });
      carried.contacts = contacts() - before;
    }
    contact_joints_.resize(pairs_.size(), -1);
    carried_.push_back(std::move(carried));
  }
}

void System::add_families() {
  for (const auto& family : families_) {
    contact_facts_.push_back(family.facts);
    contact_joints_.push_back(-1);
  }
}

template <class T>
EvaluationOf<T> System::make_evaluation() const {
  EvaluationOf<T> e;
  e.cosine.assign(bodies(), 1);
  e.sine.assign(bodies(), 0);
  e.phi.assign(rows(), 0);
  e.phi_t.assign(rows(), 0);
  e.gamma.assign(rows(), 0);
  e.bend.assign(motion_rows(), 0);
  for (const auto& d : std::get<std::vector<SpeedRow>>(rows_.kinds)) e.phi_t[d.row] = -d.speed;
  e.G.assign(rows_.constants.begin(), rows_.constants.end());
  e.force.assign(constant_force_.begin(), constant_force_.end());
  return e;
}
template Evaluation System::make_evaluation() const;
template EvaluationOf<Traced> System::make_evaluation() const;

}  // namespace freeplay
