#!/bin/sh
# Builds every release program, bench and example that the checks need, at once: another choice of packages or kinds would compile what they
# share again, with other features.
set -eu
cd "$(dirname "$0")/.."
exec cargo build --release --locked -p gripd -p gripctl -p slip-benches -p grip-daemon --bins --benches --examples
