#!/usr/bin/env python3
"""Makes the source of the book from the pages, and checks the book that mdbook made of it.

  book.py source FOLDER   FOLDER gets book.toml and src: the pages that docs/README.md lists, in its order and parts
                          (the decisions in that of docs/decisions/README.md), and every file that they link
  book.py check FOLDER    FOLDER is the finished book: a link to a file or heading that is not there, or a page that
                          wants something of a network or is not in the index of the search, is a fault; exit code 1 where there is one"""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parent.parent
INDEX, DECISIONS = Path("docs/README.md"), Path("docs/decisions/README.md")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")


def within(path):
    """A path with .. in, the same path from the root of the project out."""
    return (ROOT / path).resolve().relative_to(ROOT)


def title(page):
    return re.search(r"^# (.+)", (ROOT / page).read_text(encoding="utf-8"), re.M)[1]


def listed(index):
    """Pages that the items of an index lead to, headings of the index (as text) between them."""
    for line in (ROOT / index).read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            yield line[1:]
        elif (item := re.match(r"- \[[^\]]*\]\(([^)]+\.md)\)", line)):
            yield within(index.parent / item[1])


def linked(page):
    """What a page links of the project."""
    targets = LINK.findall((ROOT / page).read_text(encoding="utf-8"))
    return [within(page.parent / target) for target in targets if not re.match(r"[a-z]+:", target)]


def summary():
    """Lines of SUMMARY.md, and the pages they name. A page that only another one links stands below that one."""
    front = [Path("README.md"), INDEX]
    lines, pages = [f"[{title(page)}]({page})" for page in front], front
    known = {*front, *listed(INDEX), *listed(DECISIONS)}
    for entry in listed(INDEX):
        if isinstance(entry, str):
            lines.append(f"\n#{entry}\n")
            continue
        others = dict.fromkeys(page for page in linked(entry) if page.suffix == ".md" and page not in known)
        below = list(listed(entry)) if entry == DECISIONS else list(others)
        known.update(below)
        lines += [f"{'  ' * (page != entry)}- [{title(page)}]({page})" for page in [entry, *below]]
        pages += [entry, *below]
    return lines, pages


def source(folder):
    shutil.rmtree(folder / "src", ignore_errors=True)
    lines, pages = summary()
    names = {str(file) for page in pages for file in [page, *linked(page)]}
    tracked = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", *sorted(names)], cwd=ROOT, capture_output=True, text=True, check=True
    )
    for name in tracked.stdout.splitlines():
        copy = folder / "src" / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, copy)
    (folder / "src" / "SUMMARY.md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    shutil.copyfile(ROOT / "scripts/book.toml", folder / "book.toml")


class Page(HTMLParser):
    """Links of a page, its anchors, and what a browser loads with it."""

    def __init__(self, file):
        super().__init__()
        self.links, self.anchors, self.loads = [], set(), []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.anchors |= {found[key] for key in ("id", "name") if found.get(key)}
        if tag == "a" and found.get("href"):
            self.links.append(found["href"])
        elif tag in ("script", "img", "link") and (url := found.get("src") or found.get("href")):
            self.loads.append(url)


def faults(folder):
    pages = {file: Page(file) for file in folder.rglob("*.html") if file.name not in ("404.html", "print.html", "toc.html")}
    for file, page in pages.items():
        for url in page.loads + page.links:
            name, _, anchor = unquote(url).partition("#")
            to = (file.parent / name).resolve() if name else file
            if re.match(r"([a-z]+:)?//", url):
                if url in page.loads:
                    yield f"{file.relative_to(folder)}: loads {url}"
            elif not to.exists():
                yield f"{file.relative_to(folder)}: no file {url}"
            elif anchor and to in pages and anchor not in pages[to].anchors:
                yield f"{file.relative_to(folder)}: no heading {url}"
    # The index is a script, which a browser loads without a server.
    index = "".join(file.read_text(encoding="utf-8") for file in folder.glob("searchindex*.js"))
    found = set(re.findall(r'"([^"#]+\.html)#', index))
    for name in sorted(str(file.relative_to(folder)) for file in pages if file != folder / "index.html"):
        if name not in found:
            yield f"{name}: the search does not find it"


def main():
    what, folder = sys.argv[1], Path(sys.argv[2]).resolve()
    if what == "source":
        source(folder)
        return
    found = sorted(set(faults(folder)))
    print("\n".join([*found, f"{len(list(folder.rglob('*.html')))} pages of the book, {len(found)} faults"]))
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
