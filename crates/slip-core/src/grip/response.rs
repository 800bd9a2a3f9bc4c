//! Response to evidence of a slip that goes on: the force that stops it and the force to hold with afterwards.

use super::{
    GripConfig, GripInput, Sliding, SlipNow,
    feeling::{FELT_ON_S, Feeling, Forces, Giving, Yielding},
};
use crate::{
    course::Passing,
    drive::Drive,
    estimate::{ForceEstimate, G_M_S2, KAPPA},
};

/// Estimates that the force to hold with is a mean of, at most.
const MEAN_OF: f32 = 5.0;
/// Of the force that has stopped a slip this share is kept.
const KEPT: f32 = 0.95;
/// An object that becomes faster for this long (s) although its weight is known may be another one.
const BELIEVED_S: f32 = 0.05;
/// What is known of the weight grows by no more than this factor in one slip: a blow is no weight.
const HEAVIER: f32 = 1.3;
/// A load of more than this times the weight is none of the weight.
const OVERLOAD: f32 = 1.25;
/// Where less and less is held until the object slips, the ratio of static and kinetic friction and the margin make the force that stops it up to so many
/// times the one that let it slip.
const BY_FRICTION: f32 = 1.6;
/// A slip under less than this share of what is needed began before the weight was there.
const EARLY: f32 = 0.7;
/// Over the reflex where the force falls until the object slips: where nothing slides by then, static friction of up to so much over that of sliding is
/// covered by both.
const SOUGHT: f32 = 1.11;
/// The first answer where such an object has slid before, and for how long (s) it is given time to slide: static friction gives way before anything
/// slides, and what is stopped at once shows nothing of the friction of sliding.
const GENTLY: f32 = 1.05;
const GENTLY_S: f32 = 8e-3;
/// Over the force that a known object is held with it needs so much more at least, where the stylus alone shows that it needs more.
const FELT: f32 = 1.05;
/// Of an estimate with its margin that was made while the weight was put on, at least this share is needed.
const ROUGHLY: f32 = 0.5;
/// Before it slides an object moves by what its pads shear under the load that friction holds (m/N): 100 N/mm and a friction of 0.45.
const SHEARS_M_N: f32 = 4.5e-6;
/// So many peaks and valleys pass on that way, where the stylus alone shows it.
const SHEAR_TURNS: f32 = 4.0;
/// An object that comes back by this much (m) swings on its pads.
const BACK_M: f32 = 6e-6;
/// A first estimate, which no other confirms, counts up to the reflex times this.
const FIRST: f32 = 1.25;
/// Without updates of how the object slides for this long (s) it does not.
const UNSEEN_S: f32 = 0.005;
/// An object that comes back further than this (m) does not swing: no pad is that soft, the sensor has jumped.
const MOST_SWING_M: f32 = 2e-4;
/// Estimates over which the growth of the load is judged.
const GROWTH_OF: usize = 4;
/// Time from one estimate to the next (s).
const ESTIMATES_EVERY_S: f32 = 1e-3;
/// An estimate that is older than this (s) has no state.
const ESTIMATE_LASTS_S: f32 = 0.01;
/// A target that has not risen for this long (s) is what the estimates ask for.
const STANDS_S: f32 = 0.01;
/// Where the moved distance is lost, one that is not older than this (s) still slows the growth.
const ESTIMATE_SERVES_S: f32 = 0.03;
/// Share of the target that counts as arrived.
const ARRIVED: f32 = 0.9;
/// Where the moved distance is not measured and the stylus shows that the object slows down, the force grows this many times more slowly.
const SLOWED: f32 = 2.5;
/// Growth with each peak and valley that the stylus passes, and the slowest growth as a share of the fastest.
const TURN: f32 = 0.3;
const SLOWEST: f32 = 0.25;
/// The force grows by e in no less than so many times what it takes until a force is felt, down to the slowest growth.
const FELT_AFTER: f32 = 2.0;
/// A surface of which no peak has passed for this long (s) is too smooth to count them.
const UNCOUNTED_S: f32 = 0.005;
/// For this long (s) an object slides on under the force that the estimates asked for before it contradicts them: how late its course is known.
const CONTRADICTED_S: f32 = 0.012;
/// Estimates that follow a load have stopped the object within this distance (m).
const FOLLOWS_M: f32 = 8e-3;
/// ... where the force follows within this time (s); later, in proportion.
const FOLLOWS_S: f32 = 0.02;
/// A slip that only one of stylus and travel shows raises the force by this factor at most, the travel one that is slower than
/// [`SLIDES_M_S`].
const UNDECIDED: f32 = 2.0;
/// What is faster than this (m/s) slides; pads that shear and swing are slower.
const SLIDES_M_S: f32 = 0.012;
/// What is slower slides where it goes on this far (m) without slowing down; no pad shears that far under a force that stands.
pub(super) const SLIDES_ON_M: f32 = 3e-4;
/// While an object slides on, the force grows by e in this many `measured_tau_ms` at least, whatever was estimated.
pub(super) const LEAST_TAUS: f32 = 4.0;
/// Where there is no estimate by then (s), there is none to wait for.
const ESTIMATED_BY_S: f32 = 0.015;
/// An object that falls freely doubles what is known of the force in about this time (s).
const FALLING_TAU_S: f32 = 0.02;

/// Why an object is held as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum HeldBy {
    /// By what its slips have shown.
    #[default]
    Slips,
    /// Less and less, until it slips.
    Search,
    /// As somebody asked for.
    Request,
    /// With what it is known to need.
    Memory,
}

/// What earlier slips have shown of the object.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    /// Whether the command is on its way back from an alarm in which nothing moved.
    pub(super) ebbing: bool,
    /// By how much the object comes back when it swings on its pads (m).
    pub(super) swing_m: f32,
    /// Whether it may not have slipped yet: its pads shear as its load comes.
    pub(super) gives: bool,
    /// What its weight needs, with the margin of the estimate (N).
    pub(super) weight_n: Option<f32>,
    /// Why it is held as it is.
    pub(super) held_by: HeldBy,
    /// Whether its load is there.
    pub(super) loaded: bool,
}

/// Memory of the slip that goes on.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "verdicts of one slip, each reached by itself")]
pub(super) struct SlipResponse {
    /// Command when the slip began (N).
    base_n: f32,
    /// What it is raised to at once; less is not enough afterwards (N).
    step_n: f32,
    /// Why it was held as it was.
    held_by: HeldBy,
    /// Whether it began on the way back from an alarm.
    ebbing: bool,
    /// What the object was held with before the slip (N).
    hold_before_n: f32,
    /// What the weight of the object needs by an earlier slip, with its margin (N).
    weight_n: Option<f32>,
    /// For how long the object has become faster and faster (s), and since when nothing states how it slides (s).
    falling_s: f32,
    unseen_s: f32,
    /// Whether the object was seen to move, where that is measured.
    confirmed: bool,
    /// The same since the object last came back.
    goes_on: bool,
    /// Furthest that the object has moved, where it was when it last came back, and by how much it comes back at most (m).
    furthest_m: f32,
    from_m: f32,
    swing_m: f32,
    /// By how much its pads may shear as its load comes (m).
    shear_m: f32,
    /// Whether it came back in this slip.
    swings: bool,
    /// Whether only pads give way; looked at where it is held with what it is known to need.
    giving: Giving,
    /// Whether more than the weight had to be held.
    overloaded: bool,
    /// Whether pads may be giving way.
    yielding: Yielding,
    /// What the load needed by the last reading of it (N).
    last_load_n: Option<f32>,
    /// Mean of the last estimates, with their margin (N).
    mean_n: Option<f32>,
    estimates: f32,
    /// The last estimates, oldest first (N).
    last_n: Option<[f32; GROWTH_OF]>,
    /// Whether the object was estimated again after a pause.
    resumed: bool,
    /// What the measured force should become (N); never falls.
    target_n: f32,
    /// What it is at least while the object slides on (N).
    envelope_n: f32,
    /// Since the target last rose, and since the last estimate (s).
    standing_s: f32,
    unconfirmed_s: f32,
    /// Since the slip began (s).
    slip_s: f32,
    /// What the stylus alone has said, and whether it is what answers now.
    feeling: Feeling,
    alone: bool,
    /// Whether the object slides on without slowing down, and since where (m).
    slides: bool,
    slid_from_m: f32,
    /// Where it was last fast or stood (m).
    slow_from_m: f32,
    /// Where the object last did what the estimates show (m), and whether it has contradicted them since.
    obeyed_m: f32,
    disobeyed_s: f32,
    refuted: bool,
    /// The most that the target may become (N), and whether what raised it was no movement.
    most_n: f32,
    drifted: bool,
    /// Whether a force that falls made it slip: the whole step follows where nothing is estimated soon.
    sought: bool,
}

impl SlipResponse {
    /// A slip that begins under `command_n`, while `hold_n` (N) was to be held.
    pub(super) fn begin(config: &GripConfig, command_n: f32, hold_n: f32, known: &Known) -> Self {
        // A force that is on its way back moves the pads, and alarms by that must not add up.
        let from_n = if known.ebbing { hold_n.min(command_n) } else { command_n };
        let sought = known.held_by == HeldBy::Search && !known.ebbing;
        let reflex = 1.0 + config.reflex_step;
        let step = if sought { SOUGHT * reflex } else { reflex };
        let first = match known.held_by {
            HeldBy::Memory => 1.0,
            _ if sought && known.loaded => GENTLY,
            _ => step,
        };
        let step_n = (step * from_n).max(command_n);
        let step_n = step_n.min(config.ceiling_n());
        Self {
            base_n: command_n,
            hold_before_n: hold_n,
            weight_n: known.weight_n,
            step_n,
            held_by: known.held_by,
            ebbing: known.ebbing,
            swing_m: known.swing_m,
            shear_m: if known.gives { SHEARS_M_N * command_n } else { 0.0 },
            target_n: (first * from_n).max(command_n).min(step_n),
            sought,
            envelope_n: from_n.min(config.ceiling_n()),
            most_n: config.ceiling_n(),
            ..Self::default()
        }
    }

    /// The alarm follows a stop so closely that pads may swing: nothing rises before the stylus shows that the object moves.
    pub(super) fn wait(&mut self) {
        (self.step_n, self.target_n) = (self.base_n, self.base_n);
    }

    /// What the weight of the object needs by all that is known now, with its margin (N).
    pub(super) fn weight_n(&self) -> Option<f32> {
        let mean_n = self.mean_n.filter(|_| self.confirmed && !self.refuted);
        match (self.weight_n, mean_n) {
            (Some(before_n), Some(mean_n)) => Some(mean_n.min(HEAVIER * before_n)),
            // What has stopped a slip too slow for an estimate is about what the weight needs.
            (before_n, mean_n) => mean_n.or(before_n).or(self.confirmed.then_some(self.target_n)),
        }
    }

    /// What the measured force should become (N).
    #[cfg(test)]
    pub(super) fn target_n(&self) -> f32 {
        self.target_n
    }

    /// Whether the object has moved.
    pub(super) fn is_confirmed(&self) -> bool {
        self.confirmed
    }

    /// Whether only a travel that drifts has shown this slip.
    pub(super) fn drifted(&self) -> bool {
        self.drifted
    }

    /// By how much the object comes back when it swings on its pads (m).
    pub(super) fn swing_m(&self) -> f32 {
        self.swing_m
    }

    /// Whether the slip shows what is needed; `searched` states that the search waits for one, moved or not. Pads give way when an object is lifted:
    /// what is held as somebody asked for, or with what it is known to need, slips only where more than that is needed. And the search does not wait for alarms on the way back from one.
    pub(super) fn is_believed(&self, searched: bool) -> bool {
        if self.drifted {
            return false;
        }
        let more = self.mean_n.is_some_and(|mean_n| mean_n > self.base_n);
        match self.held_by {
            HeldBy::Request => return self.confirmed && more,
            HeldBy::Memory => {
                let answered = match self.feeling.held_n() {
                    Some(held_n) => held_n > FELT * KAPPA * self.base_n,
                    None => self.target_n > self.step_n,
                };
                return self.confirmed && self.giving.has_slid() && (more || answered);
            }
            HeldBy::Slips | HeldBy::Search => {}
        }
        // What swings on its pads has not slipped.
        let alarmed = searched && self.held_by == HeldBy::Search && !self.ebbing && !self.swings;
        self.confirmed || (alarmed && self.target_n >= self.step_n)
    }

    /// What to hold with (N) where the slip was left before its end.
    pub(super) fn left_n(&self) -> f32 {
        if self.is_believed(false) { self.target_n } else { self.hold_before_n }
    }

    /// Takes what is new. `dt_s` and `rise_s`: time since the sample before, and time for which the force may rise. Pads give way as the load comes:
    /// an object that is held with what it is known to need gets more only where it slides further than that.
    pub(super) fn follow(
        &mut self,
        config: &GripConfig,
        input: &GripInput,
        drive: &Drive,
        dt_s: f32,
        rise_s: f32,
    ) {
        let before_n = self.target_n;
        self.answer(config, input, drive, dt_s, rise_s);
        if self.held_by == HeldBy::Memory {
            let (turns, slides_s) = (self.feeling.turns(), self.slides.then_some(self.slip_s));
            self.giving.follow(input, self.furthest_m, turns, slides_s, dt_s);
            if !self.giving.has_slid() {
                self.target_n = before_n;
            }
        }
    }

    fn answer(
        &mut self,
        config: &GripConfig,
        input: &GripInput,
        drive: &Drive,
        dt_s: f32,
        rise_s: f32,
    ) {
        self.confirm(config, input);
        self.watch(input.sliding, dt_s);
        self.unconfirmed_s += dt_s;
        self.standing_s += dt_s;
        self.slip_s += dt_s;
        let command_n = drive.commanded_n();
        self.drifted |= input.drifts;
        if input.stale || self.drifted {
            return;
        }
        let creeps = input.motion.is_none_or(|motion| motion.speed_m_s < SLIDES_M_S);
        let alone_n = input.alone_n.filter(|_| creeps);
        self.most_n = UNDECIDED * alone_n.unwrap_or(f32::INFINITY);
        self.alone = input.moved_m.is_none() && input.felt.is_some();
        if let (None, Some(felt)) = (input.moved_m, &input.felt) {
            let before_n = self.target_n;
            let forces = Forces {
                target_n: before_n,
                applied_n: input.applied_n.unwrap_or(command_n),
                hold_n: self.hold_before_n,
            };
            self.target_n = self.feeling.target_n(config, felt, forces, dt_s, rise_s);
            let far = self.feeling.turns() >= SHEAR_TURNS || self.feeling.moved_s() >= FELT_ON_S;
            self.confirmed |= felt.moves && (far || !self.shears(config));
            if !self.confirmed {
                self.target_n = self.target_n.min(self.step_n).max(before_n);
            }
            return;
        }
        if let Some(wanted_n) = self.wanted_n(config, input, drive).filter(|_| self.goes_on) {
            self.aim(config, config.brake_gain * wanted_n);
        }
        self.watch_motion(input);
        self.judge(input, drive, dt_s);
        if self.sought && !self.confirmed && self.mean_n.is_none() && self.slip_s >= GENTLY_S {
            self.aim(config, self.step_n);
        }
        let evident = input.slip == SlipNow::Evident && self.goes_on;
        if evident && self.slides {
            // The least answer to an object that slides on, whatever was estimated.
            self.envelope_n +=
                self.envelope_n.max(1.0) * rise_s / (LEAST_TAUS * 1e-3 * config.measured_tau_ms);
            self.aim(config, self.envelope_n);
        }
        if evident && command_n >= self.target_n {
            let rate = self.growth_per_s(config, input, drive.delayed_s(input.age_s));
            let grown_n = self.target_n + self.target_n.max(1.0) * rise_s * rate;
            let most_n = if input.undecided { UNDECIDED * self.base_n } else { f32::INFINITY };
            if rate > 0.0 {
                self.aim(config, grown_n.min(most_n));
            }
        }
    }

    /// What estimate and load ask for (N), with each new one.
    fn wanted_n(&mut self, config: &GripConfig, input: &GripInput, drive: &Drive) -> Option<f32> {
        if input.estimate.is_none() && input.sliding.is_none() {
            return None;
        }
        let estimate_n = input.estimate.filter(is_usable).map(|estimate| {
            let (agreed_n, growth_n) = self.learn(with_margin(&estimate, config));
            self.unconfirmed_s = 0.0;
            // The estimate is some milliseconds old, and a load that has grown goes on growing. What has stood already rises again by a load that grows by
            // dF + n da of the need n = F / (1 - a), which is (1 - a) dn.
            let sliding = input.sliding.filter(|_| self.resumed);
            let share = 1.0 - sliding.map_or(0.0, |sliding| sliding.acceleration_g.clamp(0.0, 1.0));
            let noise_n = core::f32::consts::SQRT_2 * estimate.sigma_n;
            agreed_n + drive.beyond(agreed_n, config.ahead * (share * growth_n - noise_n))
        });
        let most_n = input
            .moved_m
            .map_or(f32::INFINITY, |moved_m| self.yielding.most_n(input.sliding.as_ref(), moved_m));
        let estimate_n = estimate_n.map(|estimate_n| estimate_n.min(most_n));
        let load_n = input.sliding.and_then(|sliding| self.load_n(&sliding));
        let load_n = load_n.map(|load_n| {
            load_n.min(self.last_load_n.replace(load_n).unwrap_or(FIRST * self.step_n))
        });
        if let (Some(load_n), Some(weight_n)) = (load_n, self.weight_n) {
            self.overloaded |= load_n > OVERLOAD * weight_n;
        }
        match (estimate_n, load_n) {
            (Some(estimate_n), Some(load_n)) => Some(estimate_n.min(load_n)),
            (estimate_n, load_n) => estimate_n.or(load_n),
        }
    }

    /// Whether the object slides on without slowing down, by the moved distance; where that is not measured, whether the slip shows.
    fn watch_motion(&mut self, input: &GripInput) {
        let Some(moved_m) = input.moved_m else {
            self.slides = true;
            return;
        };
        let motion = input.motion.filter(|motion| motion.slides(input.travel_sigma_m));
        let fast = motion.is_some_and(|motion| motion.speed_m_s >= SLIDES_M_S);
        let slows = motion.is_none_or(|motion| motion.slows());
        // A slow object that slows down stops before it has gone that far.
        if fast || motion.is_none() {
            self.slow_from_m = moved_m;
        }
        let on = motion.is_some() && moved_m - self.slow_from_m >= SLIDES_ON_M;
        self.slides = (fast && !slows) || on;
        if !self.slides {
            self.slid_from_m = moved_m;
        }
    }

    /// Judges the estimate by what the object does under the force it asked for: one that goes on all the same contradicts it.
    fn judge(&mut self, input: &GripInput, drive: &Drive, dt_s: f32) {
        let Some(moved_m) = input.moved_m else { return };
        if self.slides && self.has_arrived(input, drive) {
            self.disobeyed_s += dt_s;
        } else {
            (self.obeyed_m, self.disobeyed_s) = (moved_m, 0.0);
        }
        if self.mean_n.is_none() || self.refuted {
            return;
        }
        let under_force =
            self.disobeyed_s >= CONTRADICTED_S && moved_m - self.obeyed_m >= SLIDES_ON_M;
        let late = (drive.delayed_s(input.age_s) / FOLLOWS_S).max(1.0);
        let followed = moved_m - self.slid_from_m >= late * FOLLOWS_M;
        self.refuted = under_force || followed;
    }

    /// Whether what the estimates asked for is there, measured or by the time that it takes.
    fn has_arrived(&self, input: &GripInput, drive: &Drive) -> bool {
        let measured = input.applied_n.is_some_and(|force_n| force_n >= ARRIVED * self.target_n);
        measured && self.standing_s >= STANDS_S || self.standing_s >= drive.wait_s(input.age_s)
    }

    /// By what share of itself the target grows in a second where no estimate shows how far, and a force is felt after `delay_s` (s).
    fn growth_per_s(&self, config: &GripConfig, input: &GripInput, delay_s: f32) -> f32 {
        let recent = self.mean_n.is_some() && self.unconfirmed_s <= ESTIMATE_LASTS_S;
        if input.moved_m.is_none() || input.undecided {
            return match self.mean_n {
                _ if recent => 0.0,
                // What was estimated before the moved distance was lost gets its time.
                Some(_) if self.unconfirmed_s <= ESTIMATE_SERVES_S => {
                    SLOWEST * 1e3 / config.reflex_tau_ms
                }
                _ => felt_growth_per_s(config, input.passing, self.slip_s, delay_s),
            };
        }
        if (recent && !self.refuted) || (self.mean_n.is_some() && !self.slides) {
            return 0.0;
        }
        // An estimate takes some milliseconds, and is better.
        let missed = self.mean_n.is_none() && self.slip_s >= ESTIMATED_BY_S;
        let acceleration = input.motion.and_then(|motion| motion.acceleration_m_s2).unwrap_or(0.0);
        let falls = if self.slides && (missed || self.refuted) {
            (acceleration / G_M_S2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let least = 1e3 / (LEAST_TAUS * config.measured_tau_ms);
        if self.most_n.is_finite() { least } else { LEAST_TAUS * least + falls / FALLING_TAU_S }
    }

    /// Whether the object goes on. One that swings on its pads goes forth and back: how far it comes back is no slip.
    fn confirm(&mut self, config: &GripConfig, input: &GripInput) {
        if input.undecided {
            self.goes_on = true;
            return;
        }
        let Some(moved_m) = input.moved_m else {
            self.confirmed |= input.felt.is_none() || !self.shears(config);
            self.goes_on = true;
            return;
        };
        let noise_m = 6.0 * input.travel_sigma_m;
        self.furthest_m = self.furthest_m.max(moved_m);
        let back_m = self.furthest_m - moved_m;
        if back_m > MOST_SWING_M.max(noise_m) {
            (self.furthest_m, self.from_m) = (moved_m, moved_m);
        } else if back_m >= BACK_M.max(noise_m) {
            self.swing_m = self.swing_m.max(back_m);
            self.from_m = moved_m;
            self.swings = true;
            self.goes_on = false;
        }
        let confirm_m = config.confirm_m.max(self.shear_m) + self.swing_m;
        self.goes_on |= moved_m - self.from_m >= confirm_m.max(noise_m);
        self.confirmed |= self.goes_on;
    }

    /// Whether the pads may shear by more than what confirms a slip.
    fn shears(&self, config: &GripConfig) -> bool {
        self.shear_m > config.confirm_m
    }

    /// How long the object has been falling.
    fn watch(&mut self, sliding: Option<Sliding>, dt_s: f32) {
        self.unseen_s = if sliding.is_some() { 0.0 } else { self.unseen_s + dt_s };
        let slows = sliding.is_some_and(|sliding| sliding.acceleration_g <= 0.0);
        let falls = !slows && self.unseen_s < UNSEEN_S;
        self.falling_s = if falls { self.falling_s + dt_s } else { 0.0 };
    }

    /// What the load needs now where the weight w is known (N): by `m a = L - 2 mu F` that is F + w a/g, whatever the load is. The estimate takes
    /// it for the weight alone, and is too high where something hits or pulls the object.
    fn load_n(&self, sliding: &Sliding) -> Option<f32> {
        let weight_n = self.weight_n.filter(|_| self.falling_s <= BELIEVED_S)?;
        let load_n = KAPPA * sliding.force_n + weight_n * sliding.acceleration_g;
        (load_n.is_finite() && load_n > 0.0).then_some(load_n)
    }

    /// Takes an estimate with its margin. What it and the one before state at least, since a single one may be noise and the target never falls; and how
    /// much the estimates have grown in the time of the last [`GROWTH_OF`] (N).
    fn learn(&mut self, with_margin: f32) -> (f32, f32) {
        self.estimates = (self.estimates + 1.0).min(MEAN_OF);
        let mean = self.mean_n.unwrap_or(with_margin);
        self.mean_n = Some(mean + (with_margin - mean) / self.estimates);
        let known = self.last_n.is_some();
        let mut before = self.last_n.unwrap_or([with_margin; GROWTH_OF]);
        let [.., last] = before;
        if self.unconfirmed_s > ESTIMATE_LASTS_S {
            self.resumed |= known;
            // What has grown in a pause has not done so in the time of a few estimates.
            let step_n = (with_margin - last) * ESTIMATES_EVERY_S / self.unconfirmed_s;
            let mut past_n = with_margin;
            for place in before.iter_mut().rev() {
                past_n -= step_n;
                *place = past_n;
            }
        }
        let [_, kept @ ..] = before;
        let mut now = [with_margin; GROWTH_OF];
        for (place, value) in now.iter_mut().zip(kept) {
            *place = value;
        }
        self.last_n = Some(now);
        let [first, ..] = before;
        let last = if known { last } else { FIRST * self.step_n };
        (with_margin.min(last), with_margin - first)
    }

    fn aim(&mut self, config: &GripConfig, force_n: f32) {
        let force_n = force_n.min(config.ceiling_n()).min(self.most_n);
        if force_n > self.target_n {
            (self.target_n, self.standing_s) = (force_n, 0.0);
        }
    }

    /// What the command has to be for the measured force to become the target soon (N).
    pub(super) fn command_n(
        &self,
        config: &GripConfig,
        applied_n: Option<f32>,
        drive: &Drive,
    ) -> f32 {
        let lead_n = applied_n.map_or(0.0, |applied_n| {
            let missing_n = self.target_n - applied_n;
            let lead_n = drive.beyond(self.target_n, config.lead * missing_n);
            lead_n.max(drive.lead_n(self.target_n, applied_n, self.alone))
        });
        (self.target_n + lead_n).min(config.ceiling_n())
    }

    /// Whether `hold_n` (N), which has stopped the slip, is more than the weight asks for, as far as that was known before: something has hit or pulled the
    /// object. What the search has let slip needs more than it was held with by the friction alone.
    pub(super) fn was_more_than_weight(&self, hold_n: f32) -> bool {
        let by_friction = self.held_by == HeldBy::Search && hold_n <= BY_FRICTION * self.base_n;
        let heavier = self.weight_n.is_some_and(|weight_n| hold_n > HEAVIER * weight_n);
        !by_friction && (self.overloaded || heavier)
    }

    /// The least force that may do (N), where the slip has shown the need roughly only.
    pub(super) fn least_n(&self) -> Option<f32> {
        let mean_n = self.mean_n.filter(|_| self.confirmed && !self.overloaded && !self.refuted)?;
        let need_n = mean_n / KAPPA;
        (self.weight_n.is_none() && self.base_n < EARLY * need_n).then_some(ROUGHLY * mean_n)
    }

    /// The slip has ended: what is the force to hold with (N)?
    pub(super) fn hold_n(&self, config: &GripConfig, believed: bool) -> f32 {
        let felt_n = self.feeling.held_n();
        let known = believed || (self.held_by != HeldBy::Memory && !self.shears(config));
        if let Some(held_n) = felt_n.filter(|_| known) {
            return held_n;
        }
        let hold_n = match self.mean_n {
            _ if !believed => self.hold_before_n,
            _ if !self.confirmed => self.step_n,
            // It slid on under what was estimated: what stopped it is what it needs.
            _ if self.refuted => self.target_n.max(self.step_n),
            // More than the weight had to be held: what stopped the slip is enough.
            Some(mean_n) if self.overloaded => mean_n.max(self.step_n).max(KEPT * self.target_n),
            _ if self.held_by == HeldBy::Search && self.least_n().is_none() => {
                let reported_n = self.mean_n.unwrap_or(self.target_n);
                let sure = self.estimates >= MEAN_OF;
                let most_n = if sure { f32::INFINITY } else { self.step_n };
                reported_n.min(most_n).max(self.step_n / SOUGHT)
            }
            Some(mean_n) if self.least_n().is_none() => mean_n.max(self.step_n),
            Some(mean_n) => (KEPT * self.target_n).max(mean_n).max(self.step_n),
            None => self.target_n,
        };
        hold_n.min(config.ceiling_n())
    }
}

/// By what share of itself the target grows in a second where only the stylus shows the slip: with each peak and valley that it passes, so that it
/// follows the distance and not the time, within bounds. What grows faster than it is felt goes on growing after the object stands.
fn felt_growth_per_s(
    config: &GripConfig,
    passing: Option<Passing>,
    slip_s: f32,
    delay_s: f32,
) -> f32 {
    let fastest = 1e3 / config.reflex_tau_ms;
    let slowest = SLOWEST * fastest;
    let fastest = fastest.min(1.0 / (FELT_AFTER * delay_s)).max(slowest);
    let Some(passing) = passing else {
        return if slip_s < UNCOUNTED_S { slowest } else { fastest };
    };
    let growth = (TURN * passing.turns_per_s).max(slowest).min(fastest);
    if passing.slows { growth / SLOWED } else { growth }
}

/// Whether an estimate has a force and a noise to reckon with.
fn is_usable(estimate: &ForceEstimate) -> bool {
    estimate.force_n > 0.0 && estimate.force_n.is_finite() && !estimate.sigma_n.is_nan()
}

/// The estimate with the margin for its noise (N).
fn with_margin(estimate: &ForceEstimate, config: &GripConfig) -> f32 {
    let noise_n = estimate.sigma_n.max(0.0);
    // An estimate that shows nothing adds no more than itself.
    estimate.force_n + (config.margin_sigmas * noise_n).min(estimate.force_n)
}
