"""Draws random faults of the kind of typing errors from all lines of code.

A fault is one change on one line: a sign, an operator, a comparison, a constant by one per cent (an
integer by one), a removed statement, an index. First a line is drawn, with equal probability, then
one of its faults, so that long lines are not favoured. Strings, comments, preprocessor lines,
declarations of types and assertions (which a release does not compile) have no faults. A fault that
does not compile is skipped.
"""
import dataclasses
import pathlib
import random
import re
import subprocess

FOLDERS = ["src", "formulations"]
SUFFIXES = {".cpp", ".hpp"}


@dataclasses.dataclass(frozen=True)
class Fault:
    file: str
    line: int  # counted from 1
    kind: str
    old: str  # the original line
    new: str  # the line with the fault

    @property
    def key(self):
        """Identifies a fault independently of its line number."""
        return f"{self.file}\n-{self.old.strip()}\n+{self.new.strip()}"


# Text other than code is replaced by blanks, so that positions do not change.
HIDDEN = re.compile(
    r'R"(?P<tag>\w*)\(.*?\)(?P=tag)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])\'|^[ \t]*\#[^\n]*(?:\\\n[^\n]*)*',
    re.S | re.M)
TOKEN = re.compile(
    r"(?P<number>(?:0[xX][0-9a-fA-F.']+(?:[pP][-+]?\d+)?|\d[\d']*\.?\d*(?:[eE][-+]?\d+)?)[fFlLuU]*)"
    r"|(?P<word>[A-Za-z_]\w*)|(?P<sign><<=|>>=|<=>|\+\+|--|->|&&|\|\||[-+*/%&|^<>=!]=|<<|>>|::|\S)")
NO_FAULTS = re.compile(r"^\s*(static_assert|assert|using|namespace|template|friend|public:|private:|protected:|typedef|enum|"
                       r"\[\[noreturn\]\]|class|struct|extern)\b")
STATEMENT = re.compile(r"^\s*(?:if \(.*\) |else |for \(.*\) )?[A-Za-z_(*+-].*;\s*$")
NOT_REMOVED = re.compile(r"^\s*(return|break|continue|case|default|throw|goto|else|do|delete|using|const|constexpr|static|auto|"
                         r"virtual|template|struct|class|enum|operator|explicit|inline|mutable)\b")
DECLARATION = re.compile(r"^\s*[A-Za-z_][\w:]*(<[^;=]*>)?(::\w+)*[&* ]+[A-Za-z_]\w*\s*([=;{(,\[].*)?;$")
OTHER = {"&&": "||", "||": "&&", "*": "/", "/": "*", "*=": "/=", "/=": "*=", "%": "/", "|=": "&=", "&=": "|="}
WORDS = {"max": "min", "min": "max", "true": "false", "false": "true", "sin": "cos", "cos": "sin", "floor": "ceil", "ceil": "floor",
         "any_of": "all_of", "all_of": "any_of"}
COMPARED = {"<": ["<=", ">"], "<=": ["<", ">="], ">": [">=", "<"], ">=": [">", "<="], "==": ["!="], "!=": ["=="]}


def code_of(text):
    """The text with everything except code replaced by blanks."""
    return HIDDEN.sub(lambda m: re.sub(r"[^\n]", lambda c: '"' if m[0][0] in "\"'R" else " ", m[0]), text)


def constant(text):
    digits = text.rstrip("fFlLuU")
    suffix, plain = text[len(digits):], digits.replace("'", "")
    if plain[:2] in ("0x", "0X"):
        return hex(int(plain, 16) + 1) + suffix if re.fullmatch(r"0[xX][0-9a-fA-F]+", plain) else None
    if re.fullmatch(r"\d+", plain):
        return str(int(plain) + 1) + suffix
    changed = repr(float(plain) * 1.01)
    return changed + suffix if float(plain) != 0 else "0.01" + suffix


def on_line(code, line):
    """(kind, new line) of all faults of one line. `code`: the line with only its code."""
    def swap(start, end, text):
        return line[:start] + text + line[end:]

    tokens = [(m.lastgroup, m[0], m.start(), m.end()) for m in TOKEN.finditer(code)]
    for i, (group, text, start, end) in enumerate(tokens):
        before, after = code[start - 1:start], code[end:end + 1]
        spaced = before == " " and after == " "
        previous = tokens[i - 1] if i else None
        operand = previous is not None and (previous[0] != "sign" or previous[1] in ")]\"")
        if group == "number":
            if (new := constant(text)) is not None and not (previous and previous[1] in "<"):
                yield "constant", swap(start, end, new)
        elif group == "word":
            if text in WORDS:
                yield "operator", swap(start, end, WORDS[text])
        elif text in "+-" and (spaced and operand or not operand and not after.isspace()):
            if spaced and operand:
                yield "sign", swap(start, end, "-" if text == "+" else "+")
            elif text == "-":
                yield "sign", swap(start, end, "")
        elif text in ("+=", "-="):
            yield "sign", swap(start, end, "-=" if text == "+=" else "+=")
        elif text in OTHER and spaced and operand:
            yield "operator", swap(start, end, OTHER[text])
        elif text == "!" and not after.isspace():
            yield "operator", swap(start, end, "")
        elif text in COMPARED and spaced and operand and "operator" not in code[:start]:
            for new in COMPARED[text]:
                yield "comparison", swap(start, end, new)
        elif text == "[" and operand and previous[1] not in ("operator", "delete"):
            depth = 0
            for _, inner, at, _ in tokens[i:]:
                depth += (inner == "[") - (inner == "]")
                if depth == 0:
                    if line[end:at].strip():
                        for by in (" + 1", " - 1"):
                            yield "index", swap(end, at, line[end:at] + by)
                    break


def removed(codes, lines, n):
    """The line without its statement; None if the line is not a statement."""
    code = codes[n].rstrip()
    if not STATEMENT.match(code) or NOT_REMOVED.match(code) or DECLARATION.match(code) or code.count("(") != code.count(")"):
        return None
    before = next((c.rstrip() for c in reversed(codes[:n]) if c.strip()), "")
    if before and before[-1] not in ";{})" and not before.endswith("else"):
        return None  # continuation of a statement that began above
    indent = re.match(r"\s*(?:if \(.*?\) (?=\S+;)|else )?", code)[0]
    return indent.rstrip(" ") + ";" if not indent.strip() else indent + ";"


def order(root, seed):
    """A fault for each line of code, in the random order of the seed."""
    files = subprocess.run(["git", "ls-files", "-z", *FOLDERS], cwd=root, capture_output=True, text=True, check=True).stdout
    faults = []
    for name in sorted(f for f in files.split("\0") if pathlib.Path(f).suffix in SUFFIXES):
        path = pathlib.Path(root) / name
        if not path.exists():
            continue
        text = path.read_text()
        lines, codes = text.split("\n"), code_of(text).split("\n")
        for n, (code, line) in enumerate(zip(codes, lines)):
            if not code.strip() or NO_FAULTS.match(code):
                continue
            found = [Fault(name, n + 1, kind, line, new) for kind, new in on_line(code, line)]
            if (short := removed(codes, lines, n)) is not None:
                found.append(Fault(name, n + 1, "removed statement", line, short))
            if found:
                faults.append(found)
    draw = random.Random(seed)
    draw.shuffle(faults)
    for found in faults:
        kinds = sorted({f.kind for f in found})  # each kind has equal probability
        kind = draw.choice(kinds)
        yield draw.choice([f for f in found if f.kind == kind])
