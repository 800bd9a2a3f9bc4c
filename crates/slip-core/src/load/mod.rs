//! The load: one posterior over the force that an object needs, from every sensor of its slips.
//!
//! A bank of simulated objects is weighed by what the sensors show (`bank`). Nothing is looked at between slips. Fixed loops, no allocation, `f32`.

mod bank;
mod gains;
mod grid;
mod math;
mod prior;
mod stylus;
mod travel;

pub use grid::{Contact, Grid, Ramp};
pub use travel::TravelSensor;

use crate::{needed::NeededForce, sample::Signal, turns::Turn};
use bank::{AHEAD_S, Bank, Start};
use math::{at_least, at_most};
use prior::Prior;
use stylus::{Stylus, alarm_m};
use travel::Travel;

/// Hypotheses of the pipeline.
pub const CELLS: usize = Grid::MICRO.cells();
/// Length of a block (s).
const BLOCK_S: f32 = 5e-4;
/// Time from one weighing of the hypotheses to the next (s).
const WEIGHED_S: f32 = 1e-3;
/// A slip is not over earlier than this (s); nor by the travel alone before this (s).
const LEAST_S: f32 = 6.5e-3;
const TRAVEL_ALONE_S: f32 = 12e-3;
/// Pads swing for this long after a stop (s).
const AGAIN_S: f32 = 0.3;
/// Trust in a travel of which nothing is known; bounds of what a slip leaves of it; factor on its odds where the stylus alarms and a fine travel
/// shows less than this (m).
const TRUST: f32 = 0.97;
const LEAST_TRUST: f32 = 0.03;
const UNMOVED_M: f32 = 6e-7;
const UNMOVED: f32 = 0.12;
/// A travel with less trust than this raises no alarm of its own.
const ALARMS_FROM: f32 = 0.3;
/// Weight of a need below the force at the alarm, where the stylus has raised it.
const BELOW: f32 = 0.3;
/// Forces (N) that there are.
const LEAST_N: f32 = 1e-3;
const MOST_N: f32 = 1e4;
/// A stylus that is missing, or repeats itself, for this long (s) is none.
const LOST_S: f32 = 3e-3;
/// An object that goes on further than this (m) is not held.
const FAR_M: f32 = 1.5e-4;
/// An object that needs no more than it has with this probability is held.
const HELD: f32 = 0.9;

/// What is known when a slip is noticed.
#[derive(Clone, Copy, Debug)]
pub struct Alarm {
    /// What the stylus measures.
    pub signal: Signal,
    /// White noise of its readings (rms, their unit); `None`: it has no part in this slip.
    pub sigma: Option<f32>,
    /// Time between two samples (s).
    pub dt_s: f32,
    /// Force of a finger (N).
    pub force_n: f32,
    /// The largest force that may be commanded (N).
    pub most_n: f32,
    /// The travel, where there is one, and how far it has moved (m, with its sign).
    pub travel: Option<TravelSensor>,
    /// How far it has moved since it stood (m, with its sign).
    pub moved_m: f32,
    /// Whether the stylus has raised the alarm.
    pub by_stylus: bool,
    /// Whether the force falls until the object slips.
    pub searched: bool,
    /// For how long the object was held (s).
    pub held_s: f32,
    /// Since the slip before ended (s).
    pub rested_s: f32,
}

/// A sample of a slip.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// The stylus, where it is sound.
    pub stylus: Option<f32>,
    /// The travel (m), where there is a reading.
    pub travel_m: Option<f32>,
    /// Force of a finger (N).
    pub force_n: f32,
    /// How far the stylus sinks in with the force (its unit over N), 0 where that is not known.
    pub sinks_per_n: f32,
    /// Dead time of the drive (s).
    pub dead_s: f32,
    /// Whether the methods see the slip now.
    pub evident: bool,
}

/// What the last block has shown of the slip.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// Whether any sensor shows its course, and whether the object went further than pads swing.
    informed: bool,
    far: bool,
    /// Probability that the travel shows the object, and that it needs no more than it had.
    p_travel: f32,
    p_null: f32,
}

impl Seen {
    const NOTHING: Self = Self { informed: false, far: false, p_travel: 0.0, p_null: 0.0 };
}

/// Where a slip is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// No slip was noticed, or it has stopped.
    Rests,
    /// The object moves.
    Moves,
}

/// The posterior of the object in hand, with `H` hypotheses.
#[derive(Clone, Debug)]
pub struct Load<const H: usize> {
    bank: Bank<H>,
    stylus: Stylus,
    travel: Travel,
    prior: Prior,
    stage: Stage,
    alarm: Alarm,
    block_s: f32,
    samples: u16,
    filled: u16,
    has_stylus: bool,
    missing_s: f32,
    last: Option<f32>,
    /// Force at the end of the last block (N).
    last_n: f32,
    trust: f32,
    since_s: f32,
    /// Since the hypotheses were weighed (s).
    unweighed_s: f32,
    rested_s: f32,
    /// Since the first slip of the object (s).
    known_s: f32,
    /// Whether the hypotheses go on after a stop.
    runs: bool,
    seen: Seen,
    /// Need of the whole load (N): 10, 50 and 90 %.
    needed: Option<[f32; 3]>,
}

impl<const H: usize> Load<H> {
    /// Nothing is known.
    #[must_use]
    pub const fn new(grid: Grid) -> Self {
        Self {
            bank: Bank::new(grid),
            stylus: Stylus::NEW,
            travel: Travel::NEW,
            prior: Prior::NONE,
            stage: Stage::Rests,
            alarm: Alarm {
                signal: Signal::Displacement,
                sigma: None,
                dt_s: 1e-4,
                force_n: 1.0,
                most_n: 1.0,
                travel: None,
                moved_m: 0.0,
                by_stylus: true,
                searched: false,
                held_s: 0.0,
                rested_s: f32::INFINITY,
            },
            block_s: BLOCK_S,
            samples: 3,
            filled: 0,
            has_stylus: false,
            missing_s: 0.0,
            last: None,
            last_n: 0.0,
            trust: TRUST,
            since_s: 0.0,
            unweighed_s: 0.0,
            rested_s: f32::INFINITY,
            known_s: 0.0,
            runs: false,
            seen: Seen::NOTHING,
            needed: None,
        }
    }

    /// Another object is in hand; `need_n` (N) is what a memory states of it.
    pub fn take(&mut self, need_n: Option<f32>) {
        self.prior.forget();
        self.stylus.forget();
        self.trust = TRUST;
        self.needed = None;
        self.known_s = 0.0;
        self.rested_s = f32::INFINITY;
        if let Some(need_n) = need_n {
            self.prior.remember(need_n);
        }
    }

    /// What the slips of the object have shown that it needs, and what the force `command_n` (N) allows; `None` before the first.
    #[must_use]
    #[inline]
    pub fn needed(&self, command_n: f32) -> Option<NeededForce> {
        let [low_n, median_n, high_n] = self.needed?;
        let admissible_m_s2 = NeededForce::admissible(command_n, high_n);
        Some(NeededForce { low_n, median_n, high_n, admissible_m_s2 })
    }

    /// A slip was noticed. One that follows a stop so closely that pads may swing is none before it is seen to move.
    pub fn begin(&mut self, alarm: &Alarm) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 300")]
        let samples = libm::roundf(BLOCK_S / alarm.dt_s.max(1e-6)).clamp(1.0, 300.0) as u16;
        // What is no force is hardly any, and what is no distance none.
        let moved_m = if alarm.moved_m.is_finite() { alarm.moved_m } else { 0.0 };
        let alarm = &Alarm {
            force_n: at_most(at_least(alarm.force_n, LEAST_N), MOST_N),
            moved_m,
            ..*alarm
        };
        self.alarm = *alarm;
        self.samples = samples;
        self.block_s = f32::from(samples) * alarm.dt_s;
        self.filled = 0;
        self.last_n = alarm.force_n;
        self.missing_s = 0.0;
        self.last = None;
        self.rested_s += alarm.rested_s;
        self.known_s += alarm.rested_s;
        self.has_stylus = alarm.sigma.is_some();
        self.stylus.begin(alarm.signal, alarm.sigma.unwrap_or(1.0), alarm.dt_s, samples);
        self.travel.begin(alarm.travel, alarm.moved_m, self.block_s);
        self.stage = Stage::Rests;
        self.runs = false;
        self.seen = Seen::NOTHING;
        if self.rested_s > AGAIN_S || !self.has_stylus {
            self.start(alarm.force_n, alarm.moved_m.abs(), alarm.by_stylus);
        } else {
            self.stylus.rest();
        }
    }

    /// The object begins to move under `force_n` (N); the travel shows `moved_m` (m) of it.
    fn start(&mut self, force_n: f32, moved_m: f32, by_stylus: bool) {
        self.stylus.start();
        let there = self.alarm.travel.is_some() && self.travel.is_there();
        let fine = there && self.travel.is_fine();
        let law = self.stylus.law(!there).filter(|_| self.has_stylus);
        let mut trust = self.trust;
        if fine && by_stylus && law.is_some() && moved_m < UNMOVED_M {
            let odds = UNMOVED * trust / (1.0 - trust);
            trust = odds / (1.0 + odds);
        }
        let seen = fine && self.trust > ALARMS_FROM;
        let moved_m = if seen { moved_m.clamp(2e-6, 2e-5) } else { alarm_m(self.alarm.signal) };
        self.prior.expect(self.known_s, self.alarm.held_s, self.alarm.searched);
        let start = Start {
            force_n,
            most_n: self.alarm.most_n,
            moved_m,
            d_s: self.block_s,
            trust: if there { trust } else { 1e-6 },
            prior: &self.prior,
            below: if by_stylus { BELOW } else { 1.0 },
            law,
        };
        self.bank.begin(&start);
        if !self.prior.is_known() {
            self.known_s = 0.0;
        }
        self.since_s = 0.0;
        self.unweighed_s = WEIGHED_S;
        self.stage = Stage::Moves;
        self.seen = Seen { informed: there || law.is_some(), p_travel: trust, ..Seen::NOTHING };
    }

    /// The object moves again in the same slip: the hypotheses have gone on meanwhile.
    fn resume(&mut self, force_n: f32) {
        self.stylus.start();
        self.bank.resume(force_n);
        self.since_s = 0.0;
        self.stage = Stage::Moves;
    }

    /// Takes a sample of the slip.
    pub fn push(&mut self, reading: &Reading) {
        let finite = reading.force_n.is_finite();
        let force_n = if finite { reading.force_n.clamp(0.0, MOST_N) } else { self.last_n };
        let reading = &Reading { force_n, ..*reading };
        let dt_s = self.alarm.dt_s;
        self.travel.push(reading.travel_m, dt_s);
        let fresh = reading.stylus.filter(|x| self.last != Some(*x));
        self.last = reading.stylus;
        self.missing_s = if fresh.is_some() { 0.0 } else { self.missing_s + dt_s };
        if self.has_stylus && self.missing_s >= LOST_S {
            self.has_stylus = false;
            self.bank.lose_stylus(TRUST);
        }
        if let Some(x) = reading.stylus.filter(|_| self.has_stylus) {
            let seen = self.stylus.push(x);
            let counts = self.stage == Stage::Moves && self.bank.counts_turns();
            if let Some(seen) = seen.filter(|_| counts) {
                if let Turn::Turned { ends } = seen.turn {
                    self.bank.turn(ends);
                }
                if seen.turn != Turn::Between {
                    self.bank.extreme(seen.within_s);
                }
            }
        }
        self.filled += 1;
        if self.filled >= self.samples {
            self.filled = 0;
            self.block(reading);
        }
    }

    fn block(&mut self, reading: &Reading) {
        self.known_s += self.block_s;
        let sunk = reading.sinks_per_n * (reading.force_n - self.last_n);
        self.last_n = reading.force_n;
        let power = self.stylus.block(sunk).filter(|_| self.has_stylus);
        let travel = self.travel.block();
        match self.stage {
            Stage::Rests if !self.runs => self.rest(reading),
            stage => {
                self.since_s += self.block_s;
                self.bank.go(reading.force_n);
                if self.travel.is_there() {
                    self.bank.travel(travel);
                } else {
                    self.bank.lose_travel();
                }
                if let Some(power) = power {
                    self.bank.amplitude(power.square, power.noise);
                }
                self.unweighed_s += self.block_s;
                if self.unweighed_s > WEIGHED_S - 0.5 * self.block_s {
                    self.bank.weigh(AHEAD_S + reading.dead_s);
                    self.unweighed_s = 0.0;
                    if self.travel.is_there() {
                        self.bank.draw(WEIGHED_S);
                    }
                }
                if stage == Stage::Rests {
                    self.bank.resume(reading.force_n);
                    self.rest(reading);
                    return;
                }
                self.report();
                if self.is_over(reading) {
                    self.stop();
                }
            }
        }
    }

    /// What the bank says, with what the sensors show.
    fn report(&mut self) {
        let summary = self.bank.summary;
        let there = self.travel.is_there();
        let trusted = there && self.travel.is_fine() && summary.p_travel > 0.5;
        let informed = there || self.has_stylus;
        if informed {
            self.needed = Some(summary.whole_n);
        }
        self.seen = Seen {
            informed,
            far: trusted && self.travel.y() > FAR_M,
            p_travel: summary.p_travel,
            p_null: summary.p_null,
        };
    }

    /// Whether the object has stopped.
    fn is_over(&self, reading: &Reading) -> bool {
        if self.since_s <= LEAST_S {
            return false;
        }
        let there = self.travel.is_there();
        let fine = there && self.travel.is_fine();
        let p_travel = self.seen.p_travel;
        let stylus = !self.has_stylus || self.stylus.stands();
        let travel = !there || (!fine && self.has_stylus) || p_travel < 0.5 || self.travel.stands();
        let trusted = fine && p_travel > 0.9 && self.travel.stood_s > TRAVEL_ALONE_S;
        if !self.has_stylus && (!there || p_travel < 0.5) {
            return !reading.evident;
        }
        (stylus && travel) || trusted
    }

    /// The slip has ended for the methods.
    pub fn end(&mut self) {
        if self.stage == Stage::Moves {
            self.stop();
        }
    }

    /// The object has stopped.
    fn stop(&mut self) {
        let Seen { informed, far, p_travel, p_null } = self.seen;
        if self.travel.is_there() {
            self.trust = p_travel.clamp(LEAST_TRUST, TRUST);
        }
        let held = p_null > if self.prior.is_known() { 0.4 } else { 0.5 };
        if informed && (far || !held) {
            self.bank.learn(&mut self.prior);
        }
        self.stage = Stage::Rests;
        self.runs = true;
        self.rested_s = 0.0;
        self.stylus.stop();
        self.bank.rest(self.travel.y());
        self.travel.rest(1.0);
    }

    /// Whether it moves again.
    fn rest(&mut self, reading: &Reading) {
        let force_n = reading.force_n;
        self.rested_s += self.block_s;
        let there = self.alarm.travel.is_some() && self.travel.is_there();
        let fine = there && self.travel.is_fine() && self.trust > 0.5;
        let y = self.travel.y().abs();
        let least_m = self.travel.moved_again_m(self.has_stylus);
        let advances = there && self.trust > ALARMS_FROM && y > least_m && self.rested_s > 4e-3;
        let stands = fine && y < 0.5 * least_m;
        let soon = self.rested_s < AGAIN_S;
        // Where no sensor shows the course of a slip, the methods show that it goes on.
        let alarms = match (self.has_stylus, there) {
            (true, _) => self.stylus.moves_again(self.block_s, soon, stands),
            (false, true) if self.trust > 0.5 => false,
            (false, _) => reading.evident,
        };
        // The hypotheses, which go on, know whether the object needs more than it has.
        let needs = !self.runs || !fine || self.bank.summary.p_null < HELD || y > FAR_M;
        if (alarms || advances) && needs {
            if self.runs {
                self.resume(force_n);
            } else {
                self.start(force_n, y, alarms);
            }
        } else if there {
            let share = if self.trust > ALARMS_FROM { 0.02 } else { 0.2 };
            if !self.runs {
                self.travel.rest(share);
            }
        }
    }
}

#[cfg(test)]
mod tests;
