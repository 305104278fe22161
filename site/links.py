#!/usr/bin/env python3
"""links.py FOLDER: every link and picture of the pages in FOLDER leads to a file there, and every anchor to an element. Pages of `cargo doc` are
targets alone."""

import sys
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    def __init__(self, file):
        super().__init__()
        self.ids, self.targets = set(), []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        self.ids.update(name for name in (of.get("id"), of.get("name")) if name)
        self.targets += [unescape(of[key]) for key in ("href", "src") if of.get(key) and tag != "base"]


folder = Path(sys.argv[1]).resolve()
read = {}
broken, count = [], 0
for file in sorted(folder.rglob("*.html")):
    if file.is_relative_to(folder / "api") or file.name in ("404.html", "toc.html"):
        continue
    for target in Page(file).targets:
        parts = urlsplit(target)
        if parts.scheme or target.startswith("//"):
            continue
        count += 1
        to = (file.parent / unquote(parts.path)).resolve() if parts.path else file
        to = to / "index.html" if to.is_dir() else to
        if not to.is_file() or not to.is_relative_to(folder):
            broken.append(f"{file.relative_to(folder)}: {target}: no such file")
        elif parts.fragment and to.suffix == ".html":
            ids = read.setdefault(to, Page(to).ids)
            if unquote(parts.fragment) not in ids:
                broken.append(f"{file.relative_to(folder)}: {target}: no such place")
print(f"links: {count} within the site, {len(broken)} broken")
sys.exit("\n".join(broken) if broken else 0)
