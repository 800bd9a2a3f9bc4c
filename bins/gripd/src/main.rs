//! The daemon that feels an object slip and holds it with just enough force.

mod cli;
mod clock;
mod console;
mod daemon;
mod figures;
#[cfg(feature = "fleet")]
mod fleet;
mod notify;
mod recording;
mod service;
mod settings;
mod summary;

use clap::Parser as _;
use cli::Cli;
use grip_host::exit::{self, Exit};
use settings::Settings;
use std::{
    io::{self, Write as _},
    process::ExitCode,
};

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(exit) => exit.into(),
        Err(error) => {
            // A standard error that takes nothing must not turn the reason into a panic; the exit code tells it too.
            let _told = writeln!(io::stderr(), "gripd: {}", exit::message(error.as_ref()));
            Exit::of(error.as_ref()).into()
        }
    }
}

fn run(cli: &Cli) -> anyhow::Result<Exit> {
    let settings = Settings::new(cli)?;
    if cli.check_config {
        eprintln!("{}", settings.origin()?);
        return Ok(Exit::Done);
    }
    #[cfg(feature = "fleet")]
    let (settings, models) = fleet::open_models(settings)?;
    #[cfg(not(feature = "fleet"))]
    let models = None;
    daemon::run(cli, settings, models)
}
