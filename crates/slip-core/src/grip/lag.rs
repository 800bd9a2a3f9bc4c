//! How late the measured force follows the command: how far the command may lead the drive.

use crate::ablation::{Rule, without};

/// A gripper whose force follows within this time (s) answers at once ...
const PROMPT_S: f32 = 0.008;
/// ... and one that has not been seen to follow is taken for one that needs this long (s).
const UNKNOWN_S: f32 = 0.02;
/// A gripper that presses with the trial force from touch on, since it cannot do less, does not show it; such ones need about this long (s).
const UNSEEN_S: f32 = 0.035;

/// Beyond this delay (s), and the more up to twice of it, an object falls too far unless the command runs ahead all the same ...
pub(super) const LATE_S: f32 = 0.02;
/// ... by up to this share of what is known.
const LATE_REACH: f32 = 0.3;
/// Nothing runs ahead further than by this share: fingers that lose the object measure no force.
const LARGEST: f32 = 0.5;

/// How late the measured force follows the command: drive, link and everything between.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lag {
    /// Measured force when the command had reached the trial force (N).
    risen_n: Option<f32>,
    seconds: Option<f32>,
    /// How late the samples arrived then (s).
    late_s: f32,
}

impl Lag {
    /// The command has risen to the trial force while `applied_n` (N) was measured.
    pub(super) fn risen(&mut self, applied_n: Option<f32>) {
        self.risen_n = self.risen_n.or(applied_n);
    }

    /// The command had reached the trial force before the fingers touched: the rise of the force shows no delay.
    pub(super) fn unseen(&mut self) {
        self.seconds = self.seconds.or(Some(UNSEEN_S));
    }

    /// The delay (s), as far as it is known.
    pub(super) fn seconds(&self) -> f32 {
        self.seconds.unwrap_or(UNKNOWN_S)
    }

    /// A new grasp begins.
    pub(super) fn begin(&mut self) {
        self.risen_n = None;
    }

    /// The force has settled: what was missing at the end of a rise by `rate_n_s` (N/s) is the delay times that rate.
    pub(super) fn settled(&mut self, applied_n: Option<f32>, late_s: f32, rate_n_s: f32) {
        if let (Some(risen_n), Some(applied_n)) = (self.risen_n.take(), applied_n) {
            self.late_s = late_s;
            self.seconds = Some(((applied_n - risen_n) / rate_n_s).max(0.0));
        }
    }

    /// How far the command may run ahead of what is known.
    pub(super) fn reach(&self) -> Reach {
        let seconds = self.seconds();
        let share = PROMPT_S / seconds.max(PROMPT_S);
        let late = ((seconds - LATE_S) / LATE_S).clamp(0.0, 1.0);
        Reach { promptness: share * share, late: LATE_REACH * late, seconds, late_s: self.late_s }
    }
}

/// How far the command may run ahead of what is known, by the delay of the gripper: all of the way where it answers at once; less, with the square of
/// the delay, where it is later and would press too hard before that is seen; and where it is so late that objects fall meanwhile at least some.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reach {
    /// Share of what is wished for, from 0 to 1.
    promptness: f32,
    /// Share of the known force that is allowed in any case.
    late: f32,
    /// Delay of the gripper, with a line on which samples are so late (s).
    seconds: f32,
    late_s: f32,
}

/// A force that was commanded this many delays ago has arrived, if it ever does ...
const ARRIVES_AFTER: f32 = 3.0;
/// ... within these bounds (s).
const ARRIVES_S: [f32; 2] = [0.01, 0.1];

impl Reach {
    /// After this long (s) a commanded force has arrived, measured or not, where samples arrive `late_s` (s) late: commands do too.
    pub(super) fn wait_s(&self, late_s: f32) -> f32 {
        let [least_s, most_s] = ARRIVES_S;
        (ARRIVES_AFTER * self.delay_s(late_s)).clamp(least_s, most_s)
    }

    /// How late the measured force follows (s).
    pub(super) fn delay_s(&self, late_s: f32) -> f32 {
        self.seconds + 2.0 * (late_s - self.late_s).max(0.0)
    }

    /// How much more than `known_n` (N) may be commanded where `wish_n` (N) more is wished for.
    pub(super) fn beyond(&self, known_n: f32, wish_n: f32) -> f32 {
        let wish_n = wish_n.max(0.0);
        let late_n = wish_n.min(self.late * known_n);
        (self.promptness * wish_n).max(late_n).min(LARGEST * known_n.max(0.0))
    }
}

// Commands and measured forces of a slip in; how far the command may lead a drive that follows slowly out.

/// A force that has risen by this share, and at least this much (N), answers the command.
const ANSWERS: f32 = 0.1;
const ANSWERS_N: f32 = 0.03;
/// A force that has not risen by this share ...
const RISES: f32 = 0.02;
/// ... for this long (s) does not follow any longer.
const LEVEL_S: f32 = 0.01;
/// By this much (s) later the controller knows of a force.
const KNOWN_S: f32 = 0.003;
/// What is on its way when the target is measured may exceed it by this share.
const EXCESS: f32 = 0.05;
/// Drives that are later by this (s) than [`LATE_S`] are led in full; less late ones in proportion ...
const SLOWER_S: f32 = 0.01;
/// ... by at most this multiple of the target.
const MOST: f32 = 1.0;
/// Where the stylus alone shows what is needed, that is known only as the force rises: a drive that is later than this (s)
/// is led so that it rises as one of that lag does.
const RESPONSE_PROMPT_S: f32 = 0.005;

/// How the measured force answers the command in a slip.
///
/// A drive that moves from the first moment on, only slowly, reaches a force sooner when more is commanded meanwhile. A
/// line that is late, or a drive with dead time, does not: what is commanded on top arrives as it is. Both are equally
/// late when the fingers close; in a slip they differ in when the measured force begins to rise. A first-order lag of
/// the whole delay states when it would without dead time; what it is later by is dead time d, and the rest of the delay,
/// tau, is lag:
/// ```text
/// command <= F + (target - F) tau / (d + 3 ms)
/// ```
/// so that the force that is still on its way when the target is measured is small.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    /// Measured force when the slip began (N).
    start_n: Option<f32>,
    /// What a drive without dead time would show now (N).
    model_n: f32,
    /// The greatest measured force (N), and since when it has not become greater (s).
    most_n: f32,
    level_s: f32,
    /// How late the gripper is (s), and what of that is dead time as far as it is known.
    delay_s: f32,
    dead_s: f32,
    answered: bool,
}

impl Response {
    /// In a gripper whose force is late by `delay_s` (s).
    pub(super) fn begin(delay_s: f32) -> Self {
        Self { delay_s, ..Self::default() }
    }

    /// The command so far and the force measured under it (N).
    pub(super) fn follow(&mut self, command_n: f32, applied_n: Option<f32>, dt_s: f32) {
        let Some(applied_n) = applied_n else { return };
        let start_n = *self.start_n.get_or_insert_with(|| {
            (self.model_n, self.most_n) = (applied_n, applied_n);
            applied_n
        });
        self.model_n += (command_n - self.model_n) * dt_s / (self.delay_s + dt_s);
        let answer_n = start_n + (ANSWERS * start_n).max(ANSWERS_N);
        if !self.answered && self.model_n >= answer_n {
            self.answered = applied_n >= answer_n;
            self.dead_s += if without(Rule::DeadTime) { 0.0 } else { dt_s };
        }
        self.level_s += dt_s;
        if applied_n >= self.most_n * (1.0 + RISES) {
            (self.most_n, self.level_s) = (applied_n, 0.0);
        }
    }

    /// How far the command may lead the target while `applied_n` is measured (N); `alone`: only the stylus gives the target.
    pub(super) fn lead_n(&self, target_n: f32, applied_n: f32, alone: bool) -> f32 {
        let (late_s, known_s) =
            if alone { (RESPONSE_PROMPT_S, RESPONSE_PROMPT_S) } else { (LATE_S, KNOWN_S) };
        let slower = ((self.delay_s - late_s) / SLOWER_S).clamp(0.0, 1.0);
        let led = self.answered && self.level_s <= LEVEL_S && slower > 0.0;
        if !led || without(Rule::Response) {
            return 0.0;
        }
        let lag_s = (self.delay_s - self.dead_s).max(0.0);
        let missing_n = (1.0 + EXCESS) * target_n - applied_n;
        let driven_n = applied_n + missing_n * lag_s / (self.dead_s + known_s);
        (driven_n - target_n).min(MOST * slower * target_n).max(0.0)
    }
}

#[cfg(test)]
mod response_tests {
    extern crate std;
    use super::Response;
    use std::collections::VecDeque;

    const DT_S: f32 = 1e-3;

    #[derive(Clone, Copy, PartialEq)]
    enum Leads {
        Not,
        Measured,
        Alone,
    }

    /// A gripper that is late by a dead time and a lag (ms) goes from 1 N to a target of 6 N: until 5.4 N are measured (ms),
    /// and the greatest force (N); with or without the lead.
    fn reached(dead_ms: usize, lag_ms: f32, leads: Leads) -> (u32, f32) {
        let mut response = Response::begin(1e-3 * (dead_ms as f32 + lag_ms));
        let mut line: VecDeque<f32> = core::iter::repeat_n(1.0, dead_ms).collect();
        let (mut applied_n, mut command_n, mut most_n, mut reached_ms) = (1.0_f32, 1.0, 0.0, 0);
        for ms in 0..400 {
            response.follow(command_n, Some(applied_n), DT_S);
            let alone = leads == Leads::Alone;
            let lead_n = response.lead_n(6.0, applied_n, alone);
            command_n = 6.0 + if leads == Leads::Not { 0.0 } else { lead_n };
            line.push_back(command_n);
            let arrives_n = line.pop_front().unwrap();
            applied_n += (arrives_n - applied_n) * 1.0 / (1.0 + lag_ms);
            most_n = applied_n.max(most_n);
            reached_ms = if most_n < 5.4 { ms } else { reached_ms };
        }
        (reached_ms, most_n)
    }

    #[test]
    fn a_slow_drive_is_led_and_what_is_late_by_dead_time_is_not_pressed_harder() {
        let (plain, led) = (reached(0, 40.0, Leads::Not), reached(0, 40.0, Leads::Measured));
        assert!(2 * led.0 <= plain.0 && led.1 <= 6.3, "{plain:?} {led:?}");
        let (plain, led) = (reached(10, 30.0, Leads::Not), reached(10, 30.0, Leads::Measured));
        assert!(led.0 < plain.0 && led.1 <= 6.6, "{plain:?} {led:?}");
        for dead_ms in [30, 40, 60] {
            let (ms, most_n) = reached(dead_ms, 1.0, Leads::Measured);
            assert!(most_n <= 6.3, "dead time of {dead_ms} ms: {most_n} N after {ms} ms");
        }
        assert_eq!(reached(0, 15.0, Leads::Measured), reached(0, 15.0, Leads::Not), "not late");
    }

    #[test]
    fn for_the_stylus_alone_a_slow_drive_is_made_prompt() {
        for lag_ms in [10.0, 15.0, 20.0] {
            let (plain, led) = (reached(0, lag_ms, Leads::Not), reached(0, lag_ms, Leads::Alone));
            assert!(3 * led.0 <= 2 * plain.0 && led.1 <= 6.3, "{lag_ms} ms: {plain:?} {led:?}");
        }
        for dead_ms in [10, 15, 20] {
            let (ms, most_n) = reached(dead_ms, 1.0, Leads::Alone);
            assert!(most_n <= 6.3, "dead time of {dead_ms} ms: {most_n} N after {ms} ms");
        }
        assert_eq!(reached(0, 5.0, Leads::Alone), reached(0, 5.0, Leads::Not), "prompt");
    }

    #[test]
    fn a_force_that_does_not_answer_or_stands_still_is_not_led() {
        let mut response = Response::begin(0.04);
        for _ in 0..200 {
            response.follow(6.0, Some(1.0), DT_S);
        }
        assert_eq!(response.lead_n(6.0, 1.0, false), 0.0, "stuck from the start");
        let mut response = Response::begin(0.04);
        for ms in 0..10_u8 {
            response.follow(6.0, Some(1.0 + 0.1 * f32::from(ms)), DT_S);
        }
        assert!(response.lead_n(6.0, 1.9, false) > 1.0);
        for _ in 0..12 {
            response.follow(6.0, Some(1.9), DT_S);
        }
        assert_eq!(response.lead_n(6.0, 1.9, false), 0.0, "stuck on the way");
    }
}
