//! The vectors that every peer of the link reads: protocol/vectors/valid.tsv and invalid.tsv, and those of a daemon's clients: clients.tsv and clients-invalid.tsv.
#![cfg(test)]

mod golden;
mod invalid;
mod table;
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
mod valid;
