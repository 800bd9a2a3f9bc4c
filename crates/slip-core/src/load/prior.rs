//! What is known of the object's needed force before a slip: nothing, what a memory states, or what earlier slips have shown.

use super::math::{at_least, at_most, exp, ln};

/// Bins of the logarithm of the needed force: their number, the first one (ln N), and their width.
const BINS: usize = 180;
const FIRST: f32 = -3.0;
const WIDTH: f32 = 0.05;
/// Deviation by which what a slip has shown is widened, and that of what a memory states.
const WIDENED: f32 = 0.09;
const REMEMBERED: f32 = 0.2;
/// Probability that this is another object, or that the slips before were mistaken.
const OTHER: f32 = 0.15;
/// An object of which nothing is known: its probability falls with this power of the needed force.
const POWER: f32 = 0.3;
/// Deviation of the share of the load at which a known object breaks away: about all of it, once the load had this time to come (s).
const BREAKS: f32 = 0.35;
const COMES_S: f32 = 0.3;
/// An object that was held for this long (s) while the force fell bears its load.
const LOADED_S: f32 = 0.7;
/// The same where the force falls until the object slips.
const SEARCHED: f32 = 0.15;

/// A distribution over the needed force.
#[derive(Clone, Debug)]
pub(super) struct Prior {
    bins: [f32; BINS],
    known: bool,
    /// Whether its load has been there for long.
    loaded: bool,
    /// How much of the load is expected, and with which deviation.
    comes: f32,
    breaks: f32,
    searched: bool,
}

impl Prior {
    /// Nothing is known.
    pub(super) const NONE: Self = Self {
        bins: [0.0; BINS],
        known: false,
        loaded: false,
        comes: 0.0,
        breaks: BREAKS,
        searched: false,
    };

    /// Whether anything is known: of the need, or that the load is there.
    pub(super) fn is_known(&self) -> bool {
        self.known || self.loaded
    }

    /// Whether the load is there, and the force has fallen until the object slips.
    pub(super) fn is_searched(&self) -> bool {
        (self.known || self.loaded) && self.searched
    }

    /// Forgets the object.
    pub(super) fn forget(&mut self) {
        self.known = false;
    }

    /// A memory states that the object needs `need_n` (N).
    pub(super) fn remember(&mut self, need_n: f32) {
        self.spread(core::iter::once((ln(at_least(need_n, 1e-3)), 1.0)), REMEMBERED);
    }

    /// A slip has shown these logarithms with these weights.
    pub(super) fn learn(&mut self, cells: impl Iterator<Item = (f32, f32)>) {
        self.spread(cells.filter(|(_, w)| *w > 1e-6), WIDENED);
    }

    fn spread(&mut self, cells: impl Iterator<Item = (f32, f32)>, deviation: f32) {
        let mut bins = [0.0; BINS];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few bins")]
        let reach = (3.0 * deviation / WIDTH) as usize + 1;
        for (need_ln, w) in cells {
            let at = at_most(at_least((need_ln - FIRST) / WIDTH, 0.0), BINS as f32 - 1.0);
            let middle = whole(at);
            let from = middle.saturating_sub(reach);
            for (bin, place) in bins.iter_mut().zip(0_u16..).skip(from).take(2 * reach + 1) {
                let off = (f32::from(place) + 0.5 - at) * WIDTH / deviation;
                *bin += w * exp(-0.5 * off * off);
            }
        }
        let sum: f32 = bins.iter().sum();
        if sum > 0.0 {
            for (bin, new) in self.bins.iter_mut().zip(bins) {
                *bin = new / sum;
            }
            self.known = true;
        }
    }

    /// Since when (s) the load has been coming, for how long (s) the object was held, and whether the force falls until it slips.
    pub(super) fn expect(&mut self, since_s: f32, held_s: f32, searched: bool) {
        self.loaded = searched && held_s > LOADED_S;
        self.comes = if self.loaded { 1.0 } else { at_most(since_s / COMES_S, 1.0) };
        self.breaks = if searched { SEARCHED } else { BREAKS };
        self.searched = searched;
    }

    /// Where the distribution begins (ln N).
    pub(super) fn least_ln(&self) -> Option<f32> {
        let mut below = 0.0;
        self.bins
            .iter()
            .zip(0_u16..)
            .find(|(bin, _)| {
                below += **bin;
                below > 0.02
            })
            .map(|(_, place)| FIRST + WIDTH * f32::from(place))
            .filter(|_| self.known)
    }

    /// Logarithm of the probability of a cell at `need_ln` of a grid with this step and so many forces, `over` the force at the alarm, with this
    /// ratio of static and kinetic friction.
    pub(super) fn ln(&self, need_ln: f32, step: f32, forces: usize, over: f32, ratio: f32) -> f32 {
        let least = if self.searched { 0.5 } else { 1.0 };
        let off = ln(at_least(over / ratio, least)) / self.breaks;
        let breaks = -0.5 * off * off * self.comes;
        if !self.known {
            return -POWER * ln(at_least(over, 1.0)) + if self.loaded { breaks } else { 0.0 };
        }
        let at = at_most(at_least((need_ln - FIRST) / WIDTH, 0.0), BINS as f32 - 1.0);
        let here = self.bins.get(whole(at)).copied().unwrap_or(0.0);
        let flat = OTHER / forces as f32 * if over > 1.0 { 1.0 } else { 0.3 };
        let seen = ln((1.0 - OTHER) * here / WIDTH * step + flat + 1e-6);
        seen + breaks
    }
}

/// The bin that a place from 0 on is in.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to BINS")]
fn whole(place: f32) -> usize {
    place as usize
}

#[cfg(test)]
mod tests;
