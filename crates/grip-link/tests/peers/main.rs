//! The device in C (protocol/c) and the device in Python (protocol/python) against this crate: the same lines for the
//! same scripts and bytes. Their own tests: scripts/c-peer-check.sh, scripts/python-peer-check.sh.
#![cfg(test)]

mod device;
mod peer;
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
