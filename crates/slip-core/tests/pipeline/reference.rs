//! References that are dead, late, or another robot's: noticed, and not worse than none.

use slip_core::{
    Phase, Pipeline, PipelineConfig, Sample, Signal, SlipReport,
    health::SensorHealth,
    units::{Hertz, Micros},
};

const RATE_HZ: f32 = 2000.0;

fn noise(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        3.46 * (f64::from(state) / f64::from(u32::MAX) - 0.5) as f32
    }
}

/// The motion of a robot: two resonances, on and off by turns of 0.3 to 2 s; deviation 30 while it moves.
fn robot(seed: u32, len: usize) -> Vec<f32> {
    let (mut drive, mut turns) = (noise(seed), noise(seed ^ 0x5555));
    let modes = [(60.0, 0.05), (310.0, 0.03)].map(|(hz, damping)| {
        let w = core::f32::consts::TAU * hz / RATE_HZ;
        let pole = (-damping * w).exp();
        (2.0 * pole * w.cos(), pole * pole, damping * w)
    });
    let (mut past, mut level, mut aim, mut left) = ([[0.0_f32; 2]; 2], 0.0_f32, 0.0, 0_u32);
    // The first second is rest.
    (0..len)
        .map(|i| {
            if left == 0 && i > RATE_HZ as usize {
                left = ((1.1 + 0.5 * turns()) * RATE_HZ).max(0.3 * RATE_HZ) as u32;
                aim = if aim > 0.0 { 0.0 } else { 30.0 };
            }
            left = left.saturating_sub(1);
            level += (aim - level) / (0.03 * RATE_HZ);
            let mut sum = 0.0;
            for ((a, b, gain), past) in modes.iter().zip(&mut past) {
                let x = a * past[0] - b * past[1] + drive();
                *past = [x, past[0]];
                sum += 1.4 * gain.sqrt() * x;
            }
            level * sum
        })
        .collect()
}

struct Seen {
    /// Samples in alarm.
    alarmed: usize,
    alarms: Vec<usize>,
    healths: Vec<(f32, SensorHealth)>,
    /// How long the stylus waits for the reference at the end (ms).
    waits_ms: f32,
}

/// Alarms and changes of health of 100 s; a slip of 0.1 s with 5 times the noise begins every 5 s. `reference` makes the channel of the motion.
fn play(motion: &[f32], reference: impl Fn(usize) -> Option<f32>) -> Seen {
    let config = PipelineConfig::observing(Signal::Vibration, Hertz(RATE_HZ));
    let mut pipeline = Pipeline::<&[f32]>::new(config, None).unwrap();
    let (mut own, mut slip, mut beside) = (noise(1), noise(2), noise(3));
    let mut seen = Seen { alarmed: 0, alarms: Vec::new(), healths: Vec::new(), waits_ms: 0.0 };
    let (mut health, mut slips) = (SensorHealth::Good, false);
    for (i, moves) in motion.iter().enumerate() {
        let (slides, noise) = (i > 10_000 && i % 10_000 < 200, beside());
        let stylus = own() + moves + if slides { 5.0 * slip() } else { 0.0 };
        let step = pipeline.handle(&Sample {
            reference: reference(i).map(|r| if r == 0.0 { 0.0 } else { r + noise }),
            ..Sample::stylus(Micros(500 * (i as u64 + 1)), stylus)
        });
        match step.event {
            Some(SlipReport { first: true, .. }) => (slips, _) = (true, seen.alarms.push(i)),
            Some(SlipReport { phase: Phase::Ended, .. }) => slips = false,
            _ => {}
        }
        seen.alarmed += usize::from(slips);
        if step.sensors[3] != health {
            health = step.sensors[3];
            seen.healths.push((i as f32 / RATE_HZ, health));
        }
    }
    seen.waits_ms = 1e3 * pipeline.detector().waits_s();
    seen
}

const LEN: usize = 200_000;

fn shifted(motion: &[f32], i: usize, ms: isize) -> Option<f32> {
    let at = i.saturating_add_signed(-2 * ms).min(motion.len() - 1);
    Some(1.2 * motion[at] + 1e-3)
}

#[test]
fn a_sound_reference_stays_good() {
    for seed in [1, 2, 3] {
        let motion = robot(seed, LEN);
        let (sound, none) = (play(&motion, |i| shifted(&motion, i, 0)), play(&motion, |_| None));
        assert_eq!((&sound.healths[..], sound.waits_ms), (&[][..], 0.0));
        assert!(4 * sound.alarmed < none.alarmed, "{} of {}", sound.alarmed, none.alarmed);
    }
}

#[test]
fn a_constant_or_missing_reference_is_reported_and_is_as_none() {
    let motion = robot(1, LEN);
    let none = play(&motion, |_| None);
    assert!(none.healths.is_empty(), "there has never been one");
    let constant = play(&motion, |_| Some(0.0));
    assert_eq!(constant.alarms, none.alarms);
    assert_eq!(constant.healths.len(), 1);
    assert_eq!(constant.healths[0].1, SensorHealth::Frozen);
    for dies in [Some(0.0), None] {
        let seen = play(&motion, |i| if i < 40_000 { shifted(&motion, i, 0) } else { dies });
        let after = |alarms: &[usize]| alarms.iter().filter(|i| **i > 42_000).count();
        assert_eq!(after(&seen.alarms), after(&none.alarms));
        let [(at_s, health)] = seen.healths[..] else { panic!("{:?}", seen.healths) };
        let wanted = if dies.is_some() { SensorHealth::Frozen } else { SensorHealth::Lost };
        assert!(health == wanted && at_s < 20.3, "{at_s}");
    }
}

#[test]
fn a_late_or_early_reference_is_reported_and_blinds_less_than_it_helps() {
    let motion = robot(2, LEN);
    let none = play(&motion, |_| None).alarmed;
    for ms in [15, 20, 50, 90, -15, -50] {
        let seen = play(&motion, |i| shifted(&motion, i, ms));
        assert!(
            matches!(seen.healths[..], [(_, SensorHealth::Late)]),
            "{ms} ms: {:?}",
            seen.healths
        );
        assert!(seen.alarmed < none, "{ms} ms: {} of {none}", seen.alarmed);
    }
    let mends = play(&motion, |i| shifted(&motion, i, if i < 60_000 { 40 } else { 0 }));
    let healths: Vec<_> = mends.healths.iter().map(|(_, health)| *health).collect();
    assert_eq!(healths, [SensorHealth::Late, SensorHealth::Good]);
}

/// How soon that is differs by half from robot to robot, so the bound is one of their mean.
#[test]
fn a_wrong_reference_is_reported_within_a_minute_or_so() {
    let mean_s = |play: &dyn Fn(u32, &[f32]) -> Seen| {
        let reported = (2..8).map(|seed| match play(seed, &robot(seed, LEN)).healths[..] {
            [(at_s, _)] => at_s,
            ref other => panic!("{seed}: {other:?}"),
        });
        reported.sum::<f32>() / 6.0
    };
    for (ms, within_s) in [(20, 30.0), (90, 35.0), (-15, 25.0), (-50, 80.0)] {
        let at_s = mean_s(&|_, motion| play(motion, |i| shifted(motion, i, ms)));
        assert!(at_s < within_s, "{ms} ms: reported after {at_s} s");
    }
    let at_s = mean_s(&|seed, motion| {
        let other = robot(seed + 50, LEN);
        play(motion, |i| shifted(&other, i, 0))
    });
    assert!(at_s < 60.0, "reported after {at_s} s");
}

/// From 40 s on the alarms are those of a reference in time, later by as much as that is late and some milliseconds.
#[test]
fn the_stylus_waits_for_a_reference_that_is_late() {
    for seed in [2, 3, 4] {
        let motion = robot(seed, LEN);
        let alarms = |ms| -> Vec<usize> {
            let seen = play(&motion, |i| shifted(&motion, i, ms));
            let waits_ms = if ms > 0 { ms as f32 + 2.5 } else { 0.0 };
            assert!((seen.waits_ms - waits_ms).abs() < 2.6, "{ms} ms: waits {}", seen.waits_ms);
            seen.alarms.into_iter().filter(|i| *i > 80_000).collect()
        };
        let sound = alarms(0);
        assert!(!sound.is_empty());
        for ms in [5, 10, 20] {
            let late = alarms(ms);
            assert!(late.len() <= sound.len() + 2, "{ms} ms: {late:?}, in time {sound:?}");
            let begun = |i: usize| (80_000 + 10_000 * i)..(80_200 + 10_000 * i);
            let reported = |alarms: &[usize], by: usize| {
                (1..12)
                    .filter(|i| {
                        let slides = begun(*i);
                        alarms.iter().any(|at| (slides.start..slides.end + by).contains(at))
                    })
                    .count()
            };
            let by = 2 * (ms as usize + 5);
            assert!(
                reported(&late, by) + 1 >= reported(&sound, 0),
                "{ms} ms: {late:?}, in time {sound:?}"
            );
        }
    }
}

/// From 10 s after it is noticed the alarms are nearly as rare as with a reference in time, and none waits.
#[test]
fn a_reference_that_is_early_waits_for_the_stylus() {
    let motion = robot(2, 2 * LEN);
    let play = |ms| play(&motion, |i| shifted(&motion, i, ms));
    let sound = play(0);
    for ms in [-15, -50, -90] {
        let early = play(ms);
        let [(at_s, SensorHealth::Late)] = early.healths[..] else { panic!("{:?}", early.healths) };
        assert_eq!(early.waits_ms, 0.0, "{ms} ms");
        let from = ((at_s + 10.0) * RATE_HZ) as usize;
        let after = |seen: &Seen| seen.alarms.iter().filter(|i| **i > from).count();
        let (early, sound) = (after(&early), after(&sound));
        assert!(early <= 2 * sound + 2, "{ms} ms: {early}, in time {sound}");
    }
}

/// A robot that knocks at these samples.
fn knocking(knocks: &[usize]) -> Vec<f32> {
    let mut motion = robot(5, LEN);
    for at in knocks {
        for (i, x) in motion[*at..*at + 100].iter_mut().enumerate() {
            let t = i as f32 / RATE_HZ;
            *x += 150.0 * (-t / 4e-3).exp() * (core::f32::consts::TAU * 430.0 * t).sin();
        }
    }
    motion
}

/// Knocks show a delay that is too short for the envelopes of motion.
#[test]
fn a_reference_that_shows_knocks_later_is_waited_for() {
    let knocks: Vec<usize> = (0..95).map(|i| 6_100 + 2_030 * i).collect();
    let motion = knocking(&knocks);
    let false_alarms = |seen: &Seen| {
        let knocked = |i: &usize| knocks.iter().any(|at| (*at..*at + 20).contains(i));
        seen.alarms.iter().filter(|i| knocked(i)).count()
    };
    let sound = play(&motion, |i| shifted(&motion, i, 0));
    assert_eq!((sound.waits_ms, false_alarms(&sound)), (0.0, 0));
    for ms in [1, 2, 3] {
        let late = play(&motion, |i| shifted(&motion, i, ms));
        assert!(late.waits_ms > 3.0 && late.waits_ms < 9.0, "{ms} ms: waits {}", late.waits_ms);
        assert!(false_alarms(&late) <= 6, "{ms} ms: {}", false_alarms(&late));
    }
}

/// The second of two knocks comes just before such a reference shows the first.
#[test]
fn a_reference_that_is_too_late_is_not_waited_for_a_little() {
    let knocks: Vec<usize> =
        (0..95).flat_map(|i| [0, 56].map(|at| 6_100 + 2_030 * i + at)).collect();
    let motion = knocking(&knocks);
    let late = play(&motion, |i| shifted(&motion, i, 30));
    assert!(matches!(late.healths[..], [(_, SensorHealth::Late)]), "{:?}", late.healths);
    assert_eq!(late.waits_ms, 0.0);
}

#[test]
fn the_reference_of_another_robot_is_reported_and_is_then_as_none() {
    for seed in [3, 4, 5] {
        let (motion, other) = (robot(seed, LEN), robot(seed + 50, LEN));
        let none = play(&motion, |_| None);
        let seen = play(&motion, |i| shifted(&other, i, 0));
        let [(at_s, SensorHealth::Uncoupled)] = seen.healths[..] else {
            panic!("{:?}", seen.healths)
        };
        let from = ((at_s + 1.0) * RATE_HZ) as usize;
        let after = |alarms: &[usize]| alarms.iter().filter(|i| **i > from).count();
        assert_eq!(after(&seen.alarms), after(&none.alarms));
    }
    // A stylus that feels nothing of what the reference shows: the slips are those of a robot at rest.
    let (still, other) = (vec![0.0; LEN], robot(7, LEN));
    let seen = play(&still, |i| shifted(&other, i, 0));
    let [(at_s, SensorHealth::Uncoupled)] = seen.healths[..] else { panic!("{:?}", seen.healths) };
    let from = ((at_s + 1.0) * RATE_HZ) as usize;
    let after = |alarms: &[usize]| alarms.iter().filter(|i| **i > from).count();
    assert_eq!(after(&seen.alarms), after(&play(&still, |_| None).alarms));
    assert!(at_s < 60.0 && after(&seen.alarms) >= 8, "{at_s} s, {:?}", seen.alarms);
}
