//! Forces, rates and gains of the controller, and their ranges.

use crate::settings::settings;

settings! {
    /// Forces and rates of the controller; every force is the normal force of one finger.
    pub struct GripConfig as c in "grip" {
        f_max_n: f32 = 60.0, 0.01..=5000.0 => "Largest force ever commanded (N).";
        fragile_n: f32 = 0.0, 0.0..=5000.0 =>
            "Force that the object in hand must not be pressed with (N), where that is known and less than"
            "`f_max_n`; 0 where it is not.";
        trial_force_n: f32 = 1.2, 0.01..=c.ceiling_n() => "Force of the first, light grasp (N).";
        least_force_n: f32 = 0.2, 0.01..=c.trial_force_n =>
            "An object that has not slipped since it was grasped is held with less and less, down to this force"
            "(N); then it is light enough not to be harmed. At least a few times what the force sensor may be off"
            "by.";
        relax_per_s: f32 = 1.0, 0.0..=10.0 =>
            "The share of the force by which it falls in a second while nothing has slipped yet; 0 keeps the trial"
            "force.";
        slew_n_s: f32 = 2000.0, 0.1..=1e6 => "Fastest rise of the command (N/s).";
        close_rate_n_s: f32 = 20.0, 0.1..=c.slew_n_s => "Rise while the fingers close (N/s).";
        backoff_n_s: f32 = 20.0, 0.0..=c.slew_n_s => "Fall towards the estimate after a slip (N/s).";
        contact_n: f32 = 0.05, 1e-3..=0.5 * c.least_force_n =>
            "Measured force that counts as touch (N); at most half of `least_force_n`, or the fingers would stop"
            "before they touch. Six times the noise of the force counts where it is more.";
        settle_ms: f32 = 50.0, 0.0..=10_000.0 => "Wait between reaching the trial force and watching for slip (ms).";
        reflex_step: f32 = 0.25, 0.0..=2.0 =>
            "Immediate rise on a slip, relative to the force at that moment; what slipped at a force needs more"
            "than that force, so this much is never too much for an object that can be held with a margin.";
        reflex_tau_ms: f32 = 20.0, 1.0..=10_000.0 =>
            "Time in which the reflex raises the force by a factor e where no sensor measures the slip (ms).";
        measured_tau_ms: f32 = 80.0, 1.0..=10_000.0 =>
            "The same where the moved distance is measured, as long as the object moves but no estimate is possible"
            "(ms).";
        brake_gain: f32 = 1.0, 1.0..=3.0 => "Force while braking a slip over the estimate.";
        margin_sigmas: f32 = 0.25, 0.0..=5.0 => "Deviations of the estimate that are added to it.";
        lead: f32 = 2.0, 0.0..=10.0 =>
            "How far the command leads the measured force while that is below what is wanted, as a multiple of what"
            "is missing: makes up for the lag of the drive. Not used without a force sensor.";
        ahead: f32 = 2.0, 0.0..=5.0 =>
            "How far a growth of the estimate is carried into the future, in units of the time in which it was seen"
            "(4 ms).";
        confirm_m: f32 = 3e-5, 0.0..=0.01 => "Moved distance that confirms a slip where a sensor measures it (m).";
        lost_ms: f32 = 30.0, 1.0..=10_000.0 =>
            "Without touch for this long (ms) while the fingers are commanded to press, there is no object.";
    }
}

impl GripConfig {
    /// The largest force for the object in hand (N).
    #[must_use]
    #[inline]
    pub fn ceiling_n(&self) -> f32 {
        if self.fragile_n > 0.0 { self.f_max_n.min(self.fragile_n) } else { self.f_max_n }
    }
}
