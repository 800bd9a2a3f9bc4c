#!/bin/sh
# Builds slip-core, mlp-core and grip-link against a sysroot that holds core and nothing else, and fails where std, alloc or
# any symbol but the five memory functions of a C runtime is needed. Then lists the calls from which a panic can be
# reached. `--strict` fails on those too.
set -eu

strict=false
[ "${1:-}" = "--strict" ] && strict=true

root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}/no-std
mkdir -p "$target"
target=$(cd "$target" && pwd)
host=$(rustc -vV | sed -n 's/^host: //p')
full=$(rustc --print sysroot)/lib/rustlib/$host
bare=$target/sysroot/lib/rustlib/$host

rm -rf "$target/sysroot"
mkdir -p "$bare/lib"
[ ! -d "$full/bin" ] || ln -s "$full/bin" "$bare/bin"
for crate in core compiler_builtins; do
    ln -s "$full/lib/lib$crate-"* "$bare/lib/"
done

# With a target named, build scripts and derive macros still get the whole sysroot.
build() {
    (cd "$root/benches/no-std-check" &&
        RUSTFLAGS="--sysroot $target/sysroot -C link-arg=-nostdlib -C link-arg=-nostartfiles" \
            CARGO_TARGET_DIR="$target" cargo build --release --locked --target "$host" "$@")
}

# The check is worth something only if it can fail.
for missing in std alloc; do
    if said=$(build --features "with-$missing" 2>&1); then
        echo "no-std-check: a crate that needs $missing was linked" >&2
        exit 1
    fi
    case $said in
    *"can't find crate for \`$missing\`"*) ;;
    *)
        printf '%s\nno-std-check: the build failed, but not for want of %s\n' "$said" "$missing" >&2
        exit 1
        ;;
    esac
done

build
linked=$target/$host/release/libno_std_check.so

for tool in nm objdump; do
    command -v "$tool" >/dev/null || { echo "no-std-check: missing: $tool (Debian: binutils)" >&2; exit 1; }
done
names=$(nm --dynamic --undefined-only "$linked")
foreign=$(printf '%s\n' "$names" | awk '{ print $NF }' |
    grep -vxE '(memcpy|memmove|memset|memcmp|bcmp)(@.*)?' || true)
symbols=$(nm "$linked")
hidden=$(printf '%s\n' "$symbols" | grep -E '__rust_(alloc|dealloc|realloc)|__rg_|_ZN3std|_ZN5alloc|_RNv.*C(3std|5alloc)' || true)
if [ -n "$foreign$hidden" ]; then
    printf 'no-std-check: these symbols are not of core:\n%s\n%s\n' "$foreign" "$hidden" >&2
    exit 1
fi
echo "no-std-check: slip-core, mlp-core and grip-link link with core alone"

# Which of the exported functions reach core::panicking through direct calls and jumps?
exported=$(nm --dynamic --defined-only "$linked" | awk '$2 == "T" { print $3 }')
[ "$(echo "$exported" | wc -w)" -gt 10 ] || { echo "no-std-check: hardly a function is exported" >&2; exit 1; }
objdump --disassemble --demangle --no-show-raw-insn "$linked" >"$target/listing.txt"
panics=$(awk -v exported="$exported" -f "$root/scripts/panic-paths.awk" "$target/listing.txt")
if [ -n "$panics" ]; then
    printf 'no-std-check: a panic can be reached from\n%s\n' "$panics"
    ! $strict
else
    echo "no-std-check: no panic can be reached from $(echo "$exported" | wc -w) functions"
fi
