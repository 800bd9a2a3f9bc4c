#!/bin/sh
# Builds the C library and installs it: header, shared and static library, files for pkg-config and CMake.
#
#   scripts/c-library.sh FOLDER [PROFILE]      PROFILE is release, or dev for a quicker look
set -eu
cd "$(dirname "$0")/.."
folder=${1:?usage: scripts/c-library.sh FOLDER [PROFILE]}
profile=${2:-release}
built=${CARGO_TARGET_DIR:-target}/$([ "$profile" = dev ] && echo debug || echo "$profile")
cargo build --quiet --locked --profile "$profile" -p slip-ffi
mkdir -p "$folder/include" "$folder/lib/pkgconfig" "$folder/lib/cmake/slip"
cp crates/slip-ffi/include/slip.h "$folder/include/"
cp "$built/libslip.a" "$folder/lib/"
cp "$built/libslip.so" "$folder/lib/libslip.so.0"
ln -sf libslip.so.0 "$folder/lib/libslip.so"
cp packaging/c/slip.pc "$folder/lib/pkgconfig/"
cp packaging/c/*.cmake "$folder/lib/cmake/slip/"
