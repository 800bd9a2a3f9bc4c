//! Model of the drive: the force of one finger on the object for a force target.
//!
//! The fingers first travel to the object; from touch on the set point follows the target at a limited slew
//! rate and the force follows the set point with a first-order lag, integrated exactly.
//!
//! Coarse and late drives: a command is taken `1 / command_hz` after the last one at the earliest and acts after a dead time. It is put on
//! the nearest step from the smallest force on. A drive at rest does not answer a change within its dead band; once it moves it goes
//! all the way. Friction of a tendon in its sheath (capstan equation) holds the force between (1 - h) and (1 + h) times what the drive pulls with.

use std::collections::VecDeque;

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
    /// Smallest force that it presses with (N); a smaller target above 0 is this.
    pub force_min_n: f64,
    /// Steps of the force from the smallest one on (N); 0 where it has none.
    pub step_n: f64,
    /// Time between two commands that are taken (s); 0 where each one is.
    pub command_s: f64,
    /// Dead time of a command (s).
    pub delay_s: f64,
    /// Change that a drive at rest does not answer (N).
    pub dead_band_n: f64,
    /// Share h by which the force may differ from what the drive pulls with, 0 to below 1.
    pub hysteresis: f64,
}

/// Distance the fingers travel before they touch (m).
pub const APPROACH_M: f64 = 2e-3;

/// Drive of the fingers.
#[derive(Clone, Debug)]
pub struct Actuator {
    config: ActuatorConfig,
    slew_n_s: f64,
    gap_m: f64,
    setpoint_n: f64,
    /// The set point through the lag (N).
    lagged_n: f64,
    applied_n: f64,
    /// Leaves its dead band.
    moves: bool,
    commands: Commands,
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
            lagged_n: 0.0,
            applied_n: 0.0,
            moves: false,
            commands: Commands::default(),
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
        let config = self.config;
        let target_n = if config.command_s > 0.0 || config.delay_s > 0.0 {
            self.commands.take(target_n, dt, &config)
        } else {
            target_n
        };
        if self.gap_m > 0.0 {
            if target_n > 0.0 {
                self.gap_m = (self.gap_m - APPROACH_M * dt / config.approach_s).max(0.0);
            }
            return;
        }
        if !target_n.is_nan() {
            let away = config.on_a_step(target_n) - self.setpoint_n;
            self.moves = away.abs() > if self.moves { 0.0 } else { config.dead_band_n };
            if self.moves {
                let reach = self.slew_n_s * dt;
                self.setpoint_n += away.clamp(-reach, reach);
            }
        }
        if dt != self.follow.0 {
            self.follow = (dt, -(-dt / config.lag_s).exp_m1());
        }
        self.lagged_n += self.follow.1 * (self.setpoint_n - self.lagged_n);
        let (low, high) = (1.0 - config.hysteresis, 1.0 + config.hysteresis);
        self.applied_n = self.applied_n.max(low * self.lagged_n).min(high * self.lagged_n);
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
        (self.setpoint_n, self.lagged_n, self.applied_n) = (0.0, 0.0, 0.0);
    }
}

impl ActuatorConfig {
    /// The nearest force that the drive can press with (N); NaN stays.
    fn on_a_step(&self, target_n: f64) -> f64 {
        let target_n = target_n.clamp(0.0, self.force_max_n);
        if target_n <= 0.0 {
            return target_n;
        }
        let above_n = (target_n - self.force_min_n).max(0.0);
        let above_n =
            if self.step_n > 0.0 { (above_n / self.step_n).round() * self.step_n } else { above_n };
        (self.force_min_n + above_n).min(self.force_max_n)
    }
}

/// Commands on their way to the drive.
#[derive(Clone, Debug, Default)]
struct Commands {
    now_s: f64,
    next_s: f64,
    /// When they act (s), and the targets (N).
    under_way: VecDeque<(f64, f64)>,
    acting_n: f64,
}

impl Commands {
    /// The target that acts (N), after another `dt` (s) with `target_n` commanded; NaN is no command.
    fn take(&mut self, target_n: f64, dt: f64, config: &ActuatorConfig) -> f64 {
        // Rounding of the time must not cost a step.
        let due_s = self.now_s + 0.5 * dt;
        if due_s >= self.next_s && !target_n.is_nan() {
            let newest_n = self.under_way.back().map_or(self.acting_n, |(_, newest_n)| *newest_n);
            if target_n != newest_n {
                self.under_way.push_back((self.now_s + config.delay_s, target_n));
            }
            self.next_s = self.now_s + config.command_s;
        }
        while let Some((_, target_n)) = self.under_way.pop_front_if(|(at_s, _)| due_s >= *at_s) {
            self.acting_n = target_n;
        }
        self.now_s += dt;
        self.acting_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> Actuator {
        Actuator::new(ActuatorConfig { approach_s: 0.05, ..ActuatorConfig::default() })
    }

    fn run(actuator: &mut Actuator, target_n: f64, seconds: f64) {
        let mut left = seconds;
        while left > 0.0 {
            actuator.step(target_n, 1e-5);
            left -= 1e-5;
        }
    }

    #[test]
    fn no_force_before_touch() {
        let mut drive = drive();
        run(&mut drive, 0.0, 0.2);
        assert!(drive.gap_m() >= APPROACH_M);
        run(&mut drive, 5.0, 0.049);
        assert!(drive.applied_n() <= 0.0 && drive.gap_m() > 0.0);
        run(&mut drive, 5.0, 0.1);
        assert!((drive.applied_n() - 5.0).abs() < 1e-6);
    }

    #[test]
    fn slew_and_lag_shape_the_rise() {
        let mut drive = drive();
        run(&mut drive, 1e-9, 0.06);
        drive.set_slew(100.0);
        run(&mut drive, 10.0, 0.05);
        // A ramp through a lag trails by slew * lag once the lag has settled.
        assert!((drive.applied_n() - (5.0 - 0.5)).abs() < 0.01, "{}", drive.applied_n());
    }

    #[test]
    fn odd_targets_are_harmless() {
        let mut drive = drive();
        run(&mut drive, 4.0, 0.2);
        run(&mut drive, f64::NAN, 0.1);
        assert!((drive.applied_n() - 4.0).abs() < 1e-6);
        run(&mut drive, f64::INFINITY, 0.2);
        assert!((drive.applied_n() - 60.0).abs() < 1e-6);
        run(&mut drive, -3.0, 0.2);
        assert!(drive.applied_n().abs() < 1e-6 && drive.applied_n() >= 0.0);
    }

    const LATE: ActuatorConfig = ActuatorConfig {
        force_max_n: 60.0,
        slew_max_n_s: 300.0,
        lag_s: 20e-3,
        // Ends in the middle of a step, where rounding does not matter.
        approach_s: 0.049_95,
        force_min_n: 3.0,
        step_n: 0.8,
        command_s: 7e-3,
        delay_s: 23e-3,
        dead_band_n: 1.0,
        hysteresis: 0.15,
    };

    /// Time between two commands, and dead time, of [`LATE`] in steps of 0.1 ms.
    const EVERY: usize = 70;
    const LATE_BY: usize = 230;

    /// The force each 0.1 ms, by arrays of the whole past: what `step` should do, step by step as its description reads.
    fn reference(config: &ActuatorConfig, targets: &[f64], dt: f64) -> Vec<f64> {
        let taken: Vec<f64> = (0..targets.len()).map(|i| targets[i / EVERY * EVERY]).collect();
        let acting = |i: usize| if i < LATE_BY { 0.0 } else { taken[i - LATE_BY] };
        let mut forces: Vec<f64> = Vec::new();
        let (mut gap, mut setpoint, mut lagged, mut moves) = (1.0, 0.0_f64, 0.0, false);
        for i in 0..targets.len() {
            let before = forces.last().copied().unwrap_or(0.0);
            if gap > 1e-9 {
                gap -= if acting(i) > 0.0 { dt / config.approach_s } else { 0.0 };
                forces.push(0.0);
                continue;
            }
            let steps = (0..100).map(|step| config.force_min_n + f64::from(step) * config.step_n);
            let reachable = steps.filter(|force| *force <= config.force_max_n).chain([0.0]);
            let wanted = if acting(i) > 0.0 { acting(i).max(config.force_min_n) } else { 0.0 };
            let nearest = |a: &f64, b: &f64| (a - wanted).abs().total_cmp(&(b - wanted).abs());
            let target =
                reachable.filter(|x| (*x > 0.0) == (wanted > 0.0)).min_by(nearest).unwrap();
            moves = if moves {
                target != setpoint
            } else {
                (target - setpoint).abs() > config.dead_band_n
            };
            if moves {
                let reach = config.slew_max_n_s * dt;
                setpoint = if (target - setpoint).abs() <= reach {
                    target
                } else {
                    setpoint + reach.copysign(target - setpoint)
                };
            }
            lagged += (setpoint - lagged) * (1.0 - (-dt / config.lag_s).exp());
            let (low, high) =
                ((1.0 - config.hysteresis) * lagged, (1.0 + config.hysteresis) * lagged);
            forces.push(if before < low {
                low
            } else if before > high {
                high
            } else {
                before
            });
        }
        forces
    }

    #[test]
    fn a_coarse_and_late_drive_does_what_a_slow_reference_does() {
        let dt = 1e-4;
        // Steps, a sine and a ramp that never meets the middle between two steps of the force.
        let target = |i: u32| match f64::from(i) * dt {
            t if t < 0.05 => 0.0,
            t if t < 0.4 => 1.0,
            t if t < 0.8 => 12.1,
            t if t < 1.6 => 12.1 + 7.0 * (9.0 * (t - 0.8)).sin(),
            t => 20.013 - 8.0 * (t - 1.6),
        };
        let targets: Vec<f64> = (0..30_000).map(target).collect();
        let expected = reference(&LATE, &targets, dt);
        let mut drive = Actuator::new(LATE);
        let mut worst = 0.0_f64;
        for (target, expected) in targets.iter().zip(&expected) {
            drive.step(*target, dt);
            worst = worst.max((drive.applied_n() - expected).abs());
        }
        assert!(worst < 1e-9, "{worst}");
        assert!(expected.iter().any(|force| *force > 15.0));
    }

    #[test]
    fn each_property_of_a_coarse_drive_shows_by_itself() {
        let ideal = ActuatorConfig { approach_s: 1e-3, ..ActuatorConfig::default() };
        let after = |config: ActuatorConfig, targets: &[f64]| {
            let mut drive = Actuator::new(config);
            targets.iter().for_each(|target| run(&mut drive, *target, 0.2));
            drive.applied_n()
        };
        for (config, targets, force) in [
            (ActuatorConfig { force_min_n: 20.0, ..ideal }, &[1.0][..], 20.0),
            (ActuatorConfig { force_min_n: 20.0, step_n: 0.8, ..ideal }, &[21.1], 20.8),
            (ActuatorConfig { step_n: 50.0, ..ideal }, &[30.0], 50.0),
            (ActuatorConfig { dead_band_n: 0.5, ..ideal }, &[5.0, 5.4], 5.0),
            (ActuatorConfig { dead_band_n: 0.5, ..ideal }, &[5.0, 5.6], 5.6),
            (ActuatorConfig { hysteresis: 0.1, ..ideal }, &[10.0], 9.0),
            (ActuatorConfig { hysteresis: 0.1, ..ideal }, &[10.0, 9.0], 9.0),
            (ActuatorConfig { hysteresis: 0.1, ..ideal }, &[10.0, 5.0], 5.5),
            (ActuatorConfig { delay_s: 0.25, ..ideal }, &[10.0, 10.0], 10.0),
            (ActuatorConfig { delay_s: 0.25, ..ideal }, &[10.0], 0.0),
            (ActuatorConfig { command_s: 0.7, ..ideal }, &[2.0, 7.0], 2.0),
        ] {
            let got = after(config, targets);
            assert!((got - force).abs() < 1e-6, "{config:?} {targets:?}: {got}");
        }
    }
}
