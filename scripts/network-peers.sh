#!/bin/sh
# Trains and runs the same networks on the same rows from the same weights with our crate and with FANN (Debian's
# libfann-dev, installed if it is missing), on this machine, one after the other, and prints times and ratios.
# --gate fails where a ratio to FANN is below its bound.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
target=${CARGO_TARGET_DIR:-$root/target}
peers=$target/network-peers
mkdir -p "$peers"

[ -f /usr/include/fann.h ] || install_packages libfann-dev gcc libc6-dev
cc -std=c99 -D_POSIX_C_SOURCE=199309L -O2 -Wall -Wextra -Werror -o "$peers/fann" "$root/scripts/peers/fann.c" -lfann -lm

"$root/scripts/release-build.sh"
measure() {
    "$target/release/network-peers" "$peers" >"$peers/ours.tsv"
    "$peers/fann" "$peers" >"$peers/theirs.tsv"
}
if [ "${1:-}" = "--gate" ]; then
    # Another load on the machine slows one side at a time: three runs, one of which must do.
    for _ in 1 2 3; do
        measure
        python3 "$root/scripts/peers/ratios.py" --gate "$peers/ours.tsv" "$peers/theirs.tsv" && exit 0
    done
    exit 1
fi
measure
sed -n 's/^model name[^:]*: /machine: /p' /proc/cpuinfo | sort -u
python3 "$root/scripts/peers/ratios.py" "$peers/ours.tsv" "$peers/theirs.tsv"
