# The main job on the built-in simulator.
run:
    cargo run --release -p gripd -- --port sim --duration 10

# The monitor with the built-in simulator.
monitor:
    cargo run --release -p gripmon -- --demo

# Formatting, lints and tests of what differs from HEAD, and the tests of the heart.
quick:
    scripts/quick.sh

# All tests.
test:
    cargo test --workspace

# Formatting, pages, lints and documentation, as CI checks them.
check:
    cargo fmt --all --check
    scripts/doc-links.py
    cargo clippy --workspace --all-targets --all-features -- -D warnings
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --all-features

# Benches and the latency check.
bench:
    cargo bench --workspace

# A hundred simulated grasps.
grasp:
    cargo run --release -p gripctl -- grasp --trials 100

# What must be green before a change lands.
ci:
    bash .ci/run

# That, and what takes longer.
ci-all:
    bash .ci/run all
