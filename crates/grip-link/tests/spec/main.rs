//! The pages of the protocol state what the crate does: numbers, names and the worked example against the code.
#![cfg(test)]

mod claims;
mod codes;
mod example;
mod frame;
mod page;
mod rig;
mod source;
mod states;
#[path = "../vectors/table.rs"]
mod table;
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
mod timing;
