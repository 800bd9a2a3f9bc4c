#!/bin/sh
# Builds every release program that the checks run, at once: another choice of packages or kinds would compile what they share again, with
# other features. Benches are compiled by clippy; linking each of them would take minutes.
set -eu
cd "$(dirname "$0")/.."
exec cargo build --release --locked -p gripd -p gripctl -p slip-benches -p grip-daemon \
    --bin gripd --bin gripctl --bin null-run --bin network-peers --bin tanh-exhaustive --bin instructions --bin daemon-soak --example recording
