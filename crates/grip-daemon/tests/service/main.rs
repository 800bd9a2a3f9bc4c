//! What gripd shows of itself: metrics, status, dumps and the server that hands them out.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod dumps;
mod made;
mod page;
mod parser;
mod server;
mod shown;
