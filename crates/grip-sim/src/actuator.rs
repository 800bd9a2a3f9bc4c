//! Force target in, force of one finger on the object out.
//!
//! The fingers first travel to the object; from touch on the set point follows the target at a limited slew
//! rate and the force follows the set point with a first-order lag, integrated exactly.

/// Limits of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatorConfig {
    /// Largest force (N).
    pub force_max_n: f64,
    /// Largest slew rate of the set point (N/s).
    pub slew_max_n_s: f64,
    /// Time constant of the drive (s).
    pub lag_s: f64,
    /// Time the fingers need to reach the object (s).
    pub approach_s: f64,
}

/// Distance the fingers travel before they touch (m).
pub const APPROACH_M: f64 = 2e-3;

/// Drive of the fingers.
#[derive(Clone, Copy, Debug)]
pub struct Actuator {
    config: ActuatorConfig,
    slew_n_s: f64,
    gap_m: f64,
    setpoint_n: f64,
    applied_n: f64,
    /// The last time step (s), and the share of the way to the set point that the force goes in it.
    follow: (f64, f64),
}

impl Actuator {
    /// Open fingers, no force.
    #[must_use]
    pub fn new(config: ActuatorConfig) -> Self {
        Self {
            config,
            slew_n_s: config.slew_max_n_s,
            gap_m: APPROACH_M,
            setpoint_n: 0.0,
            applied_n: 0.0,
            follow: (0.0, 0.0),
        }
    }

    /// Sets the slew rate (N/s), limited to the drive's own; NaN is ignored.
    pub fn set_slew(&mut self, slew_n_s: f64) {
        if !slew_n_s.is_nan() {
            self.slew_n_s = slew_n_s.clamp(0.0, self.config.slew_max_n_s);
        }
    }

    /// Advances by `dt` (s) towards `target_n` (N), limited to 0..=F_max; a NaN target holds the set point.
    /// The fingers close while the target is positive and never open by themselves.
    pub fn step(&mut self, target_n: f64, dt: f64) {
        if self.gap_m > 0.0 {
            if target_n > 0.0 {
                self.gap_m = (self.gap_m - APPROACH_M * dt / self.config.approach_s).max(0.0);
            }
            return;
        }
        if !target_n.is_nan() {
            let reach = self.slew_n_s * dt;
            let target = target_n.clamp(0.0, self.config.force_max_n);
            self.setpoint_n += (target - self.setpoint_n).clamp(-reach, reach);
        }
        if dt != self.follow.0 {
            self.follow = (dt, -(-dt / self.config.lag_s).exp_m1());
        }
        self.applied_n += self.follow.1 * (self.setpoint_n - self.applied_n);
    }

    /// Force of each finger (N).
    #[must_use]
    pub fn applied_n(&self) -> f64 {
        self.applied_n
    }

    /// Distance between finger and object (m); 0 from touch on.
    #[must_use]
    pub fn gap_m(&self) -> f64 {
        self.gap_m
    }

    /// Whether the fingers travel towards the object while the force aimed at is `target_n` (N).
    #[must_use]
    pub fn travels(&self, target_n: f64) -> bool {
        self.gap_m > 0.0 && target_n > 0.0
    }

    /// The object is gone: the force drops to nothing and stays there.
    pub fn lose_object(&mut self) {
        self.setpoint_n = 0.0;
        self.applied_n = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: ActuatorConfig =
        ActuatorConfig { force_max_n: 60.0, slew_max_n_s: 2000.0, lag_s: 5e-3, approach_s: 0.05 };

    fn run(actuator: &mut Actuator, target_n: f64, seconds: f64) {
        let mut left = seconds;
        while left > 0.0 {
            actuator.step(target_n, 1e-5);
            left -= 1e-5;
        }
    }

    #[test]
    fn no_force_before_touch() {
        let mut drive = Actuator::new(DRIVE);
        run(&mut drive, 0.0, 0.2);
        assert!(drive.gap_m() >= APPROACH_M);
        run(&mut drive, 5.0, 0.049);
        assert!(drive.applied_n() <= 0.0 && drive.gap_m() > 0.0);
        run(&mut drive, 5.0, 0.1);
        assert!((drive.applied_n() - 5.0).abs() < 1e-6);
    }

    #[test]
    fn slew_and_lag_shape_the_rise() {
        let mut drive = Actuator::new(DRIVE);
        run(&mut drive, 1e-9, 0.06);
        drive.set_slew(100.0);
        run(&mut drive, 10.0, 0.05);
        // A ramp through a lag trails by slew * lag once the lag has settled.
        assert!((drive.applied_n() - (5.0 - 0.5)).abs() < 0.01, "{}", drive.applied_n());
    }

    #[test]
    fn odd_targets_are_harmless() {
        let mut drive = Actuator::new(DRIVE);
        run(&mut drive, 4.0, 0.2);
        run(&mut drive, f64::NAN, 0.1);
        assert!((drive.applied_n() - 4.0).abs() < 1e-6);
        run(&mut drive, f64::INFINITY, 0.2);
        assert!((drive.applied_n() - 60.0).abs() < 1e-6);
        run(&mut drive, -3.0, 0.2);
        assert!(drive.applied_n().abs() < 1e-6 && drive.applied_n() >= 0.0);
    }
}
