"""The keys of a scene file, as Markdown, from the documented types of crates/rhexis-scene/src/schema."""

import re
from pathlib import Path

PLAIN = {
    "f64": "number", "u32": "whole number", "u64": "whole number", "usize": "whole number", "bool": "`true`, `false`", "String": "text",
    "PathBuf": "path of a file", "Point": "point `[x, y, z]`", "TimeCurve": "number, or curve over time", "TimePath": "path over time",
    "Interval": "number, or range `[from, to]`", "Strain": "strain", "Numbers": "number, or list", "Values": "values per triangle",
    "Angles": "angles", "ColumnSpec": "name, or number from 0",
}  # fmt: skip
# Short forms of values, and the type whose doc describes each.
SHORT = {"Point": "Point", "Range": "Interval", "Curve over time": "TimeCurve", "Path over time": "TimePath", "Strain": "Strain"}
SHORT |= {"Values per triangle": "Values", "Table of a file": "TableSpec", "Trembling hand": "HandSpec"}


class Type:
    def __init__(self, kind, doc, attributes):
        self.kind, self.doc, self.fields, self.within = kind, doc, [], None
        self.all_default = bool(re.search(r"\bdefault\b", attributes))
        case = re.search(r'rename_all = "(\w+)"', attributes)
        self.case = case[1] if case else None


def read(folder):
    """Public types with their public fields or variants: (key, type, doc, whether it may be left out)."""
    types, current, doc, attributes = {}, None, [], ""
    for line in "\n".join(file.read_text() for file in [*sorted(folder.glob("*.rs")), folder.parent / "table_file.rs"]).splitlines():
        text = line.strip()
        if text.startswith("///"):
            doc.append(text[3:].strip())
            continue
        if text.startswith("#["):
            attributes += text
            continue
        opens = re.match(r"pub (struct|enum) (\w+)", line)
        tuple_struct = re.match(r"pub struct \w+\(pub (?:Vec<)?(\w+)", line)
        if opens:
            current = types[opens[2]] = Type(opens[1], " ".join(doc), attributes)
            if tuple_struct:
                current.within, current = tuple_struct[1], None
        elif line.startswith("}"):
            current = None
        elif current and line.startswith("    ") and not line.startswith("     "):
            field = re.match(r"pub (\w+): (.+),$", text) if current.kind == "struct" else re.match(r"(\w+)(?:\((.+)\))?,$", text)
            if field:
                serde = "".join(re.findall(r"#\[serde\(.*?\)\]", attributes))
                name = re.search(r'rename = "(\w+)"', serde)
                key = name[1] if name else field[1]
                if current.kind == "enum" and not name and current.case:
                    key = field[1].lower() if current.case == "lowercase" else re.sub(r"(?<!^)([A-Z])", r"_\1", field[1]).lower()
                optional = current.all_default or "default" in serde or (field[2] or "").startswith("Option<")
                current.fields.append((key, field[2], " ".join(doc), optional))
        if text:
            doc, attributes = [], ""
    for kind in types.values():
        if kind.within in types:
            kind.doc, kind.fields = f"{kind.doc} {types[kind.within].doc}", types[kind.within].fields
    return types


class Pages:
    def __init__(self, types):
        self.types, self.sections, self.places = types, [], {}
        self.visit("SceneFile", "", False)

    def named(self, rust):
        """The type within options and lists, and whether it is a list."""
        many = rust.startswith("Vec<") or "<Vec<" in rust
        return re.sub(r"^(?:Option|Vec|Box)<|>$", "", re.sub(r"^(?:Option|Vec|Box)<(.*)>$", r"\1", rust)), many

    def visit(self, name, path, many):
        if name in self.places or name not in self.types or name in PLAIN or not self.types[name].fields:
            return
        kind = self.types[name]
        if kind.kind == "enum" and not any(rust for _, rust, _, _ in kind.fields):
            return
        dots = path.count(".")
        title = "A scene file" if not path else "region" if name == "RegionSpec" else f"[[{path}]]" if many and dots < 2 else f"[{path}]" if not dots else path
        self.places[name] = re.sub(r"[^\w-]", "", title.lower().replace(" ", "-"))
        self.sections.append((title, name))
        for key, rust, _, _ in kind.fields:
            if rust:
                inner, list_of = self.named(rust)
                self.visit(inner, path if key == "reading" else f"{path}.{key}".strip("."), list_of)

    def value(self, rust):
        if rust is None:
            return ""
        exactly = re.fullmatch(r"(?:Option<)?Exactly<(.*), (\d)>>?", rust)
        if exactly:
            return f"{exactly[2]} × {self.value(exactly[1])}"
        inner, many = self.named(rust)
        inner_exactly = re.fullmatch(r"Exactly<(.*), (\d)>?", inner)
        kind = self.types.get(inner)
        if inner_exactly:
            text = f"{inner_exactly[2]} × {self.value(inner_exactly[1])}"
        elif inner in PLAIN:
            text = PLAIN[inner]
        elif inner in self.places:
            text = f"[table](#{self.places[inner]})" if kind.kind == "struct" else f"[one of](#{self.places[inner]})"
        elif kind and kind.kind == "enum":
            text = ", ".join(f'`"{key}"`' for key, _, _, _ in kind.fields)
        else:
            raise SystemExit(f"keys.py: no words for the type {rust}")
        return f"list: {text}" if many else text

    def words(self, doc):
        def link(found):
            name = found[1].split("::")[-1]
            return f"[table](#{self.places[name]})" if name in self.places else f"`{name}`"

        doc = re.sub(r"\[`([\w:]+)`\](?:\([\w:]+\))?", link, doc)
        return re.sub(r" - (?=[A-Z])", "<br>", doc).replace("|", "\\|")

    def fields(self, name):
        for key, rust, doc, optional in self.types[name].fields:
            if key == "reading" and rust == "ReadingSpec":
                yield from ((key, rust, doc, True) for key, rust, doc, _ in self.types["ReadingSpec"].fields)
            else:
                yield key, rust, doc, optional

    def markdown(self):
        text = "# Keys of a scene\n\nUnits: mm, g, ms, hence N, MPa, mJ. A key in **bold** must be there. Unknown keys are refused with the nearest known one. "
        text += "Worked examples: [gallery](gallery.md), or `rhexis scenes --show NAME`.\n"
        for title, name in self.sections:
            if name == "ReadingSpec":
                continue
            code = title if title == "A scene file" else f"`{title}`"
            doc = self.words(self.types[name].doc)
            text += f"\n## {code}\n\n" + ("" if doc == f"`{title}`." else f"{doc}\n\n") + "| key | value | meaning |\n|---|---|---|\n"
            for key, rust, doc, optional in self.fields(name):
                shown = f"`{key}`" if optional or self.types[name].kind == "enum" else f"**`{key}`**"
                text += f"| {shown} | {self.value(rust)} | {self.words(doc)} |\n"
        text += "\n## Short forms\n\n| value | written as |\n|---|---|\n"
        return text + "".join(f"| {shown.lower()} | {self.form(name)} |\n" for shown, name in SHORT.items())

    def form(self, name):
        kind = self.types[name]
        inner = " ".join(f"`{key}`: {doc}" for key, _, doc, _ in kind.fields) if kind.kind == "struct" else " ".join(doc for _, _, doc, _ in kind.fields)
        return self.words(f"{kind.doc} {inner}".strip())


def page(root: Path):
    return Pages(read(root / "crates/rhexis-scene/src/schema")).markdown()
