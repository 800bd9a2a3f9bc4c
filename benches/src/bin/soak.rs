//! Drift of every streaming state over 1e9 steps; fails where one leaves its bound.
//!
//! `soak [STEPS]`: 1,000,000,000 unless said otherwise, about five minutes.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use slip_benches::exact::{angle::tan, cot, exact, relative_error};
use slip_core::{
    Phase, Pipeline, PipelineConfig, Sample,
    esc::{LiteralSum, Trial},
    filter::{Band, Envelope, FilterBank},
    units::{Hertz, Micros},
};
use std::process::ExitCode;

/// A periodic input of seven values with mean zero: after whole periods the exact answers are known.
const TONE: [f32; 7] = [3.0, -1.0, 2.0, -4.0, 1.0, -3.0, 2.0];

fn main() -> ExitCode {
    let Ok(steps) = std::env::args().nth(1).map_or(Ok(1_000_000_000), |text| text.parse::<u64>())
    else {
        println!("usage: soak [STEPS]");
        return ExitCode::from(2);
    };
    println!("{steps} steps");
    let results = [filters(steps), literal_f64(steps), literal_f32(steps), timestamps(steps)];
    if results.contains(&false) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn row(what: &str, figure: f64, limit: f64) -> bool {
    let kept = figure <= limit;
    println!("{what}: {figure:.2e}, limit {limit:.0e}: {}", if kept { "kept" } else { "BROKEN" });
    kept
}

/// Band-pass and envelope answer to a periodic input after all steps as they did after the first hundred thousand.
fn filters(steps: u64) -> bool {
    let bands = [Band { low_hz: 20.0, high_hz: 400.0 }, Band { low_hz: 100.0, high_hz: 800.0 }];
    let Ok(mut bank) = FilterBank::new(&bands, 10_000.0) else { return false };
    let mut envelope = Envelope::new(&[5e-3; 2], 10_000.0, [0.0; 2]);
    let mut early = [[0.0; 2]; 7];
    let mut worst = 0.0_f32;
    let start = 99_995;
    for k in 0..steps / 7 * 7 {
        let phase = (k % 7) as usize;
        // On a large offset, as a gripper whose stylus is pressed in has.
        let energy = envelope.step(&bank.step(1e-4 + 1e-6 * TONE[phase]));
        if (start..start + 7).contains(&k) {
            early[phase] = energy;
        } else if k >= start + 7 && k + 7 >= steps / 7 * 7 {
            for (now, then) in energy.iter().zip(early[phase]) {
                worst = worst.max((now / then - 1.0).abs());
            }
        }
    }
    row("band energy, relative change since step 1e5", f64::from(worst), 1e-3)
}

/// The same seven irregularities over and over: the exact sum is the count times that of seven.
fn literal_f64(steps: u64) -> bool {
    let lengths: Vec<(f64, f64)> =
        (0..16_u8).map(|i| (0.013 + 0.029 * f64::from(i), 1.0)).collect();
    let mut sum = LiteralSum::<f64>::default();
    let blocks = steps.div_ceil(16);
    for _ in 0..blocks {
        sum.extend(&lengths);
    }
    let seven = lengths.iter().fold(exact(0.0), |sum, (d, s)| sum + cot(*d, *s));
    let wanted = tan(&(seven * exact(blocks as f64))) * exact(16.0 * blocks as f64);
    let Some(esc) = sum.value(&Trial::new(1.0, 1.0)) else { return false };
    let inside = exact(esc.lo) <= wanted && wanted <= exact(esc.hi);
    println!(
        "E_sc f64: S = {:e} within {:.1e} rad, relative error {:.1e}",
        esc.sum,
        sum.bound(),
        relative_error(esc.value, &wanted)
    );
    row("E_sc f64, enclosure without the exact value", f64::from(u8::from(!inside)), 0.0)
}

fn literal_f32(steps: u64) -> bool {
    let mut sum = LiteralSum::<f32>::default();
    for _ in 0..steps {
        sum.push(0.25, 1.0);
    }
    let wanted = tan(&(cot(0.25, 1.0) * exact(steps as f64))) * exact(steps as f64);
    let Some(esc) = sum.value(&Trial::new(1.0, 1.0)) else { return false };
    let inside = (esc.lo == f32::NEG_INFINITY || exact(f64::from(esc.lo)) <= wanted)
        && (esc.hi == f32::INFINITY || wanted <= exact(f64::from(esc.hi)));
    println!("E_sc f32: S within {:.1e} rad (a full turn is 3.1)", sum.bound());
    row("E_sc f32, enclosure without the exact value", f64::from(u8::from(!inside)), 0.0)
}

/// A pipeline whose clock passes 2^32 us and then comes to its end: no slip from a resting stylus, no sample refused
/// before the last tick.
fn timestamps(steps: u64) -> bool {
    let config = PipelineConfig::gripping(Hertz(10_000.0));
    let Ok(mut pipeline) = Pipeline::<&'static [f32]>::new(config, None) else { return false };
    let steps = steps / 10;
    let mut slips = 0.0;
    let mut t = (1_u64 << 32) - steps.min(20_000_000) * 50;
    for k in 0..steps {
        if k == steps / 2 {
            t = u64::MAX - (steps - k) * 100;
        }
        #[expect(clippy::cast_precision_loss, reason = "below 101")]
        let noise = 1e-7 * ((k.wrapping_mul(2_654_435_761) >> 7) % 101) as f32 / 50.0 - 1e-7;
        let sample = Sample { normal_force_n: Some(2.0), ..Sample::stylus(Micros(t), noise) };
        let step = pipeline.handle(&sample);
        slips += f64::from(u8::from(step.event.is_some_and(|slip| slip.phase != Phase::Ended)));
        t = t.saturating_add(100);
    }
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let refused = pipeline.health_counters().unusable() as f64;
    row("slips of a resting stylus while the clock wraps 32 bits and jumps", slips, 0.0)
        & row("readings refused meanwhile", refused, 0.0)
}
