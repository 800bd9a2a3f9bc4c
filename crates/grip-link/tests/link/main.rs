//! Tests of the link as its users see it.
#![cfg(test)]

mod attach;
mod clock;
mod degraded;
mod force;
mod line;
mod messages;
mod noise;
mod session;
mod silence;
mod stream;
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
