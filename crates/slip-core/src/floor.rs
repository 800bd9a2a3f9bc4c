//! Noise floor: the noise energy of each band, from energies of blocks of a signal at rest.
//!
//! The floor is learned once, from the first stretch of rest, and never rises afterwards: a floor that followed the
//! signal would learn the slip it should report. The stretch is cut into 16 parts and their median
//! is taken, so that one knock during learning does not raise the floor. A floor that was learned while the robot
//! moved is too high: where a later second is quieter than half of it, the floor falls to that, which
//! is counted. It can only make the detector more sensitive, and no slip can cause it.

use crate::settings::settings;

/// Parts whose median is the floor.
const PARTS: usize = 16;

/// A second whose median is below this fraction of the floor lowers it; for the narrowest default band (60 Hz, 7 degrees of
/// freedom in a part) a sound floor is undercut less than once in a day.
const LOWER_BELOW: f32 = 0.4;

/// Length of the stretches that may lower the floor (ms).
const LATER_MS: f32 = 1000.0;

/// Quartiles of a Gaussian variable lie this many deviations apart.
const QUARTILES: f32 = 1.349;

settings! {
    /// How the noise floor is found.
    pub struct FloorConfig as c in "floor" {
        learn_ms: f32 = 200.0, 10.0..=10_000.0 => "Length of the stretch of rest the floor is learned from (ms).";
        min_rms: f32 = 2e-9, 0.0..=1e12 =>
            "Smallest noise that is believed (signal unit, rms): the resolution of the sensor. 0: what its readings"
            "show, the smallest step between two of them over sqrt(12). That also counts where it is more, and most"
            "readings equal the one before: a coarse converter.";
    }
}

impl FloorConfig {
    /// The same for a signal in an unknown unit: the default, which is in metres, shows nothing of it.
    #[must_use]
    pub fn in_any_unit(self) -> Self {
        let given = self.min_rms != Self::default().min_rms;
        Self { min_rms: if given { self.min_rms } else { 0.0 }, ..self }
    }
}

/// The noise energy of `N` bands, or the measurement of it.
#[derive(Clone, Copy, Debug)]
pub struct Floor<const N: usize> {
    /// Least energy that is believed (signal unit squared): with the readings' own step, and by the configuration; 0 there leaves it to the step.
    min_energy: f32,
    configured: f32,
    later_len: u32,
    known: bool,
    energy: Option<[f32; N]>,
    /// The same without what rounding adds.
    measured: [f32; N],
    lowered: u32,
    part_len: u32,
    in_part: u32,
    done: usize,
    sum: [f32; N],
    parts: [[f32; N]; PARTS],
    /// Of the last stretch, until it is asked for.
    stretch: Option<Stretch<N>>,
}

/// What a stretch after the first one has shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch<const N: usize> {
    /// Deviation of the logarithm of the energy of its parts, from their quartiles.
    pub spread: [f32; N],
    /// Median energy of the parts over the floor that was known before.
    pub over_floor: [f32; N],
    /// Blocks in a part.
    pub part_blocks: u32,
}

impl<const N: usize> Floor<N> {
    /// A floor to be learned from blocks that come at `rate_hz`.
    #[must_use]
    pub fn learn(config: FloorConfig, rate_hz: f32) -> Self {
        Self {
            min_energy: config.min_rms * config.min_rms,
            configured: config.min_rms * config.min_rms,
            later_len: part_len(LATER_MS, rate_hz),
            known: false,
            energy: None,
            measured: [0.0; N],
            lowered: 0,
            part_len: part_len(config.learn_ms, rate_hz),
            in_part: 0,
            done: 0,
            sum: [0.0; N],
            parts: [[0.0; N]; PARTS],
            stretch: None,
        }
    }

    /// The same with at least `blocks` in each of the sixteen parts.
    #[must_use]
    pub fn with_parts_of(self, blocks: u32) -> Self {
        Self { part_len: self.part_len.max(blocks), later_len: self.later_len.max(blocks), ..self }
    }

    /// A floor that is known already: energies in signal units squared.
    #[must_use]
    pub fn known(config: FloorConfig, energy: [f32; N]) -> Self {
        let floor = Self::learn(config, 1.0);
        let least = energy.map(|e| e.max(floor.min_energy));
        Self { known: true, energy: Some(least), measured: energy, ..floor }
    }

    /// The floor, once it is known: energy of each band (signal unit squared).
    #[must_use]
    #[inline]
    pub fn energy(&self) -> Option<[f32; N]> {
        self.energy
    }

    /// How often a later, quieter second has lowered the floor.
    #[must_use]
    pub fn lowered(&self) -> u32 {
        self.lowered
    }

    /// Forgets the part that is being measured, for example because the filters start afresh, and the whole stretch where the floor is
    /// not known yet: it may begin in a failing sensor. Later stretches may be put together of several holds.
    pub fn interrupt(&mut self) {
        self.in_part = 0;
        self.sum = [0.0; N];
        if self.energy.is_none() {
            self.done = 0;
        }
    }

    /// What the stretch that has just ended showed, once.
    #[inline]
    pub fn take_stretch(&mut self) -> Option<Stretch<N>> {
        self.stretch.take()
    }

    /// What rounding alone adds to the readings (signal unit, rms): of a sensor whose resolution the configuration does not state, and of one that is
    /// `coarse`. Returns whether that has changed a floor that is known.
    pub(crate) fn resolve(&mut self, rms: f32, coarse: bool) -> bool {
        let rounding = if coarse || self.configured == 0.0 { rms * rms } else { 0.0 };
        self.min_energy = self.configured.max(rounding);
        let Some(energy) = self.energy else { return false };
        let resolved = self.measured.map(|measured| measured.max(self.min_energy));
        self.energy = Some(resolved);
        resolved != energy
    }

    /// Takes the mean band energies of the next block. Returns whether the floor has changed.
    #[inline]
    pub fn push(&mut self, block: &[f32; N]) -> bool {
        if self.known {
            return false;
        }
        for (sum, e) in self.sum.iter_mut().zip(block) {
            *sum += e;
        }
        self.in_part += 1;
        self.in_part >= self.part_len && self.end_part()
    }

    fn end_part(&mut self) -> bool {
        let per_block = 1.0 / self.in_part as f32;
        if let Some(part) = self.parts.get_mut(self.done) {
            *part = self.sum.map(|sum| sum * per_block);
        }
        self.sum = [0.0; N];
        self.in_part = 0;
        self.done += 1;
        self.done >= PARTS && self.end_stretch()
    }

    fn end_stretch(&mut self) -> bool {
        self.done = 0;
        if self.min_energy == 0.0 {
            // One and the same reading: a sensor that shows nothing yet.
            return false;
        }
        let part_blocks = core::mem::replace(&mut self.part_len, self.later_len);
        let mut changed = false;
        let mut spread = [0.0; N];
        let shown: [f32; N] = core::array::from_fn(|band| {
            let mut parts = self.parts.map(|part| part.get(band).copied().unwrap_or(0.0));
            parts.sort_unstable_by(f32::total_cmp);
            spread[band] = quartile_spread(&parts);
            0.5 * (parts[PARTS / 2 - 1] + parts[PARTS / 2])
        });
        let measured = shown.map(|energy| energy.max(self.min_energy));
        self.stretch = self.energy.map(|floor| {
            let over_floor = core::array::from_fn(|band| measured[band] / floor[band]);
            Stretch { spread, over_floor, part_blocks }
        });
        let mut energy = self.energy.unwrap_or([f32::INFINITY; N]);
        for (band, energy) in energy.iter_mut().enumerate() {
            if measured[band] < LOWER_BELOW * *energy {
                (*energy, self.measured[band]) = (measured[band], shown[band]);
                changed = true;
            }
        }
        self.lowered += u32::from(changed && self.energy.is_some());
        self.energy = Some(energy);
        changed
    }
}

/// Blocks in a sixteenth of `ms`, at least one.
fn part_len(ms: f32, rate_hz: f32) -> u32 {
    let blocks = ms * 1e-3 * rate_hz / 16.0;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped; the cast saturates"
    )]
    let blocks = blocks.clamp(1.0, 1e6) as u32;
    blocks
}

/// Deviation of the logarithm of Gaussian values with these quartiles.
fn quartile_spread(ordered: &[f32; PARTS]) -> f32 {
    let log = |i: usize| libm::logf(ordered[i].max(f32::MIN_POSITIVE));
    let (q, half) = (PARTS / 4, 0.5);
    let between = half * (log(PARTS - q) + log(PARTS - q - 1) - log(q) - log(q - 1));
    between / QUARTILES
}

#[cfg(test)]
mod tests {
    use super::{Floor, FloorConfig};

    #[test]
    fn a_knock_does_not_raise_the_floor() {
        let config = FloorConfig { learn_ms: 160.0, min_rms: 1e-9 };
        let mut floor = Floor::<1>::learn(config, 1000.0);
        for i in 0..160_u16 {
            assert_eq!(floor.energy(), None);
            floor.push(&[if (40..60).contains(&i) { 1e6 } else { 1.0 }]);
        }
        let [energy] = floor.energy().unwrap();
        assert!((energy - 1.0).abs() < 1e-6, "{energy}");
        for _ in 0..10_000 {
            floor.push(&[1e6]);
        }
        assert_eq!(floor.energy(), Some([energy]), "a known floor never rises");
    }

    #[test]
    fn a_later_quiet_second_lowers_a_floor_that_was_learned_in_motion() {
        let mut floor = Floor::<2>::learn(FloorConfig::default(), 1000.0);
        for _ in 0..200 {
            floor.push(&[9.0, 1.0]);
        }
        assert_eq!((floor.energy(), floor.lowered()), (Some([9.0, 1.0]), 0));
        for _ in 0..1000 {
            floor.push(&[1.0, 0.9]);
        }
        assert_eq!((floor.energy(), floor.lowered()), (Some([1.0, 1.0]), 1));
        let mut known = Floor::<1>::known(FloorConfig::default(), [4.0]);
        for _ in 0..5000 {
            assert!(!known.push(&[0.1]));
        }
        assert_eq!(known.energy(), Some([4.0]), "what was calibrated stays");
    }

    #[test]
    fn silence_has_the_sensor_resolution_as_floor() {
        let mut floor = Floor::<2>::learn(FloorConfig { learn_ms: 10.0, min_rms: 0.5 }, 2200.0);
        for _ in 0..1000 {
            floor.push(&[0.0, 0.0]);
        }
        assert_eq!(floor.energy(), Some([0.25, 0.25]));
    }
}
