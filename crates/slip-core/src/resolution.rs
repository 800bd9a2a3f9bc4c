//! Readings in, the smallest step between two of them out: the resolution of a sensor, in whatever unit.

/// The deviation of readings that are rounded to this step: 1 / sqrt(12) of it.
pub(crate) fn rounding(step: f32) -> f32 {
    0.288_675_13 * step
}

/// After so many steps the smallest one is the resolution.
const KNOWN: u32 = 64;

/// A step is a multiple of the smallest one where the ratio is this close to a whole number; only ratios below the second bound show that. On a grid one of
/// so many is none.
const ODD: f32 = 0.1;
const MULTIPLES: f32 = 30.0;
const MOST_ODD: u32 = 8;

/// The smallest step seen so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Resolution {
    last: Option<f32>,
    step: f32,
    /// Readings that differ from the one before, those of them that are no multiple of the smallest step, and readings that are equal to the one before.
    steps: u32,
    odd: u32,
    same: u32,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { last: None, step: f32::INFINITY, steps: 0, odd: 0, same: 0 }
    }
}

impl Resolution {
    /// Takes the next reading of the sensor.
    pub(crate) fn push(&mut self, x: f32) {
        if let Some(last) = self.last.replace(x) {
            self.compare(x, last);
        }
    }

    /// Takes two readings of one sensor that follow each other.
    pub(crate) fn compare(&mut self, x: f32, last: f32) {
        let step = (x - last).abs();
        self.steps = self.steps.saturating_add(u32::from(step > 0.0));
        let multiple = step.max(self.step) / step.min(self.step);
        let odd = multiple < MULTIPLES && (multiple - libm::roundf(multiple)).abs() > ODD;
        self.odd = self.odd.saturating_add(u32::from(step > 0.0 && odd));
        self.same = self.same.saturating_add(u32::from(step == 0.0));
        if step > 0.0 && step < self.step {
            // What was compared with a larger one says nothing.
            self.odd = if step < 0.9 * self.step { 0 } else { self.odd };
            self.step = step;
        }
    }

    /// Whether enough readings have differed.
    pub(crate) fn is_known(&self) -> bool {
        self.steps >= KNOWN
    }

    /// That of a sensor of which it is not asked.
    pub(crate) fn settled() -> Self {
        Self { steps: KNOWN, ..Self::default() }
    }

    /// Whether the readings lie on a grid that is coarser than what they show: most are equal to the one before, and the others differ by multiples of the
    /// smallest step.
    pub(crate) fn is_coarse(&self) -> bool {
        self.steps > 0 && self.same > self.steps && MOST_ODD * self.odd <= self.steps
    }

    /// The noise that rounding to this step makes (rms); 0 while all readings were the same.
    pub(crate) fn rms(&self) -> f32 {
        if self.step < f32::INFINITY { rounding(self.step) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::{Resolution, rounding};

    #[test]
    fn the_smallest_step_is_the_resolution_in_any_unit() {
        let mut resolution = Resolution::default();
        for x in [5.0, 5.0, 5.0] {
            resolution.push(x);
        }
        assert_eq!(resolution.rms(), 0.0);
        for x in [7.0, 4.0, 5.0, f32::NAN, 5.5, 9.0] {
            resolution.push(x);
        }
        assert!((resolution.rms() * 12.0_f32.sqrt() - 1.0).abs() < 1e-6);
        assert!(!resolution.is_coarse(), "few readings are the same");
        let mut small = Resolution::default();
        for x in [7e-9, 4e-9, 5e-9] {
            small.push(x);
        }
        assert!((small.rms() / resolution.rms() - 1e-9).abs() < 1e-14);
    }

    #[test]
    fn readings_on_a_grid_are_coarse_and_a_tone_after_a_silence_is_not() {
        let (mut grid, mut tone) = (Resolution::default(), Resolution::default());
        for _ in 0..1000 {
            grid.push(0.0);
            tone.push(0.0);
        }
        assert!(!grid.is_coarse(), "nothing has stepped");
        for i in 0..200_u16 {
            grid.push(4.9e-7 * [3.0, 5.0, 2.0, 0.0, 1.0, 0.0, 2.0][usize::from(i % 7)]);
            tone.push(3e-6 * libm::sinf(core::f32::consts::FRAC_PI_4 * f32::from(i)));
        }
        assert!(grid.is_coarse() && !tone.is_coarse());
        assert!((grid.rms() / rounding(4.9e-7) - 1.0).abs() < 1e-3);
    }
}
