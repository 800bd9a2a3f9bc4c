#!/bin/sh
# The table of many grippers in gripmon's window. Not part of .ci/run, which compiles and lints it and tests what fills it: windows and network
# together are some three minutes of compiling more.
set -eu
cd "$(dirname "$0")/.."
cargo test --locked -p gripmon --features gripmon/fleet fleet
