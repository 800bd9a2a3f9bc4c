//! The delay that is learned, what the sensor is worth, and how far the command leads.

extern crate std;
use super::{Drive, ForceSensor};
use std::{collections::VecDeque, vec::Vec};

const DT_S: f32 = 1e-3;
const LAG_S: f32 = 5e-3;

/// A drive of this delay, of which nothing else is known.
fn late_by(delay_s: f32) -> Drive {
    Drive { delay_s: Some(delay_s), ..Drive::default() }
}

/// A slip begins under a command of `force_n` (N) in a drive with a lag of 5 ms.
fn slipping(force_n: f32) -> Drive {
    slips(LAG_S, force_n)
}

fn slips(lag_s: f32, force_n: f32) -> Drive {
    let mut drive = late_by(lag_s);
    drive.begin(force_n, Some(force_n), 0.0);
    drive
}

/// The force (N) a millisecond later, by a reading and the command of the sample before (N).
fn step(drive: &mut Drive, reading_n: Option<f32>, command_n: f32) -> f32 {
    drive.follow(command_n, DT_S);
    drive.measure(reading_n, DT_S, 0.0, false)
}

#[test]
fn a_good_reading_is_the_force_and_a_missing_one_goes_on_from_it() {
    let mut force = slipping(2.0);
    for i in 0..50_u8 {
        let reading = 2.0 + 0.1 * f32::from(i);
        assert_eq!(step(&mut force, Some(reading), 8.0), reading);
    }
    let first = step(&mut force, None, 8.0);
    assert!((first - 6.9).abs() < 0.4, "{first}");
    let last = (0..50).map(|_| step(&mut force, None, 8.0)).last().unwrap();
    assert!((last - 8.0).abs() < 1e-3, "{last}");
}

#[test]
fn a_reading_that_stands_while_the_command_rises_is_none_and_one_that_may_stand_is_the_force() {
    let mut force = slipping(2.0);
    let stuck: Vec<f32> = (0..60).map(|_| step(&mut force, Some(2.0), 2.45)).collect();
    assert!(stuck[..15].iter().all(|f| *f == 2.0) && stuck[59] > 2.44, "{stuck:?}");
    assert_eq!(step(&mut force, Some(2.4), 2.45), 2.4, "it is back");
    let mut calm = slipping(2.0);
    assert!((0..500).all(|_| step(&mut calm, Some(2.0), 2.1) == 2.0));
}

/// A converter of 12 bits shows the same value until the force of a late drive comes.
#[test]
fn a_coarse_reading_stands_for_as_long_as_the_gripper_is_late() {
    const LATE_S: f32 = 0.035;
    let mut coarse = slips(LATE_S, 2.0);
    let mut show = |reading_n| {
        coarse.follow(5.0, DT_S);
        coarse.measure(Some(reading_n), DT_S, 0.0, true)
    };
    assert!((0..45).all(|_| show(2.0) == 2.0));
    assert_eq!(show(2.3), 2.3);
    let mut stuck = slips(LATE_S, 2.0);
    let last_n = (0..200).map(|_| step(&mut stuck, Some(2.0), 5.0)).last().unwrap();
    assert!(last_n > 4.9, "{last_n}");
}

/// The force of the fingers (N) `i` ms after the command rose from 2 N by 0.1 N a millisecond, behind a lag of 6 ms.
fn driven(i: i32) -> f32 {
    (0..i).fold(2.0, |force_n: f32, j| force_n + (2.0 + 0.1 * j as f32 - force_n) / 6.0)
}

#[test]
fn a_sensor_with_another_gain_gives_the_force_that_was_commanded() {
    for gain in [0.7_f32, 1.3] {
        let mut force = late_by(LAG_S);
        for _ in 0..100 {
            force.hold(Some(2.0 * gain), 2.0, 1000.0);
        }
        force.begin(2.0, Some(2.0 * gain), 0.0);
        for i in 1..60 {
            let reported = step(&mut force, Some(gain * driven(i)), 2.0 + 0.1 * i as f32);
            assert!((reported / driven(i) - 1.0).abs() < 0.02, "{gain} {i}: {reported}");
        }
    }
}

/// The command rises by a hundredth of itself a millisecond behind a load that does the same: a sensor that is late by 50 ms shows 0.6 of the
/// force, which a drive much later than the known one of 20 ms would show as well.
#[test]
fn a_reading_below_what_was_commanded_is_doubted_where_the_object_gets_faster_all_the_same() {
    let reported = |delay_ms: i32, speeds_up: bool| {
        let command_n = |i: i32| 2.0 * 1.01_f32.powi(i.max(0));
        let (mut force, mut applied) = (slips(20e-3, 2.0), Vec::new());
        let mut applied_n = 2.0;
        (0..120)
            .map(|i| {
                applied_n += (command_n(i) - applied_n) / 20.0;
                applied.push(applied_n);
                let read_n = applied[usize::try_from(i - delay_ms).unwrap_or(0)];
                force.follow(command_n(i), DT_S);
                force.measure(Some(read_n), DT_S, 0.0, speeds_up) / applied_n
            })
            .last()
            .unwrap()
    };
    assert!((reported(50, true) - 1.0).abs() < 0.02, "late: {}", reported(50, true));
    assert!(reported(50, false) < 0.7, "a drive may be late: {}", reported(50, false));
    assert!((reported(0, true) - 1.0).abs() < 1e-6, "sound: {}", reported(0, true));
}

#[test]
fn a_late_sensor_is_doubted_for_this_object_and_a_late_drive_is_not() {
    let mut late = slipping(2.0);
    let reported: Vec<f32> =
        (1..150).map(|i| step(&mut late, Some(driven(i - 50)), 2.0 + 0.1 * i as f32)).collect();
    assert!(reported[40] > 0.85 * driven(41) && reported[140] > 0.95 * driven(141), "{reported:?}");
    late.begin(8.0, Some(2.0), 0.0);
    assert_eq!(step(&mut late, Some(2.0), 8.0), 8.0, "the same object");
    late.prime();
    late.begin(8.0, Some(8.0), 0.0);
    assert_eq!(step(&mut late, Some(8.1), 8.0), 8.1, "another one");

    let mut sound = slipping(2.0);
    let (mut first, mut second) = (2.0, 2.0);
    for i in 1..150_u8 {
        let command = 2.0 + 0.1 * f32::from(i);
        first += (command - first) / 12.0;
        second += (first - second) / 6.0;
        assert_eq!(step(&mut sound, Some(second), command), second, "{i}");
    }
}

/// A drive with dead time and lag (ms).
struct Truth {
    line: VecDeque<f32>,
    lag_ms: f32,
    force_n: f32,
}

impl Truth {
    fn new(dead_ms: usize, lag_ms: f32, force_n: f32) -> Self {
        Self { line: core::iter::repeat_n(force_n, dead_ms).collect(), lag_ms, force_n }
    }

    /// The force (N) a millisecond later.
    fn step(&mut self, command_n: f32) -> f32 {
        self.line.push_back(command_n);
        self.force_n += (self.line.pop_front().unwrap() - self.force_n) / (1.0 + self.lag_ms);
        self.force_n
    }
}

/// Closes on an object as the controller does, with 5 mN of noise.
fn closed(truth: &mut Truth, mut random: u32) -> Drive {
    let mut drive = Drive::default();
    drive.close(0.2);
    let (mut command_n, mut applied_n) = (0.2_f32, 0.2);
    let mut settles = 0;
    while settles < 50 {
        settles += i32::from(command_n >= 1.2 && applied_n >= 0.96);
        command_n = (command_n + 0.02).min(1.2);
        if command_n >= 1.2 {
            drive.risen(Some(applied_n), DT_S);
        }
        drive.follow(command_n, DT_S);
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise_n = 0.017 * (random as f32 / u32::MAX as f32 - 0.5);
        applied_n = truth.step(command_n) + noise_n;
    }
    drive.settled(Some(applied_n), 0.0, 20.0);
    drive
}

#[test]
fn closing_shows_dead_time_and_lag() {
    for (dead_ms, lag_ms) in
        [(0, 5.0), (0, 20.0), (20, 1.0), (10, 10.0), (5, 15.0), (30, 5.0), (10, 0.0)]
    {
        for random in 0..20 {
            let drive = closed(&mut Truth::new(dead_ms, lag_ms, 0.2), random);
            // The ramp ends, and the force is taken for settled, before a long lag is over.
            let most_ms = 1.0 + 0.2 * lag_ms;
            let delay_ms = 1e3 * drive.delay_s() - dead_ms as f32 - lag_ms;
            let dead_ms = 1e3 * drive.dead_s() - dead_ms as f32;
            assert!(
                delay_ms.abs() < most_ms && dead_ms.abs() < 6.0,
                "{lag_ms} {delay_ms} {dead_ms}"
            );
        }
    }
}

/// From 1 N to 6 N by [`Drive::command_n`] or by the target as command: until 5.4 N (ms), and the greatest force (N).
fn led(dead_ms: usize, lag_ms: f32, by_drive: bool) -> (u32, f32) {
    let mut truth = Truth::new(dead_ms, lag_ms, 1.0);
    let mut drive = slips(1e-3 * (dead_ms as f32 + lag_ms), 1.0);
    drive.dead_s = Some(1e-3 * dead_ms as f32);
    let (mut most_n, mut reached_ms) = (0.0_f32, 0);
    for ms in 0..400 {
        let command_n = if by_drive { drive.command_n(6.0, 20.0, 0.0, DT_S) } else { 6.0 };
        drive.follow(command_n, DT_S);
        most_n = truth.step(command_n).max(most_n);
        reached_ms = if most_n < 5.4 { ms } else { reached_ms };
        let model_n = drive.modelled_n();
        assert!(lag_ms < 2.0 || (model_n - truth.force_n).abs() < 0.3, "{ms} ms");
    }
    assert!((truth.force_n - 6.0).abs() < 0.01, "{}", truth.force_n);
    (reached_ms, most_n)
}

#[test]
fn what_is_on_its_way_is_not_asked_for_again() {
    for (dead_ms, lag_ms) in [(0, 5.0), (0, 15.0), (0, 40.0), (10, 30.0), (5, 20.0)] {
        let (plain, by_drive) = (led(dead_ms, lag_ms, false), led(dead_ms, lag_ms, true));
        let dead = u32::try_from(dead_ms).unwrap();
        let lags = (plain.0 - dead, by_drive.0 - dead);
        assert!(3 * lags.1 <= 2 * lags.0, "{dead_ms} + {lag_ms} ms: {plain:?} {by_drive:?}");
        assert!(by_drive.1 <= 6.3, "{dead_ms} + {lag_ms} ms: {by_drive:?}");
    }
    // The model has no shorter lag than 2 ms: a drive without one goes beyond the target.
    for (lag_ms, most_n) in [(2.0, 6.3), (1.0, 6.6)] {
        for dead_ms in [10, 30, 40, 60] {
            let (_, force_n) = led(dead_ms, lag_ms, true);
            assert!(force_n <= most_n, "{dead_ms} + {lag_ms} ms: {force_n}");
        }
    }
    let unknown = slips(0.04, 1.0);
    assert_eq!(unknown.command_n(6.0, 20.0, 0.0, DT_S), 6.0, "what may be dead time is not led");
    assert_eq!(unknown.command_n(6.0, 5.0, 0.0, DT_S), 5.0);
}

/// Hard fingers on a heavy drive; what is not seen yet may be another force than was predicted.
#[test]
fn a_drive_that_answers_late_is_led_by_less() {
    let led_n = |dead_s: f32, lag_s: f32, late_s: f32| {
        let mut drive = slips(dead_s + lag_s, 8.0);
        drive.dead_s = Some(dead_s);
        drive.command_n(10.0, 60.0, late_s, DT_S) - 10.0
    };
    let (prompt, slow) = (led_n(0.0, 5e-3, 0.0), led_n(0.0, 20e-3, 0.0));
    assert!((prompt - 4.0).abs() < 1e-3, "twice what is missing: {prompt}");
    assert!(slow > prompt + 2.0 && slow <= 10.0, "a lag is led by more: {slow}");
    let line = led_n(0.0, 5e-3, 3e-3 + super::JITTER_S);
    for late in [led_n(6e-3, 5e-3, 0.0), led_n(20e-3, 5e-3, 0.0), line] {
        assert!((late - 1.2).abs() < 1e-3, "{late}");
    }
}

/// What has been commanded within the dead time before a slip arrives in it.
#[test]
fn a_slip_begins_with_what_is_on_its_way() {
    let mut drive = late_by(0.03);
    drive.dead_s = Some(0.02);
    drive.hold_on(2.0);
    let mut truth = Truth::new(20, 10.0, 2.0);
    for _ in 0..10 {
        drive.follow(4.0, DT_S);
        truth.step(4.0);
    }
    drive.begin(4.0, Some(truth.force_n), 0.0);
    assert!((drive.predicted_n() - 3.2).abs() < 0.1, "{}", drive.predicted_n());
    for _ in 0..60 {
        drive.follow(4.0, DT_S);
        let force_n = truth.step(4.0);
        assert_eq!(drive.measure(Some(force_n), DT_S, 0.0, false), force_n);
        assert!((drive.modelled_n() - force_n).abs() < 0.05);
    }
}

#[test]
fn the_state_of_the_sensor_is_told() {
    let state = |reading_n: fn(i32) -> Option<f32>| {
        let mut drive = slipping(2.0);
        for i in 1..100 {
            step(&mut drive, reading_n(i), 2.0 + 0.1 * i as f32);
        }
        (drive.sensor(), drive.force_n() / driven(100))
    };
    assert_eq!(state(|i| Some(driven(i))).0, ForceSensor::InTime);
    assert_eq!(state(|i| Some(driven(i - 40))).0, ForceSensor::Late);
    assert_eq!(state(|i| Some(1.5 * driven(i) + 2.0)).0, ForceSensor::Scaled);
    assert_eq!(state(|i| Some(driven(i.min(90)))).0, ForceSensor::InTime, "not for long yet");
    for reading_n in [|_| None, |i| Some(driven(i - 40)), |i| Some(1.5 * driven(i) + 2.0)] {
        let (sensor, ratio) = state(reading_n);
        assert!((ratio - 1.0).abs() < 0.03, "{sensor:?}: {ratio}");
    }
    let mut drive = slipping(2.0);
    let mut last_n = 0.0;
    for _ in 0..60 {
        last_n = step(&mut drive, Some(2.0), 2.45);
    }
    assert!(drive.sensor() == ForceSensor::Frozen && last_n == drive.force_n());
    step(&mut drive, None, 2.45);
    assert_eq!(drive.sensor(), ForceSensor::Absent);
}
