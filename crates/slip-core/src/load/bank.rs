//! The posterior: simulated objects of every hypothesis, weighed by what each sensor shows of them.
//!
//! A cell is a needed force N, a time T in which the load comes, and a contact; its state is distance x, speed v, load u over the weight, and shear
//! z of the pad. Each cell stands in two *modes* of the travel: FOLLOWED, where the travel corrects it, and FREE, where it runs without.
//! `docs/control.md` has the equations and the sources of the numbers.

use super::{
    gains::Gains,
    grid::Grid,
    math::{at_least, at_most, exp, ln},
    prior::Prior,
};
use crate::estimate::G_M_S2;

/// Speed over which static friction fades (m/s).
const STRIBECK_M_S: f32 = 5e-3;
/// Damping of a pad over the needed force (s/m^2 times N).
const DAMPING: f32 = 1400.0;
/// Time constants of the sums over blocks, and of those of the travel (s).
const FORGET_S: f32 = 0.08;
/// Deviation of the load at an alarm, and growth of its variance in a second: while it comes, and once it is there.
const LOAD: [f32; 2] = [0.1, 0.03];
const LOAD_S: [f32; 2] = [1.0, 0.04];
/// The same where a known object slips that was held with enough: something hits or pulls it.
const JUMPS: f32 = 0.4;
const JUMPS_S: f32 = 1.0;
/// Largest correction of the load by one reading.
const CORRECTS: f32 = 0.2;
/// How little the stiffness of pads is known: share of the evidence of a motion that shears them which counts for some smooth motion.
const SWINGS: f32 = 0.8;
/// A load above its bound costs this much times its square.
const OVER: f32 = 10.0;
/// A mode in which the travel follows some smooth motion has a rate of this many nats a second against it.
const FREE_S: f32 = 100.0;
/// The same for a stylus that shows another slip (nats), and for one that shows none: sensors fail silent.
const STYLUS_LOST: f32 = -8.0;
const STYLUS_SILENT: f32 = -2.0;
/// A travel this fast (m/s) is not silent: that it shows no object has this rate of nats a second against it.
const TRAVEL_M_S: f32 = 5e-3;
const TRAVEL_FAST_S: f32 = 400.0;
/// Weight of the free cells where there is no stylus (nats).
const UNCONTRADICTED: f32 = -30.0;
/// Cells that run free are drawn to the others within this time (s), and stay within so many nats.
const DRAWN_S: f32 = 5e-3;
const BEHIND: f32 = 7.0;
/// What is slower than this (m/s) still shows that much: a stylus that stands explains no smooth surface.
const CREEP_M_S: f32 = 1e-4;
/// Turns: spread of the logarithm of their distance, and of its mean over surfaces; that of all is 100 um.
const TURN_SPREAD: f32 = 0.45;
const SURFACE_SPREAD: f32 = 0.8;
const TURN_LN: f32 = -9.210_34;
const LATE_TURN: f32 = 0.35;
/// A distance that is further from it than this (logarithm) counts as this: an outlier.
const OUTLIER: f32 = 1.6;
const LEAST_M: f32 = 1e-7;
/// What moves less in a block (m) shears the pad as the load on it states.
const LEAST_WAY_M: f32 = 1e-9;
/// What is slower than this (m/s) at a turn may be turning back, which the pads do about so often a second (logarithm).
const REVERSES_M_S: f32 = 2e-3;
const REVERSES_LN: f32 = 3.0;
/// Weight of what is believed of the slope of a surface before (blocks).
const SLOPE_BLOCKS: f32 = 0.25;
/// Distance in which heights change (m): blocks that are closer state the same, down to this share.
const CHANGES_M: f32 = 1e-4;
const LEAST_SHARE: f32 = 0.03;
/// Cells of less weight than this count in no mean.
const NEGLIGIBLE: f32 = 3e-4;
/// Most needed forces of a grid.
const MOST_FORCES: usize = 32;
/// A need within this logarithm of the force at the alarm is none: the object is held.
const NULL: f32 = 0.02;
/// Growth of the load in time is looked ahead this far (s), besides the dead time of the drive.
pub(super) const AHEAD_S: f32 = 4e-3;

/// Every cell.
type Cells<const H: usize> = [f32; H];

/// How a signal follows the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    /// Bounds of the root of its power over the distance, for a block.
    pub(super) slope: [f32; 2],
    /// Whether peaks and valleys count.
    pub(super) turns: bool,
    /// What is left of a vibration after a block: the finger rings.
    pub(super) rings: f32,
    /// Weight of a block, where that does not follow from the distance.
    pub(super) weight: Option<f32>,
}

/// What is known at an alarm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<'a> {
    /// Force of a finger (N), and the largest there is.
    pub(super) force_n: f32,
    pub(super) most_n: f32,
    /// Distance that the object has moved (m).
    pub(super) moved_m: f32,
    /// Length of a block (s).
    pub(super) d_s: f32,
    /// Probability that the travel shows the object.
    pub(super) trust: f32,
    /// What is known of the object.
    pub(super) prior: &'a Prior,
    /// Weight of a need below the force at the alarm.
    pub(super) below: f32,
    /// How the signal follows the distance; `None`: it has no part.
    pub(super) law: Option<Law>,
}

/// One mode of the travel: each field for all cells, so that one instruction takes several.
#[derive(Clone, Debug)]
struct Mode<const H: usize> {
    x: Cells<H>,
    v: Cells<H>,
    u: Cells<H>,
    z: Cells<H>,
    /// Distance in the last block (m), and its square behind the ringing of the finger.
    before: Cells<H>,
    echo: Cells<H>,
    /// Share of a motion that shears the pad.
    shears: Cells<H>,
    /// Log-likelihood of the travel.
    travel: Cells<H>,
    /// Weighted sums over the blocks: squares of the distance, logarithms of the variances, squares of the readings over those.
    squares: Cells<H>,
    logs: Cells<H>,
    misfit: Cells<H>,
    /// Place and speed at the extreme that is looked for, and place of the last turn.
    extreme: Cells<H>,
    extreme_v: Cells<H>,
    turn: Cells<H>,
    /// Sums over the turns.
    ln: Cells<H>,
    ln2: Cells<H>,
    jacobian: Cells<H>,
    /// Logarithm of the weight, and the weight.
    l: Cells<H>,
    w: Cells<H>,
}

impl<const H: usize> Mode<H> {
    const EMPTY: Self = {
        let z = [0.0; H];
        Self {
            x: z,
            v: z,
            u: z,
            z,
            before: z,
            echo: z,
            shears: z,
            travel: z,
            squares: z,
            logs: z,
            misfit: z,
            extreme: z,
            extreme_v: z,
            turn: z,
            ln: z,
            ln2: z,
            jacobian: z,
            l: z,
            w: z,
        }
    };

    fn begin(&mut self, trust: f32) {
        self.travel = [ln(trust); H];
        for sums in [
            &mut self.squares,
            &mut self.logs,
            &mut self.misfit,
            &mut self.ln,
            &mut self.ln2,
            &mut self.jacobian,
            &mut self.echo,
        ] {
            sums.fill(0.0);
        }
    }
}

/// Some smooth motion that the readings of the travel follow: the filter of the cells without an object.
#[derive(Clone, Copy, Debug, Default)]
struct Track {
    x: f32,
    v: f32,
    u: f32,
}

/// Quantiles of the needed force (N), and what else the cells say together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Summary {
    /// Need of the whole load: 10, 50 and 90 %.
    pub(super) whole_n: [f32; 3],
    /// Mean speed (m/s).
    pub(super) speed_m_s: f32,
    /// Probability that the travel shows the object, and that it needs no more than it had.
    pub(super) p_travel: f32,
    pub(super) p_null: f32,
}

/// The distribution.
#[derive(Clone, Debug)]
pub(super) struct Bank<const H: usize> {
    grid: Grid,
    modes: [Mode<H>; 2],
    need: Cells<H>,
    need_ln: Cells<H>,
    per_n: Cells<H>,
    ratio: Cells<H>,
    stiffness: Cells<H>,
    damping: Cells<H>,
    rate: Cells<H>,
    load_most: Cells<H>,
    prior: Cells<H>,
    track: Track,
    gains: [Gains; 2],
    law: Option<Law>,
    d_s: f32,
    silent: bool,
    jumps: bool,
    from_n: f32,
    /// Logarithm of the force under which it is held where it needs no more.
    null_ln: f32,
    norm: f32,
    power: f32,
    weight: f32,
    turns: f32,
    pub(super) summary: Summary,
}

const FOLLOWED: usize = 0;
const FREE: usize = 1;

impl<const H: usize> Bank<H> {
    /// An empty one; `H` has to be the cells of the grid.
    pub(super) const fn new(grid: Grid) -> Self {
        assert!(grid.cells() == H && H.is_multiple_of(8));
        let z = [0.0; H];
        Self {
            grid,
            modes: [Mode::EMPTY; 2],
            need: z,
            need_ln: z,
            per_n: z,
            ratio: z,
            stiffness: z,
            damping: z,
            rate: z,
            load_most: z,
            prior: z,
            track: Track { x: 0.0, v: 0.0, u: 0.0 },
            gains: [Gains::NONE; 2],
            law: None,
            d_s: 3e-4,
            silent: false,
            jumps: false,
            from_n: 1.0,
            null_ln: 0.0,
            norm: 0.0,
            power: 0.0,
            weight: 0.0,
            turns: 0.0,
            summary: Summary { whole_n: [0.0; 3], speed_m_s: 0.0, p_travel: 0.0, p_null: 0.0 },
        }
    }

    /// An alarm: objects that have moved by `moved_m` since they began to.
    pub(super) fn begin(&mut self, start: &Start<'_>) {
        let from_n = start.force_n.max(1e-3);
        (self.d_s, self.from_n, self.law) = (start.d_s, from_n, start.law);
        (self.power, self.weight, self.turns) = (0.0, 0.0, 0.0);
        self.null_ln = ln(from_n);
        let known = start.prior.is_known();
        let searched = start.prior.is_searched();
        let mut first_ln = ln(from_n) - 1.5 * self.grid.step;
        if let Some(least_ln) = start.prior.least_ln() {
            first_ln = at_most(first_ln, least_ln - self.grid.step);
        }
        let mut h = 0;
        let grid = self.grid;
        for contact in grid.contacts {
            let shear = contact.shear_m_n;
            let p = contact.p;
            for (ramp, known_ratio) in grid.ramps.iter().zip(grid.ratios) {
                let ratio = if searched { *known_ratio } else { contact.ratio };
                let ramp_s = if searched { 0.0 } else { ramp.s };
                let mut need_ln = first_ln;
                for _ in 0..grid.forces {
                    // There are as many: nothing can panic.
                    if h >= H {
                        break;
                    }
                    let need = exp(need_ln);
                    let over = need / from_n;
                    let broke = from_n * ratio / need;
                    self.need[h] = need;
                    self.need_ln[h] = need_ln;
                    self.per_n[h] = 1.0 / need;
                    self.ratio[h] = ratio;
                    self.rate[h] = if ramp_s > 0.0 { 1.0 / ramp_s } else { 0.0 };
                    self.stiffness[h] = G_M_S2 / (need * shear);
                    self.damping[h] = DAMPING / need;
                    self.load_most[h] = if known { at_least(2.0 * broke, 1.0) } else { 1.0 };
                    let mut prior = ln(ramp.p * p);
                    prior += start.prior.ln(need_ln, grid.step, grid.forces, over, ratio);
                    if !known && over < 1.0 {
                        prior += ln(start.below);
                    }
                    if need > 1.3 * start.most_n {
                        prior -= 8.0;
                    }
                    self.prior[h] = prior;
                    self.place(h, start.moved_m, shear, broke, known);
                    need_ln += grid.step;
                    h += 1;
                }
            }
        }
        let trust = start.trust.clamp(1e-6, 0.99);
        let [followed, free] = &mut self.modes;
        free.x = followed.x;
        free.v = followed.v;
        free.u = followed.u;
        free.z = followed.z;
        for (mode, trust) in [(followed, trust), (free, 1.0 - trust)] {
            mode.begin(trust);
            mode.extreme = mode.x;
            mode.turn = mode.x;
            mode.extreme_v = mode.v;
            mode.before = mode.x;
        }
        self.norm = log_sum(&self.prior);
        self.track = Track { x: start.moved_m, v: 3e-3, u: 0.0 };
        // What makes a known object slip that is held with enough is another load.
        self.jumps = known && !searched;
        self.gains = LOAD.map(|load| Gains::begin(if self.jumps { JUMPS } else { load }));
        self.summary =
            Summary { whole_n: [from_n; 3], speed_m_s: 0.02, p_travel: trust, p_null: 0.0 };
    }

    /// Where the object of cell `h` is at the alarm.
    fn place(&mut self, h: usize, moved_m: f32, shear: f32, broke: f32, known: bool) {
        let (need, from_n, rate) = (self.need[h], self.from_n, self.rate[h]);
        let at_once = rate <= 0.0;
        let below = need < from_n;
        let sheared = from_n * shear * self.ratio[h];
        let most = self.load_most[h];
        let z = if known { at_most(sheared, need * shear) } else { at_most(moved_m, sheared) };
        let (v, u);
        if known && broke > 1.0 {
            // Held by the pads: their swing, or a load that grows.
            u = at_most(1.0 + 4e-3 * rate, most);
            v = if at_once { 5e-4 } else { at_most(need * shear * rate, 2e-3) };
        } else if moved_m > sheared + 3e-7 || known {
            let slid = at_least(moved_m - z, 1e-6) + 2e-7;
            if at_once {
                u = if broke < 1.0 || !known { 1.0 } else { 1.1 * broke };
                let a = G_M_S2 * at_least(u - from_n / need, 0.02);
                let early = at_most(libm::sqrtf(2.0 * slid / a), 0.015);
                v = if below && !known { 1e-3 } else { a * early };
            } else {
                let top = at_least(most, broke);
                let a = G_M_S2 * at_least(top - from_n / need, 0.03);
                let comes = libm::cbrtf(6.0 * slid / (G_M_S2 * rate));
                let early = at_most(at_least(comes, libm::sqrtf(2.0 * slid / a)), 0.015);
                let grows = G_M_S2 * rate;
                let ramps = at_most(early, a / grows);
                let speed = 0.5 * grows * ramps * ramps + a * (early - ramps);
                v = if below && !known { 1e-3 } else { speed };
                u = at_most(broke + early * rate, top);
            }
        } else if at_once {
            let squared = 2.0 * G_M_S2 * moved_m - self.stiffness[h] * moved_m * moved_m;
            let speed = libm::sqrtf(at_least(squared, 1e-6));
            v = if below { at_most(speed, 5e-3) } else { speed };
            u = 1.0;
        } else {
            let comes = libm::cbrtf(6.0 * moved_m / (G_M_S2 * rate));
            let takes = at_most(at_least(comes, moved_m / (need * shear * rate)), 0.05);
            u = at_most(takes * rate, 1.0);
            v = at_most(0.5 * G_M_S2 * rate * takes * takes, 1.5 * need * shear * rate);
        }
        let mode = &mut self.modes[FOLLOWED];
        mode.x[h] = moved_m;
        mode.v[h] = v;
        mode.u[h] = u;
        mode.z[h] = z;
    }

    /// The object has stopped at `y` (m), from where the distance counts.
    pub(super) fn rest(&mut self, y: f32) {
        for mode in &mut self.modes {
            for x in [&mut mode.x, &mut mode.before, &mut mode.extreme, &mut mode.turn] {
                for x in x {
                    *x -= y;
                }
            }
        }
        self.track.x -= y;
    }

    /// The object moves again under `force_n` (N).
    pub(super) fn resume(&mut self, force_n: f32) {
        self.null_ln = ln(at_least(force_n, 1e-3));
    }

    /// One block under `force_n` (N).
    pub(super) fn go(&mut self, force_n: f32) {
        let d = self.d_s;
        for mode in &mut self.modes {
            mode.before = mode.x;
            for h in 0..H {
                let (v, z, u) = (mode.v[h], mode.z[h], mode.u[h]);
                let over = v * (1.0 / STRIBECK_M_S);
                let friction = G_M_S2 * force_n * self.per_n[h];
                let friction = friction * (1.0 + (self.ratio[h] - 1.0) / (1.0 + over * over));
                let (stiffness, damping) = (self.stiffness[h], self.damping[h]);
                let most = friction / stiffness;
                let load = at_most(at_least(z / most, -1.0), 1.0);
                let ahead = if load * v > 0.0 { 1.0 } else { 0.0 };
                let held = load * most;
                // Never further than to where all of a motion slides: a block may be longer than that takes.
                let left = most - held.abs() * ahead;
                let shears = 1.0 - load * load * ahead;
                let shears = at_most(shears, left / at_least(v.abs() * d, LEAST_WAY_M));
                let after = (v + d * (G_M_S2 * u - stiffness * held))
                    / (1.0 + d * shears * (damping + stiffness * d));
                mode.z[h] = held + shears * after * d;
                mode.x[h] += 0.5 * (v + after) * d;
                mode.v[h] = after;
                mode.shears[h] = shears;
                mode.u[h] = at_least(at_most(u + self.rate[h] * d, self.load_most[h]), u);
            }
        }
    }

    /// Travel: mean reading (m since the rest before the alarm) and its variance (m^2); `None` in a block without a reading.
    pub(super) fn travel(&mut self, reading: Option<TravelBlock>) {
        let d = self.d_s;
        for (gains, load_s) in self.gains.iter_mut().zip(LOAD_S) {
            let load_s = if self.jumps { JUMPS_S } else { load_s };
            gains.step(d, load_s, reading.map(|reading| reading.variance));
        }
        let Some(TravelBlock { y, .. }) = reading else { return };
        let keep = 1.0 - d / FORGET_S;
        let [comes, there] = self.gains;
        let track = &mut self.track;
        track.x += track.v * d + 0.5 * G_M_S2 * track.u * d * d;
        track.v += G_M_S2 * track.u * d;
        let e = y - track.x;
        track.x += comes.k[0] * e;
        track.v += comes.k[1] * e;
        track.u += comes.k[2] * e;
        let smooth = -0.5 * (at_most(e * e * comes.per_s, 30.0) + comes.ln_s);
        let [followed, free] = &mut self.modes;
        for h in 0..H {
            let most = self.load_most[h];
            let is_there = self.rate[h] == 0.0;
            let pick = |comes: f32, there: f32| if is_there { there } else { comes };
            let e = y - followed.x[h];
            let kx = pick(comes.k[0], there.k[0]) * e;
            followed.x[h] += kx;
            followed.v[h] += pick(comes.k[1], there.k[1]) * e;
            followed.z[h] += followed.shears[h] * kx;
            let du = at_most(at_least(pick(comes.k[2], there.k[2]) * e, -CORRECTS), CORRECTS);
            let u = at_most(at_least(followed.u[h] + du, 0.0), 1.08 * most);
            followed.u[h] = u;
            let over = at_least(u - most, 0.0);
            let misfit = at_most(e * e * pick(comes.per_s, there.per_s), 30.0);
            let ll = -0.5 * (misfit + pick(comes.ln_s, there.ln_s)) - OVER * over * over;
            let known = 1.0 - SWINGS * followed.shears[h];
            followed.travel[h] = followed.travel[h] * keep + smooth + known * (ll - smooth);
        }
        let fast = self.silent && self.track.v > TRAVEL_M_S;
        let against = if fast { TRAVEL_FAST_S } else { FREE_S };
        for l in &mut free.travel {
            *l = *l * keep + smooth - against * d;
        }
    }

    /// A travel that is absent since its last reading is no evidence of the object from here on.
    pub(super) fn lose_travel(&mut self) {
        for l in &mut self.modes[FOLLOWED].travel {
            *l -= 5.0;
        }
    }

    /// Without a stylus nothing contradicts the travel: it is believed as before the slip, with this probability.
    pub(super) fn lose_stylus(&mut self, trust: f32) {
        self.law = None;
        let trust = trust.clamp(1e-6, 0.99);
        for (mode, trust) in self.modes.iter_mut().zip([trust, 1.0 - trust]) {
            mode.travel = [ln(trust); H];
        }
    }

    /// Where the travel has proved right in motion, the free cells are drawn to it, so that they go on from there when it fails; `passed_s` (s)
    /// since it was done.
    pub(super) fn draw(&mut self, passed_s: f32) {
        if self.summary.p_travel < 0.9 || self.track.v.abs() < 2e-3 {
            return;
        }
        let share = passed_s / DRAWN_S;
        let [followed, free] = &mut self.modes;
        for (to, from) in [
            (&mut free.x, &followed.x),
            (&mut free.v, &followed.v),
            (&mut free.u, &followed.u),
            (&mut free.z, &followed.z),
            (&mut free.echo, &followed.echo),
            (&mut free.squares, &followed.squares),
            (&mut free.logs, &followed.logs),
            (&mut free.misfit, &followed.misfit),
            (&mut free.ln, &followed.ln),
            (&mut free.ln2, &followed.ln2),
            (&mut free.jacobian, &followed.jacobian),
            (&mut free.extreme, &followed.extreme),
            (&mut free.extreme_v, &followed.extreme_v),
            (&mut free.turn, &followed.turn),
        ] {
            for h in 0..H {
                to[h] += share * (from[h] - to[h]);
            }
        }
        let (a, b) = (largest(&followed.l), largest(&free.l));
        let lift = at_least(a - BEHIND - b, 0.0);
        for h in 0..H {
            let follows = at_most(at_least(followed.l[h] - a - free.l[h] + b, -20.0), 20.0);
            free.travel[h] += share * follows + lift;
        }
    }

    /// Power of the signal in a block, with that of the noise.
    pub(super) fn amplitude(&mut self, square: f32, noise: f32) {
        let Some(law) = self.law else { return };
        let d = self.d_s;
        let slides = (self.summary.speed_m_s * d / CHANGES_M).clamp(LEAST_SHARE, 1.0);
        let w = law.weight.unwrap_or(slides);
        let keep = 1.0 - d / FORGET_S;
        self.power = self.power * keep + w * (square - noise);
        self.weight = self.weight * keep + w;
        self.silent = self.power < self.weight * noise;
        let signal = at_least(self.power, 0.0) + 1e-3 * noise;
        let per_signal = noise / at_least(signal, 0.05 * noise * w);
        let (rings, creeps) = (law.rings, CREEP_M_S * d);
        for mode in &mut self.modes {
            for h in 0..H {
                let way = (mode.x[h] - mode.before[h]).abs();
                let way = at_least(at_most(way, mode.v[h].abs() * d + 2e-8), creeps);
                let echo = rings * mode.echo[h] + (1.0 - rings) * way * way;
                let squares = mode.squares[h] * keep + w * echo;
                let variance = echo + per_signal * squares;
                mode.echo[h] = echo;
                mode.squares[h] = squares;
                mode.logs[h] = mode.logs[h] * keep + w * ln(variance * 1e12);
                mode.misfit[h] = mode.misfit[h] * keep + w * square / variance;
            }
        }
    }

    /// Whether the turns of the stylus count in this slip.
    pub(super) fn counts_turns(&self) -> bool {
        self.law.is_some_and(|law| law.turns)
    }

    /// The stylus is further than at the extreme so far, `within_s` after the end of the last block.
    pub(super) fn extreme(&mut self, within_s: f32) {
        for mode in &mut self.modes {
            for h in 0..H {
                mode.extreme[h] = mode.x[h] + mode.v[h] * within_s;
                mode.extreme_v[h] = mode.v[h].abs();
            }
        }
    }

    /// The stylus has turned at the extreme; the first turn of a slip begins a distance and ends none.
    pub(super) fn turn(&mut self, ends: bool) {
        let mean = 1.0 / (self.turns + 1.0);
        for mode in &mut self.modes {
            if ends {
                for h in 0..H {
                    let way = ln(at_least((mode.extreme[h] - mode.turn[h]).abs(), LEAST_M));
                    // A surface has finer peaks too.
                    let way = at_most(at_least(way, TURN_LN - OUTLIER), TURN_LN + OUTLIER);
                    let speed = mode.extreme_v[h];
                    // An object that turns back on its pads turns the stylus wherever it is.
                    let back = speed < REVERSES_M_S;
                    let way = if back { (mode.ln[h] + TURN_LN) * mean } else { way };
                    let rate = ln(at_least(speed, 5e-4)) - way;
                    mode.ln[h] += way;
                    mode.ln2[h] += way * way;
                    mode.jacobian[h] += if back { REVERSES_LN } else { rate };
                }
            }
            mode.turn = mode.extreme;
        }
        self.turns += if ends { 1.0 } else { 0.0 };
    }

    /// From the sums to weights and quantiles; `ahead_s`: how far ahead the load is looked at (s).
    pub(super) fn weigh(&mut self, ahead_s: f32) {
        self.evidence();
        let lost = if self.silent { STYLUS_SILENT } else { STYLUS_LOST };
        let stylus = self.law.map(|_| log_sum(&self.modes[FREE].w) - self.norm + lost);
        let mut best = at_least(largest(&self.modes[FOLLOWED].l), largest(&self.modes[FREE].l));
        let followed = &mut self.modes[FOLLOWED];
        if let Some(stylus) = stylus {
            for h in 0..H {
                best = at_least(best, self.prior[h] + followed.travel[h] + stylus);
            }
        }
        let mut lost = [0.0_f32; 8];
        let mut sums = [0.0_f32; 2];
        for (mode, sum) in self.modes.iter_mut().zip(&mut sums) {
            for h in 0..H {
                mode.w[h] = exp(mode.l[h] - best);
            }
            *sum = total(&mode.w);
        }
        let followed = &mut self.modes[FOLLOWED];
        if let Some(stylus) = stylus {
            for h in 0..H {
                let p = exp(self.prior[h] + followed.travel[h] + stylus - best);
                lost[h % 8] += p;
                followed.w[h] += p;
            }
        }
        let lost: f32 = lost.iter().sum();
        let [in_time, free] = sums;
        self.conclude(1.0 / (in_time + free + lost), ahead_s);
    }

    /// Logarithms of prior and likelihoods: `l` of all, `w` without the travel.
    fn evidence(&mut self) {
        let each = 1.0 / (TURN_SPREAD * TURN_SPREAD);
        let surface = 1.0 / (SURFACE_SPREAD * SURFACE_SPREAD);
        let deviation2 = 1.0 / (self.turns * each + surface);
        let sharpness2 = 1.0 / (TURN_SPREAD * TURN_SPREAD + deviation2);
        let law =
            self.law.unwrap_or(Law { slope: [1.0; 2], turns: false, rings: 0.0, weight: None });
        let [least, most] = law.slope;
        let (least2, most2, believed) = (least * least, most * most, SLOPE_BLOCKS * least * most);
        let per_weight = 1.0 / (self.weight + SLOPE_BLOCKS);
        let half = 0.5 * self.weight;
        let (by_power, counted) =
            (if self.law.is_some() { 1.0 } else { 0.0 }, if law.turns { 1.0 } else { 0.0 });
        let constant = TURN_LN * TURN_LN * surface;
        // Without a stylus nothing contradicts the travel.
        let alone = if self.law.is_some() { 0.0 } else { UNCONTRADICTED };
        for (mode, alone) in self.modes.iter_mut().zip([0.0, alone]) {
            for h in 0..H {
                let k2 = (mode.misfit[h] + believed) * per_weight;
                let k2 = at_most(at_least(k2, least2), most2);
                let amplitude = -0.5 * (mode.logs[h] + mode.misfit[h] / k2) - half * ln(k2);
                let sum = mode.ln[h] * each + TURN_LN * surface;
                let mean = sum * deviation2;
                let open = ln(at_least((mode.x[h] - mode.turn[h]).abs(), LEAST_M));
                let late = at_least(open - mean - LATE_TURN, 0.0);
                let squares = mode.ln2[h] * each + constant - sum * mean;
                let turns = mode.jacobian[h] - 0.5 * (squares + late * late * sharpness2);
                let without = self.prior[h] + alone + by_power * amplitude + counted * turns;
                mode.w[h] = without;
                mode.l[h] = without + mode.travel[h];
            }
        }
    }

    /// Normalised weights, quantiles and means.
    fn conclude(&mut self, per_sum: f32, ahead_s: f32) {
        let forces = self.grid.forces;
        let mut whole = [0.0_f32; MOST_FORCES];
        let (mut load, mut counted) = (0.0, 0.0);
        let mut summary = Summary { p_travel: 0.0, speed_m_s: 0.0, p_null: 0.0, ..self.summary };
        for (k, mode) in self.modes.iter_mut().enumerate() {
            for w in &mut mode.w {
                *w *= per_sum;
            }
            for w in mode.w.chunks_exact(forces.max(1)) {
                for (sum, w) in whole.iter_mut().zip(w) {
                    *sum += w;
                }
            }
            if k == FOLLOWED {
                summary.p_travel = total(&mode.w);
            }
            for h in 0..H {
                let w = mode.w[h];
                if w < NEGLIGIBLE {
                    continue;
                }
                summary.speed_m_s += w * mode.v[h].abs();
                load += w * at_least(mode.u[h], 1.0);
                counted += w;
                let (u, most) = (mode.u[h], self.load_most[h]);
                let soon = at_least(at_most(u + self.rate[h] * ahead_s, most), u);
                let need = self.need_ln[h] + ln(at_least(soon, 0.02));
                if need < self.null_ln + NULL {
                    summary.p_null += w;
                }
            }
        }
        let first_ln = self.need_ln.first().copied().unwrap_or_default();
        // What hits or pulls the object may be more than its weight.
        let load = if self.jumps && counted > 0.0 { load / counted } else { 1.0 };
        let whole = whole.get(..forces).unwrap_or(&whole);
        summary.whole_n = [0.1, 0.5, 0.9]
            .map(|share| load * exp(first_ln + self.grid.step * quantile(whole, share)));
        self.summary = summary;
    }

    /// What this slip has shown of the weight.
    pub(super) fn learn(&self, prior: &mut Prior) {
        let cells = self.modes.iter().flat_map(|mode| self.need_ln.iter().zip(&mode.w));
        prior.learn(cells.map(|(ln, w)| (*ln, *w)));
    }
}

/// Readings of the travel in a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct TravelBlock {
    /// Mean since the rest before the alarm (m).
    pub(super) y: f32,
    /// Variance of that mean (m^2).
    pub(super) variance: f32,
}

/// The place in `bins`, with fractions, below which `share` of the distribution lies.
fn quantile(bins: &[f32], share: f32) -> f32 {
    let share = share * bins.iter().sum::<f32>();
    let (mut below, mut place) = (0.0, -0.5);
    for bin in bins {
        if below + bin >= share {
            return place + (share - below) / at_least(*bin, 1e-9);
        }
        below += bin;
        place += 1.0;
    }
    place
}

/// The largest of all cells.
fn largest<const H: usize>(l: &Cells<H>) -> f32 {
    let mut most = [f32::NEG_INFINITY; 8];
    for cells in l.chunks_exact(8) {
        for (most, l) in most.iter_mut().zip(cells) {
            *most = at_least(*most, *l);
        }
    }
    most.iter().fold(f32::NEG_INFINITY, |a, b| at_least(a, *b))
}

/// The sum of all cells.
fn total<const H: usize>(w: &Cells<H>) -> f32 {
    let mut sums = [0.0_f32; 8];
    for cells in w.chunks_exact(8) {
        for (sum, w) in sums.iter_mut().zip(cells) {
            *sum += w;
        }
    }
    sums.iter().sum()
}

/// Logarithm of the sum of the exponentials.
fn log_sum<const H: usize>(l: &Cells<H>) -> f32 {
    let top = largest(l);
    let mut sums = [0.0_f32; 8];
    for cells in l.chunks_exact(8) {
        for (sum, l) in sums.iter_mut().zip(cells) {
            *sum += exp(l - top);
        }
    }
    top + ln(sums.iter().sum::<f32>())
}

#[cfg(test)]
mod tests;
