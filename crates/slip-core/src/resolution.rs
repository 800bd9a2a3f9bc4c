//! Readings in, the smallest step between two of them out: the resolution of a sensor, in whatever unit.

/// The deviation of readings that are rounded to this step: 1 / sqrt(12) of it.
pub(crate) fn rounding(step: f32) -> f32 {
    0.288_675_13 * step
}

/// The smallest step seen so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Resolution {
    last: Option<f32>,
    step: f32,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { last: None, step: f32::INFINITY }
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
        if step > 0.0 && step < self.step {
            self.step = step;
        }
    }

    /// The noise that rounding to this step makes (rms); 0 while all readings were the same.
    pub(crate) fn rms(&self) -> f32 {
        if self.step < f32::INFINITY { rounding(self.step) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::Resolution;

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
        let mut small = Resolution::default();
        for x in [7e-9, 4e-9, 5e-9] {
            small.push(x);
        }
        assert!((small.rms() / resolution.rms() - 1e-9).abs() < 1e-14);
    }
}
