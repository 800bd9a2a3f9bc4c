//! The toolbox of the slip-detection workspace.

mod cli;
mod commands;
mod output;
mod print;
mod table;
mod terminal;

use clap::{
    Parser as _,
    error::{ContextKind, ContextValue},
};
use cli::{Cli, Command};
use grip_eval::{
    calibrate::CalibrationError, collect::CollectError, profile::ProfileError, score::ScoreError,
};
use grip_port::PortError;
use grip_record::{NpzError, outputs::OutputError};
use grip_session::exit::{self, Exit};
use grip_sim::port::is_scene_error;
use mlp::train::DataSetError;
use std::process::ExitCode;

/// What the command line cannot know: words of the language it is written in, and commands of another program.
fn explained(error: &clap::Error) -> Option<String> {
    if let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand)
        && ["fleet", "foxglove"].contains(&name.as_str())
    {
        let command = if name == "fleet" { "gripfleet COMMAND" } else { "gripfleet foxglove" };
        return Some(format!(
            "gripctl: `{command}` does it: {}\n",
            exit::fleet_program("gripfleet")
        ));
    }
    output::number(error)
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => match explained(&error) {
            Some(text) => {
                eprint!("{text}");
                return Exit::WrongArguments.into();
            }
            None => error.exit(),
        },
    };
    let result = match cli.command {
        Command::Demo(args) => commands::demo::run(&args),
        Command::Ports(args) => commands::ports::run(&args),
        Command::Doctor(args) => commands::doctor::run(&args),
        Command::Status(args) => commands::status::run(&args),
        Command::Control(args) => commands::command::run(&args),
        Command::Object(args) => commands::objects::name(&args),
        Command::Objects(args) => commands::objects::list(&args),
        Command::Sim(args) => commands::sim::run(&args),
        Command::Replay(args) => commands::replay::run(&args),
        Command::Import(args) => commands::import::run(&args),
        Command::Label(args) => commands::label::run(&args),
        Command::Recover(args) => commands::recover::run(&args),
        Command::Csv(args) => commands::csv::run(&args),
        Command::Calibrate(args) => commands::calibrate::run(&args),
        Command::Score(args) => commands::score::run(&args),
        Command::Profile(args) => commands::profile::run(&args),
        Command::Esc(args) => commands::esc::run(&args),
        Command::Grasp(args) => commands::grasp::run(&args),
        Command::Generate(args) => commands::generate::run(&args),
        Command::Collect(args) => commands::collect::run(&args),
        Command::Train(args) => commands::train::run(&args),
        Command::Search(args) => commands::search::run(&args),
        Command::Estimate(args) => commands::estimate::run(&args),
        Command::Eval(args) => commands::eval::run(&args),
        Command::Export(args) => commands::export::run(&args),
        Command::Study(args) => commands::study::run(&args),
    };
    match result {
        Ok(exit) => exit.into(),
        Err(error) if output::is_closed_pipe(&error) => Exit::Done.into(),
        Err(error) => {
            eprintln!("gripctl: {}", exit::message(error.as_ref()));
            Exit::of_any(error.as_ref(), is_argument).into()
        }
    }
}

/// Scenes, ports, columns and folders of recordings that cannot be used. A recording that can be read and does not give a calibration has failed.
fn is_argument(error: &(dyn core::error::Error + 'static)) -> bool {
    is_scene_error(error)
        || matches!(error.downcast_ref(), Some(PortError::Argument(_)))
        || error.is::<DataSetError>()
        || error.is::<NpzError>()
        || matches!(error.downcast_ref(), Some(refused) if OutputError::is_refusal(refused))
        || error.is::<ScoreError>()
        || error.is::<CollectError>()
        || error.is::<ProfileError>()
        || matches!(error.downcast_ref(), Some(CalibrationError::Config(_)))
}
