#!/usr/bin/env python3
"""pages.py PROGRAM API PAGE OUT: the book's sources in OUT/src. Documents of the repository are taken as they are, but for links to Rust, which lead to
the pages of `cargo doc` (API), links to other files, which are copied beside, and formulas of the theory, which are set. Gallery, keys of scenes and
the list of crates are made here; PAGE is the built page with the engine, which is copied."""

import re
import shutil
import subprocess
import sys
from os.path import normpath
from pathlib import Path

import formula
import keys

ROOT = Path(__file__).resolve().parent.parent
PICTURES = {".png", ".gif", ".svg", ".jpg"}
CRATES = {"rhexis": "the engine", "rhexis_scene": "scene files, mesh files, measures of a tear", "rhexis_lab": "verification and benchmarks"}
CRATES |= {"rhexis_cli": "the program", "bevy_rhexis": "the plugin for Bevy"}


def api(path, folder):
    """The page of a Rust path below `folder`, if it is public."""
    *modules, item = path.split("::")
    for place, name, anchor in [(modules, item, ""), (modules[:-1], modules[-1] if modules else "", f"#method.{item}")]:
        base = folder.joinpath(*place)
        found = [base / name / "index.html"] if not anchor and (base / name / "index.html").exists() else sorted(base.glob(f"*.{name}.html"))
        if found:
            return f"api/{found[0].relative_to(folder.parent).as_posix()}{anchor}"
    return None


class Book:
    def __init__(self, folder_of_api, out):
        self.api, self.source = folder_of_api, out / "src"
        summary = (ROOT / "site/SUMMARY.md").read_text()
        self.pages = re.findall(r"\(\.\./([^)]+\.md)\)", summary)
        self.write("SUMMARY.md", summary.replace("(../", "("))

    def write(self, name, text):
        (self.source / name).parent.mkdir(parents=True, exist_ok=True)
        (self.source / name).write_text(text)

    def copy(self, name, to):
        (self.source / to).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, self.source / to)

    def target(self, page, target):
        """The place in the book that a document's link means; None if it has none."""
        rust = re.match(r"(?:crate::|https://docs\.rs/rhexis/latest/rhexis/)(.+)", target)
        if rust:
            found = api(re.sub(r"/(?:\w+\.)?(\w+)(?:\.html)?", r"::\1", rust[1]), self.api / "rhexis")
            return found and "../" * page.count("/") + found
        name, hash_, anchor = target.partition("#")
        if "://" in target or not name:
            return target
        path = normpath((Path(page).parent / name).as_posix())
        if (ROOT / path).is_dir():
            name, path = f"{name.rstrip('/')}/README.md", f"{path}/README.md"
            if path not in self.pages:
                return None
        if path in self.pages:
            return re.sub(r"README\.md$", "index.md", name) + hash_ + anchor
        if not (ROOT / path).is_file():
            sys.exit(f"{page}: {target}: no such file")
        ending = "" if Path(path).suffix in PICTURES else ".txt"
        self.copy(path, path + ending)
        return name + ending

    def link(self, page, text, target):
        found = self.target(page, target)
        return f"[{text}]({found})" if found else text

    def page(self, name):
        parts = re.split(r"(^ *```.*?^ *```\n)", (ROOT / name).read_text(), flags=re.S | re.M)
        for index, part in enumerate(parts):
            if index % 2:
                block = re.match(r" *```text\n(.*?)^ *```\n", part, re.S | re.M) if "theory/" in name else None
                indent = re.match(" *", part)[0]
                made = formula.block(block[1]) if block else None
                parts[index] = f"{indent}{made}\n" if made else part
                continue
            part = re.sub(r"^(\[[^\]]+\]): (\S+)$", lambda m: f"{m[1]}: {self.target(name, m[2])}", part, flags=re.M)
            part = re.sub(r"(!?)\[((?:[^\[\]]|\[[^\]]*\](?:\([^)]*\))?)*)\]\(([^)\s]+)\)", lambda m: m[1] + self.nested(name, m[2], m[3]), part)
            parts[index] = formula.inline(part) if "theory/" in name else part
        self.write(name, "".join(parts))

    def nested(self, page, text, target):
        """A link's text may be a picture."""
        text = re.sub(r"!\[([^\]]*)\]\(([^)\s]+)\)", lambda m: "!" + self.link(page, m[1], m[2]), text)
        return self.link(page, text, target)

    def gallery(self, program, pictures):
        def ask(*words):
            return subprocess.run([program, *words], check=True, capture_output=True, text=True).stdout

        text = "# Gallery of scenes\n\nThe catalog of the program, each scene at its beginning, in the middle and at its end. "
        text += "`rhexis scenes --show NAME > my.toml` prints a scene's file, to copy and change.\n"
        pictures.mkdir(parents=True, exist_ok=True)
        for line in ask("scenes").splitlines():
            name, about = line.split(maxsplit=1)
            picture = pictures / f"{name}.png"
            if not picture.exists() or picture.stat().st_mtime < Path(program).stat().st_mtime:
                print(f"gallery: {name}", flush=True)
                ask("render", name, "--strip", "3", "--size", "420", "--quiet", "--out", str(picture))
            text += f"\n## {name}\n\n{about[0].upper()}{about[1:]}.\n\n![{name}](gallery/{name}.png)\n\n```sh\nrhexis run {name}\n```\n"
            text += f"\n[Tear it here](play/page/index.html?scene={name})\n"
            text += f"\n<details><summary>The scene's file</summary>\n\n```toml\n{ask('scenes', '--show', name).strip()}\n```\n\n</details>\n"
        self.write("gallery.md", text)
        shutil.copytree(pictures, self.source / "gallery", dirs_exist_ok=True)

    def play(self, page):
        shutil.copytree(page, self.source / "play")
        self.copy("bindings/web/capsule.png", "bindings/web/capsule.png")
        self.write(
            "play.md",
            "# Tear it in a browser\n\n[![The page: a lens capsule whose flap is drawn by the mouse](bindings/web/capsule.png)](play/page/index.html)\n\n"
            "[Open the page](play/page/index.html), then drag the tissue to grip and tear it, or cut a slit by the blade and tear from there. The engine runs in the "
            "page; a mesh or scene of your own is dropped on it and goes nowhere else. Keys, figures and limits: [Rhexis in a browser](bindings/web/index.md#the-page).\n",
        )

    def crates(self):
        text = "# Interface in Rust\n\nMade by `cargo doc`, with an example at each call.\n\n| crate | has |\n|---|---|\n"
        rows = [f"| [`{name}`](api/{name}/index.html) | {has} |\n" for name, has in CRATES.items() if (self.api / name).is_dir()]
        self.write("rust.md", text + "".join(rows))


def main():
    program, folder_of_api, page_of_engine, out = (Path(name).resolve() for name in sys.argv[1:])
    shutil.rmtree(out / "src", ignore_errors=True)
    book = Book(folder_of_api, out)
    for page in book.pages:
        book.page(page)
    book.write("keys.md", keys.page(ROOT))
    book.play(page_of_engine)
    book.crates()
    book.gallery(program, out / "pictures")


main()
