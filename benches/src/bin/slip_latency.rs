//! Latency and misses of detectors on simulated slips, still and moving.
#![expect(clippy::print_stdout, reason = "a program that prints its result")]

use clap::Parser;
use slip_benches::detection::{Ours, RobotConfig, Slips, Trial, slips};
use slip_core::{PipelineConfig, Signal, units::Hertz};

/// Slips objects of three roughnesses, robot still and moving.
#[derive(Debug, Parser)]
#[command(name = "slip-latency")]
struct Args {
    /// Slips of each kind.
    #[arg(long, default_value_t = 200)]
    count: u64,
    /// First seed.
    #[arg(long, default_value_t = 2_000_000)]
    seed: u64,
    /// Configuration file, as for gripd.
    #[arg(long)]
    config: Option<std::path::PathBuf>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    let rate = Hertz(10_000.0);
    let config = match &args.config {
        None => PipelineConfig::observing(Signal::Displacement, rate),
        Some(file) => {
            PipelineConfig { grip: None, ..grip_host::HostConfig::read(file)?.pipeline(rate) }
        }
    };
    for ra_um in [0.4, 1.6, 6.3] {
        for moving in [false, true] {
            let slip = Slips { ra_um, moving, count: args.count, seed: args.seed };
            #[expect(clippy::expect_used, reason = "checked by the command line")]
            let trials = slips(RobotConfig::default(), slip, || Ours::new(config).expect("a sound configuration"));
            let mut found: Vec<f64> = trials
                .iter()
                .map(|t| match t {
                    Trial::Found(ms) => *ms,
                    Trial::Missed => f64::INFINITY,
                    Trial::Early => f64::NEG_INFINITY,
                })
                .collect();
            found.sort_by(f64::total_cmp);
            let at = |q: f64| found[((found.len() - 1) as f64 * q).round() as usize];
            let count = |kind: fn(&Trial) -> bool| trials.iter().filter(|t| kind(t)).count();
            println!(
                "Ra {ra_um} {}: median {:.1} ms, 95 % {:.1} ms, missed {}, early {} of {}",
                if moving { "moving" } else { "still " },
                at(0.5), at(0.95),
                count(|t| *t == Trial::Missed),
                count(|t| *t == Trial::Early),
                trials.len()
            );
        }
    }
    Ok(())
}
