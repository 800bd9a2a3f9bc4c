//! A scene, a shape or a count in; repeatable samples, networks and link frames for benches and tests out.
//!
//! ```text
//! cargo bench -p slip-benches                     everything, about five minutes
//! cargo bench -p slip-benches --bench pipeline    one sample through the pipeline, scene by scene
//! cargo bench -p slip-benches --bench network     one forward pass
//! cargo bench -p slip-benches --bench link        one frame decoded or encoded, CRC-32C
//! cargo bench -p slip-benches --bench training    one epoch of training
//! cargo bench -p slip-benches --bench peers       our side of scripts/network-peers.sh
//! cargo bench -p slip-benches --bench latency     p50 to max beside the stated limits
//! cargo test  -p slip-benches                     nothing is allocated on these paths
//! ```
//! The default members of the workspace leave this package out: name it with `-p`, or use `--workspace`.

pub mod frames;
pub mod networks;
pub mod peers;
pub mod scenes;
pub mod signals;
