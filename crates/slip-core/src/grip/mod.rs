//! Controller of the grip force: the commanded force from slip evidence and force estimates.
//!
//! ```text
//! Open --grasp()--> Closing --trial force reached--> Settling --settle_ms--> Holding <--> Slipping
//!                Holding, Slipping --no usable slip sensor--> Fault --one again--> Holding
//!                Holding, Slipping --no touch for lost_ms--> Lost --touch--> Settling
//!                any --release()--> Released --close_again()--> Open
//! ```
//!
//! `docs/control.md` has every transition with its condition.
//!
//! On a slip the reflex raises the force at once by [`GripConfig::reflex_step`]. Where a moved-distance sensor shows that nothing has moved yet,
//! that is all. As soon as there is an estimate it takes over: what the load so far needs is what the measured force should become, and the
//! command leads it by what is missing. Without an estimate the force grows exponentially as long as
//! the slip shows. After the slip the force falls slowly to what the slip has shown, and then, until it just slips, to what is really needed.
//!
//! The command never exceeds `f_max_n` or `fragile_n`, never rises faster than `slew_n_s` of host time, and rises only while closing to the trial
//! force, on slip evidence that is not older than 20 ms, or towards a force that somebody asked for with [`GripController::at_least`]. No fault of
//! a sensor lowers it. Nothing that a sensor does opens the fingers.

mod config;
mod feeling;
mod input;
mod object;
mod response;

pub use config::GripConfig;
pub use input::{GripInput, Sliding, SlipNow, Trials};
pub use object::GripEvent;
pub use slip_msg::GripState;

use crate::drive::Drive;
use object::{Search, Touch};
use response::{HeldBy, Known, SlipResponse};

/// The force controller.
#[derive(Clone, Copy, Debug)]
pub struct GripController {
    config: GripConfig,
    state: GripState,
    command_n: f32,
    hold_n: f32,
    /// What the weight of the object needs by its slips, with its margin (N).
    weight_n: Option<f32>,
    search: Search,
    /// By how much the object comes back when it swings on its pads (m).
    swing_m: f32,
    /// Since the last reading of the moved distance (s).
    unmeasured_s: f32,
    /// Time for which the force may rise in this step (s).
    rise_s: f32,
    /// Whether the command is on its way back from an alarm in which nothing moved.
    ebbing: bool,
    /// Whether it is on its way back from a slip that only a drifting travel has shown.
    drifted: bool,
    /// Force that somebody asked for (N).
    least_n: f32,
    /// Force that the next object is known to be held with (N); 0 where nothing is known of it.
    expected_n: f32,
    /// Force that the object in hand is known to be held with (N); 0 where nothing is known of it.
    known_n: f32,
    /// Slips that were taken for pads which give way as the load comes.
    excused: u8,
    /// Whether the force that the object needs is known.
    finding: Finding,
    settle_s: f32,
    /// Measured force of fingers that close (N), and for how long it has stood there (s).
    stood_n: f32,
    stood_s: f32,
    drive: Drive,
    /// Since the last evidence of the slip (s).
    quiet_s: f32,
    /// Length of the slip so far (s), and whether it has just become too long.
    slip_s: f32,
    persists: bool,
    response: SlipResponse,
    moved_m: f32,
    trials: Trials,
    touch: Touch,
}

/// Whether the force that the object needs is known: the command is on its way to it, or has just arrived.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Finding {
    #[default]
    No,
    Coming,
    Arrived,
}

/// A light touch is so many times what counts as touch at least, as `least_force_n` is of `contact_n`.
const FELT: f32 = 2.0;
/// Fingers that touch have the trial force after this long (s), whatever is measured.
const REACHED_S: f32 = 0.3;
/// A force that has changed by no more than this share of the trial force for so long (s) does not get closer to it: a drive with friction.
const STANDS: f32 = 0.05;
const STANDS_S: f32 = 0.08;
/// Margin of a force that a memory states over the need.
const MARGIN: f32 = 1.2;
/// Above this share of what is expected a known object does not slip.
const AS_KNOWN: f32 = 0.8;
/// Trials of an object that has slipped once: the grasp is the first.
const FIRST_SLIP: u32 = 2;
/// So many slips in which it moved by no more than pads give way are none.
const EXCUSED: u8 = 3;
/// From touch on a known object is pressed with what is expected within this time (s).
const EXPECTED_IN_S: f32 = 0.15;
/// Without a reading of the moved distance for this long (s) it is not measured.
const UNMEASURED_S: f32 = 0.05;
/// Longest step in time the controller believes (s): after a gap the force must not jump.
const MAX_DT_S: f32 = 0.01;
/// A slip that lasts longer than this (s) is reported.
const PERSISTENT_S: f32 = 2.0;
/// Evidence of a slip that is older than this (s) raises nothing.
const FRESH_S: f32 = 0.02;

impl GripController {
    /// A controller with open fingers.
    #[must_use]
    pub fn new(config: GripConfig) -> Self {
        Self {
            config,
            state: GripState::Open,
            command_n: 0.0,
            hold_n: 0.0,
            weight_n: None,
            search: Search::default(),
            swing_m: 0.0,
            unmeasured_s: f32::INFINITY,
            rise_s: 0.0,
            ebbing: false,
            drifted: false,
            least_n: 0.0,
            expected_n: 0.0,
            known_n: 0.0,
            excused: 0,
            finding: Finding::No,
            settle_s: 0.0,
            stood_n: 0.0,
            stood_s: 0.0,
            drive: Drive::default(),
            quiet_s: 0.0,
            slip_s: 0.0,
            persists: false,
            response: SlipResponse::default(),
            moved_m: 0.0,
            trials: Trials::default(),
            touch: Touch::default(),
        }
    }

    /// A controller that goes on holding with `force_n` (N), which another one has commanded before it; at most the largest force. Below the
    /// trial force it goes on closing; a force that is not above 0 is no grip: the fingers are open.
    #[must_use]
    pub fn holding(config: GripConfig, force_n: f32) -> Self {
        let mut grip = Self::new(config);
        if force_n > 0.0 {
            grip.command_n = force_n.min(config.ceiling_n());
            grip.drive.hold_on(grip.command_n);
            grip.hold(grip.command_n);
            grip.trials.trials = 1;
            grip.touch = Touch::carried();
            if grip.command_n < config.trial_force_n {
                grip.state = GripState::Closing;
            }
        }
        grip
    }

    /// Holds with at least `force_n` (N) from now on, as far as the largest force allows; 0 takes that back. The rise is that of closing
    /// fingers. A force below 0 or not a number changes nothing.
    pub fn at_least(&mut self, force_n: f32) {
        if force_n >= 0.0 {
            if self.is_requested() && self.may_search_below(self.command_n) {
                // What was asked for has been tried, and less has not.
                self.hold_n = self.command_n;
            }
            self.least_n = force_n.min(self.config.ceiling_n());
        }
    }

    /// Expects an object that is known to be held with `force_n` (N), with its margin: the fingers close to that force instead of the
    /// trial force, and its weight counts as known in its slips. It stands for every grasp until another one is expected; 0 is an object
    /// of which nothing is known. What is in hand already is not concerned. A force below 0 or not a number changes nothing.
    pub fn expect(&mut self, force_n: f32) {
        if force_n >= 0.0 {
            self.expected_n = force_n.min(self.config.ceiling_n());
        }
    }

    /// Lets go of the object, until [`GripController::close_again`].
    pub fn release(&mut self) {
        self.state = GripState::Released;
        self.command_n = 0.0;
        self.hold_n = 0.0;
        self.forget();
        self.search = Search::default();
        self.touch = Touch::default();
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
            self.touch = Touch::default();
            self.trials = Trials { trials: 1, moved_m: 0.0 };
            self.forget();
            self.settle_s = 0.0;
            let held = applied_n.filter(|force| *force > self.config.contact_n);
            // What others have gripped may be held for a reason.
            self.search = if held.is_some() { Search::default() } else { self.begin_search() };
            self.command_n = held.map_or(0.0, |force| force.min(self.config.ceiling_n()));
            self.drive.close(self.command_n);
        }
    }

    /// What the controller is doing.
    #[must_use]
    #[inline]
    pub fn state(&self) -> GripState {
        match self.state {
            GripState::Holding if self.touch.is_lost() => GripState::Lost,
            state => state,
        }
    }

    /// Whether the object was lost and is not touched again, whatever the sensors are worth now.
    pub(crate) fn has_lost(&self) -> bool {
        self.touch.is_lost() && matches!(self.state, GripState::Holding | GripState::Fault)
    }

    /// The commanded force (N).
    #[must_use]
    #[inline]
    pub fn command_n(&self) -> f32 {
        self.command_n
    }

    /// What the last step found out about the object in hand.
    #[must_use]
    #[inline]
    pub fn event(&self) -> Option<GripEvent> {
        if self.persists {
            Some(GripEvent::Persistent)
        } else if self.finding == Finding::Arrived {
            let limited = self.command_n >= self.config.ceiling_n();
            Some(if limited { GripEvent::Limited } else { GripEvent::Found })
        } else {
            self.touch.event()
        }
    }

    /// The drive of the fingers, as far as it is known.
    #[must_use]
    pub fn drive(&self) -> &Drive {
        &self.drive
    }

    pub(crate) fn drive_mut(&mut self) -> &mut Drive {
        &mut self.drive
    }

    /// What the object in hand is known to need (N), where it is known.
    #[must_use]
    pub fn known_n(&self) -> Option<f32> {
        Some(self.known_n / MARGIN).filter(|known_n| *known_n > 0.0)
    }

    /// The largest force that may be commanded (N).
    #[must_use]
    pub fn ceiling_n(&self) -> f32 {
        self.config.ceiling_n()
    }

    /// Whether less and less force is tried.
    #[must_use]
    pub fn is_searching(&self) -> bool {
        self.state == GripState::Holding && self.searches()
    }

    /// How the object in hand was tried so far.
    #[must_use]
    pub fn trials(&self) -> Trials {
        Trials { moved_m: self.trials.moved_m + self.moved_m, ..self.trials }
    }

    /// Whether the command stays as it is for as long as there is no slip, the stylus can be trusted, and touch neither comes nor goes.
    #[must_use]
    #[inline]
    pub fn is_steady(&self) -> bool {
        // What was let go, lost or never there waits for a client or for touch.
        match self.state {
            GripState::Released => self.is_travel_settled(),
            GripState::Holding => self.touch.is_lost() || self.is_kept(),
            GripState::Closing => {
                self.touch.is_empty() && self.presses_lightly() && self.is_travel_settled()
            }
            _ => false,
        }
    }

    /// Whether fingers without touch press as they will until there is some.
    fn presses_lightly(&self) -> bool {
        let trial_n = self.trial_n();
        (self.light_n(self.search.touch_n())..trial_n).contains(&self.command_n)
    }

    /// Whether it takes another sample to change what is known of the moved distance: that it is measured, or that it is not.
    fn is_travel_settled(&self) -> bool {
        self.unmeasured_s == 0.0 || self.unmeasured_s >= UNMEASURED_S
    }

    /// Force of a light touch (N), where `touch_n` (N) counts as touch: a noisy sensor feels no less.
    fn light_n(&self, touch_n: f32) -> f32 {
        self.config.least_force_n.max(FELT * touch_n)
    }

    /// Whether an object is held with what it is to be held with, and no less is tried.
    fn is_kept(&self) -> bool {
        self.command_n <= self.hold_n.max(self.least_n)
            && self.command_n >= self.least_n
            && self.touch.is_settled()
            && !self.searches()
            && self.finding != Finding::Coming
    }

    /// Whether a sample with or without a reading of the moved distance would change what a controller at rest knows.
    #[must_use]
    #[inline]
    pub fn follows_travel(&self, measured: bool) -> bool {
        let known = self.unmeasured_s < UNMEASURED_S;
        let runs = matches!(self.state, GripState::Closing | GripState::Released);
        if measured { !known } else { known && runs }
    }

    /// The command after the next sample (N), from 0 to the largest force.
    #[inline]
    pub fn step(&mut self, input: &GripInput) -> f32 {
        let dt_s = if input.dt_s >= 0.0 { input.dt_s.min(MAX_DT_S) } else { 0.0 };
        self.act(dt_s, input);
        // What stays has arrived: at rest no sample need be looked at for it.
        if self.is_steady() {
            self.drive.hold_on(self.command_n);
        } else {
            self.drive.follow(self.command_n, dt_s);
        }
        self.command_n
    }

    fn act(&mut self, dt_s: f32, input: &GripInput) {
        self.rise_s =
            input.rise_s.map_or(dt_s, |rise_s| if rise_s >= 0.0 { rise_s.min(dt_s) } else { 0.0 });
        self.touch.begin(input.touching);
        self.search.feel(input.touch_n);
        self.persists = false;
        if self.finding == Finding::Arrived {
            self.finding = Finding::No;
        }
        self.unmeasured_s = if input.travel { 0.0 } else { self.unmeasured_s + dt_s };
        if !input.healthy {
            self.hold_blindly(input);
            return;
        }
        if self.feel_object(dt_s) {
            return;
        }
        match self.state {
            GripState::Open
            | GripState::Released
            | GripState::Observing
            | GripState::Lost
            | GripState::Other(_) => {}
            GripState::Closing => self.close(dt_s, input),
            GripState::Settling => self.settle(dt_s, input),
            GripState::Fault => self.state = GripState::Holding,
            GripState::Holding if input.slip != SlipNow::No => self.begin_slip(dt_s, input),
            GripState::Holding if self.command_n < self.least_n => {
                self.raise_towards(self.least_n, self.config.close_rate_n_s);
            }
            // What fails to show a slip must not lead to less force.
            GripState::Holding if input.stale || (input.impaired && !self.drifted) => {}
            // What a fault has raised, it does not keep.
            GripState::Holding if input.impaired => self.give_back(dt_s),
            GripState::Holding => self.ease(dt_s),
            GripState::Slipping if input.slip != SlipNow::No => self.brake(dt_s, input),
            GripState::Slipping => self.end_slip(),
        }
    }

    /// No slip sensor is usable: the force stays, unless the load on the fingers asks for more. Closing goes on where it stopped.
    fn hold_blindly(&mut self, input: &GripInput) {
        if matches!(self.state, GripState::Holding | GripState::Slipping) {
            self.leave_slip();
            self.state = GripState::Fault;
        }
        if let (GripState::Fault, Some(loaded_n), false) = (self.state, input.loaded_n, input.stale)
        {
            self.raise_towards(loaded_n, self.config.slew_n_s);
            self.hold_n = self.hold_n.max(self.command_n.min(loaded_n));
        }
    }

    /// Watches whether there is an object. Where it is gone nothing slips and nothing rises; `true` states that this was the step.
    fn feel_object(&mut self, dt_s: f32) -> bool {
        match self.state {
            GripState::Closing => {
                let pressing = self.command_n >= self.config.least_force_n;
                self.touch.close(pressing, dt_s);
            }
            GripState::Settling => self.touch.settle(),
            GripState::Holding | GripState::Slipping => {
                match self.touch.hold(1e-3 * self.config.lost_ms, dt_s) {
                    Some(GripEvent::Lost) => {
                        self.leave_slip();
                        self.hold(self.command_n);
                    }
                    Some(GripEvent::Regrasped) => {
                        self.trials = Trials { trials: 1, moved_m: 0.0 };
                        self.forget();
                        self.search = self.begin_search();
                        self.settle_s = 0.0;
                        self.state = GripState::Settling;
                        return true;
                    }
                    _ => {}
                }
                return self.touch.is_lost();
            }
            _ => {}
        }
        false
    }

    /// Down to what is to be held, and on with the search.
    fn ease(&mut self, dt_s: f32) {
        if self.searches() {
            self.hold_n = self.search.step(&self.config, self.hold_n, dt_s);
            // The end of the search: no less than this is tried.
            if !self.searches() {
                self.finding = Finding::Coming;
            }
        }
        self.give_back(dt_s);
    }

    /// What is known of the next object is where its search begins.
    fn begin_search(&self) -> Search {
        if self.known_n > 0.0 { Search::known() } else { Search::begin() }
    }

    /// Down to what is to be held.
    fn give_back(&mut self, dt_s: f32) {
        let fall = self.config.backoff_n_s * dt_s;
        let kept = self.hold_n.max(self.least_n).min(self.command_n);
        self.command_n = (self.command_n - fall).max(kept);
        self.ebbing &= self.command_n > kept;
        if self.finding == Finding::Coming && self.command_n <= kept {
            // What somebody asked for shows nothing.
            self.finding = if kept > self.least_n { Finding::Arrived } else { Finding::No };
        }
    }

    /// Nothing is known of the object in hand but what is expected of it.
    fn forget(&mut self) {
        self.known_n = self.expected_n;
        self.weight_n = (self.known_n > 0.0).then_some(self.known_n);
        (self.finding, self.excused) = (Finding::No, 0);
        self.swing_m = 0.0;
        self.ebbing = false;
    }

    fn hold(&mut self, force_n: f32) {
        self.hold_n = force_n;
        self.state = GripState::Holding;
    }

    /// Where the command rises but for a slip.
    fn raise_towards(&mut self, target_n: f32, rate_n_s: f32) {
        let reach_n = rate_n_s.min(self.config.slew_n_s) * self.rise_s;
        let limit = (self.command_n + reach_n).min(self.config.ceiling_n());
        self.command_n = self.command_n.max(target_n.min(limit));
    }

    /// The force that the fingers close to (N).
    fn trial_n(&self) -> f32 {
        let known_n = Some(self.known_n).filter(|known_n| *known_n > 0.0);
        let trial_n =
            known_n.map_or(self.config.trial_force_n, |n| n.max(self.config.least_force_n));
        trial_n.min(self.config.ceiling_n())
    }

    /// A light touch first, then up to the trial force.
    fn close(&mut self, dt_s: f32, input: &GripInput) {
        let trial_n = self.trial_n();
        let light_n = self.light_n(input.touch_n);
        let goal_n = if input.touching { trial_n } else { light_n.min(trial_n) };
        let rises = self.command_n < trial_n;
        let known_n_s = if input.touching { self.known_n / EXPECTED_IN_S } else { 0.0 };
        self.raise_towards(goal_n, self.config.close_rate_n_s.max(known_n_s));
        if self.command_n < trial_n {
            return;
        }
        self.drive.settle(input.applied_n, dt_s);
        if rises && input.touching {
            self.drive.risen(input.applied_n);
        } else if rises {
            self.drive.unseen();
        }
        self.settle_s = if input.touching { self.settle_s + dt_s } else { 0.0 };
        // A sensor that shows too little, or a gripper that cannot do more, must not leave the object unwatched.
        let waited = self.settle_s >= REACHED_S || self.stands(input.applied_n, trial_n, dt_s);
        if waited || input.applied_n.is_none_or(|force| force >= 0.8 * trial_n) {
            (self.settle_s, self.stood_s) = (0.0, 0.0);
            self.state = GripState::Settling;
        }
    }

    /// Whether the measured force of fingers that touch gets no closer to the trial force (N).
    fn stands(&mut self, applied_n: Option<f32>, trial_n: f32, dt_s: f32) -> bool {
        let Some(force_n) = applied_n.filter(|_| self.settle_s > 0.0) else {
            self.stood_s = 0.0;
            return false;
        };
        if (force_n - self.stood_n).abs() > STANDS * trial_n {
            (self.stood_n, self.stood_s) = (force_n, 0.0);
        }
        self.stood_s += dt_s;
        self.stood_s >= STANDS_S
    }

    fn settle(&mut self, dt_s: f32, input: &GripInput) {
        self.settle_s += dt_s;
        self.drive.settle(input.applied_n, dt_s);
        if self.settle_s >= 1e-3 * self.config.settle_ms {
            self.drive.settled(input.applied_n, input.age_s, self.config.close_rate_n_s);
            self.hold(self.command_n);
        }
    }

    /// Whether it is held as somebody asked for.
    fn is_requested(&self) -> bool {
        self.state == GripState::Holding && self.least_n > 0.0 && self.command_n <= self.least_n
    }

    /// Whether it is held with about what it is known to need, and has not shown that it needs more.
    fn is_held_as_known(&self) -> bool {
        let untried = self.trials.trials <= 1 && self.known_n > 0.0;
        untried && self.excused < EXCUSED && self.command_n >= AS_KNOWN * self.known_n
    }

    /// Whether less than `force_n` (N) may be tried. Where nothing shows how an object slides it costs too much to let it.
    fn may_search_below(&self, force_n: f32) -> bool {
        self.unmeasured_s < UNMEASURED_S && self.search.goes_on(&self.config, force_n)
    }

    /// Whether less force is to be tried.
    fn searches(&self) -> bool {
        !self.is_requested() && self.may_search_below(self.hold_n)
    }

    fn begin_slip(&mut self, dt_s: f32, input: &GripInput) {
        let held_by = if self.is_requested() {
            HeldBy::Request
        } else if self.is_held_as_known() {
            HeldBy::Memory
        } else if self.searches() {
            HeldBy::Search
        } else {
            HeldBy::Slips
        };
        let known = Known {
            weight_n: self.weight_n,
            held_by,
            ebbing: self.ebbing,
            loaded: self.search.is_loaded(),
            swing_m: self.swing_m,
            gives: self.excused < EXCUSED,
        };
        self.response = SlipResponse::begin(&self.config, self.command_n, self.hold_n, &known);
        if input.felt.is_some_and(|felt| !felt.moves) {
            self.response.wait();
        }
        self.drive.begin_answer();
        self.state = GripState::Slipping;
        self.quiet_s = if input.stale { f32::INFINITY } else { 0.0 };
        self.slip_s = 0.0;
        self.moved_m = 0.0;
        self.trials.trials = self.trials.trials.saturating_add(1);
        self.press(dt_s, input);
    }

    fn brake(&mut self, dt_s: f32, input: &GripInput) {
        self.moved_m = input.moved_m.map_or(self.moved_m, |moved| self.moved_m.max(moved));
        let evident = input.slip == SlipNow::Evident || input.estimate.is_some();
        let evident = evident && !input.stale;
        self.persists = self.slip_s < PERSISTENT_S && self.slip_s + dt_s >= PERSISTENT_S;
        self.slip_s += dt_s;
        self.quiet_s = if evident { 0.0 } else { self.quiet_s + dt_s };
        self.drive.answer(input.applied_n, dt_s);
        self.response.follow(&self.config, input, &self.drive, dt_s, self.rise_s);
        self.press(dt_s, input);
    }

    /// Towards the target of the slip, within the slew. Old evidence raises nothing; what the command leads by falls with what is missing.
    fn press(&mut self, dt_s: f32, input: &GripInput) {
        let wanted_n = self.response.command_n(&self.config, input.applied_n, &self.drive);
        if wanted_n > self.command_n {
            if self.quiet_s <= FRESH_S && !input.stale {
                let reach_n = self.config.slew_n_s * self.rise_s;
                self.command_n = wanted_n.min(self.command_n + reach_n);
            }
        } else {
            self.command_n = wanted_n.max(self.command_n - self.config.slew_n_s * dt_s);
        }
    }

    /// The slip, if there is one, is not answered any longer. The command stays: no fault lowers the force.
    fn leave_slip(&mut self) {
        if self.state == GripState::Slipping {
            self.end_moving();
            self.hold_n = self.response.left_n().min(self.command_n);
            self.drifted = self.response.drifted();
            self.ebbing = self.command_n > self.hold_n;
        }
    }

    /// What the object moved in the slip that went on counts as past.
    fn end_moving(&mut self) {
        self.trials.moved_m += self.moved_m;
        self.moved_m = 0.0;
    }

    /// The slip has ended: what is the force to hold with?
    fn end_slip(&mut self) {
        self.end_moving();
        self.swing_m = self.response.swing_m();
        self.drifted = self.response.drifted();
        let believed = self.response.is_believed(self.search.believes(&self.config));
        let hold_n = self.response.hold_n(&self.config, believed);
        self.ebbing = !believed;
        if believed {
            self.learn(hold_n);
        } else {
            self.excused = self.excused.saturating_add(1);
            // Nothing has moved: an alarm, not a trial.
            self.trials.trials = self.trials.trials.saturating_sub(1).max(1);
        }
        self.hold(hold_n);
    }

    /// A slip that `hold_n` (N) has stopped shows what the object needs, unless it was hit or pulled. A known object that moves and needs more from the
    /// start is hit, or is another one: its weight is unknown, and the search goes on.
    fn learn(&mut self, hold_n: f32) {
        let more = self.response.was_more_than_weight(hold_n);
        let first = self.known_n > 0.0 && self.trials.trials == FIRST_SLIP;
        let anew = more && first && self.response.is_confirmed();
        if anew && self.may_search_below(hold_n) {
            self.weight_n = None;
            return;
        }
        self.weight_n = self.response.weight_n();
        self.search.found(self.response.least_n());
        let goes_on = self.may_search_below(hold_n);
        self.finding = if goes_on || (more && !anew) { Finding::No } else { Finding::Coming };
    }
}

#[cfg(test)]
mod tests;
