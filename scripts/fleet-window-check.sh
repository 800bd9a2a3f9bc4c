#!/bin/sh
# The table of many grippers in gripmon, over a real router. Not part of .ci/run, which compiles and lints it: windows and network together
# are some five minutes of compiling more.
set -eu
cd "$(dirname "$0")/.."
cargo test --locked -p grip-scope -p gripmon --features grip-scope/zenoh,gripmon/fleet fleet
