#!/bin/sh
# Between two edits: formatting, lints and tests of the packages that differ from REV (HEAD by default), and tests of the heart.
# quick.sh [REV]
set -eu
cd "$(dirname "$0")/.."
git rev-parse --quiet --verify "${1:-HEAD}^{commit}" >/dev/null || { echo "usage: quick.sh [REV]; no revision ${1:-HEAD}" >&2; exit 2; }
heart="slip-msg mlp-core slip-core grip-link grip-session"

changed=$({ git diff --name-only "${1:-HEAD}"; git ls-files --others --exclude-standard; } | while read -r file; do
    folder=$(dirname "$file")
    until [ -f "$folder/Cargo.toml" ]; do folder=$(dirname "$folder"); done
    # The root and workspaces of their own have no package here.
    [ "$folder" = . ] || grep -q '^\[workspace\]' "$folder/Cargo.toml" || sed -n 's/^name = "\(.*\)"/\1/p;/^name/q' "$folder/Cargo.toml"
done | sort -u)

packages() { for package in "$@"; do printf ' -p %s' "$package"; done; }
cargo fmt --all --check
# shellcheck disable=SC2046,SC2086 # lists of words
[ -z "$changed" ] || cargo clippy $(packages $changed) --all-targets -- -D warnings
# shellcheck disable=SC2046,SC2086
cargo test --quiet --no-fail-fast $(packages $heart $(printf '%s\n' $changed | grep -vxF "$(printf '%s\n' $heart)"))
