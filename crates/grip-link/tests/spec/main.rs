//! protocol/SPEC.md says what the crate does: each of its tables and worked examples against the code.

#[cfg(test)]
mod claims;
#[cfg(test)]
mod codes;
#[cfg(test)]
mod examples;
#[cfg(test)]
mod fields;
#[cfg(test)]
mod frame;
#[cfg(test)]
mod markdown;
#[cfg(test)]
mod messages;
#[cfg(test)]
mod rig;
#[cfg(test)]
mod source;
#[cfg(test)]
mod states;
#[cfg(test)]
#[path = "../vectors/table.rs"]
mod table;
#[cfg(test)]
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
#[cfg(test)]
mod timing;
