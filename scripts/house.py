#!/usr/bin/env python3
"""Measures the workspace as a building, as tables in Markdown: lines by package, constants of slip-core, gripd's closure, dependency edges that
point up, circles between folders, tuples of arguments. Says in each heading how it is counted.

Fails where a crate has no floor, an edge points up, folders import each other, or a tuple is an argument. Needs cargo; builds nothing."""

import collections
import json
import os
import re
import subprocess
import sys
from pathlib import Path

# Ground first. A package may depend on packages of lower floors only (normal and build dependencies, optional ones too).
FLOORS = [
    ["slip-msg", "mlp-core", "grip-plot", "grip-table", "stories"],
    ["slip-core", "grip-link", "mlp"],
    ["grip-port", "grip-record", "grip-robotiq"],
    ["grip-session"],
    ["grip-daemon", "slip-ffi"],
    # Below: beside a gripper. Above: not, but for the simulator of `--port sim`.
    ["grip-sim", "grip-import"],
    ["grip-eval", "grip-study"],
    ["grip-scope"],
    ["gripd", "gripctl", "gripmon"],
    ["grip-manuals"],
    ["slip-benches"],
]
# Packages that are benches or tests.
BENCHES_AND_TESTS = {"slip-benches"}


def sources():
    """Rust files under git, also new ones."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.rs"], check=True, capture_output=True, text=True
    ).stdout.split()
    return [Path(name) for name in sorted(set(listed)) if Path(name).is_file()]


def split_tests(path, text):
    """Lines of a file under src: of the program, and of its unit tests (`mod tests { .. }` at the end, or a file of tests)."""
    lines = text.count("\n")
    if path.stem == "tests" or path.stem.endswith("_tests") or "tests" in path.parts:
        return 0, lines
    found = re.search(r"^#\[cfg\(test\)\]\n(#\[.*\n)*(pub(\(crate\))? )?mod \w+ \{", text, re.M)
    if not found:
        return lines, 0
    before = text[: found.start()].count("\n")
    return before, lines - before


def lines_by_package(files, folders):
    """Lines of the program and of everything else (tests, benches, examples, fuzz targets) of each package."""
    counts = collections.defaultdict(lambda: [0, 0])
    for path in files:
        text = path.read_text()
        owner = next((name for folder, name in folders if path.is_relative_to(folder)), str(path.parts[0]))
        is_program = "src" in path.parts and path.parts[0] not in ("benches", "fuzz", "tests")
        program, rest = split_tests(path, text) if is_program else (0, text.count("\n"))
        counts[owner][0] += program
        counts[owner][1] += rest
    return counts


def constants_by_folder(texts):
    """How many numbers have a name in each folder of slip-core."""
    counts = collections.Counter()
    for name, text in texts.items():
        path = Path(name)
        if not path.is_relative_to("crates/slip-core/src"):
            continue
        program = "".join(text.splitlines(keepends=True)[: split_tests(path, text)[0]])
        found = len(re.findall(r"^ *(?:pub(?:\([^)]*\))? )?const \w+: \[?[fiu](?:8|16|32|64|size)\b", program, re.M))
        if found:
            counts[path.relative_to("crates/slip-core/src").parts[0].removesuffix(".rs")] += found
    return counts


def edges_up(packages):
    floor = {name: number for number, names in enumerate(FLOORS) for name in names}
    unknown, gone = sorted(set(packages) - set(floor)), sorted(set(floor) - set(packages))
    if unknown or gone:
        sys.exit(f"scripts/house.py: FLOORS lacks {unknown} or still names {gone}")
    up = []
    for package in packages.values():
        for dependency in package["dependencies"]:
            other = dependency["name"]
            if other in packages and floor[other] >= floor[package["name"]]:
                if dependency["kind"] != "dev" or other in BENCHES_AND_TESTS:
                    up.append(f"{package['name']} -> {other}" + (" (dev)" if dependency["kind"] == "dev" else ""))
    return up


def expand(tree):
    """`a::{b, c::{d, e}}` as lists of names."""
    tree = re.sub(r"\s+", " ", tree).strip()
    brace = tree.find("{")
    if brace < 0:
        return [[part.strip() for part in re.sub(r" as .*", "", tree).split("::")]]
    head = [part.strip() for part in tree[:brace].strip().rstrip(":").split("::") if part.strip()]
    depth, start, inner, found = 0, 0, tree[brace + 1 : tree.rindex("}")], []
    for at, char in enumerate(inner + ","):
        depth += {"{": 1, "}": -1}.get(char, 0)
        if char == "," and depth == 0:
            if inner[start:at].strip():
                found += [head + rest for rest in expand(inner[start:at])]
            start = at + 1
    return found


def imports(root, files):
    """What the top modules of a crate (folders, or files of src) import from each other, and the folders; tests are left out."""
    texts, edges = collections.defaultdict(str), set()
    for path in files:
        within, text = path.relative_to(root), path.read_text()
        program = "\n".join(text.splitlines()[: split_tests(path, text)[0]])
        names = [*within.parts[:-1], *([] if within.stem in ("mod", "lib", "main") else [within.stem])]
        # From where it stands, so many times `super` is the crate.
        program = re.sub(rf"\b(?:super::){{{len(names)}}}", "crate::", program) if names else program
        texts[names[0] if names else ""] += re.sub(r"//.*", "", program) + "\n"
    exported = {}
    for use in re.findall(r"^pub(?:\([^)]*\))? use ([^;]+);", texts.pop("", ""), re.M):
        exported |= {path[-1]: path[1] if path[0] == "crate" else path[0] for path in expand(use)}
    for top, text in texts.items():
        paths = [path for use in re.findall(r"\buse (crate::[^;]+);", text) for path in expand(use)]
        paths += [said.split("::") for said in re.findall(r"\bcrate(?:::\w+)+", text)]
        targets = {path[1] for path in paths if len(path) > 1}
        # What no other export names may come of a glob.
        edges |= {(top, target if target in texts else exported.get(target, exported.get("*"))) for target in targets}
    folders = {path.relative_to(root).parts[0] for path in files if len(path.relative_to(root).parts) > 1 and split_tests(path, path.read_text())[0]}
    return {(a, b) for a, b in edges if a != b and b in texts}, folders


def circles(edges):
    """Sets of nodes that reach each other."""
    reach = {node: {b for a, b in edges if a == node} for pair in edges for node in pair}
    for middle in reach:
        for node in reach:
            if middle in reach[node]:
                reach[node] |= reach[middle]
    return {frozenset(b for b in reach[a] if a in reach[b]) for a in reach if a in reach[a]}


def folder_circles(files, packages):
    for package in packages.values():
        root = Path(os.path.relpath(package["manifest_path"])).parent / "src"
        own = [path for path in files if path.is_relative_to(root) and "bin" not in path.relative_to(root).parts]
        edges, folders = imports(root, own)
        for knot in circles(edges):
            yield bool(knot & folders), f"{package['name']}: " + " ".join(sorted(knot))


def tuples_of_arguments(texts):
    """Functions that take a tuple apart in their signature: its parts are arguments of their own."""
    for name, text in texts.items():
        for found in re.finditer(r"\bfn (\w+)(?=[<(])", text):
            depth, begin = 0, None
            for at in range(found.end(), len(text)):
                angle = text[at] == ">" and text[at - 1] not in "-="
                depth += (text[at] in "([{<") - (text[at] in ")]}" or angle)
                if begin is None:
                    # Behind the parameters in angle brackets.
                    begin = at + 1 if depth == 1 and text[at] == "(" else None
                elif depth == 0 or depth == 1 and text[at] == ",":
                    # An argument of a property test is drawn: `(a, b) in ..`.
                    if re.match(r"\s*(#\[[^]]*\]\s*)*&?\((?!.*\) in )", text[begin:at], re.S):
                        yield f"{name}:{text.count(chr(10), 0, found.start()) + 1} {found[1]}"
                    begin = at + 1
                    if depth == 0:
                        break


def cargo(*words):
    """What cargo prints; the package index is not asked where the lock file's packages are there."""
    for offline in (["--offline"], []):
        ran = subprocess.run(["cargo", *words, "--locked", *offline], capture_output=True, text=True)
        if ran.returncode == 0:
            return ran.stdout
    sys.exit(ran.stderr)


def main():
    os.chdir(Path(__file__).parent.parent)
    metadata = json.loads(cargo("metadata", "--no-deps", "--format-version", "1"))
    packages = {package["name"]: package for package in metadata["packages"]}
    folders = sorted(
        ((Path(os.path.relpath(package["manifest_path"])).parent, name) for name, package in packages.items()),
        key=lambda pair: -len(pair[0].parts),
    )
    files = sources()

    print("## Lines of Rust (`wc -l`, files under git)\n")
    counts = lines_by_package(files, folders)
    print("| package | program | tests, benches, examples |\n|---|---|---|")
    for name, (program, rest) in sorted(counts.items(), key=lambda pair: -sum(pair[1])):
        print(f"| {name} | {program:,} | {rest:,} |")
    program, rest = (sum(row[k] for row in counts.values()) for k in (0, 1))
    print(f"| **all {program + rest:,}** | {program:,} | {rest:,} |")

    print("\n## Constants of slip-core\n")
    texts = {str(path): path.read_text() for path in files}
    print("Numbers with a name in `src`, unit tests left out: each was chosen by somebody.\n")
    constants = constants_by_folder(texts)
    print("| folder or file | constants |\n|---|---|")
    for name, count in sorted(constants.items(), key=lambda pair: (-pair[1], pair[0])):
        print(f"| {name} | {count} |")
    print(f"| **all** | **{sum(constants.values())}** |")

    up = edges_up(packages)
    tree = cargo("tree", "-p", "gripd", "-e", "normal,build", "--prefix", "none", "--format", "{p}")
    closure = {line.removesuffix(" (*)") for line in tree.splitlines()}
    own = sorted({line.split()[0] for line in closure} & set(packages))
    print("\n## gripd's closure (default features, normal and build dependencies)\n")
    print(f"{len(closure)} packages, of them {len(own)} ours: {' '.join(own)}.")
    size = sum(counts[name][0] for name in own)
    print(f"Ours have {size:,} lines under src without unit tests.")

    print("\n## Edges that point up\n")
    print(f"{len(up)} against the floors of the script (dev-dependencies count where they are benches or tests).")
    print("".join(f"- {edge}\n" for edge in sorted(up)), end="")

    knots = sorted(folder_circles(files, packages))
    print("\n## Circles between folders\n")
    print("Sets of a crate's top modules (a folder, or a file of src) that import each other, tests and lib.rs left out;")
    print("what the crate exports at its top counts for where it stands.\n")
    for is_folder, what in [(True, "With a folder"), (False, "Of files of src alone")]:
        those = [knot for has_folder, knot in knots if has_folder == is_folder]
        print(f"{what}: {len(those)}.")
        print("".join(f"- {knot}\n" for knot in those), end="")

    tuples = list(tuples_of_arguments(texts))
    print(f"\n## Tuples of arguments\n\n{len(tuples)}.")
    print("".join(f"- {place}\n" for place in tuples), end="")

    if up or tuples or any(has_folder for has_folder, _ in knots):
        sys.exit("scripts/house.py: an edge points up, folders import each other, or a tuple is an argument")


main()
