#!/bin/sh
# Builds the bare-metal firmware, runs it in QEMU and lets the real gripd hold the object through it; then breaks the host,
# the line and the firmware, and looks at the force. Installs the cross compiler and QEMU (Debian) where they are missing.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
build=$target/firmware

missing=
command -v arm-none-eabi-gcc >/dev/null || missing="gcc-arm-none-eabi"
command -v qemu-system-arm >/dev/null || missing="$missing qemu-system-arm"
if [ -n "$missing" ]; then
    command -v apt-get >/dev/null || { echo "firmware-check: install $missing first; there is no apt-get here" >&2; exit 1; }
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || { echo "firmware-check: install $missing first; that needs root or sudo" >&2; exit 1; }
        as_root="sudo"
    fi
    $as_root apt-get update -q
    # shellcheck disable=SC2086 # a list of packages
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
fi

firmware() { make -s -C "$root/protocol/firmware" "$@"; }
rm -rf "$build"
for opt in -Os -O2; do
    firmware BUILD="$build/product$opt" OPT=$opt BENCH=0
    firmware BUILD="$build/bench$opt" OPT=$opt
done
echo "flash is text + data, RAM is data + bss, without the stack; bench is the firmware that is tested, product has no test bench:"
(cd "$build" && arm-none-eabi-size product-Os/firmware.elf product-O2/firmware.elf bench-Os/firmware.elf bench-O2/firmware.elf)

(cd "$root" && cargo build --release -p gripd)
# check.py ends QEMU and gripd, whatever happens; the trap ends check.py.
PYTHONDONTWRITEBYTECODE=1 python3 "$root/protocol/firmware/test/check.py" \
    --firmware "$build/bench-O2/firmware.elf" --gripd "$target/release/gripd" &
check=$!
trap 'kill "$check" 2>/dev/null || true' EXIT
trap 'exit 1' INT TERM
wait "$check"
