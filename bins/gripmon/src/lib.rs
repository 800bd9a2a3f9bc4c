//! The window that shows what a gripper feels, does and how its link is.
//!
//! ```text
//! source's thread -> Engine { Model } -> views(&Seen, &mut ViewState) -> Vec<Effect> -> Exports
//! ```
//!
//! [`Scope`] is the whole window without a system behind it: tests and benches run it as the program does. Views are functions that look at the
//! model and change the state of the view; what needs more is an [`Effect`](apply::Effect) that waits for the end of the frame.
//! [`Desk`](desk::Desk) adds what is written to files.

pub mod apply;
pub mod cli;
pub mod desk;
pub mod engine;
pub mod exports;
pub mod files;
pub mod job;
pub mod keys;
pub mod labels;
pub mod layout;
pub mod palette;
pub mod plot;
pub mod remember;
pub mod report;
pub mod scope;
pub mod state;
pub mod strip;
pub mod time;
pub mod view_file;
pub mod views;
pub mod window;

pub use engine::Engine;
pub use grip_scope::num;
pub use scope::Scope;

use grip_session::exit::{self, Exit};
use std::process::ExitCode;

/// How a program of this name ends.
#[expect(clippy::print_stderr, reason = "the program ends with a sentence")]
#[must_use]
pub fn ended(program: &str, outcome: anyhow::Result<()>) -> ExitCode {
    let Err(error) = outcome else { return Exit::Done.into() };
    eprintln!("{program}: {}", exit::message(error.as_ref()));
    let layout = error.is::<layout::LayoutError>();
    if layout { Exit::WrongArguments.into() } else { Exit::of(error.as_ref()).into() }
}
