//! crates/grip-sim
