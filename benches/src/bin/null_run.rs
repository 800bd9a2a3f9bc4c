//! False alarms of the shipped detector on a simulated robot that holds an object which never slips.
#![expect(clippy::print_stdout, reason = "a program that prints its result")]
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "places in a list")]

use clap::Parser;
use grip_eval::poisson;
use slip_benches::detection::{Ours, RobotConfig, null_run};
use slip_core::{ConfigError, PipelineConfig, Signal, units::Hertz};

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

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let args = Args::parse();
    let robot = RobotConfig {
        level: args.level,
        taps_per_s: args.taps,
        reference: !args.no_reference,
        ..RobotConfig::default()
    };
    let config = pipeline(args.config.as_deref())?;
    Ours::new(config)?;
    let run = null_run(robot, args.hours, args.seed, || make(config));
    let (low, high) = poisson::interval(run.alarms, 0.95);
    println!(
        "{:.2} h of signal (motion {} half of the time, {} taps/s, seeds from {}): {} false alarms",
        run.hours, args.level, args.taps, args.seed, run.alarms
    );
    println!(
        "rate {:.3} an hour, 95 % interval {:.3} to {:.3}; mean interval {:.0} s, at least {:.0} s",
        run.alarms as f64 / run.hours,
        low / run.hours,
        high / run.hours,
        3600.0 * run.hours / (run.alarms as f64).max(1.0),
        3600.0 * run.hours / high
    );
    for (seed, t_s) in run.places.iter().take(20) {
        println!("  false alarm of the robot with seed {seed} at {t_s:.4} s");
    }
    println!("highest evidence of a minute over the interval: {}", spread(run.peaks));
    let names = ["shear", "vibration", "octave 1", "octave 2", "octave 3", "octave 4", "octaves"];
    for (place, name) in names.into_iter().enumerate() {
        let levels = run.levels.iter().filter_map(|l| l.get(place).copied()).collect();
        println!("{name:9} highest evidence of a minute (s): {}", spread(levels));
    }
    Ok(())
}

fn spread(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |q: f64| {
        values.get(((values.len() - 1) as f64 * q).round() as usize).copied().unwrap_or(0.0)
    };
    format!(
        "median {:.2e}, 90 % {:.2e}, 99 % {:.2e}, highest {:.2e}",
        at(0.5),
        at(0.9),
        at(0.99),
        at(1.0)
    )
}

fn pipeline(file: Option<&std::path::Path>) -> Result<PipelineConfig, Box<dyn core::error::Error>> {
    let rate = Hertz(10_000.0);
    Ok(match file {
        None => PipelineConfig::observing(Signal::Displacement, rate),
        Some(file) => PipelineConfig {
            grip: None,
            ..grip_session::HostConfig::read(file)?.pipeline(Signal::Displacement, rate)
        },
    })
}

#[expect(clippy::expect_used, reason = "checked before the run")]
fn make(config: PipelineConfig) -> Ours {
    let made: Result<Ours, ConfigError> = Ours::new(config);
    made.expect("checked")
}
