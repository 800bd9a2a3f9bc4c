//! The C device side under protocol/c against this crate: the same scripts and bytes in, the same lines out.

#[cfg(test)]
mod decode;
#[cfg(test)]
mod device;
#[cfg(test)]
mod peer;
#[cfg(test)]
mod script;
#[cfg(test)]
mod seeds;
#[cfg(test)]
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
