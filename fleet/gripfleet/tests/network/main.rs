//! A network of grippers. gripfleet stands between a gripd and a router in the test, as those who look after many grippers meet it.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod events;
mod models;
mod pair;
#[path = "../../../grip-fleet/tests/rig/mod.rs"]
#[expect(dead_code, reason = "the tests of grip-fleet need more of it")]
mod rig;
