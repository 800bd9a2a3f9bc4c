#!/usr/bin/env bash
# Builds everything of a release into one folder: programs (without libraries of the system, but for the window), Debian packages, the Python
# wheel, crates, the C library, the Arduino library, the firmware of an RP2040, a list of parts (CycloneDX) of each, README.md with the first
# commands for each, and checksums of all.
#
#   scripts/release.sh FOLDER            of a clean checkout whose version CHANGELOG.md names with a date
#   scripts/release.sh --draft FOLDER    of any
#   scripts/release.sh --check FOLDER    looks into a finished folder
#
# Nothing is uploaded. Needs what scripts/deb.sh, scripts/rp2040-check.sh and scripts/python.sh need, and installs musl-tools and cargo-cyclonedx
# where they are missing. GRIP_ALLOW_MISSING: pip, dpkg.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/missing.sh
root=$PWD
fail() { printf 'release: %s\n' "$1" >&2; exit 1; }
step() { printf 'release: %s (%s s)\n' "$1" "$SECONDS"; }
mode=release
case "${1:-}" in --draft | --check) mode=${1#--}; shift ;; esac
[ $# = 1 ] || fail "usage: scripts/release.sh [--draft | --check] FOLDER"
folder=$(realpath -m "$1")
version=$(cargo metadata --locked --no-deps --format-version 1 | python3 -c '
import json, sys
print(next(p["version"] for p in json.load(sys.stdin)["packages"] if p["name"] == "gripd"))')
host=$(rustc -vV | sed -n 's/^host: //p')
arch=${host%%-*}
programs=grip-$version-$arch-linux-static
monitor=gripmon-$version-$arch-linux
library=libslip-$version-$arch-linux

check() {
    cd "$folder"
    sha256sum --quiet --strict --check SHA256SUMS
    # Every file but the sums has one.
    [ "$(find . -type f ! -name SHA256SUMS | wc -l)" = "$(wc -l <SHA256SUMS)" ] || fail "files without a checksum"
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    tar -xzf "$programs.tar.gz" -C "$work"
    for program in gripd gripctl gripfleet; do
        file=$work/$programs/bin/$program
        [ "$("$file" --version)" = "$program $version" ] || fail "$program is not of version $version"
        if grep -q NEEDED <<<"$(readelf --dynamic "$file")"; then fail "$program needs libraries of the system"; fi
    done
    "$work/$programs/bin/gripctl" demo >/dev/null || fail "gripctl demo does not run"
    tar -xzf "$monitor.tar.gz" -C "$work"
    for program in gripmon gripmon-fleet; do
        [ "$("$work/$monitor/bin/$program" --version)" = "$program $version" ] || fail "$program is not of version $version"
    done
    tar -xzf "$library.tar.gz" -C "$work"
    [ -s "$work/$library/include/slip.h" ] || fail "no header of the C library"
    python3 -m zipfile -e GripLink.zip "$work"
    for name in "$programs" "$monitor" "$library" GripLink; do
        python3 "$root/scripts/doc-links.py" "$work/$name" || fail "$name: dead links"
    done
    for name in README.md GripLink.zip slip-rp2040.uf2 slip-core-"$version".crate; do
        [ -s "$name" ] || fail "no $name"
    done
    for name in slip-rp2040.uf2 slip-rp2040-adxl345.uf2; do
        [ "$(head -c 3 "$name")" = UF2 ] || fail "$name is no UF2"
    done
    python3 - "$version" <<'PY'
import json, pathlib, sys
for program in ["gripd", "gripctl", "gripfleet", "gripmon", "gripmon-fleet", "slip-ffi", "slipgrip-python"]:
    parts = json.loads(pathlib.Path(f"{program}.cdx.json").read_text())
    whole = parts["metadata"]["component"]
    assert (whole["name"], whole["version"]) == (program, sys.argv[1]), (program, whole["name"], whole["version"])
    assert all(part.get("licenses") for part in parts["components"]), f"{program}: a part without a licence"
    assert "slip-core" in {part["name"] for part in parts["components"]}, f"{program}: slip-core is no part of it"
    assert "file:///" not in json.dumps(parts), f"{program}: a path of the machine"
PY
    step "$(wc -l <SHA256SUMS) files of version $version in $folder are whole"
}
if [ "$mode" = check ]; then
    check
    exit 0
fi

if [ "$mode" = release ]; then
    [ -z "$(git status --porcelain)" ] || fail "the checkout is changed; --draft builds it all the same"
    grep -qE "^## \\[$version\\] - [0-9]{4}-[0-9]{2}-[0-9]{2}$" CHANGELOG.md ||
        fail "CHANGELOG.md has no '## [$version] - YYYY-MM-DD' (CONTRIBUTING.md, \"Releases\"); --draft builds it all the same"
fi
[ ! -e "$folder" ] || fail "$folder is there already"
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
export CARGO_TARGET_DIR=$target
PATH=$PATH:$target/tools/bin
mkdir -p "$folder"

step "programs without libraries of the system"
static=$arch-unknown-linux-musl
rustup target add "$static" 2>/dev/null || fail "missing: Rust's library for $static, which rustup adds"
command -v musl-gcc >/dev/null || install_packages musl-tools
cargo build --release --locked --target "$static" -p gripd -p gripctl
(cd fleet && cargo build --release --locked --target "$static" -p gripfleet)
step "programs for this system"
cargo build --release --locked -p gripd -p gripctl -p gripmon
(cd fleet && cargo build --release --locked -p gripfleet -p gripmon-fleet)
cargo run --quiet -p grip-manuals -- "$target/release-manuals"
(cd fleet && cargo run --quiet -p fleet-manuals -- "$target/release-manuals")

# FOLDER: pages with what they link to, and what stands in bin; NAME.tar.gz of it
pack() {
    python3 scripts/doc-links.py --linked | xargs git ls-files -z -co --exclude-standard -- '*.md' LICENSE-MIT |
        tar -c --null -T - | tar -x -C "$target/$1"
    tar -czf "$folder/$1.tar.gz" --owner=0 --group=0 --sort=name -C "$target" "$1"
}
rm -rf "${target:?}/$programs" "${target:?}/$monitor" "${target:?}/$library"
mkdir -p "$target/$programs/bin" "$target/$monitor/bin"
cp "$target/$static/release/"{gripd,gripctl,gripfleet} "$target/$programs/bin/"
cp -R "$target/release-manuals/." docs/gripd.toml "$target/$programs/"
pack "$programs"
cp "$target/release/"{gripmon,gripmon-fleet} "$target/$monitor/bin/"
pack "$monitor"

step "C library, Arduino library"
scripts/c-library.sh "$target/$library"
pack "$library"
scripts/arduino-library.sh "$target/release-arduino"
cp "$target/release-arduino/GripLink.zip" "$folder/"

step "Debian packages"
if command -v dpkg-deb >/dev/null; then scripts/deb.sh "$folder"; else missing dpkg dpkg; fi

step "crates"
scripts/package-check.sh
cp "$target/package/"*-"$version".crate "$folder/"

step "Python wheel"
if python=$(scripts/python.sh); then
    (cd bindings/python && "$python" -m maturin build --release --locked --quiet --out "$folder")
else
    missing pip "the packages of scripts/python.sh"
fi

step "firmware of an RP2040"
scripts/rp2040-check.sh --build
cp "$target/rp2040/slip.uf2" "$folder/slip-rp2040.uf2"
cp "$target/rp2040/slip-adxl345.uf2" "$folder/slip-rp2040-adxl345.uf2"

step "lists of parts"
command -v cargo-cyclonedx >/dev/null || cargo install cargo-cyclonedx --version 0.5.7 --locked --debug --root "$target/tools"
# It writes beside each manifest: into a copy.
copy=$target/release-source
rm -rf "$copy"
mkdir -p "$copy"
git ls-files -z -co --exclude-standard | tar -c --null -T - | tar -x -C "$copy"
parts() { cargo cyclonedx --quiet --manifest-path "$copy/$1/Cargo.toml" --format json --spec-version 1.5 --target "$host"; }
parts bins/gripd
parts bindings/python
parts fleet/gripfleet
for file in "$copy"/bins/{gripd,gripctl,gripmon}/*.cdx.json "$copy"/fleet/{gripfleet,gripmon-fleet}/*.cdx.json "$copy/crates/slip-ffi/slip-ffi.cdx.json" "$copy"/bindings/python/*.cdx.json; do
    sed "s|file://$copy/||g" "$file" >"$folder/${file##*/}"
done

python3 scripts/release-page.py "$folder" "$version" "$arch" "$target/release/gripmon"
(cd "$folder" && find . -type f ! -name SHA256SUMS -printf '%P\n' | LC_ALL=C sort | xargs -d '\n' sha256sum >SHA256SUMS)
check
