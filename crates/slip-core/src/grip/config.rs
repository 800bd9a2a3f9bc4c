//! Forces, rates and gains of the controller, and their ranges.

use crate::error::ConfigError;

/// Forces and rates of the controller; every force is the normal force of one finger.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct GripConfig {
    /// Largest force ever commanded (N).
    pub f_max_n: f32,
    /// Force that the object in hand must not be pressed with (N), where that is known and less than `f_max_n`; 0 where it is not.
    pub fragile_n: f32,
    /// Force of the first, light grasp (N).
    pub trial_force_n: f32,
    /// An object that has not slipped since it was grasped is held with less and less, down to this force (N); then it is light enough not to be
    /// harmed. At least a few times what the force sensor may be off by.
    pub least_force_n: f32,
    /// The share of the force by which it falls in a second while nothing has slipped yet; 0 keeps the trial force.
    pub relax_per_s: f32,
    /// Fastest rise of the command (N/s).
    pub slew_n_s: f32,
    /// Rise while the fingers close (N/s).
    pub close_rate_n_s: f32,
    /// Fall towards the estimate after a slip (N/s).
    pub backoff_n_s: f32,
    /// Measured force that counts as touch (N); at most half of `least_force_n`, or the fingers would stop before they touch. Six times the noise of
    /// the force counts where it is more.
    pub contact_n: f32,
    /// Wait between reaching the trial force and watching for slip (ms).
    pub settle_ms: f32,
    /// Immediate rise on a slip, relative to the force at that moment; what slipped at a force needs more than that force, so this much is never
    /// too much for an object that can be held with a margin.
    pub reflex_step: f32,
    /// Time in which the reflex raises the force by a factor e where no sensor measures the slip (ms).
    pub reflex_tau_ms: f32,
    /// The same where the moved distance is measured, as long as the object moves but no estimate is possible (ms).
    pub measured_tau_ms: f32,
    /// Force while braking a slip over the estimate.
    pub brake_gain: f32,
    /// Deviations of the estimate that are added to it.
    pub margin_sigmas: f32,
    /// How far the command leads the measured force while that is below what is wanted, as a multiple of what is missing: makes up for the lag
    /// of the drive. Not used without a force sensor.
    pub lead: f32,
    /// How far a growth of the estimate is carried into the future, in units of the time in which it was seen (4 ms).
    pub ahead: f32,
    /// Moved distance that confirms a slip where a sensor measures it (m).
    pub confirm_m: f32,
    /// Without touch for this long (ms) while the fingers are commanded to press, there is no object.
    pub lost_ms: f32,
}

impl Default for GripConfig {
    fn default() -> Self {
        Self {
            f_max_n: 60.0,
            fragile_n: 0.0,
            trial_force_n: 1.2,
            least_force_n: 0.2,
            relax_per_s: 1.0,
            slew_n_s: 2000.0,
            close_rate_n_s: 20.0,
            backoff_n_s: 20.0,
            contact_n: 0.05,
            settle_ms: 50.0,
            reflex_step: 0.25,
            reflex_tau_ms: 20.0,
            measured_tau_ms: 80.0,
            brake_gain: 1.0,
            margin_sigmas: 0.25,
            lead: 2.0,
            ahead: 2.0,
            confirm_m: 3e-5,
            lost_ms: 30.0,
        }
    }
}

impl GripConfig {
    /// The largest force for the object in hand (N).
    #[must_use]
    #[inline]
    pub fn ceiling_n(&self) -> f32 {
        if self.fragile_n > 0.0 { self.f_max_n.min(self.fragile_n) } else { self.f_max_n }
    }

    /// # Errors
    /// The first value outside its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        ConfigError::within("grip.f_max_n", self.f_max_n, 0.01, 5000.0)?;
        ConfigError::within("grip.fragile_n", self.fragile_n, 0.0, 5000.0)?;
        ConfigError::within("grip.trial_force_n", self.trial_force_n, 0.01, self.ceiling_n())?;
        ConfigError::within("grip.least_force_n", self.least_force_n, 0.01, self.trial_force_n)?;
        ConfigError::within("grip.relax_per_s", self.relax_per_s, 0.0, 10.0)?;
        ConfigError::within("grip.slew_n_s", self.slew_n_s, 0.1, 1e6)?;
        ConfigError::within("grip.close_rate_n_s", self.close_rate_n_s, 0.1, self.slew_n_s)?;
        ConfigError::within("grip.backoff_n_s", self.backoff_n_s, 0.0, self.slew_n_s)?;
        ConfigError::within("grip.contact_n", self.contact_n, 1e-3, 0.5 * self.least_force_n)?;
        ConfigError::within("grip.settle_ms", self.settle_ms, 0.0, 10_000.0)?;
        ConfigError::within("grip.reflex_step", self.reflex_step, 0.0, 2.0)?;
        ConfigError::within("grip.reflex_tau_ms", self.reflex_tau_ms, 1.0, 10_000.0)?;
        ConfigError::within("grip.measured_tau_ms", self.measured_tau_ms, 1.0, 10_000.0)?;
        ConfigError::within("grip.brake_gain", self.brake_gain, 1.0, 3.0)?;
        ConfigError::within("grip.margin_sigmas", self.margin_sigmas, 0.0, 5.0)?;
        ConfigError::within("grip.lead", self.lead, 0.0, 10.0)?;
        ConfigError::within("grip.ahead", self.ahead, 0.0, 5.0)?;
        ConfigError::within("grip.confirm_m", self.confirm_m, 0.0, 0.01)?;
        ConfigError::within("grip.lost_ms", self.lost_ms, 1.0, 10_000.0)
    }
}
