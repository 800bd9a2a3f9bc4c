#!/bin/sh
# What no default build contains: the fleet with a real router, gripd and gripctl beside one; and that the default programs know nothing
# of it. About 160 more crates are compiled.
set -eu
cd "$(dirname "$0")/.."

tree=$(cargo tree --locked -p gripd -p gripctl -e normal --prefix none)
if echo "$tree" | grep -E "^(zenoh|grip-fleet|tokio) "; then
    echo "a default gripd or gripctl contains the fleet" >&2
    exit 1
fi
cargo test --locked -p grip-fleet --features zenoh
# Also models: tests/deploy.rs and fleet_models.rs.
cargo test --locked -p gripd --features fleet --test daemon fleet
cargo test --locked -p gripctl --features fleet --test cli fleet
