#!/bin/sh
# What the no_std pipeline costs on a Cortex-M4: builds benches/mcu for thumbv7em and runs it in QEMU. Prints code size, RAM and
# instructions per sample and per inference. Installs Debian's Rust with its sources (a download of 170 MB), lld and QEMU
# where they are missing; rustup's compiler cannot serve, because its core for this target is not at hand.
# mcu-cost.sh [OPT-LEVEL ...]: 3 and s where none is named.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
target=${CARGO_TARGET_DIR:-$root/target}/mcu
mkdir -p "$target"
target=$(cd "$target" && pwd)

missing=
command -v qemu-system-arm >/dev/null || missing="qemu-system-arm"
command -v arm-none-eabi-size >/dev/null || missing="$missing binutils-arm-none-eabi"
# shellcheck disable=SC2086 # a list of packages
[ -z "$missing" ] || install_packages $missing
second_compiler

elf=$target/thumbv7em-none-eabihf/release/mcu-cost
build() {
    (cd "$root/benches/mcu" && CARGO_TARGET_DIR="$target" CARGO_PROFILE_RELEASE_OPT_LEVEL="$opt" \
        core_from_source build --release --locked --quiet "$@")
}
text() { arm-none-eabi-size "$elf" | awk 'NR == 2 { print $1 + $2 }'; }

emulator=
trap '[ -z "$emulator" ] || kill "$emulator" 2>/dev/null || true' EXIT
trap 'exit 1' INT TERM
run() {
    out=$target/out.txt
    : >"$out"
    # One instruction takes one nanosecond: the counts are the same on every machine.
    qemu-system-arm -M mps2-an386 -display none -monitor none -nodefaults -serial "file:$out" -icount shift=0 -kernel "$elf" 2>"$target/qemu.txt" &
    emulator=$!
    waited=0
    until grep -q '^done\|^failed' "$out"; do
        kill -0 "$emulator" 2>/dev/null || { cat "$target/qemu.txt" >&2; exit 1; }
        [ "$waited" -lt 60 ] || { echo "mcu-cost: no result within 60 s" >&2; exit 1; }
        waited=$((waited + 1))
        sleep 1
    done
    kill "$emulator" 2>/dev/null || true
    wait "$emulator" 2>/dev/null || true
    emulator=
    grep -v '^done' "$out"
    ! grep -q '^failed' "$out"
}

[ $# -gt 0 ] || set -- 3 s
for opt in "$@"; do
    build --no-default-features
    frame=$(text)
    build --no-default-features --features network
    network=$(text)
    build
    echo "opt-level $opt: flash for network and model $((network - frame)) bytes, for pipeline, network and model $(($(text) - frame)) bytes" \
        "(frame of the program taken off)"
    run
done
# An RP2350's cores, for which there is no firmware: it compiles.
(cd "$root" && CARGO_TARGET_DIR="$target" core_from_source check --locked --quiet -p slip-core --no-default-features --target thumbv8m.main-none-eabihf)
echo "slip-core compiles for thumbv8m.main-none-eabihf"
