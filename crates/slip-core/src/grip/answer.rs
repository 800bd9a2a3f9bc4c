//! The answer to a slip: the force that the posterior of the need asks for, and the force to hold with afterwards.

use super::{GripConfig, GripInput};
use crate::load::Forecast;
use libm::expf;

/// The first answer over the force at the alarm: of the stylus, of another sensor, to an object that is known.
const FIRST: f32 = 1.4;
const FIRST_OTHER: f32 = 1.15;
const FIRST_KNOWN: f32 = 1.08;
/// The target rises and falls by e in these times (s) at most ...
const RISE_S: f32 = 3e-3;
const FALL_S: f32 = 0.03;
/// ... and not further over the force that is on its way than by this share and this much (N).
const AHEAD: f32 = 1.7;
const AHEAD_N: f32 = 0.3;
/// What slipped at a force needs more than it.
const LEAST: f32 = 1.02;
/// A known object that needs no more than it had with this probability is held.
const HELD: f32 = 0.4;
/// An object that has not stopped under this much more than the median, so long (s) after the alarm and the delay of the drive, is heavier than
/// thought, by e in this time (s); in the next one where no hypothesis explains what is felt.
const DONE: f32 = 1.1;
const DONE_S: f32 = 6e-3;
const DONE_M_S: f32 = 1e-3;
const DOUBT_S: f32 = 0.4;
const UNEXPLAINED_S: f32 = 0.03;
const UNEXPLAINED: f32 = 2.0;
/// A trusted travel that goes on this far (m), or for this long (s) as fast as this (m/s), slides on: the target grows by e in this time (s).
const SLIDES_M: f32 = 3e-4;
const SLIDES_S: f32 = 0.01;
const SLIDES_M_S: f32 = 12e-3;
const CREEPS_M_S: f32 = 5e-4;
const SLIDES_TAU_S: f32 = 0.3;
/// ... up to this much over the force at the alarm: what goes on as fast when it is pressed twice as hard is held by no friction.
const SLIDES_MOST: f32 = 2.0;
/// Held with this much over the need by a trusted travel, and no more over its lower quantile; by the stylus alone; at least this over what slipped.
const HOLD: f32 = 1.25;
const HOLD_LOW: f32 = 1.5;
const HOLD_ALONE: f32 = 1.2;
const HOLD_LEAST: f32 = 1.05;
/// Where the force fell until the object slipped, at least this over what slipped: static friction gives way first.
const HOLD_SEARCHED: f32 = 1.3;
/// After a sensor has failed, or the travel has won or lost its trust, nothing falls for this long (s).
const UNSURE_S: f32 = 0.05;
/// A slip that a fault ends sooner than this (s) has shown nothing: a stylus that alarms and fails, again and again, must not raise the force.
const SHOWN_S: f32 = 6.5e-3;
/// Back to what is to be held within this time (s).
const BACK_S: f32 = 0.02;

/// Where less and less is tried, an object is let slide until it shows the friction of sliding: up to this speed (m/s), for this long (s) at most.
const SHOWS_M_S: f32 = 5e-3;
const SHOWS_S: f32 = 0.02;

/// Memory of the slip that goes on.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "what one slip has shown, each by itself")]
pub(super) struct Answer {
    /// What the force should become (N).
    target_n: f32,
    /// First answer (N): no faster rise bounds it.
    first_n: f32,
    /// What the object was held with before (N), and whether less and less was tried.
    before_n: f32,
    searched: bool,
    /// By what factor it is heavier than thought.
    grow: f32,
    /// What to hold with once it has stopped (N), and whether that was shown by a slip.
    hold_n: f32,
    slipped: bool,
    /// Whether the force to hold with is that of the last stop.
    concluded: bool,
    /// Whether an object that less and less was tried with has slid so fast that it shows the friction of sliding.
    shown: bool,
    slips_seen: u32,
    /// Whether the travel was trusted, and for how long (s) nothing falls because a sensor may fail.
    trusted: bool,
    unsure_s: f32,
}

impl Answer {
    /// A slip begins under `command_n`, while `hold_n` (N) was to be held; `searched`: less and less was tried.
    pub(super) fn begin(command_n: f32, hold_n: f32, searched: bool) -> Self {
        Self {
            target_n: command_n,
            before_n: hold_n,
            hold_n,
            searched,
            grow: 1.0,
            ..Self::default()
        }
    }

    /// What the force should become (N).
    pub(super) fn target_n(&self) -> f32 {
        self.target_n
    }

    /// What to hold with (N).
    pub(super) fn hold_n(&self) -> f32 {
        self.hold_n
    }

    /// Whether the object has slipped, and not only moved on its pads.
    pub(super) fn slipped(&self) -> bool {
        self.slipped
    }

    /// Takes what is new after `dt_s`, of which the force may rise for `rise_s` (s).
    pub(super) fn follow(
        &mut self,
        config: &GripConfig,
        input: &GripInput,
        forecast: &Forecast,
        dt_s: f32,
        rise_s: f32,
    ) {
        let ceiling_n = config.ceiling_n();
        // A posterior that has fallen may be a sensor that fails.
        let turned = forecast.trusted != core::mem::replace(&mut self.trusted, forecast.trusted);
        let fails = input.impaired || (turned && forecast.slips);
        self.unsure_s = if fails { UNSURE_S } else { (self.unsure_s - dt_s).max(0.0) };
        if forecast.slips_seen != self.slips_seen && forecast.slips {
            self.slips_seen = forecast.slips_seen;
            self.start(config, forecast);
        }
        if !forecast.slips {
            self.rest(forecast, dt_s, ceiling_n);
            return;
        }
        let shown = forecast.since_s > SHOWN_S && forecast.p_null < HELD;
        self.hold_n = if shown { self.target_n } else { self.before_n.min(self.target_n) };
        let before_n = self.target_n;
        let delay_s = input.dead_s + input.lag_s;
        let on_n =
            if slides_on(forecast, delay_s) { before_n * expf(rise_s / SLIDES_TAU_S) } else { 0.0 };
        let on_n = on_n.min(SLIDES_MOST * forecast.from_n);
        if input.stale || !forecast.moves {
            // A coarse or slow travel shows in some milliseconds no movement, and in many that it goes on.
            let on_n = if input.stale { 0.0 } else { on_n };
            self.target_n = before_n.max(on_n).min(ceiling_n);
            return;
        }
        let on_way_n = input.predicted_n;
        if !forecast.informed {
            self.target_n =
                (before_n * expf(rise_s / (1e-3 * config.reflex_tau_ms))).min(ceiling_n);
            return;
        }
        let mut want_n = forecast.best_n * self.grow;
        if self.searched && forecast.known && forecast.trusted {
            let slow = forecast.travel_m_s < SHOWS_M_S && forecast.since_s < SHOWS_S;
            self.shown |= !slow || forecast.far;
            if !self.shown {
                want_n = want_n.min(forecast.from_n);
            }
        }
        if forecast.known && !self.searched && forecast.p_null > HELD && !forecast.far {
            want_n = want_n.min(LEAST * forecast.from_n);
        }
        let quickly_n = self.first_n.max(before_n * expf(rise_s / RISE_S));
        let most_n = quickly_n.min((AHEAD * on_way_n + AHEAD_N).max(before_n));
        let least_n = if self.searched && !self.shown { 1.0 } else { LEAST } * forecast.from_n;
        let falls_n = if self.unsure_s > 0.0 { before_n } else { before_n * expf(-dt_s / FALL_S) };
        let least_n = falls_n.max(least_n);
        self.target_n = want_n.min(most_n).max(least_n);
        let done = on_way_n > DONE * forecast.median_n
            && forecast.since_s > DONE_S + 2.0 * delay_s
            && forecast.speed_m_s > DONE_M_S;
        if done {
            self.grow *= expf(rise_s / DOUBT_S);
        }
        if forecast.unexplained {
            let applied_n = input.applied_n.unwrap_or(on_way_n);
            let grown_n = self.target_n.max(before_n * expf(rise_s / UNEXPLAINED_S));
            self.target_n = grown_n.min((UNEXPLAINED * applied_n + AHEAD_N).max(before_n));
        }
        self.target_n = self.target_n.max(on_n);
        self.target_n = self.target_n.min(ceiling_n);
    }

    /// The object begins to move.
    fn start(&mut self, config: &GripConfig, forecast: &Forecast) {
        self.grow = 1.0;
        self.concluded = false;
        self.shown = false;
        let first = match (forecast.known, forecast.trusted, forecast.by_stylus) {
            (true, true, _) => 1.0,
            (true, false, _) => FIRST_KNOWN,
            (false, _, true) => FIRST,
            (false, _, false) => FIRST_OTHER,
        };
        self.first_n = (first * forecast.from_n).min(config.ceiling_n());
        self.target_n = self.target_n.max(self.first_n);
    }

    /// The object stands: down to what is to be held.
    fn rest(&mut self, forecast: &Forecast, dt_s: f32, ceiling_n: f32) {
        let Some(need_n) = forecast.held_n else {
            // Nothing has slipped, or nothing yet.
            if forecast.slips_seen == self.slips_seen {
                self.hold_n = self.before_n.min(self.target_n);
                self.back(dt_s);
            }
            return;
        };
        if !self.concluded {
            self.concluded = true;
            self.slipped = true;
            let wanted_n = if forecast.trusted {
                (HOLD * need_n).min(HOLD_LOW * forecast.whole_low_n)
            } else {
                // Where no sensor has shown the course of the slip, what has stopped it is more than it needs.
                let margin = if forecast.informed { HOLD_ALONE } else { 1.0 };
                margin * need_n.min(self.target_n).max(forecast.from_n)
            };
            let searched_n = if self.searched { HOLD_SEARCHED * forecast.from_n } else { 0.0 };
            let least_n = if forecast.known { self.before_n } else { HOLD_LEAST * forecast.from_n };
            // What a slow fall has shown is known well: it may be more than has stopped it.
            let shown = forecast.trusted && self.searched && forecast.known;
            let most_n = if shown { ceiling_n } else { self.target_n.max(least_n) };
            self.hold_n = wanted_n.max(searched_n).max(least_n).min(most_n).min(ceiling_n);
            self.before_n = self.hold_n;
        }
        self.back(dt_s);
    }

    /// The slip has ended for the methods.
    pub(super) fn finish(&mut self, forecast: Option<&Forecast>, config: &GripConfig) {
        if let Some(forecast) = forecast {
            self.rest(forecast, 0.0, config.ceiling_n());
        }
    }

    fn back(&mut self, dt_s: f32) {
        if self.unsure_s > 0.0 && self.hold_n < self.target_n {
            return;
        }
        self.target_n += (self.hold_n - self.target_n) * (dt_s / BACK_S).min(1.0);
    }
}

/// Whether a trusted travel shows an object that goes on although what was asked for should have arrived after the delay of the drive (s).
fn slides_on(forecast: &Forecast, delay_s: f32) -> bool {
    let far = forecast.moved_m.is_some_and(|moved_m| moved_m > SLIDES_M);
    let fast = forecast.travel_m_s > SLIDES_M_S;
    let on = forecast.trusted && (far || fast) && forecast.travel_m_s > CREEPS_M_S;
    on && forecast.since_s > SLIDES_S + 3.0 * delay_s
}
