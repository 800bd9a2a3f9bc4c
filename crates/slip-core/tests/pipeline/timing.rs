//! Samples that are missing, late, twice or far in the future; every rate the contract knows.

use crate::object::{Loop, Object};
use slip_core::{Phase, Sample, SlipReport, grip::GripConfig, units::Micros};

/// By the reflex alone: no travel is measured and there is no network.
#[test]
fn every_rate_finds_the_slip_and_stops_the_object() {
    let blind = |sample| Sample { travel_m: None, ..sample };
    for rate in [1000.0, 2200.0, 10_000.0, 20_000.0] {
        for needed_n in [3.0, 8.0, 16.0] {
            let mut grip = Loop::new(Object::new(rate, needed_n, 0.7));
            let mut events = Vec::new();
            while grip.object.t_s() < 1.5 {
                let step = grip.step(blind);
                events.extend(step.event.map(|_| step));
            }
            let found = events[0].t.as_seconds() - 0.7;
            assert!((0.0..0.03).contains(&found), "{rate} Hz, {needed_n} N: {found} s");
            let Object { speed_m_s, travel_m, applied_n, .. } = grip.object;
            assert!(
                speed_m_s == 0.0 && travel_m < 0.03,
                "{rate} Hz, {needed_n} N: slid {travel_m} m"
            );
            assert!(
                applied_n >= needed_n && applied_n < 60.01,
                "{rate} Hz: {applied_n} N of {needed_n} N"
            );
            assert!(events.last().unwrap().event.is_some_and(|slip| slip.phase == Phase::Ended));
        }
    }
}

/// 0, the 32-bit wrap of a microsecond counter, and times beyond it: the steps are the same.
#[test]
fn the_start_of_the_clock_changes_nothing() {
    let steps = |start_us: u64| {
        let mut grip = Loop::new(Object::new(10_000.0, 8.0, 0.7).starting_at(start_us));
        let steps = (0..12_000).map(|_| {
            let step = grip.step(|sample| sample);
            let since = |t: Micros| Micros(t.0 - start_us);
            let event = step.event.map(|slip| SlipReport { t: since(slip.t), ..slip });
            slip_core::Step { t: since(step.t), event, ..step }
        });
        steps.collect::<Vec<_>>()
    };
    let reference = steps(0);
    assert!(reference.iter().any(|step| step.event.is_some()));
    for start_us in [1_000_000_000, u64::from(u32::MAX) - 800_000, 1 << 52, u64::MAX - 10_000_000] {
        assert!(steps(start_us) == reference, "starting at {start_us} us");
    }
}

#[test]
fn a_gap_at_rest_is_no_slip_whatever_the_stylus_shows_after_it() {
    for gap_us in [20_000, 500_000, 3_600_000_000] {
        for zero in [0.0_f32, 2e-5, -8e-4] {
            let mut grip = Loop::new(Object::new(10_000.0, 8.0, 9.0));
            grip.run_until(0.7);
            let held = grip.command_n;
            for _ in 0..3000 {
                let step = grip.step(|sample| Sample {
                    t: sample.t.plus(Micros(gap_us)),
                    stylus: sample.stylus + zero,
                    ..sample
                });
                assert!(step.event.is_none(), "{gap_us} us, {zero}: {step:?}");
                assert!(step.command.unwrap().0 <= held, "{gap_us} us, {zero}: {step:?}");
            }
        }
    }
}

/// The force may rise by no more than the slew over the 10 ms that the controller believes.
#[test]
fn a_gap_in_a_slip_does_not_jump_the_force() {
    let slew_n_s = GripConfig::default().slew_n_s;
    let mut grip = Loop::new(Object::new(10_000.0, 20.0, 0.7));
    grip.run_until(0.73);
    for gaps in 1..50_u64 {
        let before = grip.command_n;
        let step =
            grip.step(|sample| Sample { t: sample.t.plus(Micros(gaps * 200_000)), ..sample });
        let rise = step.command.unwrap().0 - before;
        assert!(rise <= slew_n_s * 0.01 + 0.01, "{rise} N after a gap of 0.2 s");
    }
    assert!(grip.command_n <= 60.0);
}

#[test]
fn samples_that_come_twice_or_late_change_nothing() {
    let mut plain = Loop::new(Object::new(10_000.0, 8.0, 0.7));
    let mut stirred = Loop::new(Object::new(10_000.0, 8.0, 0.7));
    let mut extra = 0;
    for i in 0..12_000_u64 {
        let step = plain.step(|sample| sample);
        assert_eq!(stirred.step(|sample| sample), step);
        for late_us in [0, 100, 700_000].into_iter().filter(|_| i % 7 == 0) {
            let old = Sample {
                normal_force_n: Some(50.0),
                ..Sample::stylus(Micros(step.t.0.saturating_sub(late_us)), 3e-3)
            };
            let again = stirred.pipeline.handle(&old);
            assert_eq!((again.event, again.command), (None, step.command));
            extra += 1;
        }
    }
    assert_eq!(stirred.pipeline.health_counters().time_faults, extra);
}
