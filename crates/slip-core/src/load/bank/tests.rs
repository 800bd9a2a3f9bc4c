//! The bank against the same equations, cell by cell, in `f64` and without a thought of speed.

extern crate std;
use super::super::grid::{Contact, Ramp};
use super::*;
use std::vec::Vec;

const CELLS: usize = 16;
const TOY: Grid = Grid {
    forces: 4,
    step: 0.4,
    ramps: &[Ramp { s: 0.0, p: 0.6 }, Ramp { s: 0.05, p: 0.4 }],
    ratios: &[1.05, 1.3],
    contacts: &[
        Contact { shear_m_n: 4e-6, ratio: 1.1, p: 0.7 },
        Contact { shear_m_n: 2e-5, ratio: 1.3, p: 0.3 },
    ],
};
const D_S: f64 = 3e-4;
const G: f64 = G_M_S2 as f64;

/// One cell in one mode.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    x: f64,
    v: f64,
    u: f64,
    z: f64,
    before: f64,
    shears: f64,
    travel: f64,
    squares: f64,
    logs: f64,
    misfit: f64,
    extreme: f64,
    extreme_v: f64,
    turn: f64,
    ln: f64,
    ln2: f64,
    jacobian: f64,
    l: f64,
}

/// A cell with what it stands for.
#[derive(Clone, Copy, Debug)]
struct Hypothesis {
    need: f64,
    ratio: f64,
    shear: f64,
    rate: f64,
    most: f64,
    prior: f64,
    modes: [Cell; 2],
}

/// A Kalman filter by matrices.
#[derive(Clone, Copy)]
struct Filter {
    p: [[f64; 3]; 3],
    k: [f64; 3],
    s: f64,
}

impl Filter {
    fn new(load: f64) -> Self {
        let p = [[9e-12, 0.0, 0.0], [0.0, 3.6e-5, 0.0], [0.0, 0.0, load * load]];
        Self { p, k: [0.0; 3], s: 0.0 }
    }

    fn step(&mut self, load_s: f64, r: f64) {
        let f = [[1.0, D_S, 0.0], [0.0, 1.0, G * D_S], [0.0, 0.0, 1.0]];
        let q = [1e-14, 2.4e-3 * D_S, load_s * D_S];
        let mut next = [[0.0_f64; 3]; 3];
        for (i, row) in next.iter_mut().enumerate() {
            for (j, place) in row.iter_mut().enumerate() {
                for (a, covariances) in self.p.iter().enumerate() {
                    for (b, covariance) in covariances.iter().enumerate() {
                        *place += f[i][a] * covariance * f[j][b];
                    }
                }
            }
            row[i] += q[i];
        }
        self.s = next[0][0] + r;
        self.k = [next[0][0] / self.s, next[1][0] / self.s, next[2][0] / self.s];
        for (i, row) in self.p.iter_mut().enumerate() {
            for (j, place) in row.iter_mut().enumerate() {
                *place = next[i][j] - self.k[i] * next[0][j];
            }
        }
    }
}

/// The whole bank.
struct Reference {
    cells: Vec<Hypothesis>,
    track: [f64; 3],
    filters: [Filter; 2],
    power: f64,
    weight: f64,
    silent: bool,
    turns: f64,
}

impl Reference {
    /// From the places at the alarm on.
    fn new(bank: &Bank<CELLS>) -> Self {
        let mut cells = Vec::new();
        for contact in TOY.contacts {
            for ramp in TOY.ramps {
                for _ in 0..TOY.forces {
                    let h = cells.len();
                    let cell = |mode: &Mode<CELLS>| Cell {
                        x: mode.x[h].into(),
                        v: mode.v[h].into(),
                        u: mode.u[h].into(),
                        z: mode.z[h].into(),
                        extreme: mode.extreme[h].into(),
                        extreme_v: mode.extreme_v[h].into(),
                        turn: mode.turn[h].into(),
                        travel: mode.travel[h].into(),
                        ..Cell::default()
                    };
                    cells.push(Hypothesis {
                        need: bank.need[h].into(),
                        ratio: contact.ratio.into(),
                        shear: contact.shear_m_n.into(),
                        rate: if ramp.s > 0.0 { 1.0 / f64::from(ramp.s) } else { 0.0 },
                        most: 1.0,
                        prior: bank.prior[h].into(),
                        modes: [cell(&bank.modes[0]), cell(&bank.modes[1])],
                    });
                }
            }
        }
        let track = [bank.track.x, bank.track.v, bank.track.u].map(f64::from);
        let filters = [Filter::new(0.1), Filter::new(0.03)];
        Self { cells, track, filters, power: 0.0, weight: 0.0, silent: false, turns: 0.0 }
    }

    fn each(&mut self, mut act: impl FnMut(&Hypothesis, &mut Cell, usize)) {
        for cell in &mut self.cells {
            let mut modes = cell.modes;
            for (mode, state) in modes.iter_mut().enumerate() {
                act(cell, state, mode);
            }
            cell.modes = modes;
        }
    }

    fn go(&mut self, force_n: f64) {
        self.each(|h, cell, _| {
            let stiffness = G / (h.need * h.shear);
            let damping = 1400.0 / h.need;
            let stribeck = 1.0 + (cell.v / 5e-3).powi(2);
            let friction = G * force_n / h.need * (1.0 + (h.ratio - 1.0) / stribeck);
            let most = friction / stiffness;
            let load = (cell.z / most).clamp(-1.0, 1.0);
            let shears = if load * cell.v > 0.0 { 1.0 - load * load } else { 1.0 };
            let held = load * most;
            let left = most - if load * cell.v > 0.0 { held.abs() } else { 0.0 };
            let shears = shears.min(left / (cell.v.abs() * D_S).max(1e-9));
            let push = cell.v + D_S * (G * cell.u - stiffness * held);
            let after = push / (1.0 + D_S * shears * (damping + stiffness * D_S));
            cell.before = cell.x;
            cell.z = held + shears * after * D_S;
            cell.x += 0.5 * (cell.v + after) * D_S;
            (cell.v, cell.shears) = (after, shears);
            cell.u = cell.u.max((cell.u + h.rate * D_S).min(h.most));
        });
    }

    fn travel(&mut self, y: f64, r: f64) {
        self.filters[0].step(1.0, r);
        self.filters[1].step(0.04, r);
        let [comes, there] = self.filters;
        let [x, v, u] = &mut self.track;
        *x += *v * D_S + 0.5 * G * *u * D_S * D_S;
        *v += G * *u * D_S;
        let e = y - *x;
        for (state, k) in self.track.iter_mut().zip(comes.k) {
            *state += k * e;
        }
        let ll = |e: f64, s: f64| -0.5 * ((e * e / s).min(30.0) + (s * 1e12).ln());
        let smooth = ll(e, comes.s);
        let against = if self.silent && self.track[1] > 5e-3 { 400.0 } else { 100.0 };
        self.each(|h, cell, mode| {
            let before = cell.travel * (1.0 - D_S / 0.08);
            if mode == FREE {
                cell.travel = before + smooth - against * D_S;
                return;
            }
            let filter = if h.rate == 0.0 { there } else { comes };
            let e = y - cell.x;
            cell.x += filter.k[0] * e;
            cell.v += filter.k[1] * e;
            cell.z += cell.shears * filter.k[0] * e;
            cell.u = (cell.u + (filter.k[2] * e).clamp(-0.2, 0.2)).clamp(0.0, 1.08 * h.most);
            let over = (cell.u - h.most).max(0.0);
            let own = ll(e, filter.s) - 10.0 * over * over;
            cell.travel = before + smooth + (1.0 - 0.8 * cell.shears) * (own - smooth);
        });
    }

    fn amplitude(&mut self, square: f64, noise: f64, speed_m_s: f64) {
        let w = (speed_m_s * D_S / 1e-4).clamp(0.03, 1.0);
        let keep = 1.0 - D_S / 0.08;
        self.power = self.power * keep + w * (square - noise);
        self.weight = self.weight * keep + w;
        self.silent = self.power < self.weight * noise;
        let signal = self.power.max(0.0) + 1e-3 * noise;
        let per_signal = noise / signal.max(0.05 * noise * w);
        self.each(|_, cell, _| {
            let way = (cell.x - cell.before).abs().min(cell.v.abs() * D_S + 2e-8).max(1e-4 * D_S);
            cell.squares = cell.squares * keep + w * way * way;
            let variance = way * way + per_signal * cell.squares;
            cell.logs = cell.logs * keep + w * (variance * 1e12).ln();
            cell.misfit = cell.misfit * keep + w * square / variance;
        });
    }

    fn extreme(&mut self, within_s: f64) {
        self.each(|_, cell, _| {
            cell.extreme = cell.x + cell.v * within_s;
            cell.extreme_v = cell.v.abs();
        });
    }

    fn turn(&mut self, ends: bool) {
        let mean = 1.0 / (self.turns + 1.0);
        self.each(|_, cell, _| {
            if ends {
                let back = cell.extreme_v < 2e-3;
                let way = (cell.extreme - cell.turn).abs().max(1e-7).ln();
                let way = way.clamp(1e-4_f64.ln() - 1.6, 1e-4_f64.ln() + 1.6);
                let way = if back { (cell.ln + 1e-4_f64.ln()) * mean } else { way };
                cell.ln += way;
                cell.ln2 += way * way;
                cell.jacobian += if back { 3.0 } else { cell.extreme_v.max(5e-4).ln() - way };
            }
            cell.turn = cell.extreme;
        });
        self.turns += f64::from(u8::from(ends));
    }

    /// Logarithms of the weights.
    fn weigh(&mut self, [least, most]: [f64; 2]) {
        let (each, surface) = (0.45_f64.powi(-2), 0.8_f64.powi(-2));
        let (turns, weight) = (self.turns, self.weight);
        self.each(|h, cell, _| {
            let k2 = (cell.misfit + 0.25 * least * most) / (weight + 0.25);
            let k2 = k2.clamp(least * least, most * most);
            let amplitude = -0.5 * (cell.logs + cell.misfit / k2) - 0.5 * weight * k2.ln();
            // Distances that are log-normal around a mean that is normal: the mean is integrated out.
            let precision = turns * each + surface;
            let sum = cell.ln * each + 1e-4_f64.ln() * surface;
            let mean = sum / precision;
            let squares = cell.ln2 * each + 1e-4_f64.ln().powi(2) * surface - sum * mean;
            let open = (cell.x - cell.turn).abs().max(1e-7).ln();
            let late = (open - mean - 0.35).max(0.0);
            let spread2 = 1.0 / each + 1.0 / precision;
            let turns = cell.jacobian - 0.5 * (squares + late * late / spread2);
            cell.l = h.prior + amplitude + turns + cell.travel;
        });
    }

    /// Whether both agree within 1e-3.
    fn compare(&self, bank: &Bank<CELLS>, block: usize) {
        for (h, hypothesis) in self.cells.iter().enumerate() {
            for (cell, mode) in hypothesis.modes.iter().zip(&bank.modes) {
                for (name, slow, fast, least) in [
                    ("x", cell.x, mode.x[h], 1e-5),
                    ("v", cell.v, mode.v[h], 1e-2),
                    ("u", cell.u, mode.u[h], 0.1),
                    ("z", cell.z, mode.z[h], 1e-5),
                    ("travel", cell.travel, mode.travel[h], 10.0),
                    ("l", cell.l, mode.l[h], 10.0),
                ] {
                    let off = (slow - f64::from(fast)).abs();
                    let most = 1e-3 * slow.abs().max(least);
                    assert!(off <= most, "{name} of {h} in block {block}: {slow} {fast}");
                }
            }
        }
    }
}

struct Random(u32);

impl Random {
    /// From -1 to 1.
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from(u16::try_from(self.0 >> 16).unwrap()) / 32_768.0 - 1.0
    }
}

fn alarm(prior: &Prior) -> Start<'_> {
    Start {
        force_n: 2.0,
        most_n: 60.0,
        moved_m: 6e-6,
        d_s: 3e-4,
        trust: 0.9,
        prior,
        below: 0.3,
        law: Some(Law { slope: [0.005, 0.3], turns: true, rings: 0.0, weight: None }),
    }
}

#[test]
fn the_bank_is_the_slow_one_over_random_slips() {
    for seed in 1..20 {
        let mut random = Random(seed);
        let mut bank = Bank::<CELLS>::new(TOY);
        bank.begin(&alarm(&Prior::NONE));
        let mut slow = Reference::new(&bank);
        let (mut force_n, mut y, mut v, mut ends) = (2.0_f32, 6e-6_f32, 0.01_f32, false);
        for block in 0..100 {
            force_n = (force_n + 0.1 * (random.next() + 0.3)).clamp(1.0, 20.0);
            v = (v + 3e-3 * (1.0 - force_n / 5.0)).max(4e-3);
            y += v * 3e-4;
            let speed_m_s = bank.summary.speed_m_s;
            bank.go(force_n);
            slow.go(force_n.into());
            if random.next() < 0.7 {
                let read = y + 1e-6 * random.next();
                bank.travel(Some(TravelBlock { y: read, variance: 1e-12 }));
                slow.travel(read.into(), 1e-12_f32.into());
            } else {
                bank.travel(None);
                for (filter, load_s) in slow.filters.iter_mut().zip([1.0, 0.04]) {
                    // A reading that is no evidence.
                    filter.step(load_s, 1e6);
                }
            }
            let square = (0.05 * v * 3e-4 * random.next()).powi(2) + 1e-15;
            bank.amplitude(square, 1e-14);
            slow.amplitude(square.into(), 1e-14_f32.into(), speed_m_s.into());
            if random.next() < -0.5 {
                bank.extreme(1e-4);
                slow.extreme(1e-4_f32.into());
                bank.turn(ends);
                slow.turn(ends);
                ends = true;
            }
            bank.weigh(AHEAD_S);
            slow.weigh([0.005_f32.into(), 0.3_f32.into()]);
            slow.compare(&bank, block);
        }
    }
}

/// Where an object slides fast, the pad shears within a part of a block: a force that rises brakes by its friction, and by nothing else.
#[test]
fn a_force_that_rises_brakes_what_slides_fast_by_its_friction_alone() {
    let prior = Prior::NONE;
    let start = Start {
        force_n: 1.0,
        most_n: 40.0,
        moved_m: 1e-5,
        d_s: 5e-4,
        trust: 0.97,
        prior: &prior,
        below: 1.0,
        law: None,
    };
    let mut bank = Bank::<CELLS>::new(TOY);
    bank.begin(&start);
    let mut before = [0.0; CELLS];
    for mode in &mut bank.modes {
        (mode.v, mode.u) = ([0.15; CELLS], [1.0; CELLS]);
    }
    let mut force_n = 1.0;
    for block in 0..20 {
        force_n *= 1.04;
        before.copy_from_slice(&bank.modes[FREE].v);
        bank.go(force_n);
        // The stiff contact: a soft pad takes longer to follow.
        for (h, before) in before.iter().enumerate().take(CELLS / 2) {
            let mode = &bank.modes[FREE];
            let over = 1.0 + (before / STRIBECK_M_S).powi(2);
            let friction = force_n / bank.need[h] * (1.0 + (bank.ratio[h] - 1.0) / over);
            let wanted = before + 5e-4 * G_M_S2 * (1.0 - friction);
            let slides = block > 2 && *before > 0.05;
            assert!(
                !slides || (mode.v[h] - wanted).abs() < 1e-3,
                "{block} {h}: {} {wanted}",
                mode.v[h]
            );
        }
    }
}

#[test]
fn a_quantile_is_where_the_weights_below_add_up_to_it() {
    // Each weight is spread over its bin: from half a place before it to half a place behind it.
    let bins = [0.0, 0.3, 0.3, 0.0, 0.4];
    for (share, wanted) in [(0.1, 0.833), (0.5, 2.167), (0.9, 4.25)] {
        let place = quantile(&bins, share);
        assert!((place - wanted).abs() < 1e-3, "{share}: {place}");
    }
}
