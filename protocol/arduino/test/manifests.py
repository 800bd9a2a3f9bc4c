#!/usr/bin/env python3
"""The packed library against the rules of Arduino's Library Manager and of PlatformIO: manifests.py FOLDER

The rules of library.properties are those of the Arduino library specification, written down here: arduino-lint is in no package index. library.json
goes through PlatformIO's own schema and packer where the package platformio is installed; its list of licences, which it fetches, is given."""

import json
import re
import sys
from pathlib import Path

CATEGORIES = (
    "Display", "Communication", "Signal Input/Output", "Sensors", "Device Control", "Timing", "Data Storage", "Data Processing", "Other",
)  # fmt: skip
REQUIRED = ("name", "version", "author", "maintainer", "sentence", "paragraph", "category", "architectures")


def faults(folder):
    lines = [line for line in (folder / "library.properties").read_text().splitlines() if line and not line.startswith("#")]
    fields = dict(line.split("=", 1) for line in lines)
    other = json.loads((folder / "library.json").read_text())
    yield from (f"library.properties: no {name}" for name in REQUIRED if not fields.get(name))
    if not re.fullmatch(r"[A-Za-z0-9][\w .\-]{0,62}", fields["name"]) or "arduino" in fields["name"].lower():
        yield "name"
    if not re.fullmatch(r"\d+\.\d+\.\d+", fields["version"]):
        yield "version"
    if fields["category"] not in CATEGORIES:
        yield "category"
    if fields["paragraph"].startswith(fields["sentence"]):
        yield "paragraph repeats the sentence"
    for name in ("name", "version"):
        if fields[name] != other[name]:
            yield f"{name} differs between the manifests"
    for header in [*fields["includes"].split(","), *other["headers"]]:
        if not (folder / "src" / header).is_file():
            yield f"{header} is not there"
    sketches = sorted(file.parent.name for file in folder.glob("examples/*/*.ino"))
    if any(not (folder / f"examples/{name}/{name}.ino").is_file() for name in sketches):
        yield "a sketch has another name than its folder"
    if sketches != sorted(example["name"] for example in other["examples"]):
        yield "library.json has other examples than the folder"
    if any(file.is_symlink() or file.suffix in (".exe", ".o", ".a") for file in folder.rglob("*")):
        yield "links or binaries"
    for number, line in enumerate((folder / "keywords.txt").read_text().splitlines(), 1):
        if not re.fullmatch(r"\w+\t(KEYWORD[123]|LITERAL1)", line):
            yield f"keywords.txt:{number}: {line}"


def main():
    folder = Path(sys.argv[1])
    found = list(faults(folder))
    try:
        from platformio.package.manifest.schema import ManifestSchema
        from platformio.package.pack import PackagePacker
    except ImportError:
        packed = "PlatformIO is not installed, so that its schema was not asked"
    else:
        ManifestSchema.load_spdx_licenses = staticmethod(lambda: {"licenses": [{"licenseId": "MIT"}, {"licenseId": "Apache-2.0"}]})
        packed = f"packed by PlatformIO: {Path(PackagePacker(str(folder)).pack(str(folder.parent))).name}"
    print("; ".join(found) or f"manifests: good; {packed}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
