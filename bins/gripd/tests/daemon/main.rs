//! Tests of gripd as a person or a script meets it: its arguments, output, recording and exit code.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod arm;
mod ends;
mod live;
mod memory;
mod ports;
mod recording;
mod refusals;
mod rows;
mod running;
mod service_manager;
mod shadow;
mod signed;
mod watching;
