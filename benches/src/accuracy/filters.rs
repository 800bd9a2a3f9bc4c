//! Second-order Butterworth low-passes: state-variable sections and direct-form biquads in both formats.
#![expect(clippy::cast_possible_truncation, reason = "f32 is one of the formats compared")]

use super::{Candidate, Clock, Panel};
use crate::exact::{BITS, Draw, Exact, exact, to_f64};
use slip_core::filter::{Svf, SvfLanes};

const RATE_HZ: f64 = 10_000.0;

/// One panel for each corner.
pub(super) fn panels(few: usize, clock: Clock<'_>) -> Vec<Panel> {
    [("filter_2hz", 2.0_f32), ("filter_100hz", 100.0), ("filter_1khz", 1000.0)]
        .into_iter()
        .map(|(name, corner_hz)| panel(name, corner_hz, 20_000 / few, clock))
        .collect()
}

fn panel(name: &'static str, corner_hz: f32, count: usize, clock: Clock<'_>) -> Panel {
    let mut draw = Draw::new(51);
    let input: Vec<f32> = (0..count).map(|_| (2.0 * draw.unit() - 1.0) as f32).collect();
    let wanted = exact_low_pass(f64::from(corner_hz), &input);
    let rms = (wanted.iter().map(|y| y * y).sum::<f64>() / wanted.len() as f64).sqrt();
    type Filter = fn(f32, &[f32], &mut Vec<f64>);
    let filters: [(&'static str, Filter); 4] = [
        ("state-variable f32", state_variable_f32),
        ("state-variable f64", state_variable_f64),
        ("biquad f32", biquad_f32),
        ("biquad f64", biquad_f64),
    ];
    let candidates = filters.map(|(name, run)| {
        let mut out = Vec::with_capacity(count);
        run(corner_hz, &input, &mut out);
        let errors = out.iter().zip(&wanted).map(|(got, want)| (got - want).abs() / rms).collect();
        let input = &input;
        let work = Box::new(move || {
            out.clear();
            run(corner_hz, input, &mut out);
            out.last().copied().unwrap_or(0.0)
        });
        Candidate { name: name.into(), errors, work }
    });
    Panel {
        name,
        title: format!("Low-pass {corner_hz} Hz at 10 kHz: run time against error"),
        item: "sample",
        measure: "relative error",
        error: format!(
            "relative to the rms of the output, {count} samples of white noise, 67 digits"
        ),
        rows: Vec::new(),
    }
    .measure(candidates.into(), count, clock)
}

/// The bilinear transform of the Butterworth section in direct form, b (1 + 2 z^-1 + z^-2) over 1 + a1 z^-1 + a2 z^-2.
fn exact_low_pass(corner_hz: f64, input: &[f32]) -> Vec<f64> {
    let g = (Exact::pi(BITS) * exact(corner_hz) / exact(RATE_HZ)).tan();
    let (one, two) = (exact(1.0), exact(2.0));
    let k = exact(2.0).sqrt();
    let norm = &one / (&one + &g * (&g + &k));
    let b = &g * &g * &norm;
    let a1 = &two * (&g * &g - &one) * &norm;
    let a2 = (&one + &g * (&g - &k)) * &norm;
    let (mut s1, mut s2) = (exact(0.0), exact(0.0));
    input
        .iter()
        .map(|x| {
            let bx = &b * exact(f64::from(*x));
            let y = &bx + &s1;
            s1 = &two * &bx - &a1 * &y + &s2;
            s2 = bx - &a2 * &y;
            to_f64(&y)
        })
        .collect()
}

fn state_variable_f32(corner_hz: f32, input: &[f32], out: &mut Vec<f64>) {
    let Ok(section) = Svf::butterworth(corner_hz, RATE_HZ as f32) else { return };
    let mut section = SvfLanes::new([section]);
    out.extend(input.iter().map(|x| f64::from(section.low(&[*x])[0])));
}

fn state_variable_f64(corner_hz: f32, input: &[f32], out: &mut Vec<f64>) {
    let g = (core::f64::consts::PI * f64::from(corner_hz) / RATE_HZ).tan();
    let a1 = 1.0 / (1.0 + g * (g + core::f64::consts::SQRT_2));
    let (a2, a3) = (g * a1, g * g * a1);
    let (mut ic1, mut ic2) = (0.0, 0.0);
    out.extend(input.iter().map(|x| {
        let v3 = f64::from(*x) - ic2;
        let v1 = a1 * ic1 + a2 * v3;
        let v2 = ic2 + a2 * ic1 + a3 * v3;
        ic1 = 2.0 * v1 - ic1;
        ic2 = 2.0 * v2 - ic2;
        v2
    }));
}

/// b, a1, a2 in doubles.
fn design(corner_hz: f32) -> [f64; 3] {
    let g = (core::f64::consts::PI * f64::from(corner_hz) / RATE_HZ).tan();
    let k = core::f64::consts::SQRT_2;
    let norm = 1.0 / (1.0 + g * (g + k));
    [g * g * norm, 2.0 * (g * g - 1.0) * norm, (1.0 + g * (g - k)) * norm]
}

macro_rules! biquads {
    ($($name:ident $number:ty),*) => {$(
        /// Transposed direct form II.
        fn $name(corner_hz: f32, input: &[f32], out: &mut Vec<f64>) {
            let [b, a1, a2] = design(corner_hz).map(|c| c as $number);
            let (mut s1, mut s2) = (0.0, 0.0);
            out.extend(input.iter().map(|x| {
                let bx = b * <$number>::from(*x);
                let y = bx + s1;
                s1 = 2.0 * bx - a1 * y + s2;
                s2 = bx - a2 * y;
                f64::from(y)
            }));
        }
    )*};
}

biquads!(biquad_f32 f32, biquad_f64 f64);
