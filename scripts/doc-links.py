#!/usr/bin/env python3
"""Checks the pages: files of git that end in .md in, faults with file and line out; exit code 1 where there is one.

A fault is a link to a file or heading that is not there, a line of prose longer than 120 characters (code, tables and
what cannot be broken excepted), a README.md of more than 120 lines, a page under docs/ that docs/README.md does not
link (a decision: docs/decisions/README.md), a source file in backticks that is not there, and sentences of more than
20 words on average, of all pages together, or of more than 25 in one page of ten sentences and more.

  doc-links.py FOLDER      looks at the links of the pages of a folder alone
  doc-links.py --linked    prints what pages link to"""

import os
import re
import subprocess
import sys
from pathlib import Path

WIDTH = README_LINES = 120
# Words of a sentence, on average: all pages, one page.
WORDS, PAGE_WORDS = 20, 25
PAGE_LINES = 300
LINK = re.compile(r"\]\(([^)\s]+)\)")
# A source file that prose names: by its end, from any folder on; the folder `src` may be left out.
SOURCE = re.compile(r"`(?:\.{1,2}/)*([\w/-][\w./-]*\.(?:rs|py|sh))`")


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


def sentences(page):
    """Words of each sentence of a page: tables, headings and code left out; a code span or a link's text counts as its words."""
    paragraphs, last = [], 0
    for number, line in prose(page):
        item = re.match(r"\s*([-*]|\d+\.) ", line)
        if not line.strip() or line.lstrip().startswith(("|", "#", "<", "![")):
            last = 0
            continue
        if item or last != number - 1:
            paragraphs.append("")
        paragraphs[-1] += " " + line[item.end() if item else 0 :].strip()
        last = number
    for paragraph in paragraphs:
        text = re.sub(r"`[^`]*`", "X", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", paragraph))
        for sentence in re.split(r"(?<=[.!?:])\s+(?=[A-Z*])", text):
            # What stands alone is a word of a list.
            if len(sentence.split()) > 2:
                yield len(sentence.split())


def wordy(pages):
    every = []
    for page in pages:
        lengths = list(sentences(page))
        every += lengths
        if len(lengths) >= 10 and sum(lengths) > PAGE_WORDS * len(lengths):
            yield f"{page}: {sum(lengths) / len(lengths):.1f} words a sentence, at most {PAGE_WORDS}"
    if sum(every) > WORDS * len(every):
        yield f"all pages: {sum(every) / len(every):.1f} words a sentence, at most {WORDS}"


def missing_sources(pages, files):
    """Source files that pages name and that are not there, but for those whose text the page itself gives. The changelog may
    name what is gone."""
    ends = {"/" + name for name in files} | {"/" + name.replace("/src/", "/") for name in files}
    for page in pages:
        given = set(re.findall(r"^```\w+ (\S+)$", page.read_text(encoding="utf-8"), re.M))
        for number, line in prose(page):
            for name in SOURCE.findall(line):
                if name not in given and page.name != "CHANGELOG.md" and not any(end.endswith("/" + name) for end in ends):
                    yield f"{page}:{number}: no file {name}"


def links(page):
    """Links within the folder: number of the line, target, file."""
    for number, line in prose(page):
        for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
            if not re.match(r"[a-z]+:", target):
                yield number, target, page.parent / (target.partition("#")[0] or page.name)


def dead(pages):
    for page in pages:
        for number, target, to in links(page):
            anchor = target.partition("#")[2]
            if not to.exists():
                yield f"{page}:{number}: no file {target}"
            elif anchor and to.suffix == ".md" and anchor not in anchors(to):
                yield f"{page}:{number}: no heading {target}"


def faults(pages):
    linked = {page: {to.resolve() for *_, to in links(page)} for page in pages}
    for page in pages:
        for number, line in prose(page):
            if too_long(line):
                yield f"{page}:{number}: {len(line)} characters"
    lines = len(Path("README.md").read_text(encoding="utf-8").splitlines())
    if lines > README_LINES:
        yield f"README.md: {lines} lines, at most {README_LINES}"
    for page in pages:
        lines = len(page.read_text(encoding="utf-8").splitlines())
        if page.parts[0] == "docs" and page.parts[1] not in ("results", "reference") and lines > PAGE_LINES:
            yield f"{page}: {lines} lines, at most {PAGE_LINES}"
        folder = Path("docs/decisions" if page.parts[:2] == ("docs", "decisions") else "docs")
        index = folder / "README.md"
        if folder in page.parents and page != index and page.resolve() not in linked.get(index, ()):
            yield f"{page}: not in {index}"


def main():
    if sys.argv[1:] and sys.argv[1] != "--linked":
        pages = list(Path(sys.argv[1]).rglob("*.md"))
        found = [*dead(pages)] if pages else ["no page"]
    else:
        listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True, check=True)
        files = [name for name in listed.stdout.splitlines() if Path(name).exists()]
        pages = [Path(name) for name in files if name.endswith(".md")]
        if sys.argv[1:]:
            print(*sorted({os.path.relpath(to) for page in pages for *_, to in links(page)}), sep="\n")
            return
        found = [*dead(pages), *faults(pages), *missing_sources(pages, files), *wordy(pages)]
    print("\n".join([*found, f"{len(pages)} pages, {len(found)} faults"]))
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
