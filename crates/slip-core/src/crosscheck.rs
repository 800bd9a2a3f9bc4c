//! Cross-check of stylus and travel in the same slip: which of them contradicts the other, or itself.
//!
//! Both feel the same object, so that one of them shows a movement of some micrometres without the other is a fault of one. Which one:
//!
//! | what is seen | verdict |
//! |---|---|
//! | the stylus passes five peaks and valleys within 12 ms (weighted by its statistic) and the travel stands, before it has ever followed the stylus | travel |
//! | the stylus passes 24 peaks and valleys while the readings of the travel are equal to the last bit | travel |
//! | as the first, but the travel has followed an earlier slip of this object | undecided: the answer is bounded |
//! | the travel is back by 30 um and more with the next reading, and then as the first | travel |
//! | the stylus has passed four peaks and valleys and more within less than 10 um of travel each, but for one with each turn of the travel: hardly a surface is that fine | the stylus answers in this slip |
//! | the travel stops dead: over 0.2 mm in 3 ms, then within as much time nothing for 3 ms, while the stylus vibrates | travel |
//! | the travel moves alone within a second of an undecided alarm | travel: it is late |
//! | the travel has moved 0.3 mm and the stylus has felt nothing | stylus |
//! | as the first, but within a second of a movement of 0.1 mm that the stylus did not feel, and that had ended before the stylus began | stylus: it is late |
//! | the travel moves alone, and twice in a row within a fifth as fast as before when the force has doubled | travel: it drifts |
//! | the vibration of the stylus is white and far above its noise floor: no surface shakes a stylus at half the sample rate | stylus |
//!
//! A doubted sensor has no state while the other one is usable. The stylus is believed again when it feels a slip in time; the travel with the
//! next object, or, unless it drifts, when it follows the stylus from the beginning of a slip.

use crate::{
    course::{TurnCount, Turns},
    units::Micros,
};

/// Vibration for this long (s) moves a sound travel sensor.
const CONTRADICTED_S: f32 = 0.012;
/// What slides is not back by this (m), and by this times the period (m/s), with the next reading: the readings are those of another time.
const BACK_M: f32 = 3e-5;
const BACK_M_S: f32 = 0.1;
/// For so long (s), and for so many turns, one that has never followed is waited for.
const SUSPECTED_S: f32 = 0.006;
const SUSPECTED: u32 = 2;
/// Least distance of two turns on a surface (m), from so many turns on; a travel that shows less is late.
const CLOSE_M: f32 = 1e-5;
const CLOSE: u32 = 4;
/// After the travel has followed in this slip, ringing of the stylus may outlast the movement by this (s).
const RINGING_S: f32 = 0.06;
/// Turns of a stylus that passes peaks and valleys; what only shakes makes fewer in that time. At rates too low for the stylus to hold alone, more.
const PASSED: u32 = 5;
const PASSED_SLOW: u32 = 8;
/// The same where the readings of the travel are equal to the last bit.
const PASSED_EQUAL: u32 = 24;
/// Statistic from which an instant counts whole.
const STRONG: f32 = 30.0;
/// What the travel shows at least where the stylus vibrates (m), over its noise and its resolution.
const LEAST_M: f32 = 2.5e-6;
const NOISES: f32 = 6.0;
/// A travel that has gone this far (m) has followed the stylus.
const FOLLOWED_M: f32 = 3e-5;
/// A slip of this length (m) is felt by a sound stylus.
const UNFELT_M: f32 = 3e-4;
/// Length of a window in which a travel that went [`DEAD_M`] (m) in the one before the last cannot stand: that takes 15 m/s^2.
const WINDOW: Micros = Micros(3000);
const DEAD_M: f32 = 2e-4;
/// An undecided alarm is explained by a travel that moves alone within this time, and an alarm of the stylus by a movement
/// that it did not feel.
const LATE: Micros = Micros(1_000_000);
/// A movement of this length (m), and of this many times the least, is one that the stylus did not feel.
const MISSED_M: f32 = 1e-4;
const MISSED_LEAST: f32 = 4.0;
/// A movement ended before an alarm that comes this long after it.
const ENDED: Micros = Micros(20_000);

/// The speed of a travel that moves alone is measured while the force is below this share of where it began, and again from the next share on. Under
/// dry friction the object stops, under viscous friction it gets slower by (F' - F) / (F needed - F).
const STANDS: f32 = 1.4;
const DOUBLED: f32 = 1.9;
/// What has slowed down by less than this share of its speed has not answered.
const ANSWERED: f32 = 0.2;
/// A stylus that repeats itself for this long (s) may be stuck.
const REPEATS_S: f32 = 5e-4;
/// The second measurement takes this long (s) at least, and as long as the speed before takes for ten times the least movement.
const WEIGHED_S: f32 = 0.02;

/// One sample of a slip.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Its time.
    pub t: Micros,
    /// Time since the sample before (s).
    pub dt_s: f32,
    /// Moved distance without leaps (m), where there is a reading.
    pub travel_m: Option<f32>,
    /// Deviation of one reading (m).
    pub sigma_m: f32,
    /// Leaps of the travel so far.
    pub leaps: u64,
    /// Force of a finger (N), where it is known.
    pub force_n: Option<f32>,
    /// Statistic of the stylus, 0 where it is quiet now, and `None` where it is not usable.
    pub stylus: Option<f32>,
    /// Its reading (signal unit).
    pub reading: f32,
    /// Deviation of its noise in the vibration band (signal unit).
    pub noise: f32,
    /// Whether it can give the force alone.
    pub holds_alone: bool,
}

/// The slip that goes on.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "verdicts, each reached by itself")]
struct Slip {
    from_m: Option<f32>,
    low_m: f32,
    high_m: f32,
    moved_m: f32,
    reversals: Reversals,
    strong_s: f32,
    /// Turns of the stylus, and how many there were when the travel last moved.
    turns: TurnCount,
    passed: u32,
    felt: bool,
    /// The last reading of the travel (m), and the turns when it last changed.
    last_m: Option<f32>,
    changed: u32,
    /// Whether it has leapt back in this slip, and whether the turns were closer than those of any surface.
    leapt_back: bool,
    close: bool,
    /// Whether the travel stood for longer than it may before it followed, and whether it followed in time.
    unanswered: bool,
    in_time: bool,
    leaps: u64,
    window: Option<Window>,
    /// Whether it was that fast in the last window and in the one before.
    fast: [bool; 2],
    /// The movement that only the travel shows, and whether it was found to be none.
    alone: Option<Alone>,
    drifts: bool,
    /// The last reading of the stylus, and for how long it has repeated (s).
    reading: Option<f32>,
    repeats_s: f32,
}

/// A movement that only the travel shows, weighed against the force.
#[derive(Clone, Copy, Debug)]
struct Alone {
    /// Where it is counted from: force (N), time, travel (m).
    force_n: f32,
    begun: Micros,
    from_m: f32,
    /// Its speed while the force stood (m/s).
    speed_m_s: f32,
    /// Time and travel (m) when the force had doubled, or when the first window since then ended.
    doubled: Option<(Micros, f32)>,
    /// Whether it was as fast as before in that window.
    as_fast: bool,
}

impl Alone {
    fn at(force_n: f32, begun: Micros, from_m: f32) -> Self {
        Self { force_n, begun, from_m, speed_m_s: 0.0, doubled: None, as_fast: false }
    }
}

/// How often the travel has turned back.
#[derive(Clone, Copy, Debug, Default)]
struct Reversals {
    /// The furthest since it last turned (m).
    extreme_m: f32,
    rises: bool,
    count: u32,
}

impl Reversals {
    /// Takes the next reading (m); a way back of less than `least_m` is none.
    fn step(&mut self, travel_m: f32, least_m: f32) {
        let beyond_m = travel_m - self.extreme_m;
        let ahead_m = if self.rises { beyond_m } else { -beyond_m };
        let reverses = ahead_m <= -least_m;
        if reverses {
            (self.rises, self.count) = (!self.rises, self.count.saturating_add(1));
        }
        if reverses || ahead_m >= 0.0 {
            self.extreme_m = travel_m;
        }
    }
}

/// Readings of the travel (m) within one window.
#[derive(Clone, Copy, Debug)]
struct Window {
    begun: Micros,
    first_m: f32,
    low_m: f32,
    high_m: f32,
}

/// What is known of both sensors.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "verdicts, each reached by itself")]
pub struct CrossCheck {
    slip: Slip,
    /// Whether the travel has followed a slip of this object.
    proven: bool,
    travel_doubted: bool,
    stylus_doubted: bool,
    undecided: bool,
    /// Whether the travel has drifted since the object was taken.
    drifted: bool,
    undecided_at: Option<Micros>,
    missed: Missed,
}

/// Movements that the stylus does not feel.
#[derive(Clone, Copy, Debug, Default)]
struct Missed {
    /// Where the stylus fell silent (m), and where the travel last stood (m).
    silent_m: Option<f32>,
    stood_m: Option<f32>,
    /// When the travel last moved, and when it last moved without the stylus.
    moved: Option<Micros>,
    alone: Option<Micros>,
    /// Whether the stylus feels something now, and whether that is a movement of before.
    feels: bool,
    late: bool,
}

impl Missed {
    /// A slip begins.
    fn begin(&mut self) {
        *self = Self { moved: self.moved, alone: self.alone, ..Self::default() };
    }

    fn step(&mut self, seen: &Seen, travel_m: f32, least_m: f32) {
        let stood_m = self.stood_m.get_or_insert(travel_m);
        if (travel_m - *stood_m).abs() >= least_m {
            *stood_m = travel_m;
            self.moved = Some(seen.t);
        }
        let since = |then: Option<Micros>| then.map(|then| seen.t.since(then));
        if seen.stylus.is_some_and(|statistic| statistic >= 1.0) {
            self.silent_m = None;
            if !core::mem::replace(&mut self.feels, true) {
                let ended = since(self.moved).is_none_or(|passed| passed >= ENDED);
                self.late = ended && since(self.alone).is_some_and(|passed| passed < LATE);
            }
        } else {
            self.feels = false;
            let silent_m = *self.silent_m.get_or_insert(travel_m);
            if (travel_m - silent_m).abs() >= MISSED_M.max(MISSED_LEAST * least_m) {
                self.alone = Some(seen.t);
            }
        }
    }
}

impl CrossCheck {
    /// Another object: nothing is known.
    pub fn prime(&mut self) {
        *self = Self::default();
    }

    /// A slip begins.
    pub fn begin(&mut self) {
        self.slip = Slip::default();
        self.missed.begin();
        self.undecided = false;
    }

    /// Whether the travel is not to be believed.
    #[must_use]
    #[inline]
    pub fn doubts_travel(&self) -> bool {
        self.travel_doubted
    }

    /// Whether the stylus is not to be believed, as long as the travel is usable.
    #[must_use]
    #[inline]
    pub fn doubts_stylus(&self) -> bool {
        self.stylus_doubted && !self.travel_doubted
    }

    /// Whether the stylus shows a slip that a travel sensor, good so far, does not confirm.
    #[must_use]
    #[inline]
    pub fn is_undecided(&self) -> bool {
        self.undecided && !self.travel_doubted && !self.stylus_doubted
    }

    /// Force (N) from which on only the travel shows a movement, until the force has shown whether it is one.
    #[must_use]
    #[inline]
    pub fn alone_n(&self) -> Option<f32> {
        self.slip.alone.map(|alone| alone.force_n)
    }

    /// Whether what the travel shows in this slip was no movement.
    #[must_use]
    #[inline]
    pub fn drifts(&self) -> bool {
        self.slip.drifts
    }

    /// Whether a travel that has never followed a slip of this object, or has leapt back in this one, stands where the stylus clearly slides: the
    /// stylus answers meanwhile. Where the turns are closer than those of any surface it answers in the whole slip.
    #[must_use]
    #[inline]
    pub fn suspects_travel(&self) -> bool {
        let never = !self.proven && self.slip.moved_m < FOLLOWED_M;
        let stands = (never || self.slip.leapt_back)
            && self.slip.strong_s >= SUSPECTED_S
            && self.slip.turns.count() >= SUSPECTED;
        (stands || self.slip.close) && !self.stylus_doubted
    }

    /// Takes the next sample of the slip.
    pub fn step(&mut self, seen: &Seen) {
        let Some(travel_m) = seen.travel_m else { return };
        let least_m = LEAST_M.max(NOISES * seen.sigma_m);
        let statistic = seen.stylus.unwrap_or(0.0);
        let slip = &mut self.slip;
        if slip.from_m.is_none() {
            *slip = Slip {
                low_m: travel_m,
                high_m: travel_m,
                reversals: Reversals { extreme_m: travel_m, ..Reversals::default() },
                leaps: seen.leaps,
                ..*slip
            };
        }
        let from_m = *slip.from_m.get_or_insert(travel_m);
        let moved_m = (travel_m - from_m).abs();
        let back_m = slip.last_m.map_or(0.0, |last_m| (last_m - from_m).abs() - moved_m);
        slip.leapt_back |= back_m > BACK_M + 2.0 * least_m + BACK_M_S * seen.dt_s;
        slip.moved_m = slip.moved_m.max(moved_m);
        slip.low_m = slip.low_m.min(travel_m);
        slip.high_m = slip.high_m.max(travel_m);
        slip.reversals.step(travel_m, least_m);
        if slip.high_m - slip.low_m >= least_m {
            (slip.low_m, slip.high_m, slip.strong_s) = (travel_m, travel_m, 0.0);
            slip.passed = slip.turns.count();
        } else {
            slip.strong_s += seen.dt_s * (statistic / STRONG).min(1.0);
        }
        let turned = slip.turns.step(seen.reading, seen.noise);
        // Noise turns too, until it is found to be noise.
        slip.close &= seen.holds_alone;
        // On pads that swing the stylus turns where the travel does.
        let once = slip.turns.count().saturating_sub(slip.reversals.count);
        if turned && once >= CLOSE && seen.holds_alone {
            let least_m = CLOSE_M * once as f32;
            slip.close |= slip.moved_m < least_m;
        }
        if !slip.felt && statistic >= 1.0 {
            slip.felt = true;
            // In time: this stylus feels.
            self.stylus_doubted &= slip.moved_m >= UNFELT_M;
        }
        self.missed.step(seen, travel_m, least_m);
        self.judge(seen, travel_m, least_m);
        self.weigh(seen, travel_m, least_m);
    }

    /// Whether a movement that only the travel shows answers to the force.
    fn weigh(&mut self, seen: &Seen, travel_m: f32, least_m: f32) {
        // What repeats to the last bit may be stuck, and shows nothing.
        let repeats = self.slip.reading.replace(seen.reading) == Some(seen.reading);
        self.slip.repeats_s = if repeats { self.slip.repeats_s + seen.dt_s } else { 0.0 };
        let live = self.slip.repeats_s < REPEATS_S;
        let silent = live && seen.stylus.is_some_and(|statistic| statistic < 1.0);
        let quiet = silent && !self.travel_doubted;
        let Some(force_n) = seen.force_n.filter(|force_n| quiet && *force_n > 0.0) else {
            self.slip.alone = None;
            return;
        };
        let fresh = Alone::at(force_n, seen.t, travel_m);
        let alone = self.slip.alone.get_or_insert(fresh);
        if force_n < STANDS * alone.force_n {
            let over_s = seconds(seen.t.since(alone.begun)).max(seen.dt_s);
            alone.speed_m_s = (travel_m - alone.from_m) / over_s;
            return;
        }
        if force_n < DOUBLED * alone.force_n {
            return;
        }
        let (since, from_m) = *alone.doubled.get_or_insert((seen.t, travel_m));
        let over_s = seconds(seen.t.since(since));
        let expected_m = alone.speed_m_s * over_s;
        if over_s < WEIGHED_S || expected_m.abs() < 10.0 * least_m && over_s < 5.0 * WEIGHED_S {
            return;
        }
        let missed_m = (travel_m - from_m - expected_m).abs();
        if expected_m.abs() >= least_m && missed_m <= ANSWERED * expected_m.abs() {
            // Once may be chance: a slip passes through each speed.
            if !alone.as_fast {
                (alone.as_fast, alone.doubled) = (true, Some((seen.t, travel_m)));
                return;
            }
            self.travel_doubted = true;
            self.stylus_doubted = false;
            (self.slip.drifts, self.drifted) = (true, true);
        }
        self.slip.alone = Some(Alone { speed_m_s: (travel_m - from_m) / over_s, ..fresh });
    }

    fn judge(&mut self, seen: &Seen, travel_m: f32, least_m: f32) {
        let followed = self.slip.moved_m >= FOLLOWED_M.max(least_m);
        let leapt = seen.leaps > self.slip.leaps || self.slip.leapt_back;
        let holds_alone = seen.dt_s * Turns::LEAST_RATE_HZ <= 1.0;
        let least = if holds_alone { PASSED } else { PASSED_SLOW };
        let passes = self.slip.turns.count().saturating_sub(self.slip.passed) >= least;
        self.slip.unanswered |= passes && !self.slip.in_time;
        let follows = followed && self.slip.felt && !leapt && !self.slip.unanswered;
        if follows && !self.slip.in_time {
            self.slip.in_time = true;
            self.travel_doubted &= self.undecided_at.is_some() || self.drifted;
            self.proven |= !self.travel_doubted;
        }
        let alone = !self.slip.felt && seen.stylus.is_some();
        if alone && followed {
            let late = self.undecided_at.is_some_and(|at| seen.t.since(at) < LATE);
            self.travel_doubted |= late;
            self.stylus_doubted |= !late && self.slip.moved_m >= UNFELT_M;
        }
        let limit_s = if followed && !leapt { RINGING_S } else { CONTRADICTED_S };
        if self.slip.strong_s >= limit_s && passes && !self.stylus_doubted {
            if self.missed.late && !leapt {
                self.stylus_doubted = true;
            } else if self.proven && !leapt {
                self.undecided = true;
                self.undecided_at = Some(seen.t);
            } else {
                self.travel_doubted = true;
            }
        } else if self.slip.strong_s == 0.0 {
            self.undecided = false;
        }
        if self.slip.last_m.replace(travel_m) != Some(travel_m) {
            self.slip.changed = self.slip.turns.count();
        }
        self.travel_doubted |=
            self.slip.turns.count().saturating_sub(self.slip.changed) >= PASSED_EQUAL;
        self.watch_stop(seen, travel_m, least_m);
    }

    /// No object stops within a millisecond.
    fn watch_stop(&mut self, seen: &Seen, travel_m: f32, least_m: f32) {
        let fresh = Window { begun: seen.t, first_m: travel_m, low_m: travel_m, high_m: travel_m };
        let window = self.slip.window.get_or_insert(fresh);
        window.low_m = window.low_m.min(travel_m);
        window.high_m = window.high_m.max(travel_m);
        if seen.t.since(window.begun) < WINDOW {
            return;
        }
        let stands = window.high_m - window.low_m < least_m;
        let fast = (travel_m - window.first_m).abs() >= DEAD_M.max(4.0 * least_m);
        let vibrates = seen.stylus.is_some_and(|statistic| statistic >= 1.0);
        let [last, before] = self.slip.fast;
        self.travel_doubted |= stands && (last || before) && vibrates;
        self.slip.fast = [fast, last];
        self.slip.window = Some(fresh);
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a time within one slip")]
fn seconds(time: Micros) -> f32 {
    time.as_seconds() as f32
}

/// Whether the stylus shows the noise of its electronics instead of a surface.
///
/// The energy of second differences over that of first differences is 3 for white noise and below 0.4 for anything below a tenth of the sample
/// rate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Whiteness {
    last: Option<[f32; 2]>,
    first_energy: f32,
    second_energy: f32,
    seen: u16,
    noisy: bool,
}

impl Whiteness {
    /// Readings of a running mean, and before the first verdict.
    const READINGS: u16 = 32;
    const WHITE: f32 = 2.0;
    const NOT_WHITE: f32 = 1.0;
    /// First differences over the noise in the vibration band: 3.8 for white noise at 10 kHz; five times that is no noise of a sound stylus.
    const LOUD: f32 = 19.0;

    /// A new slip.
    pub fn begin(&mut self) {
        *self = Self { noisy: self.noisy, ..Self::default() };
    }

    /// Whether the stylus is not to be believed.
    #[must_use]
    #[inline]
    pub fn is_noisy(&self) -> bool {
        self.noisy
    }

    /// Whether enough of this slip was seen for a verdict.
    #[must_use]
    #[inline]
    pub fn is_known(&self) -> bool {
        self.seen >= Self::READINGS
    }

    /// Takes the next reading; `noise` is the noise of a sound stylus in its vibration band (rms).
    pub fn step(&mut self, x: f32, noise: f32) {
        let Some([one, two]) = self.last.replace([x, self.last.map_or(x, |[one, _]| one)]) else {
            return;
        };
        let (first, second) = (x - one, x - 2.0 * one + two);
        self.seen = self.seen.saturating_add(1).min(Self::READINGS);
        let share = 1.0 / f32::from(self.seen);
        self.first_energy += share * (first * first - self.first_energy);
        self.second_energy += share * (second * second - self.second_energy);
        if self.seen < Self::READINGS {
            return;
        }
        let loud = Self::LOUD * noise;
        let loud = noise > 0.0 && self.first_energy > loud * loud;
        let ratio = if self.noisy { Self::NOT_WHITE } else { Self::WHITE };
        self.noisy = loud && self.second_energy > ratio * self.first_energy;
    }
}

#[cfg(test)]
mod tests;
