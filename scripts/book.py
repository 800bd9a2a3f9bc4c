#!/usr/bin/env python3
"""Makes the source of the book from the pages.

  book.py FOLDER   FOLDER gets book.toml and src: the pages that docs/README.md lists, in its order and parts
                   (the decisions in that of docs/decisions/README.md), and every file that they link"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

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


source(Path(sys.argv[1]).resolve())
