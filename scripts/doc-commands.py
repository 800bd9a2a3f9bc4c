#!/usr/bin/env python3
"""Checks the commands on the pages: a folder of programs and the .md files of git in, faults with file and line out;
exit code 1 where there is one.

  doc-commands.py target/debug

A fault is a subcommand of gripctl or gripfleet, or a flag of a program, that `--help` of the program does not list.
Commands of a program that is not in the folder (those of the fleet) are left out and counted."""

import functools
import re
import subprocess
import sys
from pathlib import Path

# What gripfleet does now; the changelog and decisions name it as it was.
MOVED = {"fleet", "foxglove"}
COMMAND = re.compile(r"(?<![\w/.-])(gripd|gripctl|gripfleet|gripmon|gripmon-fleet) ([^;&#`]*)")
CARGO = re.compile(r"cargo run .*?-p (grip[\w-]+)[^#`]*? -- ")


@functools.cache
def listed(program, *words):
    """Subcommands and flags that `--help` lists, those of subcommands of a subcommand included."""
    ran = subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=True)
    _, _, commands = ran.stdout.partition("\nCommands:\n")
    names = set(re.findall(r"^  ([a-z]+)  ", commands, re.M))
    below = [listed(program, *words, name) for name in names - {"help"}] if words else []
    return names.union(re.findall(r"--[a-z][\w-]*", ran.stdout), *below)


def code(page):
    """Numbers and lines of code: fences, with lines that go on joined, and spans."""
    fenced, text = "", ""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced, text = "" if fenced else line.strip(), ""
        elif fenced:
            goes_on = text.endswith("\\") or fenced == "```text" and line.startswith(8 * " ")
            text = f"{text} {line}" if goes_on else line
            yield number, text
        else:
            yield from ((number, span) for span in re.findall(r"`([^`]+)`", line))


def check(folder, text):
    """For each command of a line what is wrong with it, or None where it is left out."""
    text = re.sub(r"cargo (build|bench|test)\b.*", "", CARGO.sub(r"\1 ", text))
    for program, rest in COMMAND.findall(text):
        path = str(folder / program)
        if not (folder / program).exists():
            yield None
            continue
        known = listed(path)
        word = re.match(r"[a-z]+(?![\w.])|", rest)[0]
        if program == "gripfleet":
            # A line names several of its commands.
            known = known.union(*(listed(path, name) for name in known if name.isalpha() and name != "help"))
        elif program == "gripctl" and word:
            if word not in known:
                yield None if word in MOVED else [f"gripctl has no {word}"]
                continue
            known = listed(path, word)
        flags = re.findall(r"(?<![\w-])--[a-z][\w-]*", rest)
        yield [f"{' '.join([program, word]).strip()} has no {flag}" for flag in flags if flag not in known]


def main():
    folder = Path(sys.argv[1])
    # The reference is what `--help` prints; a test compares it.
    pages = ["git", "ls-files", "*.md", ":!*/reference/*"]
    files = subprocess.run(pages, capture_output=True, text=True, check=True).stdout.split()
    found, checked, left_out = {}, 0, 0
    for page in map(Path, files):
        for number, text in code(page):
            for faults in check(folder, text):
                checked += faults is not None
                left_out += faults is None
                for fault in faults or []:
                    found.setdefault((page, fault), number)
    for (page, fault), number in found.items():
        print(f"{page}:{number}: {fault}")
    print(f"{checked} commands, {left_out} left out, {len(found)} faults")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
