#!/bin/sh
# Counts the instructions of hot functions, and fails where one takes 3 % more than benches/instructions.toml says; --write writes that file.
# Installs valgrind where it is missing.
set -eu
cd "$(dirname "$0")/.."
. scripts/missing.sh
command -v valgrind >/dev/null || install_packages valgrind
scripts/release-build.sh
exec python3 scripts/instructions.py "$@"
