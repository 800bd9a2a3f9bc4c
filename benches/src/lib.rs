//! A scene, a shape or a count in; repeatable samples, networks and link frames for benches and tests out.
//!
//! ```text
//! cargo bench -p slip-benches                     everything, about five minutes
//! cargo bench -p slip-benches --bench pipeline    one sample through the pipeline, scene by scene
//! cargo bench -p slip-benches --bench network     one forward pass
//! cargo bench -p slip-benches --bench link        one frame decoded or encoded, CRC-32C
//! cargo bench -p slip-benches --bench training    one epoch of training
//! cargo run --release -p slip-benches --bin network-peers -- DIR   our side of scripts/network-peers.sh
//! cargo bench -p slip-benches --bench latency     p50 to max beside the stated limits
//! cargo run --release -p slip-benches --bin accuracy          time against error: E_sc, filters, tanh, forward passes, trainers
//! cargo run --release -p slip-benches --bin detectors         run time against latency of every detector at stated false-alarm rates
//! cargo test  -p slip-benches                     nothing is allocated on these paths
//! cargo run --release -p slip-benches --bin daemon-faults   a real gripd, killed, unplugged, disturbed and starved
//! cargo run --release -p slip-benches --bin daemon-latency   the hot loop of gripd: last byte of a frame to the command
//! cargo run --release -p slip-benches --bin daemon-soak      gripd with clients and a recording: samples, processor, memory
//! ```
//! Name the package with `-p`: plain `cargo run` means gripd.

pub mod accuracy;
pub mod containment;
pub mod daemon;
pub mod daemon_faults;
pub mod detection;
pub mod exact;
pub mod frames;
pub mod learning;
pub mod networks;
pub mod peers;
pub mod scenes;
pub mod signals;
pub mod time;
