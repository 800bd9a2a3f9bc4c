//! The live scope of the slip-detection workspace.

use clap::Parser as _;
use grip_session::exit::{self, Exit};
use gripmon::cli::{Cli, SourceError};
use gripmon::{layout::LayoutError, report, window};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    #[cfg(feature = "fleet")]
    if let Some(router) = cli.fleet().filter(|_| cli.report.is_none()) {
        return ended(gripmon::fleet::run(&cli, router));
    }
    let spec = match cli.source() {
        Ok(spec) => spec,
        Err(error) => {
            eprintln!("gripmon: {error}");
            return Exit::WrongArguments.into();
        }
    };
    match &cli.report {
        Some(file) => match report::run(spec, cli.memory_bytes(), file) {
            Err(error) if error.is::<SourceError>() => {
                eprintln!("gripmon: {error}");
                Exit::WrongArguments.into()
            }
            outcome => ended(outcome),
        },
        None => ended(window::run(&cli, spec)),
    }
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
