//! The live scope of the slip-detection workspace.

use clap::Parser as _;
use grip_scope::SourceSpec;
use grip_session::exit::Exit;
use gripmon::cli::{Cli, SourceError};
use gripmon::{report, window};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let spec = match cli.source() {
        Ok(spec) => spec,
        Err(error) => {
            eprintln!("gripmon: {error}");
            return Exit::WrongArguments.into();
        }
    };
    match &cli.report {
        Some(file) => match report::run(spec, cli.window.memory_bytes(), file) {
            Err(error) if error.is::<SourceError>() => {
                eprintln!("gripmon: {error}");
                Exit::WrongArguments.into()
            }
            outcome => gripmon::ended("gripmon", outcome),
        },
        None => {
            if let SourceSpec::Recording(file) | SourceSpec::Study(file) = &spec
                && let Err(error) = std::fs::metadata(file)
            {
                // Whoever types a name waits for the window in vain.
                eprintln!("gripmon: {}: {error}", file.display());
                return Exit::WrongArguments.into();
            }
            gripmon::ended("gripmon", window::run(&cli.window, spec))
        }
    }
}
