# The main job on the built-in simulator.
run:
    cargo run --release -p gripd -- --port sim --duration 10

# The monitor with the built-in simulator.
monitor:
    cargo run --release -p gripmon -- --demo

# All tests.
test:
    cargo test --workspace

# Formatting, pages, lints and documentation, as CI checks them.
check:
    cargo fmt --all --check
    scripts/doc-links.py
    cargo clippy --workspace --all-targets --features mlp/export,mlp-core/file,grip-link/small-table,slip-core/serde,grip-fleet/zenoh,grip-fleet/foxglove,grip-scope/zenoh,gripd/fleet,gripctl/fleet,gripctl/foxglove,gripmon/fleet,stories/fleet -- -D warnings
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# Benches and the latency check.
bench:
    cargo bench --workspace

# A hundred simulated grasps.
grasp:
    cargo run --release -p gripctl -- grasp --trials 100

# Everything CI runs.
ci:
    bash .ci/run
