//! The Python peer in protocol/python gives the same answers as this crate to random scripts. Its own tests: scripts/python-peer-check.sh.

#[cfg(test)]
mod dice;
#[cfg(test)]
mod differential;
#[cfg(test)]
mod directed;
#[cfg(test)]
mod host;
#[cfg(test)]
mod host_lives;
#[cfg(test)]
mod host_player;
#[cfg(test)]
mod host_words;
#[cfg(test)]
mod python;
#[cfg(test)]
mod script;
#[cfg(test)]
mod seeds;
#[cfg(test)]
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
