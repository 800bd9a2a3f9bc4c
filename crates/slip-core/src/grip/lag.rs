//! Measured forces while the fingers close in; how far the command may run ahead out.

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
