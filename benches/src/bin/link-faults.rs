//! A count of frames in, a table of what nine kinds of line faults do to the link out; exit code 1 when a promise is broken.
//!
//! See [`slip_benches::link_faults`] for what is counted and how the truth is known.
#![expect(clippy::print_stdout, reason = "the result of the program")]

use clap::Parser;
use core::error::Error;
use grip_sim::line_fault::LineFault;
use serde_json::json;
use slip_benches::link_faults::{self, Tally};
use std::{process::ExitCode, thread};

/// Injects line faults of nine kinds into streams of real frames and counts what the link makes of them.
#[derive(Debug, Parser)]
struct Cli {
    /// Frames sent through each kind of fault, at least
    #[arg(long, default_value_t = 700_000)]
    frames: u64,
    /// Another seed gives other streams and other faults
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object a line
    #[arg(long)]
    json: bool,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let cli = Cli::parse();
    let mut tallies = Vec::new();
    for pair in LineFault::ALL.chunks(2) {
        tallies.extend(run(pair, &cli)?);
    }
    let kept = tallies.iter().all(|(_, tally)| tally.kept());
    if cli.json {
        print_json(&tallies, kept);
    } else {
        print_table(&tallies, kept);
    }
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Some kinds side by side, each in a thread.
fn run(kinds: &[LineFault], cli: &Cli) -> Result<Vec<(LineFault, Tally)>, Box<dyn Error>> {
    thread::scope(|threads| {
        let running: Vec<_> = kinds
            .iter()
            .map(|&kind| {
                (kind, threads.spawn(move || link_faults::run(kind, cli.frames, cli.seed)))
            })
            .collect();
        running
            .into_iter()
            .map(|(kind, thread)| {
                let tally = thread.join().map_err(|_| "a thread failed")??;
                Ok((kind, tally))
            })
            .collect()
    })
}

fn print_json(tallies: &[(LineFault, Tally)], kept: bool) {
    for (kind, tally) in tallies {
        let line = json!({
            "type": "fault", "kind": kind.name(), "faults": tally.faults, "frames": tally.frames,
            "damaged": tally.damaged, "refused": tally.refused, "repeats_refused": tally.repeats,
            "undetected": tally.undetected, "clean_lost": tally.clean_lost,
            "delay_bytes": tally.delay_bytes, "plain_undetected": tally.plain_undetected,
        });
        println!("{line}");
    }
    let frames: u64 = tallies.iter().map(|(_, tally)| tally.frames).sum();
    println!("{}", json!({"type": "total", "frames": frames, "kept": kept}));
}

fn print_table(tallies: &[(LineFault, Tally)], kept: bool) {
    println!(
        "{:20} {:>9} {:>10} {:>9} {:>9} {:>8} | {:>10} {:>10} {:>6} | {:>16}",
        "fault",
        "faults",
        "frames",
        "damaged",
        "refused",
        "repeats",
        "undetected",
        "clean lost",
        "delay",
        "CRC-16, no seq"
    );
    for (kind, tally) in tallies {
        println!(
            "{:20} {:>9} {:>10} {:>9} {:>9} {:>8} | {:>10} {:>10} {:>6} | {:>16}",
            kind.name(),
            tally.faults,
            tally.frames,
            tally.damaged,
            tally.refused,
            tally.repeats,
            tally.undetected,
            tally.clean_lost,
            tally.delay_bytes,
            tally.plain_undetected
        );
    }
    println!(
        "refused: blocks that are no frame; repeats: good frames refused because they came before; delay: extra bytes until a clean frame is \
         handed out; last column: wrong or repeated frames that a CRC-16 without sequence check accepts"
    );
    println!("{}", if kept { "every promise kept" } else { "A PROMISE IS BROKEN" });
}
