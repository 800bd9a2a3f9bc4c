//! Repeatable samples, networks and link frames for benches and tests, by scene, shape or count.
//!
//! ```text
//! cargo bench -p slip-benches --bench pipeline    one sample through the pipeline, scene by scene
//! cargo bench -p slip-benches --bench latency     p50 to max beside the stated limits
//! cargo bench -p slip-benches --bench network     one forward pass
//! cargo test  -p slip-benches                     nothing is allocated on these paths; enclosures of E_sc; faults of the daemon
//! scripts/instructions.sh                         instructions of hot functions against those of before
//! scripts/network-peers.sh                        training and forward passes beside other libraries
//! cargo run --release -p slip-benches --bin accuracy        run time against error: E_sc, filters, tanh, forward passes
//! cargo run --release -p slip-benches --bin null-run        false alarms without slip
//! cargo run --release -p slip-benches --bin slip-latency    how late the detector is, and what theory allows
//! cargo run --release -p slip-benches --bin daemon-soak     gripd with clients and a recording: samples, processor, memory
//! ```
//! Name the package with `-p`: plain `cargo run` means gripd.

pub mod accuracy;
pub mod daemon;
pub mod detection;
pub mod exact;
pub mod frames;
pub mod networks;
pub mod peers;
pub mod scenes;
pub mod signals;
pub mod time;
