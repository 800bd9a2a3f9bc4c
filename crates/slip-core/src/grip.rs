//! Slip evidence and force estimates in, the commanded grip force out.
//!
//! ```text
//! Open --grasp()--> Closing --trial force reached--> Settling --settle_ms--> Holding <--> Slipping
//!                Holding, Slipping --sensor not good--> Fault --good again--> Holding
//!                any --release()--> Released --close_again()--> Open
//! ```
//!
//! On a slip the reflex raises the force at once by [`GripConfig::reflex_step`] and, while the slip goes
//! on, exponentially with [`GripConfig::reflex_tau_ms`] or [`GripConfig::measured_tau_ms`]; where a moved-distance sensor says that nothing
//! has moved yet, the first step is all. As soon as there is an estimate it takes over: braking at
//! `brake_gain` times the estimate until the slip ends, then falling slowly to the estimate itself.
//! The command never exceeds `f_max_n`, never rises faster than `slew_n_s`, and rises only while closing
//! to the trial force, on slip evidence from a good sensor, or towards a force that somebody asked for with [`GripController::at_least`].

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
    /// Force of the first, light grasp (N).
    pub trial_force_n: f32,
    /// Fastest rise of the command (N/s).
    pub slew_n_s: f32,
    /// Rise while the fingers close (N/s).
    pub close_rate_n_s: f32,
    /// Fall towards the estimate after a slip (N/s).
    pub backoff_n_s: f32,
    /// Measured force that counts as touch (N).
    pub contact_n: f32,
    /// Wait between reaching the trial force and watching for slip (ms).
    pub settle_ms: f32,
    /// Immediate rise on a slip, relative to the force at that moment.
    pub reflex_step: f32,
    /// Time in which the reflex raises the force by a factor e where no sensor measures the slip (ms).
    pub reflex_tau_ms: f32,
    /// The same where the moved distance is measured (ms): a fast slip has an estimate within 10 ms, and a slow one
    /// lacks little force.
    pub measured_tau_ms: f32,
    /// Force while braking a slip over the estimate.
    pub brake_gain: f32,
    /// Moved distance that confirms a slip where a sensor measures it (m).
    pub confirm_m: f32,
}

impl Default for GripConfig {
    fn default() -> Self {
        Self {
            f_max_n: 60.0,
            trial_force_n: 2.0,
            slew_n_s: 1000.0,
            close_rate_n_s: 20.0,
            backoff_n_s: 20.0,
            contact_n: 0.3,
            settle_ms: 50.0,
            reflex_step: 0.1,
            reflex_tau_ms: 20.0,
            measured_tau_ms: 80.0,
            brake_gain: 1.25,
            confirm_m: 2e-5,
        }
    }
}

/// What the controller is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GripState {
    /// Fingers open, no force.
    #[default]
    Open,
    /// The force rises to the trial force.
    Closing,
    /// The trial force stands; contact transients fade.
    Settling,
    /// An object is held.
    Holding,
    /// A slip is being stopped.
    Slipping,
    /// The stylus cannot be trusted: the force stays as it is.
    Fault,
    /// Told to let go: no force, whatever slips.
    Released,
}

/// A slip as the controller sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SlipNow {
    /// There is none.
    #[default]
    No,
    /// The signal is back below the threshold, the release time runs.
    Fading,
    /// The signal is above the threshold.
    Evident,
}

/// What the controller is told with each sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GripInput {
    /// Time since the sample before (s).
    pub dt_s: f32,
    /// The slip as of this sample.
    pub slip: SlipNow,
    /// Distance moved since the slip began (m); `None` where no sensor tells.
    pub moved_m: Option<f32>,
    /// Estimate of the adequate force from this slip (N), newest evidence.
    pub estimate_n: Option<f32>,
    /// Measured normal force (N).
    pub applied_n: Option<f32>,
    /// Whether the stylus can be trusted.
    pub healthy: bool,
}

/// The force controller.
#[derive(Clone, Copy, Debug)]
pub struct GripController {
    config: GripConfig,
    state: GripState,
    command_n: f32,
    hold_n: f32,
    /// Force that somebody asked for (N).
    least_n: f32,
    settle_s: f32,
    slip: SlipGrip,
}

/// Memory of the slip that goes on.
#[derive(Clone, Copy, Debug, Default)]
struct SlipGrip {
    base_n: f32,
    hold_before_n: f32,
    confirmed: bool,
    estimate_n: Option<f32>,
}

/// Longest step in time the controller believes (s): after a gap the force must not jump.
const MAX_DT_S: f32 = 0.01;

impl GripController {
    /// A controller with open fingers.
    #[must_use]
    pub fn new(config: GripConfig) -> Self {
        Self {
            config,
            state: GripState::Open,
            command_n: 0.0,
            hold_n: 0.0,
            least_n: 0.0,
            settle_s: 0.0,
            slip: SlipGrip::default(),
        }
    }

    /// A controller that goes on holding with `force_n` (N), which another one has commanded before it; at most `f_max_n`. Below the
    /// trial force it goes on closing; a force that is not above 0 is no grip: the fingers are open.
    #[must_use]
    pub fn holding(config: GripConfig, force_n: f32) -> Self {
        let mut grip = Self::new(config);
        if force_n > 0.0 {
            grip.command_n = force_n.min(config.f_max_n);
            grip.hold(grip.command_n);
            if grip.command_n < config.trial_force_n {
                grip.state = GripState::Closing;
            }
        }
        grip
    }

    /// Holds with at least `force_n` (N) from now on, as far as `f_max_n` allows; 0 takes that back. The rise is that of closing fingers.
    /// A force below 0 or not a number changes nothing.
    pub fn at_least(&mut self, force_n: f32) {
        if force_n >= 0.0 {
            self.least_n = force_n.min(self.config.f_max_n);
        }
    }

    /// Lets go of the object, until [`GripController::close_again`].
    pub fn release(&mut self) {
        self.state = GripState::Released;
        self.command_n = 0.0;
        self.hold_n = 0.0;
    }

    /// Ends a release: the fingers may be closed again.
    pub fn close_again(&mut self) {
        if self.state == GripState::Released {
            self.state = GripState::Open;
        }
    }

    /// Closes the fingers on the object. Does nothing unless the controller is open.
    ///
    /// Fingers that already press with `applied_n` (N), for example after a restart of the program, start from
    /// that force: what is held must not fall.
    pub fn grasp(&mut self, applied_n: Option<f32>) {
        if self.state == GripState::Open {
            self.state = GripState::Closing;
            let held = applied_n.filter(|force| *force > self.config.contact_n);
            self.command_n = held.map_or(0.0, |force| force.min(self.config.f_max_n));
        }
    }

    /// What the controller is doing.
    #[must_use]
    #[inline]
    pub fn state(&self) -> GripState {
        self.state
    }

    /// The commanded force (N).
    #[must_use]
    #[inline]
    pub fn command_n(&self) -> f32 {
        self.command_n
    }

    /// Whether the command stays as it is for as long as there is no slip and the stylus can be trusted.
    #[must_use]
    #[inline]
    pub fn is_steady(&self) -> bool {
        self.state == GripState::Holding
            && self.command_n <= self.hold_n.max(self.least_n)
            && self.command_n >= self.least_n
    }

    /// The command after the next sample (N), within [0, `f_max_n`].
    #[inline]
    pub fn step(&mut self, input: &GripInput) -> f32 {
        let dt_s = if input.dt_s >= 0.0 { input.dt_s.min(MAX_DT_S) } else { 0.0 };
        if !input.healthy {
            // Closing goes on where it stopped.
            if matches!(self.state, GripState::Holding | GripState::Slipping) {
                self.state = GripState::Fault;
            }
            return self.command_n;
        }
        match self.state {
            GripState::Open | GripState::Released => {}
            GripState::Closing => self.close(dt_s, input.applied_n),
            GripState::Settling => self.settle(dt_s),
            GripState::Fault => self.hold(self.command_n),
            GripState::Holding if input.slip != SlipNow::No => self.begin_slip(dt_s),
            GripState::Holding if self.command_n < self.least_n => {
                self.raise_towards(self.least_n, self.config.close_rate_n_s, dt_s);
            }
            GripState::Holding => {
                let fall = self.config.backoff_n_s * dt_s;
                let kept = self.hold_n.max(self.least_n).min(self.command_n);
                self.command_n = (self.command_n - fall).max(kept);
            }
            GripState::Slipping if input.slip != SlipNow::No => self.brake(dt_s, input),
            GripState::Slipping => self.end_slip(),
        }
        self.command_n
    }

    fn hold(&mut self, force_n: f32) {
        self.hold_n = force_n;
        self.state = GripState::Holding;
    }

    /// The only place where the command rises.
    fn raise_towards(&mut self, target_n: f32, rate_n_s: f32, dt_s: f32) {
        let limit =
            (self.command_n + rate_n_s.min(self.config.slew_n_s) * dt_s).min(self.config.f_max_n);
        self.command_n = self.command_n.max(target_n.min(limit));
    }

    fn close(&mut self, dt_s: f32, applied_n: Option<f32>) {
        let trial_n = self.config.trial_force_n;
        self.raise_towards(trial_n, self.config.close_rate_n_s, dt_s);
        let reached = applied_n.is_none_or(|force| force >= 0.8 * trial_n);
        if self.command_n >= trial_n.min(self.config.f_max_n) && reached {
            self.settle_s = 0.0;
            self.state = GripState::Settling;
        }
    }

    fn settle(&mut self, dt_s: f32) {
        self.settle_s += dt_s;
        if self.settle_s >= 1e-3 * self.config.settle_ms {
            self.hold(self.command_n);
        }
    }

    fn begin_slip(&mut self, dt_s: f32) {
        self.slip = SlipGrip {
            base_n: self.command_n,
            hold_before_n: self.hold_n,
            confirmed: false,
            estimate_n: None,
        };
        self.state = GripState::Slipping;
        let target = self.command_n * (1.0 + self.config.reflex_step);
        self.raise_towards(target, self.config.slew_n_s, dt_s);
    }

    fn brake(&mut self, dt_s: f32, input: &GripInput) {
        self.slip.confirmed |= input.moved_m.is_none_or(|moved| moved >= self.config.confirm_m);
        if let Some(estimate) = input.estimate_n {
            self.slip.estimate_n = Some(estimate.max(0.0).min(self.config.f_max_n));
        }
        let step = self.slip.base_n * (1.0 + self.config.reflex_step);
        match self.slip.estimate_n {
            Some(estimate) if self.slip.confirmed => {
                self.raise_towards(estimate * self.config.brake_gain, self.config.slew_n_s, dt_s);
            }
            None if self.slip.confirmed
                && input.slip == SlipNow::Evident
                && self.command_n >= step =>
            {
                let tau_ms = match input.moved_m {
                    Some(_) => self.config.measured_tau_ms,
                    None => self.config.reflex_tau_ms,
                };
                let rate = self.command_n.max(1.0) / (1e-3 * tau_ms);
                self.raise_towards(self.config.f_max_n, rate, dt_s);
            }
            _ => self.raise_towards(step, self.config.slew_n_s, dt_s),
        }
    }

    /// The slip has ended: what is the force to hold with?
    fn end_slip(&mut self) {
        let hold_n = match self.slip.estimate_n {
            // The object slipped at `base_n`, so less than a step above it is not enough.
            Some(estimate) if self.slip.confirmed => {
                estimate.max(self.slip.base_n * (1.0 + self.config.reflex_step))
            }
            None if self.slip.confirmed => self.command_n,
            _ => self.slip.hold_before_n,
        };
        self.hold(hold_n);
    }
}

#[cfg(test)]
mod tests {
    use super::{GripConfig, GripController, GripInput, GripState, SlipNow};

    const DT_S: f32 = 1e-3;

    fn calm() -> GripInput {
        GripInput { dt_s: DT_S, healthy: true, applied_n: Some(2.0), ..GripInput::default() }
    }

    fn slipping(moved_m: f32, estimate_n: Option<f32>) -> GripInput {
        GripInput { slip: SlipNow::Evident, moved_m: Some(moved_m), estimate_n, ..calm() }
    }

    fn holding() -> GripController {
        let mut grip = GripController::new(GripConfig::default());
        grip.grasp(None);
        for _ in 0..300 {
            grip.step(&calm());
        }
        assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
        grip
    }

    #[test]
    fn nothing_moves_without_grasp() {
        let mut grip = GripController::new(GripConfig::default());
        for _ in 0..1000 {
            assert_eq!(grip.step(&slipping(1e-3, Some(10.0))), 0.0);
        }
    }

    #[test]
    fn a_wish_raises_within_the_limits_and_is_taken_back_slowly() {
        let mut grip = holding();
        for (wish, then) in [(10.0, 10.0), (f32::NAN, 10.0), (-3.0, 10.0), (1e9, 60.0)] {
            grip.at_least(wish);
            let before = grip.command_n();
            assert!(grip.step(&calm()) <= before + 20.0 * DT_S + 1e-4);
            for _ in 0..3000 {
                grip.step(&calm());
            }
            assert_eq!((grip.command_n(), grip.is_steady()), (then, true), "{wish}");
        }
        grip.at_least(0.0);
        assert!(!grip.is_steady());
        assert!(grip.step(&calm()) > 59.9);
        for _ in 0..3000 {
            grip.step(&calm());
        }
        assert_eq!((grip.command_n(), grip.is_steady()), (2.0, true));
    }

    #[test]
    fn a_release_holds_until_it_is_ended_whatever_slips() {
        let mut grip = holding();
        grip.release();
        for _ in 0..100 {
            grip.grasp(Some(5.0));
            assert_eq!(grip.step(&slipping(1e-3, Some(10.0))), 0.0);
        }
        assert_eq!(grip.state(), GripState::Released);
        grip.close_again();
        grip.grasp(None);
        for _ in 0..300 {
            grip.step(&calm());
        }
        assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
    }

    #[test]
    fn a_grip_is_carried_on_within_the_limit_and_nothing_is_no_grip() {
        for (carried, state, command_n) in [
            (7.0, GripState::Holding, 7.0),
            (1.0, GripState::Closing, 1.0 + 20.0 * DT_S),
            (1e6, GripState::Holding, 60.0),
            (0.0, GripState::Open, 0.0),
            (-2.0, GripState::Open, 0.0),
            (f32::NAN, GripState::Open, 0.0),
        ] {
            let mut grip = GripController::holding(GripConfig::default(), carried);
            assert_eq!((grip.state(), grip.step(&calm())), (state, command_n), "{carried}");
        }
    }

    #[test]
    fn an_object_that_is_held_already_stays_held() {
        let mut grip = GripController::new(GripConfig::default());
        grip.grasp(Some(12.0));
        for _ in 0..500 {
            assert_eq!(grip.step(&GripInput { applied_n: Some(12.0), ..calm() }), 12.0);
        }
        assert_eq!(grip.state(), GripState::Holding);
    }

    #[test]
    fn closing_waits_for_the_measured_force() {
        let mut grip = GripController::new(GripConfig::default());
        grip.grasp(None);
        for _ in 0..500 {
            grip.step(&GripInput { applied_n: Some(0.0), ..calm() });
        }
        assert_eq!((grip.state(), grip.command_n()), (GripState::Closing, 2.0));
    }

    #[test]
    fn the_estimate_takes_over_from_the_reflex_and_is_held_after_the_slip() {
        let mut grip = holding();
        assert!((grip.step(&slipping(0.0, None)) - 2.2).abs() < 1e-5, "a step of 10 %");
        for _ in 0..100 {
            assert!(grip.step(&slipping(1e-5, None)) < 2.21, "not confirmed: nothing moved");
        }
        for _ in 0..10 {
            grip.step(&slipping(1e-4, None));
        }
        let reflex = grip.command_n();
        assert!(reflex < 10.0 && reflex > 2.2, "{reflex}");
        for _ in 0..20 {
            grip.step(&slipping(1e-3, Some(8.0)));
        }
        assert!((grip.command_n() - 10.0).abs() < 1e-5, "brakes with 1.25 times the estimate");
        grip.step(&calm());
        assert_eq!(grip.state(), GripState::Holding);
        for _ in 0..200 {
            grip.step(&calm());
        }
        assert!((grip.command_n() - 8.0).abs() < 1e-5, "{}", grip.command_n());
    }

    #[test]
    fn without_an_estimate_the_reflex_grows_only_while_the_slip_shows() {
        let mut grip = holding();
        for _ in 0..20 {
            grip.step(&GripInput { moved_m: None, ..slipping(0.0, None) });
        }
        let grown = grip.command_n();
        assert!(grown > 4.0 && grown < 8.0, "{grown}");
        for _ in 0..20 {
            grip.step(&GripInput { slip: SlipNow::Fading, moved_m: None, ..calm() });
        }
        assert_eq!(grip.command_n(), grown);
        for _ in 0..500 {
            grip.step(&calm());
        }
        assert_eq!(grip.command_n(), grown, "what stopped the slip is kept");
    }

    #[test]
    fn an_alarm_without_movement_is_forgotten() {
        let mut grip = holding();
        for _ in 0..5 {
            grip.step(&slipping(0.0, None));
        }
        for _ in 0..100 {
            grip.step(&calm());
        }
        assert_eq!(grip.command_n(), 2.0);
    }

    #[test]
    fn a_bad_sensor_freezes_the_force() {
        let mut grip = holding();
        for _ in 0..100 {
            let force = grip.step(&GripInput { healthy: false, ..slipping(1.0, Some(50.0)) });
            assert_eq!(force, 2.0);
        }
        assert_eq!(grip.state(), GripState::Fault);
        grip.step(&calm());
        assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
    }

    #[test]
    fn a_bad_sensor_interrupts_the_closing() {
        let mut grip = GripController::new(GripConfig::default());
        grip.grasp(None);
        for _ in 0..20 {
            grip.step(&calm());
        }
        let reached = grip.command_n();
        for _ in 0..1000 {
            assert_eq!(grip.step(&GripInput { healthy: false, ..calm() }), reached);
        }
        for _ in 0..200 {
            grip.step(&calm());
        }
        assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
    }

    #[test]
    fn the_limit_stands() {
        let mut grip = holding();
        for _ in 0..1000 {
            grip.step(&slipping(1.0, Some(1e30)));
        }
        assert_eq!(grip.command_n(), 60.0);
    }
}
