//! Model of the drive of the fingers: dead time, first-order lag and gain.
//!
//! ```text
//! lag P' = C - P                        C: command, P: predicted force
//! F(t)   = P(t - dead)                  F: force of the fingers
//! delay  = dead + lag
//! ```
//!
//! The delay is learned while the fingers close. At the end of a ramp of r N/s the force lacks r delay, and what it lacks from there on has the area
//! A = r (delay^2 + lag^2) / 2: less of the delay is lag where the force settles sooner. Where the area does not show it, the begin of the answer to
//! the first slip does. What is learned goes through the line, which is a dead time of its own.
//!
//! P is one prediction for two things. The command that brings the force to a target soonest is that of a Smith predictor: what is on its way is not
//! asked for again. And the force sensor is judged by its innovation, the reading less F ([`ForceSensor`]).

/// A drive that has not been seen to follow is taken for one that needs this long (s).
const UNKNOWN_S: f32 = 0.02;
/// A gripper that presses with the trial force from touch on, since it cannot do less, does not show it; such ones need about this long (s).
const UNSEEN_S: f32 = 0.035;
/// Time constant (s) of the mean that the force has settled to.
const SETTLED_S: f32 = 0.005;
/// The prediction is kept at this interval (s), so many times: the longest dead time.
const SLOT_S: f32 = 1e-3;
const SLOTS: usize = 64;

/// The command leads the target by this multiple of what is missing, or by the lag over this time (s) where that is more ...
const LEAD: f32 = 2.0;
const LEADS_IN_S: f32 = 0.0025;
/// ... less by up to this share for a dead time of this (s): what is not seen yet may be another force than was predicted.
const SHY: f32 = 0.7;
const SHY_S: f32 = 0.006;
/// It leads by up to half of the target, or by all of it where the lag is longer than this (s).
const PROMPT_S: f32 = 0.008;

/// The force of the fingers, by sensor and command.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drive {
    /// From a command to its force, as it was measured (s), the part of it that is dead time, and how late samples arrived then.
    delay_s: Option<f32>,
    dead_s: Option<f32>,
    late_s: f32,
    /// Whether the fingers had the trial force as command before they touched: their delay does not show.
    unseen: bool,
    closing: Option<Closing>,
    /// The last command (N), the prediction (N), and what it was before, the newest at `place`.
    command_n: f32,
    predicted_n: f32,
    past: Past,
    place: usize,
    slot_s: f32,
    answer: Answer,
    reading: Reading,
    /// Dead time of the line when the slip began (s).
    line_s: f32,
}

/// Fingers that have closed: their force since the command reached the trial force.
#[derive(Clone, Copy, Debug, Default)]
struct Closing {
    /// Then (N), and about now.
    risen_n: f32,
    end_n: f32,
    /// Since then (s), and the integral of the force (N s).
    since_s: f32,
    integral_n_s: f32,
}

/// What was predicted (N).
#[derive(Clone, Copy, Debug)]
struct Past([f32; SLOTS]);

impl Default for Past {
    fn default() -> Self {
        Self([0.0; SLOTS])
    }
}

impl Drive {
    /// Dead time (s), as far as it is known.
    #[must_use]
    pub fn dead_s(&self) -> f32 {
        self.dead_s.unwrap_or(0.0)
    }

    /// Lag (s): what of the delay is not known to be dead time.
    #[must_use]
    pub fn lag_s(&self) -> f32 {
        self.delay_s() - self.dead_s()
    }

    /// How late the measured force follows the command (s), as far as that is known.
    #[must_use]
    pub fn delay_s(&self) -> f32 {
        self.delay_s.unwrap_or(if self.unseen { UNSEEN_S } else { UNKNOWN_S })
    }

    /// Force of the fingers (N) when everything commanded so far has come through the dead time.
    #[must_use]
    pub fn predicted_n(&self) -> f32 {
        self.predicted_n
    }

    /// Force of the fingers now (N): the reading as far as it is believed, else the model.
    #[must_use]
    pub fn force_n(&self) -> f32 {
        self.reading.force_n.unwrap_or_else(|| self.modelled_n())
    }

    /// What the sensor is worth.
    #[must_use]
    pub fn sensor(&self) -> ForceSensor {
        self.reading.sensor
    }

    /// The command (N), `most_n` at most, that brings the force to `target_n` (N) soonest. A drive whose dead time is not known is not led.
    #[must_use]
    pub fn command_n(&self, target_n: f32, most_n: f32) -> f32 {
        let Some(dead_s) = self.dead_s else { return target_n.min(most_n) };
        let lag_s = self.lag_s();
        let lead = LEAD.max(lag_s / LEADS_IN_S) * (1.0 - SHY * (dead_s / SHY_S).min(1.0));
        let up = if lag_s > PROMPT_S { 1.0 } else { 0.5 };
        let lead_n = lead * (target_n - self.predicted_n);
        (target_n + lead_n.min(up * target_n).max(-0.5 * target_n)).min(most_n)
    }

    /// The last command (N).
    pub(crate) fn commanded_n(&self) -> f32 {
        self.command_n
    }

    /// By the command alone (N): the prediction of a dead time ago, between two slots in proportion.
    fn modelled_n(&self) -> f32 {
        let slots = (self.dead_s() + self.line_s - self.slot_s) / SLOT_S;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the cast saturates"
        )]
        let whole = (slots.max(0.0) as usize).min(SLOTS - 2);
        let past_n = |slots: usize| {
            let place = (self.place + SLOTS - slots) % SLOTS;
            self.past.0.get(place).copied().unwrap_or(self.predicted_n)
        };
        if slots < 0.0 {
            let share = 1.0 + slots * SLOT_S / self.slot_s;
            return self.predicted_n + share * (past_n(0) - self.predicted_n);
        }
        let share = (slots - whole as f32).min(1.0);
        past_n(whole) + share * (past_n(whole + 1) - past_n(whole))
    }

    /// `command_n` (N) is in force for `dt_s` (s).
    #[inline]
    pub(crate) fn follow(&mut self, command_n: f32, dt_s: f32) {
        self.command_n = command_n;
        let lag_s = self.lag_s();
        approach(&mut self.predicted_n, command_n, dt_s, lag_s);
        self.slot_s += dt_s;
        while self.slot_s >= 0.999 * SLOT_S {
            self.slot_s = (self.slot_s - SLOT_S).max(0.0);
            self.place = (self.place + 1) % SLOTS;
            if let Some(past_n) = self.past.0.get_mut(self.place) {
                *past_n = self.predicted_n;
            }
        }
    }

    /// The fingers press with `force_n` (N) under `command_n` (N); what is on its way stays on its way.
    fn restart(&mut self, command_n: f32, force_n: f32) {
        self.command_n = command_n;
        let modelled_n = self.modelled_n();
        for past_n in self.past.0.iter_mut().chain([&mut self.predicted_n]) {
            *past_n = force_n + (*past_n - modelled_n);
        }
    }

    /// The fingers begin to close under `command_n` (N).
    pub(crate) fn close(&mut self, command_n: f32) {
        self.closing = None;
        self.hold_on(command_n);
    }

    /// The fingers have pressed with `command_n` (N) for long.
    pub(crate) fn hold_on(&mut self, command_n: f32) {
        (self.command_n, self.predicted_n) = (command_n, command_n);
        self.past = Past([command_n; SLOTS]);
    }

    /// The command had reached the trial force before the fingers touched.
    pub(crate) fn unseen(&mut self) {
        self.unseen = true;
    }

    /// The command has reached the trial force while `applied_n` (N) was measured.
    pub(crate) fn risen(&mut self, applied_n: Option<f32>) {
        let begin = |n| Closing { risen_n: n, end_n: n, ..Closing::default() };
        self.closing = self.closing.or(applied_n.map(begin));
    }

    /// What is measured from there on (N).
    pub(crate) fn settle(&mut self, applied_n: Option<f32>, dt_s: f32) {
        let Some((closing, applied_n)) = self.closing.as_mut().zip(applied_n) else { return };
        approach(&mut closing.end_n, applied_n, dt_s, SETTLED_S);
        closing.since_s += dt_s;
        closing.integral_n_s += applied_n * dt_s;
    }

    /// The force has settled after a rise by `rate_n_s` (N/s), while samples arrived `late_s` (s) late.
    pub(crate) fn settled(&mut self, applied_n: Option<f32>, late_s: f32, rate_n_s: f32) {
        let Some((closing, applied_n)) = self.closing.take().zip(applied_n) else { return };
        let delay_s = ((applied_n - closing.risen_n) / rate_n_s).max(0.0);
        let area_n_s = closing.end_n * closing.since_s - closing.integral_n_s;
        let lag_s = libm::sqrtf((2.0 * area_n_s / rate_n_s - delay_s * delay_s).max(0.0));
        (self.delay_s, self.late_s) = (Some(delay_s), late_s);
        self.dead_s = Some((delay_s - lag_s).max(0.0));
    }
}

/// A first-order lag.
#[inline]
fn approach(value: &mut f32, to: f32, dt_s: f32, lag_s: f32) {
    if dt_s > 0.0 {
        *value += dt_s / (lag_s + dt_s) * (to - *value);
    }
}

// How far the command may lead a drive, by its delay and by how its force begins to rise.

/// Beyond this delay (s), and the more up to twice of it, an object falls too far unless the command runs ahead all the same ...
const LATE_S: f32 = 0.02;
/// ... by up to this share of what is known.
const LATE_REACH: f32 = 0.3;
/// Nothing runs ahead further than by this share: fingers that lose the object measure no force.
const LARGEST: f32 = 0.5;
/// A force that was commanded this many delays ago has arrived, if it ever does ...
const ARRIVES_AFTER: f32 = 3.0;
/// ... within these bounds (s).
const ARRIVES_S: [f32; 2] = [0.01, 0.1];
/// A force that has risen by this share, and at least this much (N), answers the command.
const ANSWERS: f32 = 0.1;
const ANSWERS_N: f32 = 0.03;
/// A force that has not risen by this share for this long (s) does not follow any longer.
const RISES: f32 = 0.02;
const LEVEL_S: f32 = 0.01;
/// By this much (s) later the controller knows of a force.
const KNOWN_S: f32 = 0.003;
/// What is on its way when the target is measured may exceed it by this share.
const EXCESS: f32 = 0.05;
/// Drives that are later by this (s) than [`LATE_S`] are led in full; less late ones in proportion.
const SLOWER_S: f32 = 0.01;
/// Where the stylus alone shows what is needed, that is known only as the force rises: a drive that is later than this (s)
/// is led so that it rises as one of that lag does.
const ALONE_S: f32 = 0.005;

/// How the measured force answers in a slip.
#[derive(Clone, Copy, Debug, Default)]
struct Answer {
    /// Force of the model and measured force when the slip began (N).
    from_n: f32,
    start_n: Option<f32>,
    /// The greatest measured force (N), and since when it has not become greater (s).
    most_n: f32,
    level_s: f32,
    /// By how much it answers later than the model (s).
    later_s: f32,
    answered: bool,
}

impl Drive {
    /// A slip begins to be answered.
    pub(crate) fn begin_answer(&mut self) {
        self.answer = Answer { from_n: self.modelled_n(), ..Answer::default() };
    }

    /// The force measured in a slip (N). A drive moves from the first moment on, or after a dead time; both are equally late when the fingers close. What
    /// the force answers later by than a lag of the whole delay is dead time.
    pub(crate) fn answer(&mut self, applied_n: Option<f32>, dt_s: f32) {
        let Some(applied_n) = applied_n else { return };
        let model_n = self.modelled_n();
        let answer = &mut self.answer;
        let start_n = *answer.start_n.get_or_insert(applied_n);
        let rise_n = (ANSWERS * start_n).max(ANSWERS_N);
        if !answer.answered && model_n - answer.from_n >= rise_n {
            answer.answered = applied_n - start_n >= rise_n;
            answer.later_s += dt_s;
        }
        answer.level_s += dt_s;
        if applied_n >= answer.most_n * (1.0 + RISES) {
            (answer.most_n, answer.level_s) = (applied_n, 0.0);
        }
        if answer.answered && self.delay_s.is_some() {
            self.dead_s = self.dead_s.or(Some(answer.later_s.min(self.delay_s())));
        }
    }

    /// How far the command may lead the target while `applied_n` is measured (N), so that what is still on its way when the target is measured is
    /// little; `alone`: only the stylus gives the target.
    /// ```text
    /// command <= F + (target - F) lag / (dead + 3 ms)
    /// ```
    pub(crate) fn lead_n(&self, target_n: f32, applied_n: f32, alone: bool) -> f32 {
        let (late_s, known_s) = if alone { (ALONE_S, ALONE_S) } else { (LATE_S, KNOWN_S) };
        let slower = ((self.delay_s() - late_s) / SLOWER_S).clamp(0.0, 1.0);
        if !self.answer.answered || self.answer.level_s > LEVEL_S || slower <= 0.0 {
            return 0.0;
        }
        let dead_s = self.dead_s.unwrap_or(self.answer.later_s);
        let lag_s = (self.delay_s() - dead_s).max(0.0);
        let missing_n = (1.0 + EXCESS) * target_n - applied_n;
        let driven_n = applied_n + missing_n * lag_s / (dead_s + known_s);
        (driven_n - target_n).min(slower * target_n).max(0.0)
    }

    /// How much more than `known_n` (N) may be commanded where `wish_n` (N) more is wished for: all of it where the gripper answers at once; less, with
    /// the square of the delay, where it is later and would press too hard before that is seen; and where it is so late that objects fall meanwhile
    /// at least some.
    pub(crate) fn beyond(&self, known_n: f32, wish_n: f32) -> f32 {
        let delay_s = self.delay_s();
        let promptness = PROMPT_S / delay_s.max(PROMPT_S);
        let late = LATE_REACH * ((delay_s - LATE_S) / LATE_S).clamp(0.0, 1.0);
        let wish_n = wish_n.max(0.0);
        let late_n = wish_n.min(late * known_n);
        (promptness * promptness * wish_n).max(late_n).min(LARGEST * known_n.max(0.0))
    }

    /// After this long (s) a commanded force has arrived, measured or not, where samples arrive `late_s` (s) late: commands do too.
    pub(crate) fn wait_s(&self, late_s: f32) -> f32 {
        let [least_s, most_s] = ARRIVES_S;
        (ARRIVES_AFTER * self.delayed_s(late_s)).clamp(least_s, most_s)
    }

    /// How late the measured force follows where samples arrive `late_s` late (s).
    pub(crate) fn delayed_s(&self, late_s: f32) -> f32 {
        self.delay_s() + 2.0 * (late_s - self.late_s).max(0.0)
    }
}

// What the force sensor is worth, by its innovation.

/// The same reading for this long (s) ...
const FROZEN_S: f32 = 0.015;
/// ... and this many delays of the drive, since a force that has not arrived yet stands on a coarse sensor, ...
const FROZEN_DELAYS: f32 = 2.0;
/// ... while the model has moved by more than this share of it, and this much (N), is none.
const FROZEN_SHARE: f32 = 0.2;
const FROZEN_N: f32 = 0.3;
/// Time constant of the mean difference between reading and command while an object is held (s), and the share of it that has to be there.
const HELD_S: f32 = 0.02;
const HELD: f32 = 0.918;
/// A gain within this of 1 is the deviation of a sound sensor.
const SOUND: f32 = 0.1;
/// Readings outside of these bounds, and by this (N), ...
const LOW: f32 = 0.8;
const HIGH: f32 = 1.25;
const LEAST_N: f32 = 0.2;
/// ... for this long (s), and as many times, contradict the command.
const CONTRADICTED_S: f32 = 0.005;
const CONTRADICTIONS: f32 = 5.0;
/// The latest drive that is believed, a lag of second order: each of its two lags over the known delay, and more (s).
const LATER: f32 = 1.5;
const LATER_S: f32 = 0.005;
/// A delay is at least so long (s) where the motion of the object is weighed against it.
const LEAST_DELAY_S: f32 = 0.01;

/// What the force sensor is worth in a slip, by its innovation: the reading less what the drive has made of the command.
///
/// It is the *command* that has to hold the object. While an object is held the reading is compared with it: a sensor that shows more than a tenth more or
/// less has another gain, by which its readings are divided in the slip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ForceSensor {
    /// The reading is the force.
    #[default]
    InTime,
    /// The same reading for 15 ms and two delays while the model has moved on: the force is the last reading that changed and what the drive has made
    /// of the command since. Until it changes.
    Frozen,
    /// For 5 ms below 0.8 of what even a drive two and a half times as late would show; or for three delays below 0.9 of the model while the
    /// object gets faster all the same. The force is that of the model. Until another object is held.
    Late,
    /// For 5 ms above 1.25 of the highest command of the slip. The same.
    Scaled,
    /// There is none: as frozen.
    Absent,
}

/// The reading of the force sensor.
#[derive(Clone, Copy, Debug, Default)]
struct Reading {
    sensor: ForceSensor,
    /// Whether it shows no touch although there was some.
    numb: bool,
    /// Mean of reading less command (N) while the object is held, and the share of the time of that mean that it was.
    excess_n: f32,
    held: f32,
    /// Reading over command in this slip; 0 before the first one.
    gain: f32,
    /// The last one over the gain (N), and for how long it has been the same (s).
    last_n: Option<f32>,
    same_s: f32,
    /// Innovation when it last changed, gone with the delay since (N).
    innovation_n: f32,
    /// Of the latest drive that is believed, and the highest command of the slip (N).
    late_n: [f32; 2],
    most_n: f32,
    /// How far it is contradicted; enough at 1.
    contradicted: f32,
    /// The force (N) in a slip.
    force_n: Option<f32>,
}

impl Reading {
    fn is_wrong(&self) -> bool {
        matches!(self.sensor, ForceSensor::Late | ForceSensor::Scaled)
    }

    /// Judges a reading (N) over the gain by the model (N), in a drive with this delay (s) with its line; the object may get faster meanwhile.
    fn judge(&mut self, read_n: f32, model_n: f32, dt_s: f32, delay_s: f32, speeds_up: bool) {
        let low = read_n < LOW * self.late_n[1] - LEAST_N;
        let high = read_n > HIGH * self.most_n + LEAST_N;
        let missing = speeds_up && read_n < (1.0 - SOUND) * model_n;
        let patience_s =
            if low || high { CONTRADICTED_S } else { ARRIVES_AFTER * delay_s.max(LEAST_DELAY_S) };
        let counted = (dt_s / patience_s).min(1.0 / CONTRADICTIONS);
        self.contradicted = if low || high || missing { self.contradicted + counted } else { 0.0 };
        if self.contradicted >= 1.0 && !self.is_wrong() {
            self.sensor = if high { ForceSensor::Scaled } else { ForceSensor::Late };
        }
        if self.last_n != Some(read_n) {
            (self.last_n, self.same_s, self.innovation_n) = (Some(read_n), 0.0, read_n - model_n);
            if !self.is_wrong() {
                self.sensor = ForceSensor::InTime;
            }
            return;
        }
        self.same_s += dt_s;
        let moved_n = (model_n + self.innovation_n - read_n).abs();
        let stands = self.same_s >= FROZEN_S.max(FROZEN_DELAYS * delay_s);
        if self.sensor == ForceSensor::InTime
            && stands
            && moved_n > (FROZEN_SHARE * read_n).max(FROZEN_N)
        {
            self.sensor = ForceSensor::Frozen;
        }
    }
}

impl Drive {
    /// Another object: the sensor is believed again.
    pub(crate) fn prime(&mut self) {
        self.reading = Reading::default();
    }

    /// The reading as far as it shows touch. One that contradicts the command and shows no touch while the object `slides` is none, until it shows
    /// some again.
    #[inline]
    pub(crate) fn touch(
        &mut self,
        reading_n: Option<f32>,
        touches: bool,
        slides: bool,
    ) -> Option<f32> {
        let reading = &mut self.reading;
        reading.numb = !touches && (reading.numb || (slides && reading.is_wrong()));
        reading_n.filter(|_| !reading.numb)
    }

    /// Whether the reading shows no touch although there was some; the next one that does ends that.
    #[inline]
    pub(crate) fn is_numb(&self) -> bool {
        self.reading.numb
    }

    /// By the command alone (N), in a slip, as the sensor would show it.
    #[inline]
    pub(crate) fn modelled_as_read_n(&self) -> f32 {
        self.as_read(self.modelled_n())
    }

    /// A force (N) in a slip as the sensor would show it.
    #[inline]
    pub(crate) fn as_read(&self, force_n: f32) -> f32 {
        self.reading.gain * force_n
    }

    /// An object is held under `command_n` (N), and does not slip; the sensor is read `rate_hz` times a second.
    #[inline]
    pub(crate) fn hold(&mut self, reading_n: Option<f32>, command_n: f32, rate_hz: f32) {
        let Some(reading_n) = reading_n else { return };
        let share = 1.0 / (1.0 + HELD_S * rate_hz);
        self.reading.excess_n += share * (reading_n - command_n - self.reading.excess_n);
        self.reading.held += share * (1.0 - self.reading.held);
    }

    /// A slip begins under this command (N) on a line that is late by `line_s` (s).
    pub(crate) fn begin(&mut self, command_n: f32, reading_n: Option<f32>, line_s: f32) {
        self.line_s = line_s;
        let before = self.reading;
        let held = before.held >= HELD;
        let gain = 1.0 + before.excess_n / command_n.max(1e-3);
        let gain = match before.gain {
            _ if held && (gain - 1.0).abs() > SOUND => gain.clamp(0.5, 2.0),
            known if !held && known > 0.0 => known,
            _ => 1.0,
        };
        let wrong = before.is_wrong();
        let arrived_n = reading_n.filter(|_| !held && !wrong);
        let arrived_n = arrived_n.map_or(command_n, |force_n| force_n / gain);
        self.reading = Reading {
            sensor: if wrong { before.sensor } else { ForceSensor::InTime },
            numb: before.numb,
            gain,
            late_n: [arrived_n.min(command_n); 2],
            most_n: command_n.max(arrived_n),
            ..Reading::default()
        };
        if held {
            self.hold_on(command_n);
        } else {
            self.restart(command_n, arrived_n);
        }
    }

    /// Takes the next reading of a slip (N) under the command of the sample before, on a line that is late by `line_s` (s); gives the force (N).
    pub(crate) fn measure(
        &mut self,
        reading_n: Option<f32>,
        dt_s: f32,
        line_s: f32,
        speeds_up: bool,
    ) -> f32 {
        let delay_s = self.delay_s() + line_s;
        let (model_n, command_n) = (self.modelled_n(), self.command_n);
        let reading = &mut self.reading;
        let [first_n, late_n] = &mut reading.late_n;
        let later_s = LATER * delay_s + LATER_S;
        approach(first_n, command_n, dt_s, later_s);
        approach(late_n, *first_n, dt_s, later_s);
        reading.most_n = reading.most_n.max(command_n);
        approach(&mut reading.innovation_n, 0.0, dt_s, delay_s);
        let read_n = reading_n.map(|force_n| force_n / reading.gain);
        match read_n {
            Some(read_n) => reading.judge(read_n, model_n, dt_s, delay_s, speeds_up),
            None => {
                reading.last_n = None;
                if !reading.is_wrong() {
                    reading.sensor = ForceSensor::Absent;
                }
            }
        }
        let force_n = match (reading.sensor, read_n) {
            (ForceSensor::InTime, Some(read_n)) => read_n,
            (ForceSensor::Late | ForceSensor::Scaled, _) => model_n,
            _ => model_n + reading.innovation_n,
        };
        reading.force_n = Some(force_n);
        force_n
    }
}

#[cfg(test)]
mod tests;
