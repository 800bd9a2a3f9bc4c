//! Stylus profilometer traces: `NAME_primary.csv` and the instrument's `NAME_roughness.csv`.

use crate::{name, recordings};
use grip_eval::{
    profile::{Agreement, Evaluation, ProfileOptions, evaluate},
    roughness::{FilterKind, ProfileFilter},
};
use grip_record::HeightProfile;
use slip_core::irregularity::{Irregularity, IrregularityExtractor, SpatialLowPass};
use std::path::{Path, PathBuf};

/// Step of the instrument (m): 10 mm over the 28087 heights of a full trace. The shorter traces have the same step, but
/// their `x_mm` is stretched to 10 mm; `the_step_of_the_short_traces_is_that_of_the_full_ones` shows it.
const STEP_M: f64 = 10e-3 / 28_087.0;

fn traces() -> Vec<(PathBuf, HeightProfile, Vec<f64>)> {
    let read = |file: PathBuf| {
        let instrument = file.to_string_lossy().replace("_primary", "_roughness");
        let theirs = HeightProfile::read(Path::new(&instrument), Some(STEP_M)).unwrap().heights_m;
        let profile = HeightProfile::read(&file, None).unwrap();
        (file, profile, theirs)
    };
    recordings("surfcom_profiles", "_primary.csv").into_iter().map(read).collect()
}

fn at_true_step(profile: &HeightProfile) -> HeightProfile {
    HeightProfile { step_m: STEP_M, ..profile.clone() }
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn the_roughness_profile_is_the_instruments() {
    println!("trace, filter: correlation, Ra over the instrument's; Rz, RSm (um)");
    for (file, profile, theirs) in traces() {
        for filter in [FilterKind::MovingAverage, FilterKind::Gaussian] {
            let options = ProfileOptions { filter, ..ProfileOptions::new(2.5e-3) };
            let ours = evaluate(&at_true_step(&profile), &options).unwrap();
            let agreement = Agreement::of(&ours.roughness_m, &theirs).unwrap();
            println!(
                "{}, {filter:?}: {:.6}, {:.4}; {:.2}, {:.0}",
                name(&file),
                agreement.correlation,
                agreement.ra_ratio,
                1e6 * ours.parameters.rz_m,
                1e6 * ours.parameters.rsm_m.unwrap_or(f64::NAN)
            );
            assert!(agreement.correlation >= 0.999, "{}: {agreement:?}", file.display());
            // The instrument does not have the exact Gaussian: its Ra is 0.2 to 1.7 % off.
            let ra_within = if filter == FilterKind::Gaussian { 0.02 } else { 0.01 };
            assert!(
                (agreement.ra_ratio - 1.0).abs() <= ra_within,
                "{}: {agreement:?}",
                file.display()
            );
        }
    }
}

/// The difference to the instrument at the cutoff of `steps` steps, rms (um).
fn difference(profile: &HeightProfile, theirs: &[f64], steps: f64) -> f64 {
    let filter = ProfileFilter::new(FilterKind::MovingAverage, steps, 1.0).unwrap();
    let mut line = vec![0.0; theirs.len()];
    let mut scratch = vec![0.0; filter.scratch_len(theirs.len())];
    filter.mean_line(&profile.heights_m, &mut line, &mut scratch).unwrap();
    let ours: Vec<f64> = profile.heights_m.iter().zip(&line).map(|(z, l)| z - l).collect();
    Agreement::of(&ours, theirs).unwrap().rms_um
}

/// Which cutoff the instrument used, in steps of each trace: 2.5 mm at one and the same step.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn the_step_of_the_short_traces_is_that_of_the_full_ones() {
    for (file, profile, theirs) in traces() {
        let best = (900..=1100)
            .step_by(5)
            .map(|permille| f64::from(permille) * 1e-3)
            .min_by(|a, b| {
                let at = |scale: &f64| difference(&profile, &theirs, scale * 2.5e-3 / STEP_M);
                at(a).total_cmp(&at(b))
            })
            .unwrap();
        let in_file = 2.5 * best * profile.step_m / STEP_M;
        println!(
            "{}: {} heights; fits best with a cutoff of {:.3} mm at {:.4} um a step, or {in_file:.3} mm of its own x_mm",
            name(&file),
            theirs.len(),
            2.5 * best,
            1e6 * STEP_M
        );
        assert!((best - 1.0).abs() < 0.011, "{}: {best}", file.display());
    }
}

/// Normal deviates, nearly: the sum of twelve uniform numbers.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(self.0 >> 8) / f64::from(1 << 24) - 0.5
        };
        (0..12).map(|_| uniform()).sum()
    }
}

/// The roughness profile under a stylus at `speed` (m/s), 10 kHz, 0.1 um of noise: what the streaming extraction finds.
fn played(evaluation: &Evaluation, low_pass_m: f64, speed: f64, seed: u32) -> Vec<Irregularity> {
    let (heights, step) = (&evaluation.roughness_m, evaluation.step_m);
    let mut filter = SpatialLowPass::new(low_pass_m);
    let mut extractor = IrregularityExtractor::new(evaluation.hysteresis_m as f32);
    let mut noise = Noise(seed);
    let mut found = Vec::new();
    for i in 0_u32.. {
        let x = f64::from(i) * speed * 1e-4;
        #[expect(clippy::cast_sign_loss, reason = "not negative")]
        let left = (x / step) as usize;
        let Some([a, b]) = heights.get(left..left + 2) else { break };
        let height = a + (b - a) * (x / step - left as f64) + 1e-7 * noise.next();
        found.extend(extractor.push(x, filter.push(x, height as f32)));
    }
    found
}

fn means(all: &[Irregularity]) -> (f64, f64) {
    let mean = |f: fn(&Irregularity) -> f32| {
        all.iter().map(|i| f64::from(f(i))).sum::<f64>() / all.len() as f64
    };
    (1e6 * mean(|i| i.delta_m), 1e6 * mean(|i| i.spacing_m))
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn a_played_trace_gives_the_irregularities_of_the_profile() {
    println!(
        "trace: n, delta, s (um) of the profile; then delta and s of the played one over those, worst of three"
    );
    let (mut runs, mut off) = (0, Vec::new());
    for (file, profile, _) in traces() {
        let options = ProfileOptions::new(2.5e-3);
        let evaluation = evaluate(&at_true_step(&profile), &options).unwrap();
        let (delta, spacing) = means(&evaluation.irregularities);
        let n = evaluation.irregularities.len();
        print!("{}: {n}, {delta:.3}, {spacing:.1}", name(&file));
        for speed in [0.005, 0.02, 0.05] {
            let mut worst = (0.0_f64, 0.0_f64);
            for seed in 1..=3 {
                let found = played(&evaluation, options.low_pass_m, speed, seed);
                let (d, s) = means(&found);
                let ratio = (d / delta - 1.0, s / spacing - 1.0);
                worst = if ratio.0.abs() > worst.0.abs() { (ratio.0, worst.1) } else { worst };
                worst = if ratio.1.abs() > worst.1.abs() { (worst.0, ratio.1) } else { worst };
                runs += 1;
                // Also where nothing was found and the means are NaN.
                let within = ratio.0.abs() <= 0.05 && ratio.1.abs() <= 0.05;
                if !within {
                    off.push(format!(
                        "{} at {speed} m/s, seed {seed}: n {}, {ratio:?}",
                        name(&file),
                        found.len()
                    ));
                }
            }
            print!("; {:.0} mm/s {:+.1} % {:+.1} %", 1e3 * speed, 100.0 * worst.0, 100.0 * worst.1);
        }
        println!();
    }
    assert!(
        off.is_empty(),
        "{} of {runs} runs off by more than 5 %:\n{}",
        off.len(),
        off.join("\n")
    );
}
