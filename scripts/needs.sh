#!/bin/bash
# Names everything that the checks of .ci/run need and do not find, and fails where GRIP_ALLOW_MISSING (CONTRIBUTING.md) does not name it too.
# Makes the Python environment of the checks. What the firmware and the peers of other projects need, their scripts install.
set -u
cd "$(dirname "$0")/.."
. scripts/missing.sh

bad=0
need() { # WORD WHAT COMMAND...
    word=$1
    what=$2
    shift 2
    "$@" >/dev/null || (missing "$word" "$what") || bad=1
}
data=${GRIP_DATA:-../shared/data}
for folder in biotac_slide fabricslide learning stylus_accel_1k surfcom_profiles; do
    need data "recordings, $data/$folder" test -d "$data/$folder"
done
need pip "the Python environment of scripts/python.sh" scripts/python.sh
for tool in c++ openssl; do need "$tool" "$tool" command -v "$tool"; done
need node "Node.js with npm" sh -c "command -v node && command -v npm"
need dpkg dpkg command -v dpkg-deb
need systemd systemd-analyze command -v systemd-analyze
need udevadm "udevadm verify (systemd 254)" sh -c "udevadm verify --help 2>&1"
for tool in cc make nm objdump python3; do need - "$tool" command -v "$tool"; done
exit "$bad"
