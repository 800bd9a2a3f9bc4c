//! Irregularities and E_sc with and without waviness: on simulated surfaces whose waviness is known, and on the traces.

use crate::{name, traces};
use grip_eval::profile::{Evaluation, ProfileLine, ProfileOptions, evaluate};
use grip_record::HeightProfile;
use grip_sim::{shape::Shape, surface::Surface};
use slip_core::esc::{EscSums, Reading, Trial};

const SURFACES: u64 = 60;
/// Seeds of no other page and no other test.
const FIRST_SEED: u64 = 52_000;
const LITERAL: usize = 0;
const SLOPE_POWER: usize = 2;

fn trial() -> Trial {
    Trial::new(2.0, 0.05)
}

fn options() -> ProfileOptions {
    ProfileOptions { form_degree: 2, ..ProfileOptions::new(0.8e-3) }
}

fn line(evaluation: &Evaluation) -> ProfileLine {
    ProfileLine::new(evaluation, &options(), &trial())
}

/// 8 mm at 2 um of the asperities of `seed` on a bent form, with waviness of `amplitude_m` and 2 mm.
fn simulated(seed: u64, amplitude_m: f64) -> HeightProfile {
    let part = |k: u32| (seed * u64::from(k) % 1000) as f64 * core::f64::consts::TAU / 1000.0;
    let shape = Shape {
        amplitude_m,
        wavelength_m: 2e-3,
        phases: [part(7), part(131), part(577)],
        tilt: 2e-3,
        curvature_1_m: 0.7,
    };
    let mut surface = Surface::new(1.2e-6, 130e-6, seed).with_shape(shape);
    let heights_m = (0..4000).map(|i| surface.height(f64::from(i) * 2e-6)).collect();
    HeightProfile::new(heights_m, 2e-6)
}

/// Mean of |w| of the waviness and n, literal and slope power of the true irregularities over those 8 mm.
fn truth(seed: u64) -> (u32, f64) {
    let mut sums = EscSums::default();
    let surface = Surface::new(1.2e-6, 130e-6, seed);
    let n = surface.within(8e-3).map(|a| _ = sums.push(a.delta_m, a.spacing_m)).count();
    (n as u32, sums.value(Reading::SlopePower, &trial()).unwrap().value)
}

/// Fifth, fiftieth and ninety-fifth percentile.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    [5, 50, 95].map(|percent| sorted[(sorted.len() - 1) * percent / 100])
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (a, b) = pairs.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(x, y)| f(*x, *y)).sum::<f64>();
    sum(&|x, y| (x - a) * (y - b))
        / (sum(&|x, _| (x - a).powi(2)) * sum(&|_, y| (y - b).powi(2))).sqrt()
}

#[test]
fn e_sc_of_simulated_surfaces_with_and_without_waviness() {
    println!(
        "{SURFACES} surfaces from seed {FIRST_SEED}: waviness, then 5, 50 and 95 % of each ratio"
    );
    let flat: Vec<ProfileLine> = (FIRST_SEED..FIRST_SEED + SURFACES)
        .map(|seed| line(&evaluate(&simulated(seed, 0.0), &options()).unwrap()))
        .collect();
    for amplitude_um in [0.0, 3.0, 10.0] {
        let lines: Vec<ProfileLine> = (FIRST_SEED..FIRST_SEED + SURFACES)
            .map(|seed| simulated(seed, amplitude_um * 1e-6))
            .map(|profile| line(&evaluate(&profile, &options()).unwrap()))
            .collect();
        let value = |line: &ProfileLine, reading: usize| line.esc[reading].value.unwrap();
        let primary = |line: &ProfileLine, reading: usize| line.primary.esc[reading].value.unwrap();
        let ratio = |reading| spread(lines.iter().map(|l| primary(l, reading) / value(l, reading)));
        let wa = spread(lines.iter().map(|l| l.wa_um.unwrap()));
        let to_flat = spread(
            lines.iter().zip(&flat).map(|(l, f)| value(l, SLOPE_POWER) / value(f, SLOPE_POWER)),
        );
        let to_truth = spread(
            lines.iter().zip(FIRST_SEED..).map(|(l, seed)| value(l, SLOPE_POWER) / truth(seed).1),
        );
        let count = spread(lines.iter().map(|l| l.primary.n as f64 / l.n as f64));
        let counted = spread(
            lines.iter().zip(FIRST_SEED..).map(|(l, seed)| l.n as f64 / f64::from(truth(seed).0)),
        );
        let both = |reading| {
            let pairs: Vec<_> =
                lines.iter().map(|l| (value(l, reading), primary(l, reading))).collect();
            correlation(&pairs)
        };
        let angle = |l: &f64| (l / 10.0).atan();
        let angles: Vec<_> = lines
            .iter()
            .map(|l| (angle(&value(l, LITERAL)), angle(&primary(l, LITERAL))))
            .collect();
        println!(
            "A {amplitude_um} um, Wa {wa:.2?} um, Ra {:.2?}\n  primary / roughness: n {count:.3?}, slope_power {:.3?} (correlation {:.3}), literal {:.2?} (correlation of its arctangent {:.3})\n  roughness with / without waviness: slope_power {to_flat:.3?}\n  roughness / true irregularities: n {counted:.3?}, slope_power {to_truth:.3?}",
            spread(lines.iter().map(|l| l.ra_um)),
            ratio(SLOPE_POWER),
            both(SLOPE_POWER),
            ratio(LITERAL),
            correlation(&angles),
        );
        assert!((to_flat[1] - 1.0).abs() < 0.05, "{to_flat:?}");
        assert!((ratio(SLOPE_POWER)[1] - 1.0).abs() < 0.1, "{:?}", ratio(SLOPE_POWER));
    }
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn e_sc_of_the_traces_with_and_without_waviness() {
    println!(
        "trace: Ra, Wa, Wz (um); n, slope_power (W), literal (W) of roughness; the same of the primary profile"
    );
    for (file, profile, _) in traces::traces() {
        let line = line(&evaluate(&traces::at_true_step(&profile), &options()).unwrap());
        let value = |reading: usize| line.esc[reading].value.unwrap();
        let primary = |reading: usize| line.primary.esc[reading].value.unwrap();
        println!(
            "| {} | {:.3} | {:.3} | {:.2} | {} | {:.4e} | {:+.3e} | {} | {:.4e} | {:+.3e} |",
            name(&file).trim_end_matches("_primary"),
            line.ra_um,
            line.wa_um.unwrap(),
            line.wz_um.unwrap(),
            line.n,
            value(SLOPE_POWER),
            value(LITERAL),
            line.primary.n,
            primary(SLOPE_POWER),
            primary(LITERAL),
        );
        let at_2_5 = ProfileOptions::new(2.5e-3);
        assert_eq!(evaluate(&traces::at_true_step(&profile), &at_2_5).unwrap().waviness, None);
    }
}
