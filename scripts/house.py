"""What scripts/house.sh prints: cargo's metadata and the files of git in, tables in Markdown out."""

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


def kind(path):
    parts = path.parts
    if parts[0] in ("fuzz",):
        return "fuzz"
    if "examples" in parts:
        return "examples"
    if parts[0] == "benches":
        return "integration tests" if parts[1] == "tests" else "benches"
    if "benches" in parts:
        return "benches"
    if parts[0] == "tests" or "tests" in parts and "src" not in parts:
        return "integration tests"
    return "src"


def lines_by_kind(files, folders):
    counts = collections.defaultdict(collections.Counter)
    for path in files:
        text = path.read_text()
        owner = next((name for folder, name in folders if path.is_relative_to(folder)), str(path.parts[0]))
        if kind(path) == "src":
            program, tests = split_tests(path, text)
            counts[owner]["src"] += program
            counts[owner]["unit tests"] += tests
        else:
            counts[owner][kind(path)] += text.count("\n")
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


class Modules:
    """The modules of one crate and what they import from each other; tests are left out."""

    def __init__(self, root, files):
        self.files = {}
        for path in files:
            within = path.relative_to(root)
            names = [*within.parts[:-1], within.stem]
            if names[-1] in ("mod", "lib", "main"):
                names.pop()
            text = path.read_text()
            kept = split_tests(path, text)[0]
            if kept:
                self.files[tuple(names)] = "\n".join(text.splitlines()[:kept])
        self.exports = {module: self._uses(text, r"pub(?:\([^)]*\))? use") for module, text in self.files.items()}

    @staticmethod
    def _expand(tree):
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
                    found += [head + rest for rest in Modules._expand(inner[start:at])]
                start = at + 1
        return found

    @staticmethod
    def _uses(text, what):
        paths = []
        for found in re.finditer(rf"^\s*{what} ([^;]+);", text, re.M):
            paths += Modules._expand(found.group(1))
        return paths

    def _place(self, module, path, depth=0):
        """The deepest module that `path`, said in `module`, leads to, through what modules export again."""
        names = list(path)
        if names[0] == "crate":
            base, names = [], names[1:]
        elif names[0] in ("self", "super"):
            base = list(module)
            while names and names[0] in ("self", "super"):
                if names.pop(0) == "super":
                    base = base[:-1]
        elif (*module, names[0]) in self.files:
            base = list(module)
        else:
            return None
        while names and (*base, names[0]) in self.files:
            base.append(names.pop(0))
        if names and depth < 5:
            for export in self.exports.get(tuple(base), []):
                if export[-1] in (names[0], "*") and export != path:
                    place = self._place(tuple(base), export, depth + 1)
                    if place:
                        return place
        return tuple(base)

    def edges(self):
        """From module to module; a folder's own file (`mod.rs`, `x.rs` beside `x/`) names its parts without leaning on them."""
        found = set()
        for module, text in self.files.items():
            code = re.sub(r"//.*", "", text)
            paths = self._uses(code, r"use")
            paths += [said.split("::") for said in re.findall(r"\b((?:crate|super)(?:::\w+)+)", code)]
            for path in paths:
                place = self._place(module, path)
                if place and place != module and place in self.files:
                    found.add((module, place))
        return found

    def folder(self, module):
        """A folder is a module with parts; a file without parts lies in the folder of its parent."""
        is_folder = any(len(other) > len(module) and other[: len(module)] == module for other in self.files)
        return module if is_folder else module[:-1]


def circles(edges):
    """Sets of nodes that reach each other (Tarjan, iterative enough for these sizes)."""
    graph = collections.defaultdict(set)
    for source, target in edges:
        graph[source].add(target)
        graph.setdefault(target, set())
    order, low, stack, found = {}, {}, [], []
    sys.setrecursionlimit(10_000)

    def visit(node):
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in graph[node]:
            if other not in order:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == order[node]:
            knot = set()
            while node not in knot:
                knot.add(stack.pop())
            if len(knot) > 1:
                found.append(knot)

    for node in list(graph):
        if node not in order:
            visit(node)
    return found


def folder_circles(files, packages):
    found = []
    for package in packages.values():
        root = Path(os.path.relpath(package["manifest_path"])).parent / "src"
        own = [path for path in files if path.is_relative_to(root) and "bin" not in path.relative_to(root).parts]
        if not own:
            continue
        modules = Modules(root, own)
        # The crate's own front page names everything.
        edges = {(a, b) for a, b in modules.edges() if a and b}
        top = {(a[0], b[0]) for a, b in edges if a[0] != b[0]}
        parts = {module[0] for module in modules.files if len(module) > 1}
        for knot in circles(top):
            found.append((bool(knot & parts), f"{package['name']}: " + " ".join(sorted(knot))))
    return found


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


def main():
    metadata = json.loads(Path(sys.argv[1]).read_text())
    packages = {package["name"]: package for package in metadata["packages"]}
    folders = sorted(
        ((Path(os.path.relpath(package["manifest_path"])).parent, name) for name, package in packages.items()),
        key=lambda pair: -len(pair[0].parts),
    )
    files = sources()

    print("## Lines of Rust (`wc -l`, files under git)\n")
    kinds = ["src", "unit tests", "integration tests", "benches", "fuzz", "examples"]
    counts = lines_by_kind(files, folders)
    print("| package | " + " | ".join(kinds) + " | all |\n|---|" + "---|" * (len(kinds) + 1))
    total = collections.Counter()
    for name in sorted(counts, key=lambda name: -sum(counts[name].values())):
        row = counts[name]
        total.update(row)
        print(f"| {name} | " + " | ".join(f"{row[k]:,}" if row[k] else "" for k in kinds) + f" | {sum(row.values()):,} |")
    print("| **all** | " + " | ".join(f"{total[k]:,}" for k in kinds) + f" | **{sum(total.values()):,}** |")
    print("\n`benches` are the package of the benches and the folders of that name.")

    print("\n## Constants of slip-core\n")
    texts = {str(path): path.read_text() for path in files}
    print("Numbers with a name in `src`, unit tests left out: each was chosen by somebody.\n")
    constants = constants_by_folder(texts)
    print("| folder or file | constants |\n|---|---|")
    for name, count in sorted(constants.items(), key=lambda pair: (-pair[1], pair[0])):
        print(f"| {name} | {count} |")
    print(f"| **all** | **{sum(constants.values())}** |")

    up = edges_up(packages)
    closure = os.environ["GRIPD_CLOSURE"].splitlines()
    own = sorted({line.split()[0] for line in closure} & set(packages))
    print("\n## gripd's closure (default features, normal and build dependencies)\n")
    print(f"{len(closure)} packages, of them {len(own)} ours: {' '.join(own)}.")
    size = sum(counts[name]["src"] for name in own)
    print(f"Ours have {size:,} lines under src without unit tests.")

    print("\n## Edges that point up\n")
    print(f"{len(up)} against the floors of the script (dev-dependencies count where they are benches or tests).")
    print("".join(f"- {edge}\n" for edge in sorted(up)), end="")

    knots = sorted(folder_circles(files, packages))
    print("\n## Circles between folders\n")
    print("Sets of a crate's top modules (a folder, or a file of src) that import each other, tests and lib.rs left out;")
    print("imports through what a module exports again count for where the item stands.\n")
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
