//! Latency and misses of the shipped detector, and what theory allows, on simulated slips, robot still and moving.
#![expect(clippy::print_stdout, reason = "a program that prints its result")]

use clap::Parser;
use serde_json::json;
use slip_benches::detection::{Latency, Ours, RobotConfig, Slips, bound::simulated, slips};
use std::path::PathBuf;

/// Rates of the bound (Hz); objects slip at the first.
const RATES_HZ: [f64; 4] = [10_000.0, 1000.0, 2200.0, 20_000.0];

/// Slips objects of three roughnesses.
#[derive(Debug, Parser)]
#[command(name = "slip-latency")]
struct Args {
    /// Slips of each kind.
    #[arg(long, default_value_t = 1000)]
    count: u64,
    /// First seed.
    #[arg(long, default_value_t = 6_000_000)]
    seed: u64,
    /// Also the least delay that any detector of the energies of four bands can have at one false alarm an hour.
    #[arg(long)]
    bound: bool,
    /// Configuration file, as for gripd.
    #[arg(long)]
    config: Option<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    json: bool,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let ours = Ours::configured(args.config.as_deref())?;
    for slip in kinds(&args) {
        let trials = slips(RobotConfig::default(), slip, &ours);
        line(&args, "shipped", slip, &Latency::of(&trials));
    }
    if args.bound {
        RATES_HZ.into_iter().for_each(|rate_hz| bounds(&args, rate_hz));
    }
    Ok(())
}

fn kinds(args: &Args) -> impl Iterator<Item = Slips> {
    let Args { count, seed, .. } = *args;
    [0.4, 1.6, 6.3].into_iter().flat_map(move |ra_um| {
        [false, true].into_iter().map(move |moving| Slips { ra_um, moving, count, seed })
    })
}

fn bounds(args: &Args, rate_hz: f64) {
    let robot = RobotConfig { rate_hz, ..RobotConfig::default() };
    for slip in kinds(args) {
        let latency = Latency::of_ms(simulated(robot, slip, 3600.0));
        line(args, &format!("ln(ARL)/KL {rate_hz}"), slip, &latency);
    }
}

fn line(args: &Args, name: &str, slip: Slips, latency: &Latency) {
    let Latency { slips, p50: median, p95: late, missed, early } = *latency;
    let robot = if slip.moving { "moving" } else { "still" };
    if args.json {
        let finite = |x: f64| x.is_finite().then_some(x);
        println!(
            "{}",
            json!({"detector": name, "ra_um": slip.ra_um, "robot": robot, "slips": slips,
                "latency_ms": {"p50": finite(median), "p95": finite(late)}, "missed": missed, "early": early})
        );
    } else {
        println!(
            "{name:16} Ra {:3} {robot:6}: median {median:6.1} ms, 95 % {late:6.1} ms, missed {missed}, alarm stood before {early}, of {slips}",
            slip.ra_um
        );
    }
}
