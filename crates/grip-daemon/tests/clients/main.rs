//! The clients' side of the daemon at real sockets: what they see, what they cost each other, and what they cannot do.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod abuse;
mod commands;
mod models;
mod rig;
mod session;
mod stream;
