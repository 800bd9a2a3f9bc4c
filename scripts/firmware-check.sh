#!/bin/sh
# Builds the bare-metal firmware, runs it in QEMU and lets the real gripd hold the object through it; then breaks the host,
# the line and the firmware, and looks at the force. Installs the cross compiler and QEMU (Debian) where they are missing.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
target=${CARGO_TARGET_DIR:-$root/target}
build=$target/firmware

missing=
command -v arm-none-eabi-gcc >/dev/null || missing="gcc-arm-none-eabi"
command -v qemu-system-arm >/dev/null || missing="$missing qemu-system-arm"
# shellcheck disable=SC2086 # a list of packages
[ -z "$missing" ] || install_packages $missing

firmware() { make -s -C "$root/protocol/firmware" "$@"; }
rm -rf "$build"
for opt in -Os -O2; do
    firmware BUILD="$build/product$opt" OPT=$opt BENCH=0
    firmware BUILD="$build/bench$opt" OPT=$opt
done
echo "flash is text + data, RAM is data + bss, without the stack; bench is the firmware that is tested, product has no test bench:"
(cd "$build" && arm-none-eabi-size product-Os/firmware.elf product-O2/firmware.elf bench-Os/firmware.elf bench-O2/firmware.elf)

# What the library costs.
chip="-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -ffreestanding -I$root/protocol/firmware/include -I$root/protocol/c"
cost() {
    # shellcheck disable=SC2086 # lists of flags
    for opt in -Os -O2; do
        arm-none-eabi-gcc -std=c99 $chip "$@" $opt -ffunction-sections -c -o "$build/link$opt.o" "$root/protocol/c/grip_link.c"
    done
    if arm-none-eabi-nm -u "$build/link-O2.o" | grep -vE '__aeabi_u?ldivmod|memcpy|memset'; then
        echo 'more of libc than memcpy and memset is needed' >&2
        exit 1
    fi
    # shellcheck disable=SC2086
    arm-none-eabi-gcc -std=c99 $chip "$@" -c -o "$build/sizes.o" "$root/protocol/c/test/sizes.c"
    flash=$(arm-none-eabi-size "$build/link-Os.o" "$build/link-O2.o" | awk 'NR > 1 { printf "%s ", $1 + $2 }')
    ram=$(arm-none-eabi-nm -S -t d "$build/sizes.o" | awk '{ printf "%s %d, ", $4, $2 }')
    echo "grip_link.c ${*:-default}: flash -Os, -O2: $flash; RAM: $ram"
}
cost
cost -DGL_CHANNELS=3
cost -DGL_KEPT_BATCHES=1
cost -DGL_CHANNELS=3 -DGL_KEPT_BATCHES=1 -DGL_BATCH_BYTES=64
cost -DGL_CHANNELS=1 -DGL_KEPT_BATCHES=1 -DGL_BATCH_BYTES=20

"$root/scripts/release-build.sh"
# check.py ends QEMU and gripd, whatever happens; the trap ends check.py.
PYTHONDONTWRITEBYTECODE=1 python3 "$root/protocol/firmware/test/check.py" \
    --firmware "$build/bench-O2/firmware.elf" --gripd "$target/release/gripd" &
check=$!
trap 'kill "$check" 2>/dev/null || true' EXIT
trap 'exit 1' INT TERM
wait "$check"
