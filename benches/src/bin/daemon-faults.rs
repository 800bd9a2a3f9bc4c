//! A gripd program in, a table of what faults of nine kinds do to it out; exit code 1 when a promise is broken.
//!
//! See [`slip_benches::daemon_faults`] for what is promised and how it is checked.
#![expect(clippy::print_stdout, reason = "the result of the program")]

use clap::Parser;
use serde_json::json;
use slip_benches::{
    daemon::program,
    daemon_faults::{self, Counts, Outcome, Setup},
};
use std::{path::PathBuf, process::ExitCode};

/// Kills, unplugs, disturbs and starves a real gripd, and checks every command that it sends meanwhile.
#[derive(Debug, Parser)]
struct Cli {
    /// The daemon; without it the gripd beside this program
    #[arg(long, value_name = "FILE")]
    gripd: Option<PathBuf>,
    /// Small counts: half a minute instead of eight
    #[arg(long)]
    quick: bool,
    /// Only the kinds whose name contains this; may be given again
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// kill -9 at random moments; 200 unless --quick
    #[arg(long, value_name = "N")]
    kills: Option<u64>,
    /// The port goes and comes back; 100 unless --quick
    #[arg(long, value_name = "N")]
    unplugs: Option<u64>,
    /// Connections of clients that come and go; 1000 unless --quick
    #[arg(long, value_name = "N")]
    connects: Option<u64>,
    /// Restarts of the gripper; 20 unless --quick
    #[arg(long, value_name = "N")]
    reboots: Option<u64>,
    /// Pauses of the daemon by SIGSTOP; 20 unless --quick
    #[arg(long, value_name = "N")]
    pauses: Option<u64>,
    /// SIGHUP with a broken file, and as many with a good one; 20 unless --quick
    #[arg(long, value_name = "N")]
    reloads: Option<u64>,
    /// Seconds of noise on the line; 30 unless --quick
    #[arg(long, value_name = "S")]
    noise_s: Option<u64>,
    /// Slips with each fault in their middle; 4 unless --quick
    #[arg(long, value_name = "N")]
    slips: Option<u64>,
    /// Another seed kills and disturbs at other moments
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object a line
    #[arg(long)]
    json: bool,
}

impl Cli {
    fn counts(&self) -> Counts {
        let base = if self.quick { Counts::QUICK } else { Counts::FULL };
        Counts {
            kills: self.kills.unwrap_or(base.kills),
            unplugs: self.unplugs.unwrap_or(base.unplugs),
            connects: self.connects.unwrap_or(base.connects),
            reboots: self.reboots.unwrap_or(base.reboots),
            pauses: self.pauses.unwrap_or(base.pauses),
            reloads: self.reloads.unwrap_or(base.reloads),
            noise_s: self.noise_s.unwrap_or(base.noise_s),
            slips: self.slips.unwrap_or(base.slips),
        }
    }

    fn wants(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|part| name.contains(part.as_str()))
    }
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(what) => {
            eprintln!("daemon-faults: {what}");
            ExitCode::from(2)
        }
    }
}

/// Whether every promise was kept.
fn run(cli: &Cli) -> Result<bool, String> {
    let gripd = program(cli.gripd.clone()).map_err(|error| error.to_string())?;
    let names: Vec<_> = daemon_faults::names().filter(|name| cli.wants(name)).collect();
    if names.is_empty() {
        let all: Vec<_> = daemon_faults::names().collect();
        return Err(format!("--only: no such kind; there are {}", all.join("; ")));
    }
    let setup = Setup { gripd: &gripd, seed: cli.seed, slack_ms: 0 };
    if !cli.json {
        print_head();
    }
    let mut kept = true;
    for name in names {
        let Some(outcome) = daemon_faults::run(name, &setup, cli.counts()) else { continue };
        kept &= outcome.broken == 0;
        if cli.json { print_json(&outcome) } else { print_row(&outcome) }
    }
    print_end(cli.json, kept);
    Ok(kept)
}

fn print_head() {
    println!(
        "{:28} {:>6} {:>9} {:>11} {:>7}  figures",
        "fault", "times", "commands", "recordings", "broken"
    );
}

fn print_row(outcome: &Outcome) {
    let Outcome { name, times, commands, recordings, broken, .. } = outcome;
    let figures = outcome.figures.join("; ");
    println!("{name:28} {times:>6} {commands:>9} {recordings:>11} {broken:>7}  {figures}");
    for violation in &outcome.violations {
        println!("  BROKEN: {violation}");
    }
}

fn print_json(outcome: &Outcome) {
    println!("{}", json!({"type": "fault", "outcome": outcome}));
}

fn print_end(json: bool, kept: bool) {
    if json {
        println!("{}", json!({"type": "total", "kept": kept}));
        return;
    }
    println!(
        "times: faults; commands: those that reached the gripper, each checked; recordings: read or recovered; broken: promises"
    );
    println!("{}", if kept { "every promise kept" } else { "A PROMISE IS BROKEN" });
}
