//! What is known of the slip in, the commanded force out, by the force of the fingers and the time that the host allows.

use super::{Pipeline, detect::Rest};
use crate::{
    alarm::Method,
    estimate::FrictionMeter,
    grip::{GripEvent, GripInput, GripState, SlipNow},
    health::SensorHealth,
    sample::{Arrival, Sample},
    units::{Hertz, Micros, Newtons},
};

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// The command after this sample; `None` in a pipeline that only observes.
    #[inline]
    pub(super) fn control(
        &mut self,
        sample: &Sample,
        dt: Micros,
    ) -> (Option<Newtons>, Option<GripEvent>) {
        let Some(grip) = self.grip.as_mut() else { return (None, None) };
        let stylus = self.fusion.uses(Method::Stylus);
        if !(stylus && self.detector.is_learning()) {
            grip.grasp(sample.normal_force_n);
        }
        let travel = self.fusion.believed_travel(sample.travel_m);
        let felt = stylus && self.health.feels() && !self.whiteness.is_noisy();
        // Before an object is held the other sensors are not looked at.
        let healthy = felt || if self.decides { self.fusion.is_usable(sample.t) } else { !stylus };
        let loaded_n = if healthy { None } else { loaded_n(&mut self.friction, sample) };
        let complete = felt && self.health.health() == SensorHealth::Good;
        let impaired = stylus && !complete || !self.fusion.healthy();
        #[expect(clippy::cast_possible_truncation, reason = "the controller limits both")]
        let (dt_s, late_s) = (
            dt.as_seconds() as f32,
            sample.arrival.map_or(0.0, |arrival| arrival.age.as_seconds() as f32),
        );
        let mut input = GripInput {
            dt_s,
            rise_s: self.host_time.rise_s(sample.t, dt),
            stale: self.host_time.is_stale(),
            late_s,
            travel: travel.is_some(),
            applied_n: sample.normal_force_n,
            touching: self.contact.is_touching(),
            touch_n: self.contact.touch_n(),
            healthy,
            loaded_n,
            impaired,
            slip: SlipNow::No,
            moved_m: None,
            forecast: None,
            predicted_n: 0.0,
            dead_s: 0.0,
            lag_s: 0.0,
        };
        if self.slip.is_some() || grip.state() == GripState::Slipping {
            self.add_slip(sample, &mut input);
        }
        let Some(grip) = self.grip.as_mut() else { return (None, None) };
        (Some(Newtons(grip.step(&input))), grip.event())
    }

    /// What the controller has to know of the slip.
    fn add_slip(&self, sample: &Sample, input: &mut GripInput) {
        let forecast = *self.load.forecast();
        let evident = self.is_fresh(sample.t) || forecast.moves;
        input.slip = match self.slip {
            Some(_) if evident => SlipNow::Evident,
            Some(_) => SlipNow::Fading,
            None => SlipNow::No,
        };
        input.moved_m = self.observation.moved_m(sample);
        input.forecast = Some(forecast);
        let lag_s = self.grip.map_or(0.0, |grip| grip.lag_s());
        let command_n = self.grip.map_or(0.0, |grip| grip.command_n());
        input.lag_s = lag_s;
        input.predicted_n = sample.normal_force_n.unwrap_or(command_n);
    }

    /// Holds with at least `force_n` (N) from the next sample on; see [`GripController::at_least`](crate::grip::GripController::at_least).
    pub fn at_least(&mut self, force_n: f32) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.at_least(force_n);
        }
    }

    /// Expects an object that is known to be held with `force_n` (N); see
    /// [`GripController::expect`](crate::grip::GripController::expect).
    pub fn expect(&mut self, force_n: f32) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.expect(force_n);
        }
    }

    /// Lets go of the object, until [`Pipeline::close_again`].
    pub fn release(&mut self) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.release();
        }
    }

    /// Ends a release: the fingers close to the trial force.
    pub fn close_again(&mut self) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.close_again();
        }
    }
}

/// The force (N) that the load needs by the tangential force, where that is all there is.
fn loaded_n(friction: &mut FrictionMeter, sample: &Sample) -> Option<f32> {
    friction.watch(sample.normal_force_n?, sample.tangential_n?);
    friction.loaded_n()
}

// Measured force and command in; the force of the fingers during a slip, also where the sensor has failed, out.

/// The same reading for this long (s) ...
const FROZEN_S: f32 = 0.015;
/// ... and this many delays of the gripper, since a force that has not arrived yet stands on a coarse sensor, ...
const FROZEN_LAGS: f32 = 2.0;
/// ... while the command moves the fingers by more than this share of it, and this much (N), is none.
const FROZEN_SHARE: f32 = 0.2;
const FROZEN_N: f32 = 0.3;
/// Time constant of the mean difference between reading and command while an object is held (s), and how long it has to be held for it.
const HELD_S: f32 = 0.02;
const HELD_FOR_S: f32 = 0.05;
/// A ratio within this of 1 is the deviation of a sound sensor.
const SOUND: f32 = 0.1;
/// Readings outside of these bounds, and by this (N), ...
const LOW: f32 = 0.8;
const HIGH: f32 = 1.25;
const LEAST_N: f32 = 0.2;
/// ... for this long (s), and as many times, contradict the command.
const CONTRADICTED_S: f32 = 0.005;
const CONTRADICTIONS: f32 = 5.0;
/// The latest drive that is believed, a lag of second order: each of the two lags of it over the known delay, and more (s).
const LATER: f32 = 1.5;
const LATER_S: f32 = 0.005;
/// A force that was commanded this many delays ago has arrived; a delay is at least so long (s).
const ARRIVES_AFTER: f32 = 3.0;
const LEAST_LAG_S: f32 = 0.01;

/// The force of one finger during a slip.
///
/// The force that counts is the one that the *command* stands for, since it is the command that has to hold the object. While an object is held the
/// sensor is compared with the command; where it shows more than a tenth more or less, its readings are divided by that ratio in the slip.
///
/// Where no reading comes, or the same one for [`FROZEN_S`] and [`FROZEN_LAGS`] delays although the command moved on, the force is that of the command through a first-order
/// lag, `F' = (C - F) / T` with the delay T that the gripper showed when it closed. It takes over from the last good reading. The same holds for
/// the rest of the object's time where the readings contradict the command for [`CONTRADICTED_S`]: below [`LOW`] of what even a drive two and a half
/// times as late would show by now, or above [`HIGH`] of the highest command of the slip. Such a sensor is late or wrong. So is one that shows less
/// than the known drive has made of the command while the object gets faster all the same for longer than a command takes to arrive. What a line
/// holds back counts as delay.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GripForce {
    period_s: f32,
    held_share: f32,
    /// Mean of reading less command (N) while the object is held, and since when that was (s).
    excess_n: f32,
    held_s: f32,
    /// Reading over command in this slip.
    ratio: f32,
    /// By the command (N), since the reading last changed.
    modelled_n: f32,
    reading_n: Option<f32>,
    same_s: f32,
    frozen: bool,
    /// By the command (N) alone: as expected, of the latest drive that is believed, and at most.
    commanded_n: f32,
    late_n: [f32; 2],
    most_n: f32,
    contradicted_s: f32,
    /// For how long the object has become faster while less was read than the command has made (s).
    missing_s: f32,
    doubted: bool,
    /// Whether it shows no touch although there was some.
    numb: bool,
}

impl GripForce {
    /// Nothing is known of a sensor that is read `rate_hz` times a second.
    pub(super) fn new(rate_hz: f32) -> Self {
        let period_s = 1.0 / rate_hz;
        Self { period_s, held_share: period_s / (HELD_S + period_s), ..Self::default() }
    }

    /// Another object: the sensor is believed again.
    pub(super) fn prime(&mut self) {
        let Self { period_s, held_share, .. } = *self;
        *self = Self { period_s, held_share, ..Self::default() };
    }

    /// The reading as far as it shows touch. One that contradicts the command and shows no touch while the object `slides` is none, until it shows
    /// some again.
    #[inline]
    pub(super) fn touch(
        &mut self,
        reading_n: Option<f32>,
        touches: bool,
        slides: bool,
    ) -> Option<f32> {
        self.numb = !touches && (self.numb || (slides && self.doubted));
        reading_n.filter(|_| !self.numb)
    }

    /// Whether the reading shows no touch although there was some; the next one that does ends that.
    #[inline]
    pub(super) fn is_numb(&self) -> bool {
        self.numb
    }

    /// By the command alone (N), in a slip, as the sensor would show it.
    #[inline]
    pub(super) fn commanded_n(&self) -> f32 {
        self.as_read(self.commanded_n)
    }

    /// A force (N) in a slip as the sensor would show it.
    #[inline]
    pub(super) fn as_read(&self, force_n: f32) -> f32 {
        self.ratio * force_n
    }

    /// An object is held, and does not slip.
    #[inline]
    pub(super) fn hold(&mut self, reading_n: Option<f32>, command_n: f32) {
        let Some(reading_n) = reading_n else { return };
        self.excess_n += self.held_share * (reading_n - command_n - self.excess_n);
        self.held_s += self.period_s;
    }

    /// A slip begins under this command (N).
    pub(super) fn begin(&mut self, command_n: f32, reading_n: Option<f32>) {
        let held = self.held_s >= HELD_FOR_S;
        let ratio = 1.0 + self.excess_n / command_n.max(1e-3);
        let ratio = match self.ratio {
            _ if held && (ratio - 1.0).abs() > SOUND => ratio.clamp(0.5, 2.0),
            known if !held && known > 0.0 => known,
            _ => 1.0,
        };
        let arrived_n = reading_n.filter(|_| !held && !self.doubted);
        let arrived_n = arrived_n.map_or(command_n, |force_n| force_n / ratio);
        *self = Self {
            ratio,
            modelled_n: command_n,
            commanded_n: arrived_n,
            late_n: [arrived_n.min(command_n); 2],
            most_n: command_n.max(arrived_n),
            doubted: self.doubted,
            numb: self.numb,
            period_s: self.period_s,
            held_share: self.held_share,
            ..Self::default()
        };
    }

    /// Takes the next reading (N), the command of the sample before it (N), the delay of the gripper with its line (s), and whether the object gets faster; gives
    /// the force (N).
    pub(super) fn step(
        &mut self,
        reading_n: Option<f32>,
        command_n: f32,
        dt_s: f32,
        lag_s: f32,
        speeds_up: bool,
    ) -> f32 {
        let follow = |n: &mut f32, to_n: f32, lag_s: f32| {
            let share = if lag_s > dt_s { dt_s / lag_s } else { 1.0 };
            *n += share * (to_n - *n);
        };
        follow(&mut self.commanded_n, command_n, lag_s);
        let later_s = LATER * lag_s + LATER_S;
        let [first_n, late_n] = &mut self.late_n;
        follow(first_n, command_n, later_s);
        follow(late_n, *first_n, later_s);
        self.most_n = self.most_n.max(command_n);
        follow(&mut self.modelled_n, command_n, lag_s);
        let reading_n = reading_n.map(|force_n| force_n / self.ratio);
        if let Some(force_n) = reading_n {
            self.judge(force_n, dt_s);
            let missing = speeds_up && force_n < (1.0 - SOUND) * self.commanded_n;
            self.missing_s = if missing { self.missing_s + dt_s } else { 0.0 };
            self.doubted |= self.missing_s >= ARRIVES_AFTER * lag_s.max(LEAST_LAG_S);
        }
        if self.doubted {
            return self.commanded_n;
        }
        self.believed(reading_n, dt_s, FROZEN_S.max(FROZEN_LAGS * lag_s))
    }

    fn judge(&mut self, force_n: f32, dt_s: f32) {
        let low = force_n < LOW * self.late_n[1] - LEAST_N;
        let high = force_n > HIGH * self.most_n + LEAST_N;
        let counted_s = dt_s.min(CONTRADICTED_S / CONTRADICTIONS);
        self.contradicted_s = if low || high { self.contradicted_s + counted_s } else { 0.0 };
        self.doubted |= self.contradicted_s >= CONTRADICTED_S;
    }

    /// The reading, or where it stands or is missing what the command has made of the last one.
    fn believed(&mut self, reading_n: Option<f32>, dt_s: f32, frozen_s: f32) -> f32 {
        match reading_n {
            Some(force_n) if self.reading_n != Some(force_n) => {
                self.reading_n = reading_n;
                (self.modelled_n, self.same_s, self.frozen) = (force_n, 0.0, false);
                return force_n;
            }
            Some(force_n) => {
                self.same_s += dt_s;
                let moved_n = (self.modelled_n - force_n).abs();
                self.frozen |=
                    self.same_s >= frozen_s && moved_n > (FROZEN_SHARE * force_n).max(FROZEN_N);
                if !self.frozen {
                    return force_n;
                }
            }
            None => self.reading_n = None,
        }
        self.modelled_n
    }
}

// Arrival times in; for how long the force may rise on a sample, and whether the sample is too old for that, out.

/// Longest time between two arrivals that counts.
const MOST: Micros = Micros(10_000);
/// What may be left over from one arrival to the next: frames come early and late.
const SLACK: Micros = Micros(2000);
/// Age of evidence that still raises the force, on top of the usual delay and one period ...
const FRESH: Micros = Micros(20_000);
/// ... which count this much at most.
const USUAL: Micros = Micros(40_000);
/// The usual age follows a longer one by this share of the time.
const FOLLOWS: u64 = 1000;
/// The largest age is forgotten by this share of the time.
const FORGETS: u64 = 10;

/// Samples that arrive together, and those before them.
///
/// The controller counts device time. After a stall of the line or of the computer many samples come at once, and what they ask for in
/// sequence would be commanded in one moment. So a rise counts host time: the samples that arrive together share the time since the arrival
/// before them, at most [`MOST`], plus what of it was left over, at most [`SLACK`]. And a sample whose age exceeds [`FRESH`] plus what the
/// line usually takes, plus its own period, raises nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct HostTime {
    period: Micros,
    /// Host time of the latest arrival; `None` before the first and where arrivals are not known.
    at: Option<Micros>,
    /// Device time of the sample before it, and for how much device time from there on the force may rise.
    from: Micros,
    allowed: Micros,
    /// The smallest age of late, and the largest.
    usual: Micros,
    longest: Micros,
    stale: bool,
}

impl HostTime {
    pub(super) fn new(rate: Hertz) -> Self {
        Self {
            period: Micros::from_ms(1e3 / rate.0),
            at: None,
            from: Micros(0),
            allowed: MOST,
            usual: USUAL,
            longest: Micros(0),
            stale: false,
        }
    }

    /// The next sample arrived so; `last` is the device time of the one before.
    #[inline]
    pub(super) fn arrive(&mut self, arrival: Option<Arrival>, last: Option<Micros>) {
        let Some(Arrival { at, age }) = arrival else {
            self.at = None;
            return;
        };
        if self.at != Some(at) {
            self.begin(at, last.unwrap_or_default());
            self.usual = self.usual.min(age);
            self.longest = self.longest.max(age.min(USUAL));
        }
        self.stale = age > FRESH.plus(self.usual.plus(self.period).min(USUAL));
    }

    fn begin(&mut self, at: Micros, last: Micros) {
        let waited = self.at.map_or(MOST, |before| at.since(before));
        let left = self.allowed.since(last.since(self.from)).min(SLACK);
        self.allowed = waited.min(MOST).plus(left);
        self.usual = self.usual.plus(Micros(waited.0 / FOLLOWS));
        self.longest = self.longest.since(Micros(waited.0 / FORGETS));
        (self.at, self.from) = (Some(at), last);
    }

    /// The largest age of late (s), 40 ms at most. So much later than the drive makes it a command shows in the samples: what a batch asks for
    /// leaves at its end.
    #[inline]
    pub(super) fn late_s(&self) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "at most 40 ms")]
        let late_s = self.longest.as_seconds() as f32;
        late_s
    }

    /// Whether the latest sample is too old to raise the force on it.
    #[inline]
    pub(super) fn is_stale(&self) -> bool {
        self.at.is_some() && self.stale
    }

    /// For how long (s) the force may rise on a sample at device time `t` that follows one `dt` before; `None` where arrivals are not known.
    #[inline]
    pub(super) fn rise_s(&self, t: Micros, dt: Micros) -> Option<f32> {
        self.at?;
        let used = Micros(t.0.saturating_sub(dt.0)).since(self.from);
        #[expect(clippy::cast_possible_truncation, reason = "at most 12 ms")]
        let rise_s = self.allowed.since(used).min(dt).as_seconds() as f32;
        Some(rise_s)
    }
}

#[cfg(test)]
mod grip_force_tests {
    extern crate std;
    use super::GripForce;
    use std::vec::Vec;

    const DT_S: f32 = 1e-3;
    const LAG_S: f32 = 5e-3;

    #[test]
    fn a_good_reading_is_the_force_and_a_missing_one_goes_on_from_it() {
        let mut force = GripForce::new(1000.0);
        force.begin(2.0, Some(2.0));
        for i in 0..50_u8 {
            let reading = 2.0 + 0.1 * f32::from(i);
            assert_eq!(force.step(Some(reading), 8.0, DT_S, LAG_S, false), reading);
        }
        let first = force.step(None, 8.0, DT_S, LAG_S, false);
        assert!((first - 6.9).abs() < 0.4, "{first}");
        let last = (0..50).map(|_| force.step(None, 8.0, DT_S, LAG_S, false)).last().unwrap();
        assert!((last - 8.0).abs() < 1e-3, "{last}");
    }

    #[test]
    fn a_reading_that_stands_while_the_command_rises_is_none_and_one_that_may_stand_is_the_force() {
        let mut force = GripForce::new(1000.0);
        force.begin(2.0, Some(2.0));
        let stuck: Vec<f32> =
            (0..60).map(|_| force.step(Some(2.0), 2.45, DT_S, LAG_S, false)).collect();
        assert!(stuck[..15].iter().all(|f| *f == 2.0) && stuck[59] > 2.44, "{stuck:?}");
        assert_eq!(force.step(Some(2.4), 2.45, DT_S, LAG_S, false), 2.4, "it is back");
        let mut calm = GripForce::new(1000.0);
        calm.begin(2.0, Some(2.0));
        assert!((0..500).all(|_| calm.step(Some(2.0), 2.1, DT_S, LAG_S, false) == 2.0));
    }

    /// A converter of 12 bits shows the same value until the force of a late drive comes.
    #[test]
    fn a_coarse_reading_stands_for_as_long_as_the_gripper_is_late() {
        const LATE_S: f32 = 0.035;
        let mut force = GripForce::new(1000.0);
        force.begin(2.0, Some(2.0));
        assert!((0..45).all(|_| force.step(Some(2.0), 5.0, DT_S, LATE_S, true) == 2.0));
        assert_eq!(force.step(Some(2.3), 5.0, DT_S, LATE_S, true), 2.3);
        let mut stuck = GripForce::new(1000.0);
        stuck.begin(2.0, Some(2.0));
        let last_n =
            (0..200).map(|_| stuck.step(Some(2.0), 5.0, DT_S, LATE_S, false)).last().unwrap();
        assert!(last_n > 4.9, "{last_n}");
    }

    /// The force of the fingers (N) `i` ms after the command rose from 2 N by 0.1 N a millisecond, behind a lag of 6 ms.
    fn driven(i: i32) -> f32 {
        (0..i).fold(2.0, |force_n: f32, j| force_n + (2.0 + 0.1 * j as f32 - force_n) / 6.0)
    }

    #[test]
    fn a_sensor_with_another_gain_gives_the_force_that_was_commanded() {
        for gain in [0.7_f32, 1.3] {
            let mut force = GripForce::new(1000.0);
            for _ in 0..100 {
                force.hold(Some(2.0 * gain), 2.0);
            }
            force.begin(2.0, Some(2.0 * gain));
            for i in 1..60 {
                let reported =
                    force.step(Some(gain * driven(i)), 2.0 + 0.1 * i as f32, DT_S, LAG_S, false);
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
            let (mut force, mut applied) = (GripForce::new(1000.0), Vec::new());
            force.begin(2.0, Some(2.0));
            let mut applied_n = 2.0;
            (0..120)
                .map(|i| {
                    applied_n += (command_n(i) - applied_n) / 20.0;
                    applied.push(applied_n);
                    let read_n = applied[usize::try_from(i - delay_ms).unwrap_or(0)];
                    force.step(Some(read_n), command_n(i), DT_S, 20e-3, speeds_up) / applied_n
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
        let mut late = GripForce::new(1000.0);
        late.begin(2.0, Some(2.0));
        let reported: Vec<f32> = (1..150)
            .map(|i| late.step(Some(driven(i - 50)), 2.0 + 0.1 * i as f32, DT_S, LAG_S, false))
            .collect();
        assert!(
            reported[40] > 0.85 * driven(41) && reported[140] > 0.95 * driven(141),
            "{reported:?}"
        );
        late.begin(8.0, Some(2.0));
        assert_eq!(late.step(Some(2.0), 8.0, DT_S, LAG_S, false), 8.0, "the same object");
        late.prime();
        late.begin(8.0, Some(8.0));
        assert_eq!(late.step(Some(8.1), 8.0, DT_S, LAG_S, false), 8.1, "another one");

        let mut sound = GripForce::new(1000.0);
        sound.begin(2.0, Some(2.0));
        let (mut first, mut second) = (2.0, 2.0);
        for i in 1..150_u8 {
            let command = 2.0 + 0.1 * f32::from(i);
            first += (command - first) / 12.0;
            second += (first - second) / 6.0;
            assert_eq!(sound.step(Some(second), command, DT_S, LAG_S, false), second, "{i}");
        }
    }
}

#[cfg(test)]
mod host_time_tests {
    extern crate std;
    use super::HostTime;
    use crate::{
        sample::Arrival,
        units::{Hertz, Micros},
    };
    use std::vec::Vec;

    /// Samples at 1 kHz that arrive at these host times (ms) with these ages (ms): rise (ms) and staleness of each.
    fn rises(arrivals: &[(u64, u64)]) -> Vec<(f32, bool)> {
        let mut host = HostTime::new(Hertz(1000.0));
        let mut last = None;
        let mut out = Vec::new();
        for (i, (at, age)) in arrivals.iter().enumerate() {
            let t = Micros(1000 * (i as u64 + 1));
            host.arrive(Some(Arrival { at: Micros(1000 * at), age: Micros(1000 * age) }), last);
            let dt = last.map_or(Micros(0), |last| t.since(last));
            out.push((1e3 * host.rise_s(t, dt).unwrap(), host.is_stale()));
            last = Some(t);
        }
        out
    }

    #[test]
    fn samples_in_time_count_whole_and_a_burst_counts_ten_milliseconds() {
        let mut arrivals: Vec<(u64, u64)> = (1..100).map(|ms| (ms, 1)).collect();
        arrivals.extend((100..400).map(|ms| (400, 401 - ms)));
        let out = rises(&arrivals);
        assert!(out[1..99].iter().all(|&(rise, stale)| (rise - 1.0).abs() < 1e-3 && !stale));
        let burst: f32 = out[99..].iter().map(|(rise, _)| rise).sum();
        assert!((9.9..=12.1).contains(&burst), "{burst}");
        let fresh = out[99..].iter().filter(|(_, stale)| !stale).count();
        assert!(
            (20..=23).contains(&fresh),
            "{fresh}: 20 ms, a period and what the line usually takes"
        );
    }

    #[test]
    fn a_line_that_is_always_late_is_used_up_to_sixty_milliseconds() {
        let late = |age| rises(&(1..2000).map(|ms| (ms, age)).collect::<Vec<_>>()).pop().unwrap().1;
        assert!(!late(30) && !late(55) && late(61));
    }

    #[test]
    fn a_line_in_batches_is_as_late_as_their_first_samples_and_a_stall_is_forgotten() {
        let mut host = HostTime::new(Hertz(1000.0));
        let mut give = |t: u64, at: u64| {
            let (t, at) = (Micros(1000 * t), Micros(1000 * at));
            host.arrive(Some(Arrival { at, age: at.since(t) }), Some(t));
            host.late_s()
        };
        let batches: Vec<f32> = (1..=160).map(|t: u64| give(t, t.next_multiple_of(16))).collect();
        assert!(batches.iter().all(|late_s| (0.013..=0.016).contains(late_s)), "{batches:?}");
        assert!((161..460).all(|t| give(t, 460) <= 0.04), "a stall");
        let after: Vec<f32> = (460..900).map(|t| give(t, t)).collect();
        assert!(after[100] > 0.02 && after[439] < 1e-6, "{after:?}");
    }

    #[test]
    fn without_arrivals_nothing_is_bounded() {
        let mut host = HostTime::new(Hertz(1000.0));
        host.arrive(None, None);
        assert_eq!((host.rise_s(Micros(5), Micros(1)), host.is_stale()), (None, false));
    }
}
