//! The vectors that every peer of the link reads: protocol/vectors/valid.tsv and invalid.tsv.

#[cfg(test)]
mod fields;
#[cfg(test)]
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/gripper.rs"]
mod gripper;
#[cfg(test)]
mod invalid;
#[cfg(test)]
mod table;
#[cfg(test)]
mod valid;
#[cfg(test)]
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/words.rs"]
mod words;
