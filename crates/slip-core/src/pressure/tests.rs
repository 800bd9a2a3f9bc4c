extern crate std;
use super::{PressureConfig, PressurePattern};
use crate::health::SensorHealth;
use crate::{detector::SlipState, error::ConfigError, units::Micros};
use std::{vec, vec::Vec};

/// A pad of 4 x 4 taxels under a round object: a pressure hill, read at 100 Hz with noise of 1 count rms.
struct Pad {
    seed: u32,
    t: u64,
}

impl Pad {
    fn new() -> Self {
        Self { seed: 9, t: 0 }
    }

    fn noise(&mut self) -> f32 {
        // Sum of four uniform numbers of variance 1/4 each.
        let mut sum = 0.0;
        for _ in 0..4 {
            self.seed = self.seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            #[expect(clippy::cast_precision_loss, reason = "test signal")]
            let unit = (self.seed >> 8) as f32 / 16_777_216.0 - 0.5;
            sum += unit * 1.732;
        }
        sum
    }

    /// The hill `moved` taxels further, everything times `factor` plus `offset`.
    fn frame(&mut self, moved: f32, factor: f32, offset: f32) -> (Micros, Vec<f32>) {
        self.t += 10_000;
        let mut out = vec![0.0; 16];
        for (i, out) in out.iter_mut().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "test signal")]
            let (x, y) = ((i % 4) as f32 - 1.6 - moved, (i / 4) as f32 - 1.3);
            *out = offset + factor * 60.0 * libm::expf(-(x * x + y * y) / 2.0) + self.noise();
        }
        (Micros(self.t), out)
    }
}

type Method = PressurePattern<64>;

fn give(method: &mut Method, (t, frame): (Micros, Vec<f32>)) -> SlipState {
    method.step(t, &frame, true);
    method.state()
}

fn at_rest() -> (Method, Pad) {
    let mut method = Method::new(PressureConfig::default()).unwrap();
    let mut pad = Pad::new();
    for _ in 0..100 {
        assert_eq!(give(&mut method, pad.frame(0.0, 1.0, 0.0)), SlipState::Quiet);
    }
    let rms = method.rms().unwrap();
    assert!((rms - 1.0).abs() < 0.25, "noise of 1 count: {rms}");
    (method, pad)
}

#[test]
fn shaking_of_the_whole_pad_is_no_slip() {
    let (mut method, mut pad) = at_rest();
    let mut highest = 0.0_f32;
    for i in 0..10_000_u16 {
        let phase = f32::from(i) * 0.7;
        let factor = 1.0 + 0.5 * libm::sinf(phase);
        let offset = 20.0 * libm::cosf(0.31 * phase);
        assert_eq!(give(&mut method, pad.frame(0.0, factor, offset)), SlipState::Quiet, "{i}");
        highest = highest.max(method.statistic());
    }
    assert!(highest < 0.9, "{highest}");
}

/// What a method that watches single taxels would do with the same shaking.
#[test]
fn the_same_shaking_moves_single_taxels_far_beyond_the_threshold() {
    let mut pad = Pad::new();
    let (_, rest) = pad.frame(0.0, 1.0, 0.0);
    let (_, shaken) = pad.frame(0.0, 1.5, 20.0);
    let energy: f32 = rest.iter().zip(&shaken).map(|(a, b)| (a - b) * (a - b)).sum::<f32>() / 16.0;
    assert!(energy > 100.0 * PressureConfig::default().threshold, "{energy}");
}

#[test]
fn a_pattern_that_moves_at_constant_sum_is_a_slip_and_ends() {
    let (mut method, mut pad) = at_rest();
    let mut told = None;
    for i in 0..30_u8 {
        let moved = 0.03 * f32::from(i);
        if give(&mut method, pad.frame(moved, 1.0, 0.0)) != SlipState::Quiet && told.is_none() {
            told = Some(moved);
        }
    }
    assert!(told.unwrap() < 0.2, "{told:?} taxels");
    assert_eq!(method.state(), SlipState::Gross);
    let mut lasted = 0;
    while give(&mut method, pad.frame(0.87, 1.0, 0.0)) != SlipState::Quiet {
        lasted += 1;
    }
    assert!((10..40).contains(&lasted), "{lasted} frames of 10 ms");
    for _ in 0..200 {
        assert_eq!(give(&mut method, pad.frame(0.87, 1.0, 0.0)), SlipState::Quiet);
    }
}

/// A slip under shaking is found as well as without.
#[test]
fn a_slip_is_found_while_the_hand_shakes() {
    let (mut method, mut pad) = at_rest();
    let told = (0..60_u8).find(|&i| {
        let factor = 1.0 + 0.4 * libm::sinf(f32::from(i) * 0.7);
        give(&mut method, pad.frame(0.03 * f32::from(i), factor, 0.0)) != SlipState::Quiet
    });
    assert!(told.unwrap() < 12, "{told:?}");
}

#[test]
fn creep_is_followed() {
    let (mut method, mut pad) = at_rest();
    for i in 0..6000_u16 {
        let moved = 1e-4 * f32::from(i);
        assert_eq!(give(&mut method, pad.frame(moved, 1.0, 0.0)), SlipState::Quiet, "{i}");
    }
}

#[test]
fn one_broken_taxel_is_no_slip_and_many_are_told() {
    let (mut method, mut pad) = at_rest();
    for value in [1e6, -1e6, f32::NAN, f32::INFINITY] {
        let (t, mut frame) = pad.frame(0.0, 1.0, 0.0);
        frame[3] = value;
        method.step(t, &frame, true);
        assert!(method.statistic().is_finite());
        method.prime();
        give(&mut method, pad.frame(0.0, 1.0, 0.0));
        give(&mut method, pad.frame(0.0, 1.0, 0.0));
    }
    for _ in 0..5 {
        let (t, mut frame) = pad.frame(0.0, 1.0, 0.0);
        frame[3] = f32::NAN;
        method.step(t, &frame, true);
        assert_eq!((method.state(), method.health()), (SlipState::Quiet, SensorHealth::Good));
    }
    let (t, mut frame) = pad.frame(0.0, 1.0, 0.0);
    frame.iter_mut().take(5).for_each(|taxel| *taxel = f32::NAN);
    method.step(t, &frame, true);
    assert_eq!((method.state(), method.health()), (SlipState::Quiet, SensorHealth::Failed));
    give(&mut method, pad.frame(0.0, 1.0, 0.0));
    assert_eq!(method.health(), SensorHealth::Good);
}

#[test]
fn repeated_frames_are_no_news_until_they_are_a_frozen_array() {
    let (mut method, mut pad) = at_rest();
    let (t, frame) = pad.frame(0.0, 1.0, 0.0);
    let mut told = None;
    for i in 0..2000_u64 {
        let now = t.plus(Micros(1000 * i));
        method.step(now, &frame, true);
        assert_eq!(method.state(), SlipState::Quiet);
        if method.health() == SensorHealth::Frozen && told.is_none() {
            told = Some(i);
        }
    }
    assert_eq!(told, Some(1001));
    pad.t += 2_000_000;
    give(&mut method, pad.frame(0.0, 1.0, 0.0));
    assert_eq!(method.health(), SensorHealth::Good);
}

#[test]
fn a_threshold_that_a_broken_taxel_could_pass_is_refused() {
    let config = PressureConfig { threshold: 40.0, ..PressureConfig::default() };
    let Err(ConfigError::Range { name, .. }) = Method::new(config) else { panic!("accepted") };
    assert_eq!(name, "pressure.threshold");
}
