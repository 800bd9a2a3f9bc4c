//! False alarms of the shipped detector on a simulated robot that holds an object which never slips.
#![expect(clippy::print_stdout, reason = "a program that prints its result")]

use clap::Parser;
use grip_eval::poisson;
use slip_benches::detection::{Ours, RobotConfig, null_run, quantile};

/// Hours of signal in minutes: motion half of the time, taps, gear tones; counts false alarms.
#[derive(Debug, Parser)]
#[command(name = "null-run")]
struct Args {
    /// Hours of signal.
    #[arg(long, default_value_t = 10.0)]
    hours: f64,
    /// First seed; each piece of ten minutes has its own.
    #[arg(long, default_value_t = 1_000_000)]
    seed: u64,
    /// Size of the motion.
    #[arg(long, default_value_t = 1.0)]
    level: f64,
    /// Taps a second.
    #[arg(long, default_value_t = 0.2)]
    taps: f64,
    /// Leave the motion reference out.
    #[arg(long)]
    no_reference: bool,
    /// Configuration file, as for gripd.
    #[arg(long)]
    config: Option<std::path::PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let robot = RobotConfig {
        level: args.level,
        taps_per_s: args.taps,
        reference: !args.no_reference,
        ..RobotConfig::default()
    };
    let ours = Ours::configured(args.config.as_deref())?;
    let mut run = null_run(robot, args.hours, args.seed, &ours);
    let alarms = run.alarms.len() as u64;
    let (low, high) = poisson::interval(alarms, 0.95);
    println!(
        "{:.2} h of signal (motion {} half of the time, {} taps/s, seeds from {}): {alarms} false alarms",
        run.hours, args.level, args.taps, args.seed
    );
    println!(
        "rate {:.3} an hour, 95 % interval {:.3} to {:.3}; mean interval {:.0} s, at least {:.0} s",
        alarms as f64 / run.hours,
        low / run.hours,
        high / run.hours,
        3600.0 * run.hours / (alarms as f64).max(1.0),
        3600.0 * run.hours / high
    );
    for (seed, t_s) in run.alarms.iter().take(20) {
        println!("  false alarm of the robot with seed {seed} at {t_s:.4} s");
    }
    run.peaks.sort_by(f64::total_cmp);
    let [median, tail, most] = [0.5, 0.9, 1.0].map(|q| quantile(&run.peaks, q));
    println!(
        "highest evidence of a minute over the interval: median {median:.2e}, 90 % {tail:.2e}, highest {most:.2e}"
    );
    Ok(())
}
