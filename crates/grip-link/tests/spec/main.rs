//! protocol/SPEC.md states what the crate does: each of its tables and worked examples against the code.
#![cfg(test)]

mod claims;
mod codes;
mod examples;
mod frame;
mod markdown;
mod messages;
mod rig;
mod source;
mod states;
#[path = "../vectors/table.rs"]
mod table;
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
mod timing;
