//! crates/grip-record
