#!/usr/bin/env bash
# Measures the workspace as a building: lines by kind and package, constants of slip-core, gripd's closure, dependency edges
# that point up, circles between folders. Says in each heading how it is counted.
# Fails where a crate has no floor, an edge points up, or folders import each other. Needs Python 3.9 and cargo; builds nothing.
set -euo pipefail
cd "$(dirname "$0")/.."
metadata=$(mktemp)
trap 'rm -f "$metadata"' EXIT
cargo metadata --locked --offline --no-deps --format-version 1 >"$metadata" 2>/dev/null ||
    cargo metadata --locked --no-deps --format-version 1 >"$metadata"
export GRIPD_CLOSURE
GRIPD_CLOSURE=$(cargo tree --locked -p gripd -e normal,build --prefix none --format '{p}' | sed 's/ (\*)$//' | sort -u)
python3 scripts/house.py "$metadata"
