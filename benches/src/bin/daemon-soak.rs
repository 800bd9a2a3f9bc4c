//! The program gripd and minutes in; a table of samples, processor time and memory out; exit code 1 where samples are not accounted for.
//!
//! See [`slip_benches::daemon::soak`] for what runs and which counts must agree.
#![expect(clippy::print_stdout, reason = "the result of the program")]

use clap::Parser;
use core::error::Error;
use slip_benches::{
    daemon::{
        program,
        soak::{self, Look, Report, Soak},
    },
    time,
};
use std::{fs, path::PathBuf, process::ExitCode};

/// Memory in use does not grow by more after the first minute (kB).
const FLAT_KB: u64 = 1024;

/// Runs gripd against a virtual gripper, with two clients that want every sample, and a recording.
#[derive(Debug, Parser)]
struct Cli {
    /// How long, after gripd has started and gripped
    #[arg(long, default_value_t = 30.0)]
    minutes: f64,
    /// Samples a second, 1000 to 20000
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1000..=20_000))]
    rate: u32,
    /// The program; beside this one, unless it is named
    #[arg(long, value_name = "FILE")]
    gripd: Option<PathBuf>,
    /// Folder for the recording, which stays there; a new one that is removed, unless it is named
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// One JSON object instead of the table
    #[arg(long)]
    json: bool,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let cli = Cli::parse();
    let gripd = program(cli.gripd.clone())?;
    let name = format!("daemon-soak-{}", std::process::id());
    let folder = cli.keep.clone().unwrap_or_else(|| std::env::temp_dir().join(name));
    fs::create_dir_all(&folder)?;
    let seconds = cli.minutes * 60.0;
    let soak = Soak { gripd, folder, rate_hz: cli.rate, seconds, look_s: seconds.min(60.0) };
    let reported = soak::run(&soak, &time::clock(), &mut progress);
    if cli.keep.is_none() {
        fs::remove_dir_all(&soak.folder)?;
    }
    let report = reported?;
    if cli.json {
        print_json(&report)?;
    } else {
        print_table(&cli, &report);
    }
    Ok(if report.fine() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

#[expect(clippy::print_stderr, reason = "how far it is, for whoever waits")]
fn progress(look: &Look) {
    let Look { t_s, resident_kb, cpu_percent, .. } = look;
    eprintln!("{t_s:6.0} s: {resident_kb} kB in use, {cpu_percent:.2} % of a processor");
}

fn print_json(report: &Report) -> Result<(), serde_json::Error> {
    println!("{}", serde_json::to_string(report)?);
    Ok(())
}

fn print_table(cli: &Cli, report: &Report) {
    let row = |name: &str, value: String| println!("| {name} | {value} |");
    println!("| {} minutes at {} Hz, machine {} | |", cli.minutes, cli.rate, time::machine());
    println!("|---|---|");
    row("rows the gripper sampled", report.given.to_string());
    row("samples handled", report.samples.to_string());
    row("rows counted as lost", report.lost.to_string());
    row("rows discarded at a CONFIG after a stall", report.discarded.to_string());
    row("of the lost, dropped by the gripper", report.dropped_by_gripper.to_string());
    row("**not accounted for** (wanted 0)", report.unaccounted().to_string());
    row("handled, not recorded", report.unrecorded.to_string());
    row("notes not reported", report.unreported.to_string());
    row("rows of each client", format!("{:?}", report.clients));
    row("restarts of the gripper", report.restarts.to_string());
    for (name, percent) in &report.threads_percent {
        row(&format!("processor, thread {name} (%)"), format!("{percent:.2}"));
    }
    row(
        "**processor, all threads** (% of one; wanted 2 at 10 kHz)",
        format!("{:.2}", report.cpu_percent),
    );
    row("wake-ups a second", format!("{:.0}", report.wakes_per_s));
    let last = report.looks.last();
    row(
        "**memory in use** (kB; wanted 20480)",
        last.map_or(0, |look| look.resident_kb).to_string(),
    );
    row("of these anonymous (kB)", last.map_or(0, |look| look.anonymous_kb).to_string());
    let (growth, flat) = (report.growth_kb(60.0), report.growth_kb(60.0) <= FLAT_KB);
    let verdict = if flat { "kept" } else { "NOT KEPT" };
    row("growth after the first minute (kB; wanted 1024)", format!("{growth}, {verdict}"));
    row("frame to command (us)", report.latency_us.to_string());
    row("bytes recorded", report.recorded_bytes.to_string());
    println!(
        "{}",
        if report.fine() {
            "every sample is accounted for"
        } else {
            "SAMPLES ARE NOT ACCOUNTED FOR"
        }
    );
}
