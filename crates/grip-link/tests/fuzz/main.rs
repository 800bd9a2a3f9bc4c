//! The fuzz targets of `fuzz/`, run on a stable compiler over the committed seeds and over what one fault makes of them.
#![cfg(test)]

mod seeds;
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
