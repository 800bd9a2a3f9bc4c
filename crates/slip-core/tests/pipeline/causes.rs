//! Knocks, changes of the grip force, closing fingers and stops of the arm, with and without a slip: what an alarm states of its causes.

use slip_core::{
    Cause::{self, ArmStop, Closing, GripChange, Knock, Motion},
    CauseSet, Causes, Phase, Pipeline, PipelineConfig, Sample, Signal,
    units::{Hertz, Micros},
};

const RATE_HZ: f32 = 10_000.0;
/// When the slip begins, where there is one (s).
const SLIP_S: f32 = 3.0;

/// What the sensors show at a time (s): deviations of stylus and reference that motion or a knock adds, force and command.
#[derive(Clone, Copy)]
struct World {
    stylus: fn(f32) -> f32,
    reference: fn(f32) -> Option<f32>,
    force_n: fn(f32) -> Option<f32>,
    motion: fn(f32) -> Option<f32>,
    slips: bool,
}

/// A hand with a sound reference and a force sensor that has held an object since 1 s.
const CALM: World = World {
    stylus: |_| 0.0,
    reference: |_| Some(0.0),
    force_n: |t| Some(if t < 1.0 { 0.0 } else { 2.0 }),
    motion: |_| None,
    slips: true,
};

fn noise(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        3.46 * (f64::from(state) / f64::from(u32::MAX) - 0.5) as f32
    }
}

/// Whether `t` (s) is within the time.
fn within(t: f32, from_s: f32, to_s: f32) -> bool {
    (from_s..to_s).contains(&t)
}

/// Time and causes of every alarm. Motion and knocks leave the same at stylus and reference; a slip vibrates with 8 times the noise.
fn alarms(world: World) -> Vec<(f64, bool, Causes)> {
    let config = PipelineConfig::observing(Signal::Vibration, Hertz(RATE_HZ));
    let mut pipeline = Pipeline::<&[f32]>::new(config, None).unwrap();
    let (mut own, mut shared) = (noise(3), noise(5));
    let steps = (0..(3.5 * RATE_HZ) as u32).map(|i| {
        let t = i as f32 / RATE_HZ;
        let slip = if world.slips && within(t, SLIP_S, SLIP_S + 0.2) { 8.0 } else { 0.0 };
        let both = shared();
        let stylus = own() + slip * own() + (world.stylus)(t) * both;
        pipeline.handle(&Sample {
            reference: (world.reference)(t).map(|level| own() + level * both),
            normal_force_n: (world.force_n)(t),
            motion: (world.motion)(t),
            ..Sample::stylus(Micros(100 * u64::from(i)), stylus)
        })
    });
    let causes = steps.filter_map(|step| {
        let slip = step.event.filter(|slip| slip.phase != Phase::Ended)?;
        let (ruled_out, possible) =
            (CauseSet::from_bits(slip.ruled_out), CauseSet::from_bits(slip.possible));
        Some((step.t.as_seconds(), slip.first, Causes { ruled_out, possible }))
    });
    causes.collect()
}

/// The causes of the first alarm from [`SLIP_S`] - 0.1 s on.
fn first(world: World) -> Causes {
    let alarms = alarms(world);
    let at = |(t, first, _): &&(f64, bool, Causes)| *first && *t > f64::from(SLIP_S) - 0.1;
    alarms.iter().find(at).unwrap().2
}

/// Causes possible, ruled out, and not judged.
fn expect(causes: Causes, possible: &[Cause], ruled_out: &[Cause]) {
    let named = |set: CauseSet| set.iter().collect::<Vec<_>>();
    assert_eq!(named(causes.possible), possible, "{causes:?}");
    assert_eq!(named(causes.ruled_out), ruled_out, "{causes:?}");
}

#[test]
fn a_slip_of_a_quiet_hand_has_every_other_cause_ruled_out() {
    expect(first(CALM), &[], &Cause::ALL);
}

#[test]
fn without_its_sensor_a_cause_cannot_be_judged() {
    let deaf = World { reference: |_| None, ..CALM };
    expect(first(deaf), &[], &[GripChange, Closing]);
    let reported = World { motion: |_| Some(0.0), ..deaf };
    expect(first(reported), &[], &[Motion, GripChange, Closing, ArmStop]);
    expect(first(World { force_n: |_| None, ..CALM }), &[], &[Knock, Motion, ArmStop]);
    let lost = |t: f32| (t < 2.9).then_some(0.0);
    expect(first(World { reference: lost, ..CALM }), &[], &[GripChange, Closing]);
}

/// A blow of 5 ms; at the stylus it is ten times as strong as at the reference, which raises an alarm.
#[test]
fn a_knock_is_possible_while_it_rings_and_ruled_out_afterwards() {
    let reference = |t: f32| Some(if within(t, 2.98, 2.985) { 20.0 } else { 0.0 });
    for slips in [false, true] {
        let stylus = |t: f32| if within(t, 2.98, 2.985) { 200.0 } else { 0.0 };
        let causes = first(World { stylus, reference, slips, ..CALM });
        assert_eq!(causes.ruled_out(Knock), Some(false), "{slips}: {causes:?}");
        assert_eq!(causes.ruled_out(GripChange), Some(true));
    }
    // A slip well after a light one.
    let reference = |t: f32| Some(if within(t, 2.9, 2.905) { 20.0 } else { 0.0 });
    let causes = first(World { reference, ..CALM });
    assert_eq!(causes.ruled_out(Knock), Some(true), "{causes:?}");
}

#[test]
fn a_step_of_the_grip_force_is_possible_for_half_a_second() {
    let force_n =
        |t: f32| Some(if t < 1.0 { 0.0 } else { 2.0 + (10.0 * (t - 2.95)).clamp(0.0, 1.0) });
    expect(first(World { force_n, ..CALM }), &[GripChange], &[Knock, Motion, Closing, ArmStop]);
    // The pads creep, nothing slips.
    let stylus = |t: f32| if within(t, 2.98, 3.0) { 8.0 } else { 0.0 };
    let creep = World { force_n, stylus, slips: false, ..CALM };
    expect(first(creep), &[GripChange], &[Knock, Motion, Closing, ArmStop]);
    let force_n = |t: f32| {
        Some(if t < 1.0 {
            0.0
        } else if t < 2.4 {
            2.0
        } else {
            3.0
        })
    };
    expect(first(World { force_n, ..CALM }), &[], &Cause::ALL);
}

#[test]
fn closing_is_possible_for_half_a_second_after_contact() {
    let force_n = |t: f32| Some((20.0 * (t - 2.7)).clamp(0.0, 2.0));
    let closing = World { force_n, ..CALM };
    expect(first(closing), &[GripChange, Closing], &[Knock, Motion, ArmStop]);
    let stylus = |t: f32| if within(t, 2.95, 2.97) { 8.0 } else { 0.0 };
    let creep = World { stylus, slips: false, ..closing };
    expect(first(creep), &[GripChange, Closing], &[Knock, Motion, ArmStop]);
}

/// The arm moves until 2.9 s; the gate knows how strongly the stylus shows that.
#[test]
fn the_stop_of_the_arm_is_possible_after_motion_and_not_in_it() {
    let level = |t: f32| if within(t, 2.0, 2.9) { 30.0 } else { 0.0 };
    let seen = |t: f32| Some(if within(t, 2.0, 2.9) { 60.0 } else { 0.0 });
    let stops = World { stylus: level, reference: seen, ..CALM };
    assert_eq!(first(stops).ruled_out(ArmStop), Some(false));
    assert_eq!(first(stops).ruled_out(GripChange), Some(true));
    let long_ago = |t: f32| Some(if within(t, 2.0, 2.5) { 60.0 } else { 0.0 });
    expect(first(World { reference: long_ago, ..CALM }), &[], &Cause::ALL);

    let sways = |t: f32| if within(t, 2.95, 2.97) { 8.0 } else { 0.0 };
    let swaying = World { stylus: sways, reference: long_ago, slips: false, ..CALM };
    expect(first(swaying), &[], &Cause::ALL);
    let until = |t: f32| Some(if within(t, 2.0, 2.9) { 1.0 } else { 0.0 });
    let reported = World { stylus: sways, motion: until, slips: false, ..CALM };
    assert_eq!(first(reported).ruled_out(ArmStop), Some(false));
    // The reference shows how the arm rings after its command has ended.
    let rings = World { stylus: level, reference: |_| Some(60.0), motion: until, ..CALM };
    let learned = |t: f32| Some(if t > 2.0 { 60.0 } else { 0.0 });
    let rings = World { reference: learned, ..rings };
    let loud = |t: f32| {
        if within(t, 2.0, 2.95) {
            30.0
        } else if t > 2.95 {
            400.0
        } else {
            0.0
        }
    };
    assert_eq!(first(World { stylus: loud, ..rings }).ruled_out(ArmStop), Some(false));
}

#[test]
fn motion_is_possible_in_weak_alarms_and_ruled_out_in_strong_ones() {
    let goes_on = |t: f32| Some(if t > 2.0 { 20.0 } else { 0.0 });
    let moves = World { reference: goes_on, slips: false, ..CALM };
    let weak =
        |t: f32| if t > 2.0 { 10.0 + 12.0 * (4.0 * (t - 2.9)).clamp(0.0, 10.0) } else { 0.0 };
    let causes = first(World { stylus: weak, ..moves });
    assert_eq!(causes.ruled_out(Motion), Some(false), "{causes:?}");
    assert_eq!(causes.ruled_out(ArmStop), None, "it may be stopping");
    let strong = |t: f32| {
        if within(t, 2.0, 3.0) {
            10.0
        } else if t >= 3.0 {
            900.0
        } else {
            0.0
        }
    };
    let causes = first(World { stylus: strong, ..moves });
    assert_eq!(causes.ruled_out(Motion), Some(true), "{causes:?}");
}

/// The answer to a slip is no cause of it, and what outlasts a knock is not that knock.
#[test]
fn later_events_of_a_slip_know_more_of_knocks_and_no_more_of_the_grip() {
    let force_n =
        |t: f32| Some(if t < 1.0 { 0.0 } else { 2.0 + (10.0 * (t - 3.01)).clamp(0.0, 1.0) });
    let reference = |t: f32| Some(if within(t, 2.98, 2.985) { 20.0 } else { 0.0 });
    let stylus = |t: f32| match t {
        t if within(t, 2.99, 3.04) => 4.5,
        t if within(t, 3.04, 3.2) => 30.0,
        _ => 0.0,
    };
    let events = alarms(World { force_n, reference, stylus, slips: false, ..CALM });
    let [(_, true, noticed), (_, false, gross), ..] = events[..] else { panic!("{events:?}") };
    assert_eq!((noticed.ruled_out(Knock), gross.ruled_out(Knock)), (Some(false), Some(true)));
    assert_eq!(noticed.ruled_out(GripChange), Some(true));
    assert_eq!(gross.ruled_out(GripChange), Some(true));
}
