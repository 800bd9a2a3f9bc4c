//! Stylus samples in; slip events, features and grip-force commands out.
#![no_std]

pub mod sample;
pub mod units;
