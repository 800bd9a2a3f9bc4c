#!/usr/bin/env bash
# The C library: its header as C99 and C++17, examples under ASan and valgrind, random calls, what docs/c.md shows, and
# the same slips as gripctl.
#
#   scripts/c-library-check.sh [PROFILE]      PROFILE is release, or dev for a quicker look
#
# Needs cc, c++ and, installed where they are missing, cmake, pkg-config and valgrind.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/missing.sh
profile=${1:-release}
target=${CARGO_TARGET_DIR:-target}
missing=()
for tool in cmake pkg-config valgrind; do command -v "$tool" >/dev/null || missing+=("$tool"); done
[ ${#missing[@]} = 0 ] || install_packages "${missing[@]}"
command -v c++ >/dev/null || { missing c++ 'c++: the C library is not checked'; exit 0; }

mkdir -p "$target/c-library-check"
work=$(cd "$target/c-library-check" && pwd)
find "$work" -mindepth 1 -delete
slip=$work/slip
scripts/c-library.sh "$slip" "$profile"
crate=$PWD/crates/slip-ffi
export PKG_CONFIG_PATH=$slip/lib/pkgconfig LD_LIBRARY_PATH=$slip/lib ASAN_OPTIONS=detect_leaks=0
# The version of the files that are kept by hand is that of the crate.
version=$(cargo metadata --locked --no-deps --format-version 1 | python3 -c '
import json, sys
print(next(p["version"] for p in json.load(sys.stdin)["packages"] if p["name"] == "slip-ffi"))')
[ "$(pkg-config --modversion slip)" = "$version" ]
grep -q "\"$version\"" packaging/c/slipConfigVersion.cmake
{ nm -D --defined-only "$slip/lib/libslip.so"; nm -g --defined-only "$slip/lib/libslip.a"; } |
    awk 'NF == 3 && $3 !~ /^slip_/ { print "c-library-check: exported: " $3; bad = 1 } END { exit bad }'

warnings='-Wall -Wextra -Werror -pedantic'
read -ra flags <<<"$(pkg-config --cflags slip)"
read -ra shared <<<"$(pkg-config --libs slip)"
read -ra static <<<"-L$slip/lib -l:libslip.a $(sed -n 's/^Libs.private: //p' packaging/c/slip.pc)"
c() { cc -std=c99 $warnings -g -O1 "${flags[@]}" "$@"; }
cpp() { c++ -std=c++17 $warnings -g -O1 "${flags[@]}" "$@"; }
printf '#include <slip.h>\n#include <slip.h>\n' >"$work/header.c"
c -fsyntax-only "$work/header.c"
cpp -fsyntax-only -x c++ "$work/header.c"

# The names of what is inside the static library are those of the program too.
printf '#include <slip.h>\nint %s(void) { return 0; }\n' LZ4_compress_default >"$work/names.c"
printf 'int %s(void) { return 0; }\n' rust_eh_personality XXH32 >>"$work/names.c"
echo 'int main(void) { return LZ4_compress_default() + rust_eh_personality() + XXH32() + !slip_size(); }' \
    >>"$work/names.c"
c "$work/names.c" -o "$work/names" "${static[@]}"
"$work/names"

# Versions that a program may ask of CMake, and those it may not.
mkdir "$work/versions"
cat >"$work/versions/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.16)
project(versions NONE)
foreach(version 0 0.1 0.1.0 not 0.0 0.1.99 0.2 1)
  if(version STREQUAL not)
    set(refused TRUE)
    continue()
  endif()
  find_package(slip ${version} CONFIG QUIET)
  if((slip_FOUND AND refused) OR NOT (slip_FOUND OR refused))
    message(FATAL_ERROR "find_package(slip ${version}): slip_FOUND is ${slip_FOUND}")
  endif()
endforeach()
CMAKE
cmake -S "$work/versions" -B "$work/versions/build" -DCMAKE_PREFIX_PATH="$slip" >"$work/versions/log"

sanitized='-fsanitize=address,undefined -fno-sanitize-recover=all'
# shellcheck disable=SC2086 # the options are words
for kind in plain asan; do
    options=$([ $kind = plain ] || echo "$sanitized")
    ros=fleet/ros/slip_grip_controller
    distribution=$([ $kind = plain ] && echo -DJAZZY || echo -DHUMBLE)
    c $options "$crate/examples/detect.c" -o "$work/detect-$kind" "${shared[@]}"
    cpp $options "$crate/examples/grip.cpp" -o "$work/grip-$kind" "${shared[@]}"
    cpp $options "$distribution" -I"$ros/test/mock" "$ros/src/slip_grip_controller.cpp" "$ros/test/run.cpp" -o "$work/ros-$kind" "${shared[@]}"
    c $options "$crate/tests/c/fuzz.c" -o "$work/fuzz-$kind" "${static[@]}"
done

python3 - "$work" <<'PY'
import random, sys
random.seed(3000)
with open(f"{sys.argv[1]}/slip.csv", "w") as file:
    file.write("t_s,vibration\n")
    for at in range(12000):
        deviation = 20 if 6000 < at < 7000 else 1
        file.write(f"{at / 2000:.6f},{random.gauss(0, deviation):.3f}\n")
PY
for kind in plain asan; do
    [ "$("$work/detect-$kind" 2000 <"$work/slip.csv" | grep -c 'slip (')" -ge 1 ]
    "$work/grip-$kind"
    "$work/ros-$kind"
done
valgrind='valgrind -q --leak-check=full --error-exitcode=9'
$valgrind "$work/detect-plain" 2000 <"$work/slip.csv"
$valgrind "$work/grip-plain"
$valgrind "$work/ros-plain"
if "$work/detect-plain" nan </dev/null 2>"$work/said"; then exit 1; fi
grep -q 'sample_rate_hz = NaN is outside 20 to 50000' "$work/said"
# The stack that docs/c.md names; without optimization it is more.
[ "$profile" = dev ] || (ulimit -s 600 && "$work/grip-plain")
"$work/fuzz-plain" 100000
"$work/fuzz-asan" 20000 7
$valgrind "$work/fuzz-plain" 2000 77

# The same slips at the same samples as gripctl, from C.
gripctl=${GRIPCTL:-$target/release/gripctl}
data=${GRIP_DATA:-../shared/data}
files=("$data"/biotac_slide/m??_??.csv)
if [ -d "$data/biotac_slide" ] && [ -x "$gripctl" ]; then
    slips=0
    for file in "${files[@]}"; do
        ours=$("$work/detect-plain" 2200 <"$file" |
            sed -E 's/ s  slip \((.*), (.*)\), .*/ \1 \2/; s/ s  slip (ended) .*/ \1/')
        theirs=$("$gripctl" replay "$file" --observe --rate 2200 --json 2>/dev/null |
            sed -nE 's/^\{"type":"slip","t_s":([0-9.]+),.*"phase":"([a-z]+)","method":"([a-z]+)".*/\1 \2 \3/p
                s/^\{"type":"slip_end","t_s":([0-9.]+).*/\1 ended/p' | awk '{ $1 = sprintf("%.6f", $1); print }')
        [ "$ours" = "$theirs" ] || { echo "c-library-check: other slips than gripctl: $file" >&2; exit 1; }
        slips=$((slips + $(grep -c ended <<<"$ours" || true)))
    done
    echo "c-library-check: ${#files[@]} recordings, $slips slips as those of gripctl replay"
    [ $slips -ge 100 ] || { echo "c-library-check: so few slips compare nothing" >&2; exit 1; }
else
    missing data "recordings or $gripctl: the slips are not compared with those of gripctl"
fi

scripts/doc-blocks.py docs/c.md >"$work/page.sh"
WORK=$work bash "$work/page.sh"
echo "c-library-check: done"
