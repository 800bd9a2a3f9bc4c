extern crate std;
use super::{PatternRest, PressureConfig, PressurePattern};
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
            let (x, y) = ((i % 4) as f32 - 1.6 - moved, (i / 4) as f32 - 1.3);
            *out = offset + factor * 60.0 * libm::expf(-(x * x + y * y) / 2.0) + self.noise();
        }
        (Micros(self.t), out)
    }
}

type Method = PressurePattern<64>;

fn give(method: &mut Method, frame: &(Micros, Vec<f32>)) -> SlipState {
    method.step(frame.0, &frame.1, true);
    method.state()
}

fn at_rest() -> (Method, Pad) {
    let mut method = Method::new(PressureConfig::default()).unwrap();
    let mut pad = Pad::new();
    for _ in 0..100 {
        assert_eq!(give(&mut method, &pad.frame(0.0, 1.0, 0.0)), SlipState::Quiet);
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
        assert_eq!(give(&mut method, &pad.frame(0.0, factor, offset)), SlipState::Quiet, "{i}");
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
    let mut reported = None;
    for i in 0..30_u8 {
        let moved = 0.03 * f32::from(i);
        if give(&mut method, &pad.frame(moved, 1.0, 0.0)) != SlipState::Quiet && reported.is_none()
        {
            reported = Some(moved);
        }
    }
    assert!(reported.unwrap() < 0.2, "{reported:?} taxels");
    assert_eq!(method.state(), SlipState::Gross);
    let mut lasted = 0;
    while give(&mut method, &pad.frame(0.87, 1.0, 0.0)) != SlipState::Quiet {
        lasted += 1;
    }
    assert!((10..40).contains(&lasted), "{lasted} frames of 10 ms");
    for _ in 0..200 {
        assert_eq!(give(&mut method, &pad.frame(0.87, 1.0, 0.0)), SlipState::Quiet);
    }
}

/// A slip under shaking is found as well as without.
#[test]
fn a_slip_is_found_while_the_hand_shakes() {
    let (mut method, mut pad) = at_rest();
    let reported = (0..60_u8).find(|&i| {
        let factor = 1.0 + 0.4 * libm::sinf(f32::from(i) * 0.7);
        give(&mut method, &pad.frame(0.03 * f32::from(i), factor, 0.0)) != SlipState::Quiet
    });
    assert!(reported.unwrap() < 12, "{reported:?}");
}

#[test]
fn creep_is_followed() {
    let (mut method, mut pad) = at_rest();
    for i in 0..6000_u16 {
        let moved = 1e-4 * f32::from(i);
        assert_eq!(give(&mut method, &pad.frame(moved, 1.0, 0.0)), SlipState::Quiet, "{i}");
    }
}

#[test]
fn one_broken_taxel_is_no_slip_and_many_are_reported() {
    let (mut method, mut pad) = at_rest();
    for value in [1e6, -1e6, f32::NAN, f32::INFINITY] {
        let (t, mut frame) = pad.frame(0.0, 1.0, 0.0);
        frame[3] = value;
        method.step(t, &frame, true);
        assert!(method.statistic().is_finite());
        method.prime();
        give(&mut method, &pad.frame(0.0, 1.0, 0.0));
        give(&mut method, &pad.frame(0.0, 1.0, 0.0));
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
    give(&mut method, &pad.frame(0.0, 1.0, 0.0));
    assert_eq!(method.health(), SensorHealth::Good);
}

#[test]
fn repeated_frames_are_no_updates_until_they_are_a_frozen_array() {
    let (mut method, mut pad) = at_rest();
    let (t, frame) = pad.frame(0.0, 1.0, 0.0);
    let mut reported = None;
    for i in 0..2000_u64 {
        let now = t.plus(Micros(1000 * i));
        method.step(now, &frame, true);
        assert_eq!(method.state(), SlipState::Quiet);
        if method.health() == SensorHealth::Frozen && reported.is_none() {
            reported = Some(i);
        }
    }
    assert_eq!(reported, Some(1001));
    pad.t += 2_000_000;
    give(&mut method, &pad.frame(0.0, 1.0, 0.0));
    assert_eq!(method.health(), SensorHealth::Good);
}

#[test]
fn a_pattern_that_stands_to_the_last_bit_ends_the_slip_and_one_that_is_read_seldom_does_not() {
    for (every_ms, ends) in [(1000, true), (150, false)] {
        let (mut method, mut pad) = at_rest();
        for i in 0..8_u8 {
            give(&mut method, &pad.frame(0.2 * f32::from(i), 1.0, 0.0));
        }
        assert_ne!(method.state(), SlipState::Quiet);
        // Frames that still change, or the same one again and again.
        let (t, mut frame) = pad.frame(1.6, 1.0, 0.0);
        let mut quiet = false;
        for ms in 0..600_u64 {
            if ms % every_ms == 0 && ms > 0 {
                let moved = if ms / every_ms % 2 == 0 { 1.6 } else { 0.4 };
                frame = pad.frame(moved, 1.0, 0.0).1;
            }
            method.step(t.plus(Micros(1000 * ms)), &frame, false);
            quiet |= method.state() == SlipState::Quiet;
        }
        assert_eq!(quiet, ends, "a frame in {every_ms} ms");
    }
}

#[test]
fn a_threshold_that_a_broken_taxel_could_pass_is_refused() {
    let config = PressureConfig { threshold: 40.0, ..PressureConfig::default() };
    let Err(ConfigError::Range { name, .. }) = Method::new(config) else { panic!("accepted") };
    assert_eq!(name, "pressure.threshold");
}

/// Seconds of a pad at `rate` frames a second whose hill moves by `speed` taxels a second from 4 s on, all times `unit`;
/// a tremor of 10 Hz shifts it all the time.
fn slide(rate: u32, speed: f32, unit: f32) -> Vec<(Micros, Vec<f32>)> {
    let mut pad = Pad::new();
    let frames = 8 * rate;
    let frame = |i: u32| {
        let t_s = f64::from(i) / f64::from(rate);
        #[expect(clippy::cast_possible_truncation, reason = "test signal")]
        let (t, tremor) = (t_s as f32, (62.8 * t_s).sin() as f32);
        let moved = 0.02 * tremor + speed * (t - 4.0).max(0.0);
        let values = pad.frame(moved, 1.0, 0.0).1;
        (
            Micros(u64::from(i) * 1_000_000 / u64::from(rate)),
            values.iter().map(|v| v * unit).collect(),
        )
    };
    (0..frames).map(frame).collect()
}

/// What the rest of such a pad shows, with a tenth of room.
fn rested(rate: u32, unit: f32) -> PressureConfig {
    let config = PressureConfig::default();
    let mut meter = PatternRest::<64>::new(config.follow_ms);
    slide(rate, 0.0, unit).iter().for_each(|(t, frame)| meter.push(*t, frame));
    let known_range = meter.range().map(|range| 1.1 * range);
    PressureConfig { known_rms: meter.rms(config.threshold), known_range, ..config }
}

/// Times (s) at which slips begin.
fn begins(config: PressureConfig, frames: &[(Micros, Vec<f32>)]) -> Vec<f64> {
    let mut method = Method::new(config).unwrap();
    let mut before = SlipState::Quiet;
    let mut out = Vec::new();
    for (t, frame) in frames {
        method.step(*t, frame, false);
        if before == SlipState::Quiet && method.state() != SlipState::Quiet {
            out.push(t.as_seconds());
        }
        before = method.state();
    }
    out
}

#[test]
fn a_slow_slide_is_found_by_its_range_at_any_rate_and_a_hold_is_none() {
    for rate in [20, 50, 100, 290, 1000] {
        let config = rested(rate, 1.0);
        assert!(begins(config, &slide(rate, 0.0, 1.0)).is_empty(), "{rate}");
        let slow = slide(rate, 0.1, 1.0);
        let found = begins(config, &slow);
        assert!(found.first().is_some_and(|t| (4.0..6.5).contains(t)), "{rate}: {found:?}");
        let blind = PressureConfig { known_range: None, ..config };
        let without = begins(blind, &slow);
        assert!(without.first().is_none_or(|t| *t > found[0]), "{rate}: {without:?}");
    }
}

#[test]
fn the_range_is_the_same_in_any_unit() {
    let (config, slow) = (rested(100, 1.0), slide(100, 0.1, 1.0));
    let expected = begins(config, &slow);
    assert!(!expected.is_empty());
    for unit in [2.0_f32.powi(-30), 2.0_f32.powi(30), 1e-9, 1e9] {
        let found = begins(rested(100, unit), &slide(100, 0.1, unit));
        let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let most = if unit.log2().fract() == 0.0 { 0.0 } else { 0.011 };
        assert!(found.len() == expected.len() && apart <= most, "{unit}: {found:?} {expected:?}");
    }
}

#[test]
fn a_stretch_too_short_for_a_range_gives_none() {
    let mut meter = PatternRest::<64>::new(1000.0);
    for part in slide(100, 0.0, 1.0).chunks(150) {
        meter.start();
        part.iter().for_each(|(t, frame)| meter.push(*t, frame));
    }
    assert_eq!(meter.range(), None);
    assert!(meter.rms(6.0).is_some());
}

/// A pad that is held for 12 s in stretches of `stretch` s, from which the range is learned, and what it has learned.
fn learned(stretch: usize, unit: f32) -> (Method, Option<f32>) {
    let mut method = Method::new(PressureConfig::default()).unwrap();
    let mut pad = Pad::new();
    for i in 0..1200 {
        if i % (100 * stretch) == 0 {
            pad.t += 1_000_000;
            method.prime();
        }
        let (t, frame) = pad.frame(0.0, 1.0, 0.0);
        let frame: Vec<f32> = frame.iter().map(|value| value * unit).collect();
        assert_eq!(give(&mut method, &(t, frame)), SlipState::Quiet);
    }
    (method, method.known_range())
}

#[test]
fn the_range_is_learned_while_an_object_is_held() {
    let (_, whole) = learned(12, 1.0);
    let (_, parts) = learned(3, 1.0);
    let (_, small) = learned(12, 1e-6);
    assert!(whole.unwrap() < 1.5 * parts.unwrap() && parts.unwrap() < 1.5 * whole.unwrap());
    assert!((small.unwrap() / whole.unwrap() - 1e-6).abs() < 1e-8);
    assert_eq!(learned(1, 1.0).1, None, "too short for a range");
}

/// The first frame, of 100 a second, with a slip of an object that slides by `speed` taxels a second from frame 6000 on.
fn first_slip(method: &mut Method, speed: f32, learning: bool) -> Option<u16> {
    let mut pad = Pad { seed: 10, t: 20_000_000 };
    method.prime();
    (0..7500_u16).find(|i| {
        let moved = 0.01 * speed * f32::from(i.saturating_sub(6000));
        let (t, frame) = pad.frame(moved, 1.0, 0.0);
        method.step(t, &frame, learning);
        method.state() != SlipState::Quiet
    })
}

#[test]
fn a_slow_slide_is_found_sooner_by_the_range_that_was_learned_and_a_hold_is_none() {
    let (method, _) = learned(12, 1.0);
    let config = PressureConfig { known_rms: method.rms(), ..PressureConfig::default() };
    let blind = Method::new(config).unwrap();
    assert_eq!(first_slip(&mut method.clone(), 0.0, true), None);
    for speed in [0.14, 0.2] {
        let sooner = first_slip(&mut method.clone(), speed, true).unwrap();
        let later = first_slip(&mut blind.clone(), speed, false).unwrap();
        assert!(sooner > 6000 && sooner + 40 < later, "{speed}: {sooner} and {later}");
    }
}
