//! Whether the certified false-alarm interval holds on noise of several laws, and what it costs in delay.
#![expect(clippy::print_stdout, reason = "a program that prints its result")]

use clap::Parser;
use grip_eval::poisson;
use rayon::prelude::*;
use slip_benches::{
    detection::bound,
    null_laws::{Alarms, Delays, Law, Noise, calibrated, null_run, shipped, slips},
};

/// Calibrates on one stretch of noise and judges on others of the same law: false alarms without slip, and delays of slips.
#[derive(Debug, Parser)]
#[command(name = "null-laws")]
struct Args {
    /// Hours of noise of each law, shared by the calibrations.
    #[arg(long, default_value_t = 50.0)]
    hours: f64,
    /// Wanted mean time between false alarms (s).
    #[arg(long, default_value_t = 600.0)]
    interval: f64,
    /// Length of a calibration (s).
    #[arg(long, default_value_t = 600.0)]
    calibration_s: f64,
    /// Calibrations of each law.
    #[arg(long, default_value_t = 10)]
    calibrations: u32,
    /// Slips of each size, shared by the calibrations.
    #[arg(long, default_value_t = 300)]
    slips: u32,
    /// First seed.
    #[arg(long, default_value_t = 50_000_000)]
    seed: u64,
}

/// Energy of a slip over that of the noise (dB).
const SLIPS_DB: [f64; 3] = [6.0, 10.0, 20.0];

/// What one calibration led to.
struct Judged {
    alarms: Alarms,
    /// Of the shipped settings, on a further stretch.
    shipped: Alarms,
    certified: bool,
    blocks_ms: [f64; 2],
    clusters: f64,
    claimed_s: f64,
    delays: Vec<Vec<Delays>>,
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let args = Args::parse();
    println!(
        "{} calibrations of {:.0} s a law, each judged on {:.1} h of another stretch; wanted one false alarm in {:.0} s",
        args.calibrations,
        args.calibration_s,
        args.hours / f64::from(args.calibrations),
        args.interval
    );
    println!(
        "| law | certified: alarms | mean interval s (95 %) | most in one calibration (expected at most) | fast trigger, calibrated: alarms, interval s (95 %), least claimed s | shipped: alarms, interval s (95 %) | blocks ms | clusters | delay 6 dB certified / fast | 10 dB | 20 dB |\n|---|---|---|---|---|---|---|---|---|---|---|"
    );
    for (place, law) in (0_u64..).zip(Law::ALL) {
        let seed = args.seed + 1_000_000 * place;
        // A stretch that gives no calibration is said, and another one taken.
        let judged: Vec<Judged> = (0..args.calibrations)
            .into_par_iter()
            .filter_map(|n| {
                (0..10).find_map(|again| {
                    let seed = seed + 100 * u64::from(n) + 10 * again;
                    judge(&args, law, seed)
                        .map_err(|error| eprintln!("{}, seed {seed}: {error}", law.name()))
                        .ok()
                })
            })
            .collect();
        print(&args, law, &judged);
    }
    // The octaves that the rate carries: 30-90, 90-250 and 250-700 Hz.
    let bounds = SLIPS_DB.map(|db| {
        let snr = 10.0_f64.powf(0.1 * db);
        1e3 * bound::delay_s(&[(60.0, snr), (160.0, snr), (450.0, snr)], args.interval)
    });
    println!("ln(ARL)/KL for Gaussian noise, mean ms: {bounds:.1?}");
    Ok(())
}

fn judge(args: &Args, law: Law, seed: u64) -> Result<Judged, String> {
    let mut noise = Noise::new(law, seed);
    let (made, config) = calibrated(&mut noise, args.calibration_s, args.interval)
        .map_err(|error| error.to_string())?;
    let hours = args.hours / f64::from(args.calibrations);
    let refused = |error: slip_core::ConfigError| error.to_string();
    let count = args.slips.div_ceil(args.calibrations) as usize;
    let stylus = made.calibration.stylus().ok_or("the noise is that of a stylus")?;
    let laws = stylus.certified.map_or([None; 2], |certified| [certified.rest, certified.motion]);
    let laws = || laws.into_iter().flatten();
    if let Err(why) = made.certified {
        eprintln!("{} {seed}: {why}", law.name());
    }
    Ok(Judged {
        alarms: null_run(&mut noise, hours, config).map_err(refused)?,
        shipped: null_run(&mut noise, hours, shipped()).map_err(refused)?,
        certified: made.certified.is_ok(),
        blocks_ms: [
            laws().map(|law| law.blocks_ms[0]).fold(f64::INFINITY, f64::min),
            laws().map(|law| law.blocks_ms[1]).fold(0.0, f64::max),
        ],
        clusters: laws().map(|law| law.clusters).fold(0.0, f64::max),
        claimed_s: stylus.evidence.interval_low_s.min(args.interval),
        delays: SLIPS_DB
            .map(|db| slips(&mut noise, count, 10.0_f64.powf(0.1 * db), config).map_err(refused))
            .into_iter()
            .collect::<Result<_, _>>()?,
    })
}

/// The mean interval and its exact interval at 95 %.
fn interval(hours: f64, alarms: u64) -> String {
    let (low, high) = poisson::interval(alarms, 0.95);
    let s = 3600.0 * hours;
    match alarms {
        0 => format!("- ({:.0} or more)", s / high),
        _ => format!("{:.0} ({:.0} to {:.0})", s / alarms as f64, s / high, s / low),
    }
}

fn print(args: &Args, law: Law, judged: &[Judged]) {
    let sum = |of: fn(&Judged) -> u64| judged.iter().map(of).sum::<u64>();
    let hours: f64 = judged.iter().filter(|j| j.certified).map(|j| j.alarms.hours).sum();
    let all_hours: f64 = judged.iter().map(|j| j.alarms.hours).sum();
    let most = judged.iter().map(|j| j.alarms.certified).max().unwrap_or(0);
    let expected = 3600.0 * args.hours / f64::from(args.calibrations) / args.interval;
    let of_shipped = sum(|j| j.shipped.fast);
    let (certified, fast) = (sum(|j| j.alarms.certified), sum(|j| j.alarms.fast));
    let range = |of: &dyn Fn(&Judged) -> f64| {
        let values = || judged.iter().filter(|j| j.certified).map(of);
        (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max))
    };
    let shortest = range(&|j| j.blocks_ms[0]).0;
    let longest = range(&|j| j.blocks_ms[1]).1;
    let (low, high) = range(&|j| j.clusters);
    let delays: Vec<String> = (0..SLIPS_DB.len())
        .map(|size| {
            let all: Vec<Delays> =
                judged.iter().filter_map(|j| j.delays.get(size)).flatten().copied().collect();
            let certified = quantiles(all.iter().map(|d| d.certified_ms));
            format!("{certified} / {}", quantiles(all.iter().map(|d| d.fast_ms)))
        })
        .collect();
    println!(
        "| {} | {certified} in {hours:.0} h ({} of {} certify) | {} | {most} ({expected:.0}) | {fast}, {}, {:.0} | {of_shipped}, {} | {shortest:.0}-{longest:.0} | {low:.1}-{high:.1} | {} |",
        law.name(),
        judged.iter().filter(|j| j.certified).count(),
        judged.len(),
        interval(hours, certified),
        interval(all_hours, fast),
        judged.iter().map(|j| j.claimed_s).fold(f64::INFINITY, f64::min),
        interval(all_hours, of_shipped),
        delays.join(" | ")
    );
}

/// Median and 95 % (ms), and what was missed.
fn quantiles(delays: impl Iterator<Item = Option<f64>>) -> String {
    let mut all: Vec<f64> = delays.map(|ms| ms.unwrap_or(f64::INFINITY)).collect();
    all.sort_by(f64::total_cmp);
    let at = |share: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place")]
        let place = (share * (all.len().max(1) - 1) as f64).round() as usize;
        match all.get(place) {
            Some(ms) if ms.is_finite() => format!("{ms:.0}"),
            _ => "-".to_owned(),
        }
    };
    let missed = all.iter().filter(|ms| ms.is_infinite()).count();
    let text = format!("{}-{}", at(0.5), at(0.95));
    if missed > 0 { format!("{text} (missed {missed} of {})", all.len()) } else { text }
}
