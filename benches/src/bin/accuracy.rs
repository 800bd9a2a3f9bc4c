//! Run time against error of everything that has more than one way to be computed.
//!
//! `accuracy [--json] [--plots DIR] [--only esc|filters|networks|trainers]`: a table for each question, or one JSON object a
//! line; with `--plots` also DIR/accuracy-NAME.svg. The environment variable GRIP_DATA names the folder of real data;
//! without it the trainers run on drawn rows alone. Times are processor time, so that other programs do not count.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints tables")]

use clap::Parser;
use core::error::Error;
use rustix::time::{ClockId, clock_gettime};
use slip_benches::accuracy::{self, GROUPS, Panel};
use std::{path::PathBuf, process::ExitCode};

/// Run time against error of everything that has more than one way to be computed.
#[derive(Parser)]
struct Wanted {
    /// One JSON object a line
    #[arg(long)]
    json: bool,
    /// Folder for the charts
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Only one group of questions
    #[arg(long, value_parser = GROUPS)]
    only: Option<String>,
}

fn main() -> ExitCode {
    let wanted = Wanted::parse();
    let data = std::env::var_os("GRIP_DATA").map(PathBuf::from);
    let groups =
        GROUPS.iter().filter(|name| wanted.only.as_deref().is_none_or(|only| only == **name));
    for group in groups {
        if *group == "trainers" && data.is_none() {
            eprintln!(
                "GRIP_DATA is not set: building1 is left out, surface2 is drawn from its formula"
            );
        }
        for panel in accuracy::panels(group, &processor_ns, data.as_deref()) {
            if let Err(error) = show(&panel, &wanted) {
                eprintln!("{}: {error}", panel.name);
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

fn show(panel: &Panel, wanted: &Wanted) -> Result<(), Box<dyn Error>> {
    if wanted.json {
        println!("{}", serde_json::to_string(panel)?);
    } else {
        println!("{panel}");
    }
    if let Some(folder) = &wanted.plots {
        let file = folder.join(format!("accuracy-{}.svg", panel.name));
        std::fs::write(file, panel.chart()?.svg()?)?;
    }
    Ok(())
}

/// Processor time of this process.
#[expect(clippy::cast_precision_loss, reason = "differences of seconds are exact to nanoseconds")]
fn processor_ns() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}
