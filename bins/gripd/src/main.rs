//! The daemon that feels an object slip and holds it with just enough force.

mod accepted;
mod cli;
mod clock;
mod console;
mod daemon;
mod figures;
mod notify;
mod recording;
mod service;
mod settings;
mod summary;

use clap::Parser as _;
use cli::Cli;
use grip_port::PortError;
use grip_session::exit::{self, Exit};
use grip_sim::port::is_scene_error;
use settings::Settings;
use std::{
    io::{self, Write as _},
    process::ExitCode,
};

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(exit) => exit.into(),
        Err(error) => {
            // A standard error that takes nothing must not turn the reason into a panic; the exit code reports it too.
            let _reported = writeln!(io::stderr(), "gripd: {}", exit::message(error.as_ref()));
            Exit::of_any(error.as_ref(), is_argument).into()
        }
    }
}

/// Scenes and ports that cannot be used.
fn is_argument(error: &(dyn core::error::Error + 'static)) -> bool {
    is_scene_error(error) || matches!(error.downcast_ref(), Some(PortError::Argument(_)))
}

fn run(cli: &Cli) -> anyhow::Result<Exit> {
    let settings = Settings::new(cli)?;
    if cli.check_config {
        eprintln!("{}", settings.origin()?);
        return Ok(Exit::Done);
    }
    daemon::run(cli, settings)
}
