"""Formulas of the theory, written in lines of Unicode, as MathML: fractions, roots, scripts, matrices."""

import re
from html import escape

SUB = dict(zip("₀₁₂₃₄₅₆₇₈₉ₑᵢ", "0123456789ei"))
SUP = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ᵀ", "0123456789−+T"))
NAMES = {"tr", "det", "adj", "dev", "exp", "max", "min"}
CLOSES = {"(": ")", "[": "]", "|": "|"}
TOKEN = re.compile(
    r"\s+|\+=|[⎡⎢⎣].*?[⎤⎥⎦]|\d+(?:\.\d+)?|d(?:[A-Z](?![a-z])|[xt]\b)|[A-Za-z]{2,}(?![₀-₉])|[½¼⅓]|[A-Za-zα-ωΑ-Ω]\u0304?|_(?:\w+|∞)|\^\{[^}]*\}|\^\S|[₀-₉ₑᵢ]+|[⁰¹²³⁴-⁹⁻⁺ᵀ]+|[′″']|."
)


class Unreadable(Exception):
    """A line that is no formula of this kind."""


def row(parts):
    return parts[0] if len(parts) == 1 else "<mrow>" + "".join(parts) + "</mrow>"


class Line:
    def __init__(self, text):
        self.tokens = TOKEN.findall(text)
        self.at = 0

    def peek(self):
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self):
        token = self.peek()
        if not token:
            raise Unreadable
        self.at += 1
        return token

    def skip(self):
        while self.peek().isspace():
            self.at += 1

    def until(self, end):
        """A sequence of operands, operators and words."""
        parts = []
        while self.peek() != end:
            token = self.peek()
            if token.isspace():
                self.at += 1
            elif re.fullmatch(r"[a-z]{2,}|[a-z]{2,}:|a", token) and token not in NAMES and self.is_word(token):
                parts.append(f"<mtext>&nbsp;{escape(self.take())}&nbsp;</mtext>")
            elif re.match(r"[\w½¼⅓α-ωΑ-Ω√(\[|∂∇Δ]", token):
                parts.append(self.fraction())
                if token in NAMES and self.peek().isspace():
                    parts.append('<mspace width="0.2em"/>')
            else:
                parts.append(f"<mo>{escape(self.take())}</mo>")
        self.at += bool(end)
        return parts

    def is_word(self, token):
        """An article is a word where one follows; letters with an index do not count."""
        following = self.tokens[self.at + 1 : self.at + 2]
        return (len(token) > 1 and not (following and following[0][0] in SUB)) or re.match(r"\s+[a-z]{2,}", "".join(self.tokens[self.at + 1 : self.at + 3]))

    def fraction(self):
        value = self.operand()
        while True:
            mark = self.at
            self.skip()
            if self.peek() != "/":
                self.at = mark
                return value
            self.take()
            self.skip()
            value = f"<mfrac>{bare(value)}{bare(self.operand())}</mfrac>"

    def operand(self):
        """Factors without a space or a sign between them: 2k₂, exp(x), ∂u."""
        parts = [self.scripted()]
        while re.match(r"[A-Za-zα-ωΑ-Ω(∇√]", self.peek()) and self.peek() != "":
            parts.append(self.scripted())
        return row(parts)

    def scripted(self):
        token = self.take()
        if token in "∂∇Δ":
            kind = 'mi mathvariant="normal"' if token == "Δ" else "mo"
            return row([f"<{kind}>{token}</{kind[:2]}>", self.scripted()])
        if token == "√":
            return f"<msqrt>{bare(self.scripted())}</msqrt>"
        if token in CLOSES:
            inner = self.until(CLOSES[token])
            base = row([f"<mo>{token}</mo>", *inner, f"<mo>{CLOSES[token]}</mo>"])
        elif token in "½¼⅓":
            return "<mfrac><mn>1</mn><mn>{}</mn></mfrac>".format("243"["½¼⅓".index(token)])
        elif token[0].isdigit():
            base = f"<mn>{token}</mn>"
        else:
            base = f"<mi>{escape(token)}</mi>"
        return self.scripts(base)

    def scripts(self, base):
        below, above = [], []
        while token := self.peek():
            if token[0] == "_" and len(token) > 1:
                below.append(f"<mi>{token[1:]}</mi>")
            elif token[0] in SUB:
                below.append("<mn>" + "".join(SUB[c] for c in token) + "</mn>")
            elif token[0] in SUP:
                above.append("<mi>" + "".join(SUP[c] for c in token) + "</mi>")
            elif token[0] == "^":
                above += Line(token[1:].strip("{}")).until("")
            elif token in "′″'":
                base = row([base, f'<mo lspace="0" rspace="0">{token.replace(chr(39), "′")}</mo>'])
            else:
                break
            self.at += 1
        if below and above:
            return f"<msubsup>{base}{row(below)}{row(above)}</msubsup>"
        if below or above:
            kind = "msub" if below else "msup"
            return f"<{kind}>{base}{row(below or above)}</{kind}>"
        return base


def bare(value):
    """A numerator, denominator or radicand loses the brackets that only kept it together in a line."""
    inner = re.fullmatch(r"<mrow><mo>\(</mo>(.*)<mo>\)</mo></mrow>", value)
    if not inner:
        return value
    depth = 0
    for mark in re.findall(r"<mo>([()])</mo>", inner[1]):
        depth += 1 if mark == "(" else -1
        if depth < 0:
            return value
    return f"<mrow>{inner[1]}</mrow>"


def cell(text):
    """A remark as text, all else as a formula."""
    words = [word for word in re.findall(r"\b[a-z]{2,}\b", text) if word not in NAMES]
    if text.startswith("[N/mm") or (words and not re.search(r"[=·√:∇]", text)):
        return f"<mtext>{escape(text)}</mtext>"
    return row(Line(text).until("") or ["<mrow></mrow>"])


def matrix(lines):
    inner = [re.search(r"[⎡⎢⎣](.*?)[⎤⎥⎦]", line)[1].strip() for line in lines]
    rows = "".join("<mtr>" + "".join(f"<mtd>{cell(c)}</mtd>" for c in re.split(r"\s{2,}", line)) + "</mtr>" for line in inner)
    before = "".join(re.split("[⎡⎢⎣]", line)[0].strip() for line in lines)
    after = "".join(re.split("[⎤⎥⎦]", line)[1].strip() for line in lines)
    return [row([*Line(before).until(""), f"<mo>[</mo><mtable>{rows}</mtable><mo>]</mo>"]), cell(after)]


def block(text):
    """The block in MathML, a table where its lines begin by short labels; None where a line cannot be read."""
    lines, rows, labels = [line.strip() for line in text.splitlines() if line.strip()], [], []
    try:
        while lines:
            if lines[0].startswith("⎡"):
                rows.append(matrix(lines[:3]))
                labels.append(lines[0])
                lines = lines[3:]
                continue
            cells = re.split(r"\s{2,}(?!\+?=)", lines.pop(0))
            rows.append([cell(c) for c in cells])
            labels.append(cells[0] if len(cells) > 1 else "")
    except (Unreadable, TypeError, IndexError):
        return None
    rows = [[f'<math displaystyle="true">{c}</math>' for c in cells] for cells in rows]
    if max(map(len, labels)) > 16:
        return '<div class="formula">' + "".join(f"<p>{' &emsp; '.join(cells)}</p>" for cells in rows) + "</div>"
    width = max(len(cells) for cells in rows)
    html = ""
    for cells in rows:
        spans = [1] * (len(cells) - 1) + [width - len(cells) + 1]
        html += "<tr>" + "".join(f'<td colspan="{n}">{c}</td>' for n, c in zip(spans, cells)) + "</tr>"
    return f'<div class="formula"><table>{html}</table></div>'


def inline(text):
    """Scripts of formulas in running text, outside code and targets of links."""
    parts = re.split(r"(`[^`]*`|\]\([^)]*\)|^\[.*?\]: .*$)", text, flags=re.M)
    subscript = r"(?<!\w)([A-Za-zα-ωΑ-Ω]\u0304?)_([A-Za-z]{1,6}|\d{1,2}|∞)(?![A-Za-z0-9_])"
    superscript = r"\^(?:\{([^}]*)\}|([A-Za-zα-ωℓ]|\d+(?:\.\d+)?|\(\d/\w\)))"
    raised = [re.sub(superscript, lambda m: f"<sup>{m[1] or m[2]}</sup>", part) for part in parts[::2]]
    parts[::2] = [re.sub(subscript, r"\1<sub>\2</sub>", part) for part in raised]
    return "".join(parts)
