//! Measured forces while the fingers close in; how far the command may run ahead out.

/// A gripper whose force follows within this time (s) answers at once ...
const PROMPT_S: f32 = 0.008;
/// ... and one that has not been seen to follow is taken for one that needs this long (s).
const UNKNOWN_S: f32 = 0.01;

/// How late the measured force follows the command: drive, link and everything between.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lag {
    /// Measured force when the command had reached the trial force (N).
    risen_n: Option<f32>,
    seconds: Option<f32>,
}

impl Lag {
    /// The command has risen to the trial force while `applied_n` (N) was measured.
    pub(super) fn risen(&mut self, applied_n: Option<f32>) {
        self.risen_n = self.risen_n.or(applied_n);
    }

    /// The force has settled: what was missing at the end of a rise by `rate_n_s` (N/s) is the delay times that rate.
    pub(super) fn settled(&mut self, applied_n: Option<f32>, rate_n_s: f32) {
        if let (Some(risen_n), Some(applied_n)) = (self.risen_n.take(), applied_n) {
            self.seconds = Some(((applied_n - risen_n) / rate_n_s).max(0.0));
        }
    }

    /// How far the command may run ahead of what is known, as a share of what it may where the gripper answers at once: a late one would press
    /// too hard before it is seen.
    pub(super) fn promptness(&self) -> f32 {
        let share = PROMPT_S / self.seconds.unwrap_or(UNKNOWN_S).max(PROMPT_S);
        share * share
    }
}
