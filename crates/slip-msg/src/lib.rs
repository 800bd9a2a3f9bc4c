//! The vocabulary of the workspace: what a sample leads to, and what of it travels to clients, files and networks.
//!
//! Every code stands once, in a table of number, name and meaning ([`codes`]). Core, link, daemon, recordings, scope and fleet use these types;
//! nothing is translated on the way.
#![no_std]

pub mod codes;
mod table;
pub mod units;

pub use codes::*;
pub use table::Row;
