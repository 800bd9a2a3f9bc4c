#!/usr/bin/env bash
# What docs/rows.md shows, run as it stands there: rows from Python over a pipe and from C++ over TCP, and the slips that come back.
#
#   scripts/rows-check.sh [PROFILE]      PROFILE is release, or dev for a quicker look
#
# Needs python3 and c++.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/missing.sh
profile=${1:-release}
target=${CARGO_TARGET_DIR:-target}
command -v c++ >/dev/null || { missing c++ 'c++: rows from C++ are not checked'; exit 0; }

if [ "$profile" = release ]; then scripts/release-build.sh; else cargo build --locked -q --profile "$profile" -p gripd; fi
mkdir -p "$target/rows-check"
work=$(cd "$target/rows-check" && pwd)
find "$work" -mindepth 1 -delete
programs=$(cd "$target/${profile/#dev/debug}" && pwd)
cp docs/examples/slips.cpp "$work"
python3 scripts/doc-blocks.py docs/rows.md >"$work/page.sh"
(cd "$work" && env PATH="$programs:$PATH" WORK="$work" bash page.sh)
# The rows of the page, and every row of the programs.
{ cat "$work/first.csv" && sleep 1; } | "$programs/gripd" --sensor rows:- --listen off --json 2>/dev/null | tail -1 |
    grep -q '"rows":{"taken":2,"bad":0,"late":0,"missing":0}'
tail -1 "$work/gripd.json" | grep -q '"rows":{"taken":3200,"bad":0,"late":0,"missing":0}'
python3 -c 'import json, sys; [json.loads(line) for line in open(sys.argv[1])]' "$work/slip.json"
PATH="$programs:$PATH" scripts/bridge-check.py
echo "rows-check: done"
