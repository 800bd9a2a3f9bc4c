#!/bin/sh
# A web page in Chromium that attacks gripd: nothing of what it sends is carried out. Installs Debian's chromium where it is missing.
# GRIPD names a built program.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
python_work browser-check
if ! command -v chromium >/dev/null && ! (install_packages chromium); then
    missing chromium "Chromium"
    exit 0
fi

if [ -z "${GRIPD:-}" ]; then
    (cd "$root" && CARGO_TARGET_DIR="$target" cargo build --locked -p gripd)
    GRIPD=$target/debug/gripd
fi
rm -rf "$work/files"
mkdir -p "$work/files"
PYTHONPATH="$root/protocol/python/src" "$python" "$root/scripts/peers/browser_check.py" "$GRIPD" "$work/files"
