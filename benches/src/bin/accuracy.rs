//! Run time against error of everything that has more than one way to be computed.
//!
//! `accuracy [--json] [--plots DIR] [--only esc|filters|networks]`: a table for each question, or one JSON object a line; with
//! `--plots` also DIR/accuracy-NAME.svg. Times are processor time, so that other programs count little.
#![expect(clippy::print_stdout, reason = "a program that prints tables")]

use anyhow::Context as _;
use clap::Parser;
use rustix::time::{ClockId, clock_gettime};
use slip_benches::accuracy::{self, GROUPS};
use std::path::PathBuf;

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
    /// A twentieth of the values, for a first look
    #[arg(long)]
    quick: bool,
}

fn main() -> anyhow::Result<()> {
    let wanted = Wanted::parse();
    let few = if wanted.quick { 20 } else { 1 };
    let groups =
        GROUPS.iter().filter(|name| wanted.only.as_deref().is_none_or(|only| only == **name));
    for panel in groups.flat_map(|group| accuracy::panels(group, few, &processor_ns)) {
        if wanted.json {
            println!("{}", serde_json::to_string(&panel)?);
        } else {
            println!("{panel}");
        }
        if let Some(folder) = &wanted.plots {
            let svg = panel.svg().context(panel.name)?;
            std::fs::write(folder.join(format!("accuracy-{}.svg", panel.name)), svg)?;
        }
    }
    Ok(())
}

/// Processor time of this thread.
fn processor_ns() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}
