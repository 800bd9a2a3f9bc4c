#!/usr/bin/env python3
"""Fails when a dependency has a licence that MIT OR Apache-2.0 projects cannot use.

Reads `cargo metadata`; an expression passes when one of its OR branches consists of allowed licences only.
"""

import json
import re
import subprocess
import sys

# MPL-2.0 binds the files of the crate that has it, not ours; whoever gets a program is told where they are (packaging/copyright).
ALLOWED = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0",
    "CC0-1.0", "CDLA-Permissive-2.0", "ISC", "MIT", "MIT-0", "MPL-2.0", "Unicode-3.0", "Unlicense", "Zlib",
    # of fonts, which gripmon carries unchanged
    "OFL-1.1", "Ubuntu-font-1.0",
}


def passes(expression: str) -> bool:
    """Whether the SPDX expression can be met with allowed licences; parentheses only group ORs in practice."""
    expression = expression.replace("/", " OR ")
    parts = [part.strip() for part in re.split(r"\bAND\b", re.sub(r"[()]", "", expression))]
    if "(" not in expression and "AND" in expression and " OR " in expression:
        # AND binds tighter than OR.
        return any(all(term.strip() in ALLOWED for term in branch.split(" AND ")) for branch in expression.split(" OR "))
    return all(any(option.strip() in ALLOWED for option in part.split(" OR ")) for part in parts)


def main() -> int:
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
    packages = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)["packages"]
    bad = [
        f"{package['name']} {package['version']}: {package['license']}"
        for package in packages
        if not package["license"] or not passes(package["license"])
    ]
    for line in bad:
        print(line, file=sys.stderr)
    print(f"{len(packages)} packages, {len(bad)} with a licence that is not allowed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
