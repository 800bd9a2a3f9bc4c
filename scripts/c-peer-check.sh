#!/bin/sh
# The C device side: built with every warning and with sanitizers, read against the vectors, compared with the Rust
# device on random scripts and damaged streams. firmware-check.sh compiles it for a Cortex-M4.
# Needs: cc, c++, make, cargo. Usage: scripts/c-peer-check.sh
set -eu
cd "$(dirname "$0")/.."
. scripts/missing.sh
build=${CARGO_TARGET_DIR:-target}/c-peer
mkdir -p "$build"
build=$(cd "$build" && pwd)
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=0}

make -s -C protocol/c/test BUILD="$build" check
printf 'device beef:0 41542b474341500d00\n' | "$build/peer" decode | grep -qx 'cobs gap=0 garbage=8'
GRIP_C_FLAGS='-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all' cargo test -q -p grip-link --test peers

warnings='-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror'
for option in -DGL_KEPT_BATCHES=1 '-DGL_BATCH_BYTES=64 -DGL_CHANNELS=3 -DGL_KEPT_BATCHES=2'; do
  # shellcheck disable=SC2086 # the options are words
  cc $warnings $option -O2 -c protocol/c/grip_link.c -o "$build/small.o"
done
if command -v c++ >/dev/null; then
  echo '#include "grip_link.h"' | c++ -std=c++11 -Wall -Wextra -Werror -Iprotocol/c -fsyntax-only -x c++ -
else
  missing c++ 'c++: the header is not compiled as C++'
fi
