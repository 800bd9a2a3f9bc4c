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
# Of the static library what slip_* needs, and no other name: it stands beside an LZ4 and a Rust library of the program.
# The bitcode of Rust's own library, pieced together, would stop tools that read it.
names=$(nm -D --defined-only "$built/libslip.so" | sed -n 's/.* \(slip_.*\)/-u \1/p')
# shellcheck disable=SC2086 # options
ld -r --gc-sections $names "$built/libslip.a" -o "$folder/lib/slip.o"
objcopy --wildcard --keep-global-symbol='slip_*' --remove-section .llvmbc --remove-section .llvmcmd "$folder/lib/slip.o"
rm -f "$folder/lib/libslip.a"
ar rc "$folder/lib/libslip.a" "$folder/lib/slip.o"
rm "$folder/lib/slip.o"
cp "$built/libslip.so" "$folder/lib/libslip.so.0"
ln -sf libslip.so.0 "$folder/lib/libslip.so"
cp packaging/c/slip.pc "$folder/lib/pkgconfig/"
cp packaging/c/*.cmake "$folder/lib/cmake/slip/"
