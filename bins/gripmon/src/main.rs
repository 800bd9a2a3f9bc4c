//! The live scope of the slip-detection workspace.

use clap::Parser as _;
use grip_session::exit::{self, Exit};
use gripmon::{cli::Cli, layout::LayoutError, window};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    #[cfg(feature = "fleet")]
    if let Some(router) = cli.fleet() {
        return ended(gripmon::fleet::run(&cli, router));
    }
    let spec = match cli.source() {
        Ok(spec) => spec,
        Err(error) => {
            eprintln!("gripmon: {error}");
            return Exit::WrongArguments.into();
        }
    };
    ended(window::run(&cli, spec))
}

/// How the program ends.
fn ended(outcome: anyhow::Result<()>) -> ExitCode {
    match outcome {
        Ok(()) => Exit::Done.into(),
        Err(error) => {
            eprintln!("gripmon: {}", exit::message(error.as_ref()));
            let exit = if error.is::<LayoutError>() {
                Exit::WrongArguments
            } else {
                Exit::of(error.as_ref())
            };
            exit.into()
        }
    }
}
