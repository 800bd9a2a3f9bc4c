//! The vectors that every peer of the link reads: protocol/vectors/valid.tsv and invalid.tsv.

#[cfg(test)]
mod fields;
#[cfg(test)]
mod invalid;
#[cfg(test)]
mod table;
#[cfg(test)]
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
#[cfg(test)]
mod valid;
