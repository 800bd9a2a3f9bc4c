//! The vocabulary of the workspace: what a sample leads to, and what of it travels to clients, files and networks.
//!
//! Every code stands once, in a table of number, name and meaning ([`codes`]). Core, link, daemon, recordings, scope and fleet use these types;
//! nothing is translated on the way.
//!
#![doc = include_str!("../README.md")]
#![no_std]

pub mod codes;
mod command;
mod fault;
mod health;
mod message;
mod named;
mod state;
mod table;
pub mod units;
pub mod wire;

pub use codes::*;
pub use command::ClientCommand;
pub use fault::{FaultCode, Reaction};
pub use health::{Appended, BadFrames, ClockOffset, Dropped, Health, Latency};
pub use message::{Absent, Field, SlipReport, Wire};
pub use state::{EXTRAPOLATED, INFORMATIVE, PipelineState};
pub use table::Row;
pub use wire::PayloadError;
