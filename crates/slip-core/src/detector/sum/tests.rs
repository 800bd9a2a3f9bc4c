#![expect(clippy::cast_possible_truncation, reason = "test signals")]
extern crate std;
use super::{AlarmSum, BANDS, Block, COMPONENTS, DetectorConfig, JOINT, exp};

/// Independent readings in a block of 0.5 ms at 10 kHz.
const READINGS: [f32; BANDS] = [0.38, 0.7, 0.06, 0.16, 0.45, 2.3];
const BLOCK_S: f32 = 5e-4;

fn sum(interval_s: f32) -> AlarmSum {
    let config = DetectorConfig { interval_s, ..DetectorConfig::default() };
    AlarmSum::new(&config, &READINGS, BLOCK_S)
}

/// Uniform numbers above 0 and up to 1, seeded.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*state >> 11) + 1) as f64 / (1_u64 << 53) as f64
}

fn gaussian(state: &mut u64) -> f64 {
    libm::sqrt(-2.0 * libm::log(uniform(state)))
        * libm::cos(core::f64::consts::TAU * uniform(state))
}

#[test]
fn exp_is_the_exponential() {
    for i in -8000..=1300 {
        let x = f32::from(i16::try_from(i).unwrap()) * 0.01;
        let (got, wanted) = (f64::from(exp(x)), libm::exp(f64::from(x)));
        // The argument itself is rounded.
        let allowed = 4e-7 + 1.2e-7 * f64::from(x.abs());
        assert!((got / wanted - 1.0).abs() < allowed, "{x}: {got} {wanted}");
    }
    assert!(exp(f32::NEG_INFINITY) < 1e-34 && exp(-1e9) < 1e-34);
}

/// The module's formulas in f64, one line each.
#[test]
fn agrees_with_the_formula() {
    let (mut fast, mut state) = (sum(60.0), 3);
    let mut evidence_s = [0.0_f64; COMPONENTS];
    let config = DetectorConfig::default();
    for k in 0..4000_u32 {
        let moving = (k / 1000) % 2 == 1;
        let loud = if (k / 250) % 4 == 3 { 30.0 } else { 1.0 };
        let energy = core::array::from_fn(|_| (loud * gaussian(&mut state).powi(2)) as f32);
        let floor = if moving {
            core::array::from_fn(|_| (1.0 + uniform(&mut state)) as f32)
        } else {
            [1.0; BANDS]
        };
        let got = fast.step(&Block { energy, floor, moving });
        let slack = if moving { config.slack_moving } else { config.slack_still };
        let l = |b: usize, slack: f32| {
            let (n, z) = (f64::from(READINGS[b]), f64::from(energy[b]) / f64::from(floor[b]));
            n / 2.0 * (z / f64::from(slack) * (1.0 - 1.0 / 6.0) - libm::log(6.0))
        };
        let mut gains: [f64; COMPONENTS] =
            core::array::from_fn(|b| if b < BANDS { l(b, slack[b]).min(5.0) } else { 0.0 });
        let decides =
            if moving { [true; COMPONENTS] } else { [true, true, false, false, true, true, false] };
        if moving {
            gains[JOINT] =
                (2..BANDS).map(|b| (0.5 * l(b, slack[JOINT])).min(6.0)).sum::<f64>().min(12.0);
        }
        let mut mean_s = 0.0;
        let count = decides.iter().filter(|decides| **decides).count() as f64;
        for i in 0..COMPONENTS {
            let now_s = libm::exp(gains[i]) * (evidence_s[i] + f64::from(BLOCK_S));
            mean_s += if decides[i] { now_s / count } else { 0.0 };
            evidence_s[i] = if decides[i] { now_s.min(60.0 * libm::exp(2.0)) } else { 0.0 };
        }
        let wanted = mean_s / 60.0;
        assert!((f64::from(got) / wanted - 1.0).abs() < 1e-3, "block {k}: {got} {wanted}");
    }
}

/// Gaussian noise as loud as the slack allows: of 400 runs the mean time to an alarm is not below the interval (2 s; standard error 5 %).
#[test]
fn gaussian_noise_keeps_the_interval() {
    let interval_s = 2.0;
    // Whole readings, so that the energies have the law of the formula.
    let readings = [1.0, 1.0, 1.0, 1.0, 1.0, 2.0];
    let config = DetectorConfig { interval_s, ..DetectorConfig::default() };
    for moving in [false, true] {
        let slack = if moving { config.slack_moving } else { config.slack_still };
        let (mut state, mut blocks, runs) = (11, 0_u32, 400);
        for _ in 0..runs {
            let mut sum = AlarmSum::new(&config, &readings, BLOCK_S);
            loop {
                blocks += 1;
                let energy = core::array::from_fn(|b| {
                    // The joint component has slack of its own, and less.
                    let scale = f64::from(if moving && b >= 2 { slack[JOINT] } else { slack[b] });
                    let square = gaussian(&mut state).powi(2);
                    let second = if b == BANDS - 1 { gaussian(&mut state).powi(2) } else { square };
                    (0.5 * scale * (square + second)) as f32
                });
                if sum.step(&Block { energy, floor: [1.0; BANDS], moving }) >= 1.0 {
                    break;
                }
            }
        }
        let mean_s = f64::from(blocks) * f64::from(BLOCK_S) / f64::from(runs);
        std::println!("moving {moving}: {mean_s:.2} s");
        assert!(mean_s > 0.9 * f64::from(interval_s), "moving {moving}: {mean_s}");
    }
}

#[test]
fn one_block_is_no_slip_and_three_are() {
    for moving in [false, true] {
        let mut sum = sum(600.0);
        let block = |energy: f32| Block { energy: [energy; BANDS], floor: [1.0; BANDS], moving };
        (0..1000).for_each(|_| {
            sum.step(&block(1.0));
        });
        assert!(sum.step(&block(1e30)) < 1.0, "a single block");
        (0..1000).for_each(|_| {
            sum.step(&block(1.0));
        });
        let steps = (0..10).take_while(|_| sum.step(&block(1e30)) < 1.0).count();
        assert!((1..=3).contains(&steps), "{steps}");
    }
}

/// Motion of 3 times the energy that is evidence for nothing, 100 ms: with the floor as much higher as is stated it is no slip.
#[test]
fn what_is_unexplained_is_the_factor_that_explains_it() {
    let run = |floor: f32| {
        let mut sum = sum(600.0);
        let neutral: [f32; BANDS] =
            core::array::from_fn(|b| sum.moving.offset[b] / sum.moving.slope[b]);
        let mut step = |energy| sum.step(&Block { energy, floor: [floor; BANDS], moving: true });
        (0..100).for_each(|_| {
            step([1.0; BANDS]);
        });
        (0..200).for_each(|_| {
            step(neutral.map(|energy| 3.0 * energy));
        });
        (sum.unexplained(), sum.evidence_s())
    };
    let (factors, _) = run(1.0);
    assert!(factors[BANDS - 1] > 2.0, "{factors:?}");
    for (i, factor) in factors.into_iter().enumerate().filter(|(i, _)| *i < BANDS) {
        let log = libm::logf(run(factor).1[i] / BLOCK_S);
        let slip = libm::logf(600.0 / BLOCK_S);
        assert!(log < slip, "component {i}: {factor} {log} {slip}");
    }
}

#[test]
fn the_smallest_energy_is_found_in_time() {
    let within_s = 0.02;
    for moving in [false, true] {
        let smallest = sum(600.0).smallest(moving, within_s);
        for b in 0..BANDS {
            if !smallest[b].is_finite() {
                continue;
            }
            for (times, found) in [(1.05, true), (0.6, false)] {
                let mut sum = sum(600.0);
                let mut energy = [0.0; BANDS];
                energy[b] = times * smallest[b];
                let block = Block { energy, floor: [1.0; BANDS], moving };
                let got = (0..40).any(|_| sum.step(&block) >= 1.0);
                // In motion the octaves together may find sooner what one of them shows.
                let sooner = got && moving && b >= 2;
                assert!(got == found || !found && sooner, "moving {moving} band {b}: {times}");
            }
        }
    }
}
