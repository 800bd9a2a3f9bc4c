#!/bin/sh
# Builds the C device side with the system compiler, warnings as errors and sanitizers, and lets it read the vectors.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
build=${CARGO_TARGET_DIR:-$root/target}/c-peer
make -C "$root/protocol/c/test" BUILD="$build" check
