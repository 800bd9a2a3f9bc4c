//! A stylus that fails while an object is held, and while it slips: the fault is counted and reported, the force does not
//! rise, and what comes after is felt as before.

use crate::object::{Loop, Object};
use slip_core::{
    Sample, SlipReport,
    grip::GripState,
    health::{HealthCounters, SensorHealth},
    sample::Scene,
};
use std::collections::VecDeque;

/// What happens to the stylus, sample by sample of the fault.
type Fault = fn(u32, f32) -> f32;

/// Name, fault, the health it leads to (none for lone spikes) and the counter that reports it.
type Case = (&'static str, Fault, Option<SensorHealth>, fn(&HealthCounters) -> u64);

const CASES: [Case; 8] = [
    ("NaN", |_, _| f32::NAN, Some(SensorHealth::Failed), |c| c.not_finite),
    ("infinite", |_, _| f32::NEG_INFINITY, Some(SensorHealth::Failed), |c| c.not_finite),
    ("huge", |_, _| 1e30, Some(SensorHealth::Saturated), |c| c.saturated),
    ("saturated", |_, _| 5e-3, Some(SensorHealth::Saturated), |c| c.saturated),
    (
        "alternating",
        |i, _| if i % 2 == 0 { 6e-3 } else { f32::NAN },
        Some(SensorHealth::Failed),
        |c| c.saturated,
    ),
    ("frozen", |_, _| 1.0e-4, Some(SensorHealth::Frozen), |c| c.failures),
    ("glitches", |i, x| if i % 40 == 0 { 4e-3 } else { x }, None, |c| c.glitches),
    ("gaps", |i, x| if i % 40 < 5 { f32::NAN } else { x }, None, |c| c.not_finite),
];

/// Long enough for a frozen stylus to be noticed (samples at 10 kHz).
const LENGTH: u32 = 1500;

fn broken(fault: Fault, i: u32) -> impl FnOnce(Sample) -> Sample {
    move |sample| Sample { stylus: fault(i, sample.stylus), ..sample }
}

/// A gripper that holds an object at rest, which begins to slide at `lifted_s`.
fn holding(lifted_s: f64) -> Loop {
    let mut grip = Loop::new(Object::new(10_000.0, 6.0, lifted_s));
    grip.run_until(0.6);
    assert_eq!(grip.pipeline.grip_state(), Some(GripState::Holding));
    grip
}

fn is_first_slip(event: Option<SlipReport>) -> bool {
    event.is_some_and(|slip| slip.first)
}

#[test]
fn a_fault_while_holding_is_reported_and_moves_nothing() {
    for (name, fault, health, counter) in CASES {
        let mut grip = holding(1.2);
        let held = grip.command_n;
        let mut worst = SensorHealth::Good;
        for i in 0..LENGTH {
            let step = grip.step(broken(fault, i));
            if step.sensors[0] != SensorHealth::Good {
                worst = step.sensors[0];
            }
            assert!(step.event.is_none() && step.command.unwrap().0 <= held, "{name}: {step:?}");
        }
        assert_eq!(worst, health.unwrap_or_default(), "{name}");
        assert!(counter(&grip.pipeline.health_counters()) > 0, "{name}");
        let failures = grip.pipeline.health_counters().failures;
        assert_eq!(failures > 0, health.is_some(), "{name}");
        assert!(
            grip.run_until(1.2).is_empty() && grip.command_n <= held,
            "{name}: {}",
            grip.command_n
        );
        let events = grip.run_until(1.25);
        let first = events.first().unwrap_or_else(|| panic!("{name}: the slip was not found"));
        assert!(
            is_first_slip(first.event) && first.sensors[0] == SensorHealth::Good,
            "{name}: {first:?}"
        );
        assert!(first.t.as_seconds() < 1.22, "{name}: {first:?}");
        assert!(grip.command_n > held, "{name}: the slip is answered");
    }
}

/// A sensor that was gone may come back with another zero, which is no slip.
#[test]
fn a_new_zero_after_a_fault_is_no_slip() {
    for (name, fault, health, _) in CASES.into_iter().filter(|case| case.2.is_some()) {
        for zero in [5e-6_f32, 1e-4, -9e-4] {
            let mut grip = holding(9.0);
            let held = grip.command_n;
            for i in 0..LENGTH {
                grip.step(broken(fault, i));
            }
            for _ in 0..5000 {
                let step = grip.step(|sample| Sample { stylus: sample.stylus + zero, ..sample });
                assert!(step.event.is_none(), "{name} ({health:?}), back at {zero}: {step:?}");
                assert!(step.command.unwrap().0 <= held, "{name}, back at {zero}: {step:?}");
            }
        }
    }
}

/// The stylus alone: where travel is measured as well, it carries on.
#[test]
fn a_fault_in_a_slip_stops_the_rise_and_the_next_slip_is_found() {
    for (name, fault, health, counter) in CASES {
        let alone = |sample: Sample| Sample { travel_m: None, ..sample };
        let mut grip = holding(0.7);
        while grip.pipeline.grip_state() != Some(GripState::Slipping)
            || grip.object.speed_m_s < 0.02
        {
            assert!(grip.object.t_s() < 1.0, "held before");
            grip.step(alone);
        }
        let mut reported = false;
        for i in 0..LENGTH {
            let before = grip.command_n;
            let step = grip.step(|sample| broken(fault, i)(alone(sample)));
            reported |= Some(step.sensors[0]) == health;
            assert!(
                step.sensors[0] == SensorHealth::Good || step.command.unwrap().0 <= before,
                "{name}: {step:?}"
            );
            // Held up from below meanwhile: this is about the sensor, not about the fall.
            grip.object.speed_m_s = grip.object.speed_m_s.min(0.05);
        }
        assert_eq!(reported, health.is_some(), "{name}");
        assert!(counter(&grip.pipeline.health_counters()) > 0, "{name}");
        // Set down, at rest, and lifted again with more weight than the force so far can hold.
        grip.object.lifted_s = grip.object.t_s() + 0.5;
        grip.object.speed_m_s = 0.0;
        grip.run_until(grip.object.lifted_s - 0.1);
        assert!(grip.run_until(grip.object.lifted_s).is_empty(), "{name}: at rest");
        let held = grip.command_n;
        grip.object.needed_n = 3.0 * f64::from(held);
        let lifted = grip.object.lifted_s;
        let events = grip.run_until(lifted + 0.05);
        assert!(events.first().is_some_and(|step| is_first_slip(step.event)), "{name}: {events:?}");
        assert!(events[0].t.as_seconds() < lifted + 0.02 && grip.command_n > held, "{name}");
    }
}

/// Travel shows the fall: the force goes on rising, and the object is held, here without a network and so without estimates.
#[test]
fn a_stylus_that_is_lost_in_a_slip_leaves_the_answer_to_the_travel() {
    for (name, fault, health, _) in CASES.into_iter().filter(|case| case.2.is_some()) {
        for lost_at_m_s in [0.005, 0.02, 0.06] {
            let mut grip = holding(0.7);
            while grip.object.speed_m_s < lost_at_m_s {
                grip.step(|sample| sample);
                assert!(grip.object.t_s() < 1.0, "{lost_at_m_s}: held before");
            }
            let mut i = 0;
            while grip.object.t_s() < 1.2 {
                grip.step(broken(fault, i));
                i += 1;
            }
            let Object { applied_n, needed_n, travel_m, speed_m_s, .. } = grip.object;
            assert!(speed_m_s == 0.0 && travel_m < 0.03, "{name} {health:?}: {:?}", grip.object);
            // An answer that grows until the object stands overshoots; with estimates it would not.
            assert!(applied_n >= needed_n && applied_n < 2.6 * needed_n, "{name}: {applied_n} N");
        }
    }
}

/// Invariant (g): nothing that friction holds goes on as fast when it is pressed twice as hard. A drift that looks as fast as a fall (12 mm/s) is not bounded.
#[test]
fn a_travel_that_drifts_raises_nothing_for_good() {
    for speed_m_s in [3e-4, 1e-3, 5e-3] {
        // While less and less force is tried, and while the force stands.
        for from_s in [0.9, 4.0] {
            let mut grip = Loop::new(Object::new(10_000.0, 6.0, 0.7));
            let (mut held_n, mut peak_n, mut noise_m) = (0.0, 0.0_f32, 2e-7);
            while grip.object.t_s() < from_s + 12.0 {
                let drift_m = (speed_m_s * (grip.object.t_s() - from_s).max(0.0)) as f32 + noise_m;
                grip.step(|sample| Sample {
                    travel_m: sample.travel_m.map(|travel_m| travel_m + drift_m),
                    ..sample
                });
                noise_m = -noise_m;
                if drift_m < 1e-6 {
                    held_n = grip.command_n;
                }
                peak_n = peak_n.max(grip.command_n);
            }
            let case = format!(
                "{speed_m_s} m/s from {from_s} s on: {held_n} N, at most {peak_n} N, at last {} N",
                grip.command_n
            );
            assert!(peak_n <= 2.6 * held_n && grip.command_n <= 1.4 * held_n.max(8.0), "{case}");
        }
    }
}

/// What it shows when the travel has long stood is the slip of before. Without a network an object of 12 N slides too far
/// with a sound stylus already.
#[test]
fn a_stylus_that_is_late_neither_drops_nor_crushes() {
    for needed_n in [5.0, 8.0] {
        let mut grip = Loop::new(Object::new(10_000.0, needed_n, 0.7));
        let mut past = VecDeque::from([0.0; 3000]);
        while grip.object.t_s() < 3.0 {
            grip.step(|sample| {
                past.push_back(sample.stylus);
                Sample { stylus: past.pop_front().unwrap_or_default(), ..sample }
            });
        }
        let Object { applied_n, needed_n, travel_m, speed_m_s, .. } = grip.object;
        assert!(speed_m_s == 0.0 && travel_m < 0.03, "{needed_n} N: {:?}", grip.object);
        assert!(applied_n >= needed_n && applied_n < 2.5 * needed_n, "{needed_n} N: {applied_n} N");
    }
}

/// It reads as if nothing were touched. But what slides on between the fingers is there.
#[test]
fn a_force_sensor_that_falls_to_zero_in_a_slip_does_not_let_the_object_go() {
    for lost_at_m_s in [0.03, 0.045, 0.06] {
        let mut grip = Loop::new(Object::new(10_000.0, 8.0, 0.7));
        while grip.object.speed_m_s < lost_at_m_s {
            grip.step(|sample| sample);
            assert!(grip.object.t_s() < 1.0, "{lost_at_m_s}: held before");
        }
        let zero = |sample: Sample| Sample { normal_force_n: Some(0.0), ..sample };
        for _ in 0..10_000 {
            grip.step(zero);
        }
        let Object { speed_m_s, travel_m, applied_n, needed_n, .. } = grip.object;
        assert!(speed_m_s == 0.0 && travel_m < 0.03, "{lost_at_m_s}: {:?}", grip.object);
        assert!(applied_n < 2.7 * needed_n, "no more than without that sensor: {applied_n} N");
        // Nor is it deaf afterwards.
        grip.object.needed_n = 1.5 * applied_n;
        for _ in 0..10_000 {
            grip.step(zero);
        }
        assert!(grip.object.speed_m_s == 0.0, "{lost_at_m_s}: {:?}", grip.object);
    }
}

/// 50 um/s, reached within a second, for 5 s; then back at its place.
#[test]
fn a_drifting_stylus_moves_nothing_and_comes_back_after_three_calm_seconds() {
    let mut grip = holding(12.0);
    let held = grip.command_n;
    let mut reported_s = None;
    for i in 0..50_000_u16 {
        let t = 1e-4 * f32::from(i);
        // Without a kink, which would be a jerk that the detector receives.
        let drift = 5e-5 * if t < 1.0 { 0.5 * t * t } else { t - 0.5 };
        let step = grip.step(|sample| Sample { stylus: sample.stylus + drift, ..sample });
        assert!(step.event.is_none() && step.command.unwrap().0 <= held, "{step:?}");
        if step.sensors[0] == SensorHealth::Drifting {
            reported_s = reported_s.or(Some(step.t.as_seconds()));
        }
    }
    assert!(
        (2.6..5.5).contains(&reported_s.unwrap()),
        "100 um are passed after 2.6 s: {reported_s:?}"
    );
    let good = |grip: &mut Loop| grip.step(|sample| sample).sensors[0] == SensorHealth::Good;
    assert!(grip.run_until(7.5).is_empty() && !good(&mut grip), "not yet calm");
    assert!(grip.run_until(11.0).is_empty() && good(&mut grip));
    assert_eq!(grip.pipeline.health_counters().failures, 1);
    assert!(grip.command_n <= held);
    grip.run_until(11.9);
    let held = grip.command_n;
    let events = grip.run_until(12.05);
    assert!(is_first_slip(events.first().unwrap().event) && grip.command_n > held, "{events:?}");
}

/// The pads give way by 30 um/N under a force that comes and goes, as far as the reflex may drive it.
#[test]
fn a_change_of_grip_is_no_drift() {
    let mut grip = holding(60.0);
    for i in 0..100_000_u32 {
        let wave = (core::f64::consts::TAU * f64::from(i) / 160_000.0).sin();
        let more = (20.0 * wave * wave) as f32;
        let step = grip.step(|sample| Sample {
            stylus: sample.stylus + 3e-5 * more,
            normal_force_n: sample.normal_force_n.map(|force| force + more),
            ..sample
        });
        assert!(step.sensors[0] == SensorHealth::Good && step.event.is_none(), "{step:?}");
    }
}

/// The floor is the noise of the sensor, not the silence of a dead one.
#[test]
fn a_sensor_that_wakes_late_teaches_no_false_floor() {
    for (name, fault, ..) in CASES {
        let mut grip = Loop::new(Object::new(10_000.0, 6.0, 1.8));
        for i in 0..5000 {
            let step = grip.step(broken(fault, i));
            assert!(step.scene == Scene::Idle || step.event.is_none(), "{name}: {step:?}");
        }
        let events = grip.run_until(1.8);
        assert!(events.is_empty(), "{name}: {:?}", events[0]);
        assert_eq!(grip.pipeline.grip_state(), Some(GripState::Holding), "{name}");
        let events = grip.run_until(1.85);
        assert!(events.first().is_some_and(|step| is_first_slip(step.event)), "{name}: {events:?}");
    }
}

/// Broken force and travel sensors are taken as absent; the stylus alone still finds the slip.
#[test]
fn broken_other_sensors_are_left_out() {
    for bad in [f32::NAN, f32::INFINITY, -1e30] {
        let mut grip = holding(1.0);
        let held = grip.command_n;
        let spoil = |sample: Sample| Sample {
            normal_force_n: Some(bad),
            travel_m: Some(bad),
            velocity_m_s: Some(bad),
            ..sample
        };
        let mut found = None;
        while grip.object.t_s() < 1.05 {
            let step = grip.step(spoil);
            assert_eq!(step.sensors[0], SensorHealth::Good);
            if grip.object.t_s() < 1.0 {
                assert!(step.event.is_none() && step.command.unwrap().0 <= held, "{bad}: {step:?}");
            }
            found = found.or(step.event.map(|_| step.t.as_seconds()));
        }
        assert!(found.is_some_and(|t| t < 1.02) && grip.command_n > held, "{bad}: {found:?}");
        assert!(grip.pipeline.health_counters().other_channels > 10_000, "{bad}");
    }
}

/// Without a travel sensor, and with a second stylus that shows the same surface from another zero.
#[test]
fn a_second_stylus_carries_on_where_the_first_is_lost() {
    for (name, fault, health, _) in CASES.into_iter().filter(|case| case.2.is_some()) {
        for (lost_at_m_s, second) in [(0.0, true), (0.005, true), (0.02, true), (0.02, false)] {
            let shown = |sample: Sample| Sample {
                travel_m: None,
                second_stylus: second.then_some(sample.stylus + 3e-5),
                ..sample
            };
            let mut grip = holding(0.9);
            while grip.object.speed_m_s < lost_at_m_s {
                grip.step(shown);
                assert!(grip.object.t_s() < 1.2, "{lost_at_m_s}: held before");
            }
            let mut i = 0;
            while grip.object.t_s() < 1.5 {
                let step = grip.step(|sample| broken(fault, i)(shown(sample)));
                assert!(i < 1000 || Some(step.sensors[0]) == health, "{name}: {step:?}");
                i += 1;
            }
            let Object { applied_n, needed_n, travel_m, speed_m_s, .. } = grip.object;
            let held = speed_m_s == 0.0 && travel_m < 0.05;
            assert_eq!(held, second, "{name}, lost at {lost_at_m_s} m/s: {:?}", grip.object);
            assert!(!held || applied_n < 3.0 * needed_n, "{name}: {applied_n} N");
        }
    }
}

/// Forces of a finger at an object with this friction; at rest it carries what the force that just holds it would at most.
fn with_tangential(grip: &mut Loop, fault: impl Fn(Sample) -> Sample) -> slip_core::Step {
    const MU: f64 = 0.3;
    let Object { applied_n, needed_n, speed_m_s, .. } = grip.object;
    let lifted = grip.object.t_s() > grip.object.lifted_s;
    let load_n = if lifted { MU * if speed_m_s > 0.0 { applied_n } else { needed_n } } else { 0.0 };
    grip.step(|sample| {
        let flicker_n = 1e-3 * (sample.t.0 % 700) as f32 / 700.0;
        let tangential_n = Some(load_n as f32 + flicker_n);
        fault(Sample { travel_m: None, tangential_n, ..sample })
    })
}

#[test]
fn the_tangential_force_carries_on_where_every_slip_sensor_is_lost() {
    let lost = |sample: Sample| Sample { stylus: f32::NAN, ..sample };
    // In a slip.
    let mut grip = holding(0.7);
    while grip.object.speed_m_s < 0.05 {
        with_tangential(&mut grip, |sample| sample);
        assert!(grip.object.t_s() < 1.0, "held before");
    }
    while grip.object.t_s() < 1.2 {
        with_tangential(&mut grip, lost);
    }
    let Object { applied_n, needed_n, travel_m, speed_m_s, .. } = grip.object;
    assert!(speed_m_s == 0.0 && travel_m < 0.05, "{:?}", grip.object);
    // While it slides nothing states how heavy it is.
    assert!((1.0..3.3).contains(&(applied_n / needed_n)), "{applied_n} N");
    // While the object is held, with a load that then grows.
    let mut grip = holding(0.7);
    while grip.object.t_s() < 1.2 {
        with_tangential(&mut grip, |sample| sample);
    }
    let before_n = grip.object.needed_n;
    while grip.object.t_s() < 1.5 {
        let step = with_tangential(&mut grip, lost);
        assert!(step.command.unwrap().0 >= 0.99 * grip.object.needed_n as f32, "{step:?}");
        grip.object.needed_n = before_n * (1.0 + (grip.object.t_s() - 1.3).clamp(0.0, 0.1) * 10.0);
    }
    let Object { applied_n, needed_n, speed_m_s, .. } = grip.object;
    assert!(speed_m_s == 0.0 && (1.0..1.5).contains(&(applied_n / needed_n)), "{applied_n} N");
    // Nothing rises where the friction is not known, nor where the tangential force is lost too.
    let mut grip = holding(0.7);
    let held_n = grip.command_n;
    while grip.object.t_s() < 1.0 {
        with_tangential(&mut grip, lost);
        assert!(grip.command_n <= held_n);
    }
}

/// Healths of stylus and travel that are shown in the slip of an object that is lifted at 0.7 s, where the sensors show it as `seen` makes of it.
fn shown(seen: fn(u32, Sample) -> Sample) -> (Vec<SensorHealth>, Vec<SensorHealth>) {
    let mut grip = holding(0.7);
    let (mut stylus, mut travel) = (vec![SensorHealth::Good], vec![SensorHealth::Good]);
    for i in 0..5000 {
        let flicker_m = 1e-8 * (i % 3) as f32;
        let step = grip.step(|sample| {
            let travel_m = sample.travel_m.map(|travel_m| travel_m + flicker_m);
            seen(i, Sample { travel_m, ..sample })
        });
        if stylus.last() != Some(&step.sensors[0]) {
            stylus.push(step.sensors[0]);
        }
        if travel.last() != Some(&step.sensors[1]) {
            travel.push(step.sensors[1]);
        }
    }
    (stylus, travel)
}

#[test]
fn a_sensor_that_has_no_say_is_named() {
    let (stylus, travel) = shown(|_, sample| sample);
    assert_eq!((stylus, travel), (vec![SensorHealth::Good], vec![SensorHealth::Good]));
    // Equal to the last bit it would be frozen.
    let stands = |i, sample| Sample { travel_m: Some(1e-7 * (i % 2) as f32), ..sample };
    assert_eq!(shown(stands).1, [SensorHealth::Good, SensorHealth::Doubted]);
    let coarse = |_, sample: Sample| {
        let steps = sample.travel_m.map(|travel_m| (travel_m / 2e-5).floor());
        Sample { travel_m: steps.map(|steps| steps * 2e-5), ..sample }
    };
    // Where the object creeps between two steps it may look frozen in the end.
    assert_eq!(shown(coarse).1[..2], [SensorHealth::Good, SensorHealth::Coarse]);
    let noisy = |i, sample| Sample { stylus: 1e-6 * (i * 7919 % 97) as f32, ..sample };
    assert_eq!(shown(noisy).0, [SensorHealth::Good, SensorHealth::Doubted]);
}
