#!/bin/sh
# The detector as firmware of an RP2040: builds it into a UF2, and runs that in an emulator (rp2040js) with slips on its sensor. What comes
# back over the emulated USB port must be what the same detector finds on this computer.
#
#   rp2040-check.sh               everything; --recordings N takes N fingertip recordings (2)
#   rp2040-check.sh --build       only target/rp2040/slip.uf2 (piezo) and slip-adxl345.uf2
#
# Needs Rust's core for thumbv6m-none-eabi, which rustup adds; where it cannot, Debian's compiler builds it, and is installed. Needs Python 3 and
# Node.js with npm. GRIP_ALLOW_MISSING: node, data.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/rp2040"
target=$(cd "$target" && pwd)
work=$target/rp2040
only_build=
most=2
while [ $# -gt 0 ]; do
    case "$1" in
    --build) only_build=1 ;;
    --recordings) most=$2; shift ;;
    *) echo "rp2040-check: unknown argument $1" >&2; exit 2 ;;
    esac
    shift
done

cd "$root/protocol/firmware/rp2040"
triple=thumbv6m-none-eabi
core=$(rustc --print sysroot)/lib/rustlib/$triple
[ -d "$core" ] || { command -v rustup >/dev/null && rustup target add "$triple" >&2; } || true

# No flag of the caller may leak in. What was built before counts only where this build succeeds.
rm -f "$work/slip.uf2" "$work/slip-adxl345.uf2"
firmware() { # FEATURE NAME
    name=$2
    set -- build --release --locked --quiet --features "$1" --target "$triple"
    if [ -d "$core" ]; then
        env -u RUSTFLAGS CARGO_TARGET_DIR="$work" cargo "$@"
    else
        second_compiler
        CARGO_TARGET_DIR="$work" core_from_source "$@"
    fi
    cp "$work/$triple/release/slip-rp2040" "$work/$name.elf"
    python3 test/uf2.py "$work/$name.elf" "$work/$name.uf2"
}
firmware board slip
firmware adxl345 slip-adxl345
[ -z "$only_build" ] || exit 0

cargo fmt --check
"$root/scripts/deny.sh" protocol/firmware/rp2040
# That file needs no other, and no link-time optimization, which would take a minute.
rustc --edition 2024 -O --test src/float.rs -o "$work/float"
"$work/float" --quiet
env -u RUSTFLAGS CARGO_TARGET_DIR="$work" cargo test --locked --quiet --test faults
env -u RUSTFLAGS CARGO_TARGET_DIR="$work" cargo build --release --locked --quiet --example host

command -v node >/dev/null && command -v npm >/dev/null || { missing node "Node.js with npm: the firmware is not run"; exit 0; }
[ -d "$work/node_modules/rp2040js" ] || npm install --silent --no-save --no-audit --no-fund --prefix "$work" rp2040js@1.4.1 >&2
set -- --modules "$work/node_modules" --host "$work/release/examples/host"
recordings=${GRIP_DATA:-$root/../shared/data}/biotac_slide
if [ -f "$recordings/labels.csv" ]; then
    set -- "$@" --recordings "$recordings" --most "$most"
else
    missing data "$recordings: simulated signals only"
fi
echo "piezo"
python3 test/check.py --uf2 "$work/slip.uf2" --work "$work/run" "$@"
echo "ADXL345"
python3 test/check.py --adxl345 --uf2 "$work/slip-adxl345.uf2" --work "$work/run-adxl345" "$@"
