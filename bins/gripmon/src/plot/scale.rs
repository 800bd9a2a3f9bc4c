//! Axis of values: where a value stands between bottom and top.

/// How values are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; what is not positive stands at the bottom.
    Log,
}

/// The values of an axis from bottom to top; `high` is above `low`, both are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    kind: Kind,
    low: f64,
    high: f64,
}

/// The smallest value of a logarithmic axis.
const SMALLEST: f64 = 1e-12;

impl Scale {
    /// An axis from `low` to `high`; where that is no range, a small one around it.
    #[must_use]
    pub fn new(kind: Kind, low: f64, high: f64) -> Self {
        let finite = |x: f64| if x.is_finite() { x.clamp(-1e30, 1e30) } else { 0.0 };
        let (low, high) = (finite(low.min(high)), finite(high.max(low)));
        match kind {
            Kind::Linear => {
                let least = (low.abs().max(high.abs()) * 1e-9).max(1e-12);
                let room = ((least - (high - low)) / 2.0).max(0.0);
                Self { kind, low: low - room, high: high + room }
            }
            Kind::Log => {
                let low = low.max(SMALLEST);
                Self { kind, low, high: high.max(low * 10.0) }
            }
        }
    }

    /// An axis that shows all values between `low` and `high` with some room, ending at round numbers so that it does not
    /// tremble with every new value.
    #[must_use]
    pub fn around(kind: Kind, low: f64, high: f64) -> Self {
        if kind == Kind::Log {
            let (low, high) = (low.max(SMALLEST).log10(), high.max(SMALLEST).log10());
            return Self::new(kind, 10f64.powf(low.floor()), 10f64.powf((high + 0.1).ceil()));
        }
        // A value that stands still is shown in a range of its own size.
        let size = low.abs().max(high.abs());
        let still = if high - low < 1e-4 * size { 0.1 * size } else { 0.0 };
        let exact = Self::new(kind, low - still, high + still);
        let length = exact.high - exact.low;
        let step = 10f64.powf((length / 2.0).log10().floor());
        let step = if length / step > 8.0 { step * 2.0 } else { step / 2.0 };
        let room = length * 0.04;
        // Where values begin or end at zero the axis does too, but for a margin.
        let end = |value: f64, out: f64| match value.abs() < 0.03 * length {
            true => out * 0.3 * step,
            false => out * ((out * value + room) / step).ceil() * step,
        };
        Self::new(kind, end(exact.low, -1.0), end(exact.high, 1.0))
    }

    /// Where a value stands: 0 at the bottom, 1 at the top, beyond both for values outside, at most 50 times.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        let [low, high, value] = [self.low, self.high, value].map(|value| self.drawn(value));
        ((value - low) / (high - low)).clamp(-50.0, 50.0)
    }

    /// The number that stands for a value in a plot: its logarithm where values are spread by that.
    #[must_use]
    pub fn drawn(&self, value: f64) -> f64 {
        match self.kind {
            Kind::Linear => value,
            Kind::Log => value.max(SMALLEST).log10(),
        }
    }

    /// The value at a place.
    #[must_use]
    pub fn value(&self, place: f64) -> f64 {
        match self.kind {
            Kind::Linear => self.low + place * (self.high - self.low),
            Kind::Log => {
                let (low, high) = (self.low.log10(), self.high.log10());
                10f64.powf(low + place * (high - low))
            }
        }
    }

    /// Lowest value.
    #[must_use]
    pub const fn low(&self) -> f64 {
        self.low
    }

    /// Highest value.
    #[must_use]
    pub const fn high(&self) -> f64 {
        self.high
    }

    /// How values are spread.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        self.kind
    }

    /// `factor` times as large a range, the value at `place` unmoved, then moved up by `by` of its length.
    #[must_use]
    pub fn changed(&self, place: f64, factor: f64, by: f64) -> Self {
        let end = |at: f64| self.value(place + (at - place) * factor - by);
        Self::new(self.kind, end(0.0), end(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, Scale};

    #[test]
    fn a_range_is_never_empty() {
        for (low, high) in [
            (1.0, 1.0),
            (0.0, 0.0),
            (f64::NAN, 1.0),
            (5.0, -5.0),
            (1e30, 1e30),
            (-1e300, f64::INFINITY),
        ] {
            for kind in [Kind::Linear, Kind::Log] {
                for scale in [Scale::new(kind, low, high), Scale::around(kind, low, high)] {
                    assert!(scale.high() > scale.low(), "{kind:?} {low} {high}: {scale:?}");
                    assert!(scale.place(0.3).is_finite() && scale.value(0.5).is_finite());
                }
            }
        }
    }

    #[test]
    fn place_and_value_are_inverse() {
        for scale in [Scale::new(Kind::Linear, -2.0, 6.0), Scale::new(Kind::Log, 0.1, 1000.0)] {
            for place in [0.0, 0.25, 1.0] {
                assert!((scale.place(scale.value(place)) - place).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_ends_stand_still_while_values_tremble() {
        let first = Scale::around(Kind::Linear, -1.01, 1.02);
        assert_eq!(first, Scale::around(Kind::Linear, -1.015, 1.018));
        assert!(first.low() <= -1.015 && first.high() >= 1.02 && first.high() < 1.6);
    }

    #[test]
    fn zooming_keeps_the_value_under_the_pointer() {
        let scale = Scale::new(Kind::Linear, 0.0, 10.0).changed(0.25, 0.5, 0.0);
        assert!(
            (scale.value(0.25) - 2.5).abs() < 1e-9
                && (scale.high() - scale.low() - 5.0).abs() < 1e-9
        );
        let moved = Scale::new(Kind::Linear, 0.0, 10.0).changed(0.0, 1.0, 0.1);
        assert!((moved.low() + 1.0).abs() < 1e-9);
    }
}
