"""README.md of a release: packaging/release.md with a row for each file that is there, and for no other.

Usage: release-page.py FOLDER VERSION ARCH PROGRAM, where PROGRAM is linked with the glibc of the system.
"""

import fnmatch
import re
import subprocess
import sys
from pathlib import Path

folder, version, arch, program = Path(sys.argv[1]), *sys.argv[2:]
symbols = subprocess.run(["readelf", "--version-info", program], capture_output=True, text=True, check=True).stdout
glibc = max(re.findall(r"GLIBC_([0-9]+)[.]([0-9]+)", symbols), key=lambda found: [int(part) for part in found])
page = (Path(__file__).parent.parent / "packaging/release.md").read_text()
for name, value in {"VERSION": version, "ARCH": arch, "GLIBC": ".".join(glibc)}.items():
    page = page.replace(f"@{name}@", value)
names = [file.name for file in folder.iterdir() if file.name not in {"README.md", "SHA256SUMS"}]
lines, named = [], set()
for line in page.splitlines(keepends=True):
    row = re.match(r"[|] `([^`]+)`", line)
    found = fnmatch.filter(names, row[1]) if row else []
    if found or not row:
        lines.append(line)
        named.update(found)
if missing := sorted(set(names) - named):
    sys.exit(f"release: packaging/release.md says nothing of {', '.join(missing)}")
(folder / "README.md").write_text("".join(lines))
