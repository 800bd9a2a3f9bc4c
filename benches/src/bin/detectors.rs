//! Run time of every detector against its latency at stated false-alarm rates; the latency that theory allows beside it.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints its result")]

use clap::Parser;
use slip_benches::detection::{
    Hand, RobotConfig, Slips,
    bound::simulated,
    contest::{self, CONTESTANTS},
    cost,
    report::{BoundRow, Cost, PER_HOUR, Report, SHOWN},
};
use std::{path::PathBuf, time::Instant};

/// Sets the thresholds of every detector for stated false-alarm rates on simulated hours without slip, counts its false alarms on as many
/// fresh ones, and lets objects slip: still and moving robot, three roughnesses, the same samples for all detectors.
#[derive(Debug, Parser)]
#[command(name = "detectors")]
struct Args {
    /// Hours without slip for the thresholds, and again for the count.
    #[arg(long, default_value_t = 4.0)]
    hours: f64,
    /// Slips of each of the six kinds.
    #[arg(long, default_value_t = 200)]
    count: u64,
    /// First seed of the hours for the thresholds; those for the count begin 1,000,000 later, those of the slips 2,000,000.
    #[arg(long, default_value_t = 20_000_000)]
    seed: u64,
    /// Folder for detectors.json and the charts.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Only the run time: this many rounds, and no charts.
    #[arg(long)]
    cost_rounds: Option<u32>,
    /// Only detectors whose name begins so (run time only).
    #[arg(long, default_value = "", requires = "cost_rounds")]
    only: String,
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let args = Args::parse();
    let robot = RobotConfig::default();
    let cost = run_time(robot, args.cost_rounds.unwrap_or(40), &args.only)?;
    if args.cost_rounds.is_some() {
        cost.iter().for_each(|cost| println!("{cost}"));
        return Ok(());
    }
    eprintln!("thresholds: {} h without slip", args.hours);
    let mut working = contest::thresholds(robot, args.hours, args.seed, &PER_HOUR)?;
    eprintln!("false alarms: {} fresh hours", args.hours);
    contest::count_false(robot, args.hours, args.seed + 1_000_000, &mut working, &SHOWN)?;
    let mut bounds = Vec::new();
    for slips in kinds(args.count, args.seed + 2_000_000) {
        let robot_is = if slips.moving { "moving" } else { "still" };
        eprintln!("slips: Ra {} um, robot {robot_is}", slips.ra_um);
        contest::let_slip(robot, slips, &mut working)?;
        for per_hour in SHOWN {
            let least = simulated(robot, slips, 3600.0 / per_hour);
            bounds.push(BoundRow::new(robot, slips, per_hour, &least));
        }
    }
    for rate_hz in [1000.0, 2200.0, 20_000.0] {
        let robot = RobotConfig { rate_hz, ..robot };
        for slips in kinds(args.count, args.seed + 2_000_000).filter(|slips| !slips.moving) {
            bounds.push(BoundRow::new(robot, slips, 1.0, &simulated(robot, slips, 3600.0)));
        }
    }
    let report = Report { hours: args.hours, cost, working, bounds };
    print!("{report}");
    if let Some(folder) = &args.out {
        report.write(folder)?;
    }
    Ok(())
}

fn kinds(count: u64, seed: u64) -> impl Iterator<Item = Slips> {
    [false, true].into_iter().flat_map(move |moving| {
        [0.4, 1.6, 6.3].into_iter().map(move |ra_um| Slips { ra_um, moving, count, seed })
    })
}

/// Ten seconds of a held object, the robot moving for half of the time, with the floor learned before.
fn run_time(
    robot: RobotConfig,
    rounds: u32,
    only: &str,
) -> Result<Vec<Cost>, Box<dyn core::error::Error>> {
    let mut hand = Hand::new(robot, 1.6, 77);
    let mut warm = contest::deaf(robot.rate_hz)?;
    contest::warm_up(&mut hand, &mut warm);
    let samples: Vec<_> = (0..100_000).map(|_| hand.sample()).collect();
    #[expect(clippy::disallowed_methods, reason = "a program may read a clock")]
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64() * 1e9;
    let taking_part = CONTESTANTS.iter().zip(warm).filter(|(c, _)| c.name.starts_with(only));
    let (names, warm): (Vec<&str>, Vec<_>) = taking_part.map(|(c, warm)| (c.name, warm)).unzip();
    let ns = cost(&warm, &samples, rounds, &clock);
    Ok(names.into_iter().zip(ns).map(|(detector, ns)| Cost { detector, ns }).collect())
}
