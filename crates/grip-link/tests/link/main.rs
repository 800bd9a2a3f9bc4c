//! Tests of the link as its users see it.

#[cfg(test)]
mod attach;
#[cfg(test)]
mod clock;
#[cfg(test)]
mod degraded;
#[cfg(test)]
mod force;
#[cfg(test)]
mod golden;
#[cfg(test)]
mod line;
#[cfg(test)]
mod messages;
#[cfg(test)]
mod noise;
#[cfg(test)]
mod session;
#[cfg(test)]
mod silence;
#[cfg(test)]
mod sizes;
#[cfg(test)]
mod stream;
#[cfg(test)]
#[expect(unreachable_pub, dead_code, reason = "shared with the fuzz workspace and other tests")]
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;
