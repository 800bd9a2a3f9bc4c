//! The daemon that feels an object slip and holds it with just enough force.

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
use grip_host::exit::{self, Exit};
use settings::Settings;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(exit) => exit.into(),
        Err(error) => {
            eprintln!("gripd: {}", exit::message(error.as_ref()));
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
    daemon::run(cli, settings)
}
