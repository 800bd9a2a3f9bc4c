//! What a gripper can do, as its data sheet or the gripper itself declares it, and the controller settings that it can follow.

use slip_core::grip::GripConfig;

/// What a gripper can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperSpec {
    /// Smallest force that it presses with (N); a smaller one above 0 is this.
    pub force_min_n: f32,
    /// Largest force (N).
    pub force_max_n: f32,
    /// Steps of the force (N); 0 where it has none.
    pub step_n: f32,
    /// First-order lag (s) from a command that it has taken to the force, where it measures none; `None` where it does.
    pub lag_s: Option<f32>,
}

impl GripperSpec {
    /// Lets the controller ask for nothing that the gripper cannot do.
    pub fn limit(&self, grip: &mut GripConfig) {
        grip.f_max_n = grip.f_max_n.min(self.force_max_n);
        least_force(grip, self.force_min_n.max(self.step_n).min(grip.f_max_n));
    }
}

/// No object is held with less than `least_n` (N). Where that is more than the trial force it takes its place, and the fingers close to it
/// in the usual time.
pub fn least_force(grip: &mut GripConfig, least_n: f32) {
    grip.least_force_n = grip.least_force_n.max(least_n);
    if least_n > grip.trial_force_n {
        grip.close_rate_n_s *= least_n / grip.trial_force_n;
        grip.trial_force_n = least_n;
    }
}

#[cfg(test)]
mod tests {
    use super::GripperSpec;
    use slip_core::grip::GripConfig;

    #[test]
    fn the_controller_asks_for_what_the_gripper_can_do() {
        let usual = GripConfig::default();
        for (force_min_n, force_max_n, f_max_n) in
            [(20.0, 235.0, 60.0), (0.0, 10.0, 10.0), (100.0, 235.0, 60.0)]
        {
            let spec = GripperSpec { force_min_n, force_max_n, step_n: 0.8, lag_s: None };
            let mut grip = usual;
            spec.limit(&mut grip);
            grip.check().unwrap();
            assert!((grip.f_max_n - f_max_n).abs() < 1e-6);
            assert!(
                grip.least_force_n >= spec.force_min_n.min(f_max_n) && grip.least_force_n >= 0.8
            );
            let closes_s = |grip: &GripConfig| grip.trial_force_n / grip.close_rate_n_s;
            assert!((closes_s(&grip) - closes_s(&usual)).abs() < 1e-6);
        }
    }
}
