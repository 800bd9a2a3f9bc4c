#!/usr/bin/env python3
"""Checks the pages: files of git that end in .md in, faults with file and line out; exit code 1 where there is one.

A fault is a link to a file or heading that is not there, a line of prose longer than 120 characters (code, tables and
what cannot be broken excepted), a README.md of more than 120 lines, and a page under docs/ that docs/README.md does not
link (a decision: docs/decisions/README.md)."""

import re
import subprocess
import sys
from pathlib import Path

WIDTH = README_LINES = 120
LINK = re.compile(r"\]\(([^)\s]+)\)")


def slug(heading):
    """The anchor of a heading, as GitHub makes it."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.strip().lower())
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def prose(page):
    """Numbers and lines of a page outside of code."""
    fenced = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield number, line


def anchors(page):
    """Anchors of a page; a heading that comes again has a number."""
    found = {}
    for _, line in prose(page):
        if heading := re.match(r"#+ (.+)", line):
            name = slug(heading[1])
            found[name] = found.get(name, -1) + 1
            yield f"{name}-{found[name]}" if found[name] else name


def too_long(line):
    """Whether prose could be broken before the margin: a code span or a link counts as one word."""
    words = re.sub(r"`[^`]*`|\[[^\]]*\]\([^)]*\)", lambda span: "x" * len(span[0]), line).split()
    return len(line) > WIDTH and not line.startswith("|") and len(words) > 1


def faults(pages):
    linked = {}
    for page in pages:
        for number, line in prose(page):
            if too_long(line):
                yield f"{page}:{number}: {len(line)} characters"
            for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
                if re.match(r"[a-z]+:", target):
                    continue
                file, _, anchor = target.partition("#")
                to = page.parent / file if file else page
                linked.setdefault(page, set()).add(to.resolve())
                if not to.exists():
                    yield f"{page}:{number}: no file {target}"
                elif anchor and to.suffix == ".md" and anchor not in anchors(to):
                    yield f"{page}:{number}: no heading {target}"
    lines = len(Path("README.md").read_text(encoding="utf-8").splitlines())
    if lines > README_LINES:
        yield f"README.md: {lines} lines, at most {README_LINES}"
    for page in pages:
        folder = Path("docs/decisions" if page.parts[:2] == ("docs", "decisions") else "docs")
        index = folder / "README.md"
        if folder in page.parents and page != index and page.resolve() not in linked.get(index, ()):
            yield f"{page}: not in {index}"


def main():
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "*.md"], capture_output=True, text=True, check=True
    )
    pages = [Path(name) for name in listed.stdout.splitlines() if Path(name).exists()]
    found = list(faults(pages))
    print("\n".join([*found, f"{len(pages)} pages, {len(found)} faults"]))
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
