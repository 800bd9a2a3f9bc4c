extern crate std;

use super::{BET, Certificate, Evidence, LIMITS, ScoreLaw};
use crate::detector::{BANDS, Block};
use std::vec::Vec;

/// Uniform numbers in (0, 1).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as f64 + 0.5) / f64::from(1_u32 << 31)
    }

    /// Exponentially distributed with mean 1: P(x > t) = exp(-t).
    fn energy(&mut self) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "test data")]
        let energy = -self.next().ln() as f32;
        energy
    }
}

/// The law of single exponential scores, with the limits that are passed with chances 2^-2 .. 2^-16.
fn law(blocks: [u32; BANDS]) -> ScoreLaw {
    let chances: [f32; LIMITS] = core::array::from_fn(|j| libm::exp2f(-2.0 * (j as f32 + 1.0)));
    ScoreLaw { blocks, limits: [chances.map(|p| -p.ln()); BANDS], chances: [chances; BANDS] }
}

fn block(energy: [f32; BANDS]) -> Block {
    Block { energy, floor: [1.0; BANDS], moving: false }
}

/// The evidence by its definition: over all pasts, what would have been won by a bet that began then.
fn by_definition(law: &ScoreLaw, scores: &[Vec<f64>; BANDS], base_s: f64) -> f64 {
    let bands = law.blocks.iter().filter(|n| **n > 0).count() as f64;
    let mut total = 0.0;
    for b in (0..BANDS).filter(|b| law.blocks[*b] > 0) {
        let long = law.blocks[b] as usize;
        let factors: Vec<f64> = scores[b]
            .chunks_exact(long)
            .map(|block| {
                let score = block.iter().sum::<f64>() / long as f64;
                let won: f64 = (0..LIMITS)
                    .filter(|j| score > f64::from(law.limits[b][*j]))
                    .map(|j| 1.0 / f64::from(law.chances[b][j]))
                    .sum();
                1.0 - f64::from(BET) + f64::from(BET) * won / LIMITS as f64
            })
            .collect();
        let since = |from: usize| factors[from..].iter().product::<f64>();
        total += (0..factors.len()).map(|from| long as f64 * base_s * since(from)).sum::<f64>();
    }
    total / bands
}

#[test]
fn agrees_with_the_formula() {
    let law = law([1, 2, 1, 4, 0, 1]);
    let certificate = Certificate { interval_s: 1e9, rest: Some(law), motion: None };
    // Ten decisions of half a millisecond make a base block.
    let mut evidence = Evidence::new(&certificate, 5e-4);
    let mut uniform = Uniform(1);
    let mut scores: [Vec<f64>; BANDS] = core::array::from_fn(|_| Vec::new());
    for n in 0..300 {
        let level = if n > 280 { 2.0 } else { 1.0 };
        let mut sums = [0.0; BANDS];
        for _ in 0..10 {
            let energy: [f32; BANDS] = core::array::from_fn(|_| level * uniform.energy());
            for (sum, e) in sums.iter_mut().zip(energy) {
                *sum += f64::from(e);
            }
            evidence.step(&block(energy));
        }
        scores.iter_mut().zip(sums).for_each(|(scores, sum)| scores.push(0.1 * sum));
        let got = f64::from(evidence.evidence_s.iter().sum::<f32>()) / 5.0;
        let wanted = by_definition(&law, &scores, 5e-3);
        assert!((got / wanted - 1.0).abs() < 1e-4 || n < 4, "{n}: {got}, wanted {wanted}");
        let last = evidence.scores().unwrap();
        assert!((f64::from(last.scores[3]) / scores[3][n] - 1.0).abs() < 1e-5);
        assert_eq!(last.number, n as u64);
    }
}

/// Where the chances are the true ones, certified false alarms come no more often than once in the interval, for independent bands and for
/// bands that all show the same.
#[test]
fn the_interval_is_kept() {
    for same in [false, true] {
        let certificate =
            Certificate { interval_s: 2.0, rest: Some(law([1; BANDS])), motion: None };
        let mut evidence = Evidence::new(&certificate, 5e-3);
        let mut uniform = Uniform(7);
        let blocks = 2_000_000;
        let alarms = (0..blocks)
            .filter(|_| {
                let one = uniform.energy();
                let energy = core::array::from_fn(|_| if same { one } else { uniform.energy() });
                evidence.step(&block(energy))
            })
            .count();
        let mean_s = 5e-3 * f64::from(blocks) / alarms as f64;
        // Four deviations of the count.
        assert!(mean_s > 2.0 / (1.0 + 4.0 / (alarms as f64).sqrt()), "{mean_s} s, {alarms}");
        assert!(mean_s < 40.0, "not for want of power: {mean_s} s");
    }
}

#[test]
fn a_slip_is_certified_in_a_few_blocks_and_forgotten_with_its_certificate() {
    let certificate = Certificate { interval_s: 600.0, rest: Some(law([1; BANDS])), motion: None };
    let mut evidence = Evidence::new(&certificate, 5e-3);
    let mut uniform = Uniform(3);
    for _ in 0..1000 {
        assert!(!evidence.step(&block(core::array::from_fn(|_| uniform.energy()))));
    }
    let after = (1..20).find(|_| evidence.step(&block([100.0; BANDS]))).unwrap();
    assert!((2..=4).contains(&after), "{after}");
    assert!(evidence.is_certified() && !evidence.step(&block([0.1; BANDS])));
}

/// A floor that has fallen since changes neither scores at rest nor those in motion.
#[test]
fn a_lowered_floor_changes_no_score() {
    let certificate = Certificate { interval_s: 600.0, rest: None, motion: None };
    let mut evidence = Evidence::new(&certificate, 5e-3);
    let score = |evidence: &mut Evidence, energy: f32, floor: f32| {
        let [energy, floor] = [[energy; BANDS], [floor; BANDS]];
        evidence.step(&Block { energy, floor, moving: floor[0] > 1.0 });
        evidence.scores().unwrap().scores[2]
    };
    assert_eq!(score(&mut evidence, 6.0, 1.0), 6.0);
    assert_eq!(score(&mut evidence, 6.0, 3.0), 2.0);
    evidence.rescale([0.25; BANDS]);
    // In units of a quarter of the floor the energy is 24, and motion of twice the floor is 8.
    assert_eq!(score(&mut evidence, 24.0, 1.0), 6.0);
    assert_eq!(score(&mut evidence, 24.0, 9.0), 2.0);
}

#[test]
fn wrong_values_are_refused() {
    let certificate = |interval_s: f32, law: ScoreLaw| {
        Certificate { interval_s, rest: None, motion: Some(law) }.check()
    };
    let good = law([1; BANDS]);
    assert_eq!(certificate(600.0, good), Ok(()));
    let mut zero = good;
    zero.chances[2][3] = 0.0;
    let mut nan = good;
    nan.limits[5][0] = f32::NAN;
    for (interval_s, law) in [(f32::NAN, good), (0.1, good), (600.0, zero), (600.0, nan)] {
        assert!(certificate(interval_s, law).is_err(), "{interval_s} {law:?}");
    }
    // A band without a part has no limits.
    nan.blocks[5] = 0;
    assert_eq!(certificate(600.0, nan), Ok(()));
}
