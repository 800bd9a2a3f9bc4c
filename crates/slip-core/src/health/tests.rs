//! What is unusable, isolated, frozen and drifting, on hand-made readings.

use super::{HealthCheck, HealthConfig, Passed, SensorHealth};
use crate::{
    sample::Sample,
    units::{Hertz, Micros},
};

const RATE: Hertz = Hertz(10_000.0);

fn check() -> HealthCheck {
    HealthCheck::new(HealthConfig::default(), RATE)
}

fn at(i: u16, stylus: f32) -> Sample {
    Sample::stylus(Micros(100 * (u64::from(i) + 1)), stylus)
}

#[test]
fn bad_readings_are_replaced_and_counted() {
    let mut check = check();
    let mut out = |i, x| check.check(&at(i, x)).unwrap().stylus;
    assert_eq!(out(0, 1e-6), 1e-6);
    assert_eq!(out(1, f32::NAN), 1e-6);
    assert_eq!(out(2, f32::NEG_INFINITY), 1e-6);
    assert_eq!(out(3, 1e30), 1e-6);
    assert_eq!(out(4, 4e-3), 1e-6, "a jump of 4 mm in 0.1 ms is a glitch");
    assert_eq!(out(5, 2e-6), 2e-6);
    let counters = check.counters();
    assert_eq!((counters.not_finite, counters.saturated, counters.glitches), (2, 1, 1));
    assert_eq!(check.health(), SensorHealth::Good, "four in a row are not yet a failure");
}

/// A driver that fills up with NaN: for some readings the other axes count, then the sensor has failed.
#[test]
fn an_axis_without_a_number_leaves_the_others_for_some_readings() {
    let mut check = check();
    let reading =
        |i: u16, [stylus, y, z]: [f32; 3]| Sample { stylus_axes: [y, z], ..at(i, stylus) };
    let wave = |i: u16, k: f32| 1e-6 * libm::sinf(f32::from(i) * 1.3 + k);
    let whole = |i| [wave(i, 0.0), wave(i, 1.0), wave(i, 2.0)];
    for i in 0..2000 {
        let [x, y, z] = whole(i);
        let broken = match i % 100 {
            93..=96 if i > 1000 => [f32::NAN, y, z],
            97..=99 if i > 1000 => [x, f32::NAN, f32::INFINITY],
            _ => [x, y, z],
        };
        let before = whole(if i % 100 < 97 { i / 100 * 100 + 92 } else { i / 100 * 100 + 96 });
        let out = check.check(&reading(i, broken)).unwrap().vibration();
        for axis in 0..3 {
            let wanted = if broken[axis].is_finite() { broken[axis] } else { before[axis] };
            assert_eq!(out[axis], wanted, "{i}, axis {axis}");
        }
        assert_eq!(check.health(), SensorHealth::Good, "{i}");
    }
    assert_eq!(check.counters().not_finite, 70);
    for i in 2000..2008 {
        let [_, y, z] = whole(i);
        check.check(&reading(i, [f32::NAN, y, z]));
    }
    assert_eq!(check.health(), SensorHealth::Failed, "the floor was learned with that axis");
    check.check(&reading(2008, whole(2008)));
    assert_eq!(check.health(), SensorHealth::Good);
}

#[test]
fn a_real_step_is_accepted_after_a_while() {
    let mut check = check();
    check.check(&at(0, 0.0));
    let values: [f32; 10] = core::array::from_fn(|i| {
        check.check(&at(u16::try_from(i).unwrap() + 1, 4e-3)).unwrap().stylus
    });
    assert_eq!(values[7], 0.0);
    assert_eq!(values[8], 4e-3);
}

#[test]
fn frozen_saturated_and_failed_are_reported_and_recover() {
    let mut check = check();
    for i in 0..600 {
        check.check(&at(i, 1e-6));
    }
    assert_eq!(check.health(), SensorHealth::Frozen);
    check.check(&at(600, 1.1e-6));
    assert_eq!(check.health(), SensorHealth::Good);
    for i in 601..620 {
        check.check(&at(i, 5e-3));
    }
    assert_eq!(check.health(), SensorHealth::Saturated);
    for i in 620..640 {
        check.check(&at(i, f32::NAN));
    }
    assert_eq!(check.health(), SensorHealth::Failed);
    check.check(&at(640, 1e-6));
    assert_eq!(check.health(), SensorHealth::Good);
    assert_eq!(check.counters().failures, 2);
}

/// Readings of some hundredths, as of an accelerometer, with serial glitches.
#[test]
fn without_a_unit_a_glitch_is_reported_by_the_steps_before() {
    let config = HealthConfig { range: 1e9, max_step: 1e9, ..HealthConfig::default() };
    let mut check = HealthCheck::uncalibrated(config, RATE);
    let wave = |i: u16| 0.06 * libm::sinf(f32::from(i) * 2.5);
    for i in 0..2000_u16 {
        let glitch = i % 100 == 99;
        let out = check.check(&at(i, if glitch { 5e5 } else { wave(i) })).unwrap().stylus;
        assert!(i < 99 || out.abs() <= 0.06, "{out}");
    }
    assert_eq!((check.counters().glitches, check.health()), (20, SensorHealth::Good));
    // A signal that has really become a million times louder is taken as it is after a while.
    let taken = (2000..3000_u16).filter(|&i| {
        let loud = 1e6 * wave(i);
        check.check(&at(i, loud)).unwrap().stylus == loud
    });
    assert!(taken.count() > 980);
    // Long silence of a coarse sensor does not make its first count a glitch.
    let mut check = HealthCheck::uncalibrated(config, RATE);
    for i in 0..10_000_u16 {
        check.check(&at(i, if i % 1000 < 100 { f32::from(i % 2) } else { 0.0 }));
    }
    assert_eq!(check.counters().glitches, 0);
}

#[test]
fn other_channels_turn_absent() {
    let mut check = check();
    let sample = Sample {
        normal_force_n: Some(f32::NAN),
        travel_m: Some(1e30),
        velocity_m_s: Some(0.1),
        ..at(0, 0.0)
    };
    let out = check.check(&sample).unwrap();
    assert_eq!((out.normal_force_n, out.travel_m, out.velocity_m_s), (None, None, Some(0.1)));
    assert_eq!(check.counters().other_channels, 2);
}

/// In mN a light grip reads 2000: the controller would follow it to the largest force.
#[test]
fn a_force_that_no_finger_meets_is_absent() {
    let mut check = check().of_gripper(60.0);
    let mut force = |i, force_n| {
        let sample = Sample { normal_force_n: Some(force_n), ..at(i, 1e-6 * f32::from(i)) };
        match check.passes(&sample) {
            Passed::Not => check.check(&sample).unwrap().normal_force_n,
            Passed::AsItIs => sample.normal_force_n,
            Passed::As(sample) => sample.normal_force_n,
        }
    };
    for (i, given, wanted) in [
        (0, 2.0, Some(2.0)),
        (1, 299.0, Some(299.0)),
        (2, 2000.0, None),
        // The tare of a sensor in mN: nothing is touched.
        (3, -400.0, Some(-400.0)),
        (4, 301.0, None),
    ] {
        assert_eq!(force(i, given), wanted);
    }
    assert_eq!((check.counters().forces, check.counters().unusable()), (2, 2));
}

#[test]
fn time_only_goes_forward() {
    let mut check = check();
    assert!(check.check(&at(5, 0.0)).is_some());
    assert!(check.check(&at(5, 0.0)).is_none());
    assert!(check.check(&at(4, 0.0)).is_none());
    assert_eq!(check.counters().time_faults, 2);
}

/// Two equal readings on both sides of a gap are what a coarse sensor shows in a quarter of all cases.
#[test]
fn a_gap_does_not_freeze_the_stylus() {
    let coarse = |i: u16| 1e-6 * libm::roundf(2.0 * libm::sinf(f32::from(i) * 1.3));
    for second in [None, Some(0.0)] {
        let mut check = check();
        let (mut t, mut last) = (0, 0.0);
        for i in 0..10_000_u16 {
            let gap = i % 1000 == 999;
            t += if gap { 500_000 } else { 100 };
            last = if gap { last } else { coarse(i) };
            let sample = Sample { second_stylus: second, ..Sample::stylus(Micros(t), last) };
            assert!(check.check(&sample).is_some());
            assert_eq!(check.health(), SensorHealth::Good, "{i}");
        }
        assert_eq!(check.counters().failures, 0);
    }
}

/// The time between gaps counts, however often they come.
#[test]
fn a_stylus_that_is_frozen_on_both_sides_of_gaps_is_reported() {
    let mut check = check();
    let mut t = 0;
    let mut frozen_after = None;
    for i in 0..2000_u32 {
        t += if i % 100 == 99 { 200_000 } else { 100 };
        check.check(&Sample::stylus(Micros(t), if i == 0 { 0.0 } else { 1e-6 }));
        let frozen = check.health() == SensorHealth::Frozen;
        frozen_after = frozen_after.or(frozen.then_some(i));
    }
    // 50 ms of readings.
    assert_eq!(frozen_after, Some(502));
}

/// The fast path against every check of every sample: noise with wrong readings, gaps, repeats, glitches and no numbers.
#[test]
fn what_passes_is_what_the_checks_give() {
    let (mut fast, mut slow) = (check(), check());
    let (mut state, mut t, mut as_other) = (1_u32, 0, 0);
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as u16
    };
    for i in 0..20_000_u16 {
        t += if random() % 500 == 0 { 30_000 } else { 100 };
        let x = 1e-9 * f32::from(random() % 64);
        let stylus = match random() % 300 {
            0 => f32::NAN,
            1 => 4e-3,
            2..=5 => x + 1e-6,
            6 => 1e-9,
            _ => x,
        };
        let r = f32::from(random() % 64) + if random() % 100 == 0 { 9e3 } else { 0.0 };
        let sample = Sample {
            stylus_axes: [0.0, if i < 10_000 { 0.0 } else { 1e-9 * f32::from(random() % 64) }],
            reference: Some(r),
            ..Sample::stylus(Micros(t), stylus)
        };
        let shown = match fast.passes(&sample) {
            Passed::Not => fast.check(&sample),
            Passed::AsItIs => Some(sample),
            Passed::As(other) => {
                as_other += 1;
                Some(other)
            }
        };
        assert_eq!(shown, slow.check(&sample), "{i}");
        assert_eq!((fast.health(), fast.counters()), (slow.health(), slow.counters()), "{i}");
    }
    let counters = fast.counters();
    assert!(counters.isolated > 200 && counters.glitches > 20 && as_other > 200, "{counters:?}");
}

/// They are replaced, not missing: the sensor works.
#[test]
fn isolated_readings_are_counted_beside_the_unusable_ones() {
    let mut check = check();
    for i in 0..1000 {
        let x = 1e-7 * libm::sinf(f32::from(i) * 2.5) + if i == 500 { 1e-5 } else { 0.0 };
        let out = check.check(&at(i, x)).unwrap().stylus;
        assert!(out.abs() < 2e-7, "{i}: {out}");
    }
    let counters = check.counters();
    assert_eq!((counters.isolated, counters.unusable()), (1, 0));
    assert_eq!(check.health(), SensorHealth::Good);
}
