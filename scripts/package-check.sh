#!/usr/bin/env bash
# Packs the crates that can be published (docs/rust.md) as `cargo publish` would, and looks into them.
#
#   scripts/package-check.sh [--verify]      with it, what was packed is built too, which takes a minute or two
set -euo pipefail
cd "$(dirname "$0")/.."
build=--no-verify
[ "${1:-}" != --verify ] || build=
packages=$(cargo metadata --locked --no-deps --format-version 1 | python3 <(cat <<'PY'
import json, sys
ours = {p["name"]: p for p in json.load(sys.stdin)["packages"] if p["publish"] is None}
for name, package in ours.items():
    for dependency in package["dependencies"]:
        if dependency.get("path") and dependency["kind"] is None:
            other = ours.get(dependency["name"])
            if not other or dependency["req"] != "^" + other["version"]:
                sys.exit(f"package-check: {name} needs {dependency['name']} {dependency['req']}, which is not what is published")
    wanted = ["description", "license", "readme", "rust_version", "documentation", "keywords", "categories"]
    if missing := [key for key in wanted if not package[key]]:
        sys.exit(f"package-check: {name} has no {', '.join(missing)}")
    if (package["metadata"] or {}).get("docs", {}).get("rs") != {"all-features": True}:
        sys.exit(f"package-check: {name} has no metadata of docs.rs")
print(" ".join(f"{name}@{package['version']}" for name, package in ours.items()))
PY
))
read -ra named <<<"$packages"
# shellcheck disable=SC2086 # no word where it is empty
cargo package --quiet --locked --allow-dirty $build "${named[@]/#/--package=}"
for package in "${named[@]}"; do
    file=${CARGO_TARGET_DIR:-target}/package/${package/@/-}.crate
    listing=$(tar -tzf "$file")
    for wanted in README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE src/lib.rs; do
        grep -q "^${package/@/-}/$wanted" <<<"$listing" || { echo "package-check: $package has no $wanted" >&2; exit 1; }
    done
    # Tests of each crate run the example on its front page.
    grep -q '^```rust' <<<"$(tar -xzOf "$file" "${package/@/-}/README.md")" ||
        { echo "package-check: the front page of $package has no example" >&2; exit 1; }
    echo "$package: $(wc -l <<<"$listing") files, $(stat -c %s "$file") bytes"
done
