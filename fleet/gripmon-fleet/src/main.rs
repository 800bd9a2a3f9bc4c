//! The table of many grippers, as a window.

use clap::Parser as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    gripmon::ended("gripmon-fleet", gripmon_fleet::run(&gripmon_fleet::cli::Cli::parse()))
}
