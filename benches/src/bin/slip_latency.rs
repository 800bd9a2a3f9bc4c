//! Latency and misses of the shipped detector and of older ones on simulated slips, robot still and moving.
#![expect(clippy::print_stdout, reason = "a program that prints its result")]
#![expect(clippy::expect_used, reason = "the configuration was checked before the run")]

use clap::Parser;
use serde_json::json;
use slip_benches::detection::{
    Alarm, Latency, Ours, Peer, RobotConfig, Slips, Trial, null_run, quantile, slips,
};
use slip_core::{PipelineConfig, Signal, units::Hertz};

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
    /// Also the older detectors, with thresholds for one false alarm in ten minutes, set on this many hours
    /// without slip; 0 leaves them out.
    #[arg(long, default_value_t = 0.0)]
    peers: f64,
    /// First seed of the hours without slip.
    #[arg(long, default_value_t = 7_000_000)]
    null_seed: u64,
    /// Configuration file, as for gripd.
    #[arg(long)]
    config: Option<std::path::PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    json: bool,
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let args = Args::parse();
    let rate = Hertz(10_000.0);
    let config = match &args.config {
        None => PipelineConfig::observing(Signal::Displacement, rate),
        Some(file) => PipelineConfig {
            grip: None,
            ..grip_session::HostConfig::read(file)?.pipeline(Signal::Displacement, rate)
        },
    };
    Ours::new(config)?;
    table(&args, "shipped", &|| Ours::new(config).expect("checked"));
    if args.peers > 0.0 {
        peer(&args, "fft 128", &|threshold| Peer::fft(1e4, threshold));
        peer(&args, "force-scaled pad", &|threshold| Peer::pad(1e4, threshold));
        peer(&args, "single threshold", &|threshold| Peer::single(1e4, threshold));
    }
    Ok(())
}

/// Sets the threshold that the highest statistic of a minute exceeds in one minute of ten, then as [`table`].
fn peer(args: &Args, name: &str, make: &(dyn Fn(f64) -> Peer + Sync)) {
    let null = null_run(RobotConfig::default(), args.peers, args.null_seed, || make(f64::INFINITY));
    let mut peaks = null.peaks;
    peaks.sort_by(f64::total_cmp);
    let threshold = quantile(&peaks, 0.9);
    table(args, name, &|| make(threshold));
}

fn table<A: Alarm>(args: &Args, name: &str, make: &(dyn Fn() -> A + Sync)) {
    for ra_um in [0.4, 1.6, 6.3] {
        for moving in [false, true] {
            let slip = Slips { ra_um, moving, count: args.count, seed: args.seed };
            line(args, name, slip, &slips(RobotConfig::default(), slip, make));
        }
    }
}

fn line(args: &Args, name: &str, slip: Slips, trials: &[Trial]) {
    let Latency { p50: median, p95: late, missed, early, .. } = Latency::of(trials);
    let robot = if slip.moving { "moving" } else { "still" };
    if args.json {
        let finite = |x: f64| x.is_finite().then_some(x);
        println!(
            "{}",
            json!({"detector": name, "ra_um": slip.ra_um, "robot": robot, "slips": trials.len(),
                "latency_ms": {"p50": finite(median), "p95": finite(late)}, "missed": missed, "early": early})
        );
    } else {
        println!(
            "{name:16} Ra {:3} {robot:6}: median {median:6.1} ms, 95 % {late:6.1} ms, missed {missed}, alarm stood before {early}, of {}",
            slip.ra_um,
            trials.len()
        );
    }
}
