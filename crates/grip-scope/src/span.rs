//! The stretch between two times.

/// A stretch of time on the axis of the model (s); `from_s` is not above `to_s`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// Where it begins (s).
    pub from_s: f64,
    /// Where it ends (s).
    pub to_s: f64,
}

impl Span {
    /// The stretch between two times, in either order; a time that is not finite counts as 0.
    #[must_use]
    pub fn new(a_s: f64, b_s: f64) -> Self {
        let finite = |t: f64| if t.is_finite() { t } else { 0.0 };
        let (a_s, b_s) = (finite(a_s), finite(b_s));
        Self { from_s: a_s.min(b_s), to_s: a_s.max(b_s) }
    }

    /// Its length (s).
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.to_s - self.from_s
    }

    /// Whether the time lies in it, its ends included.
    #[must_use]
    pub fn holds(&self, t_s: f64) -> bool {
        (self.from_s..=self.to_s).contains(&t_s)
    }

    /// The smallest stretch that holds both.
    #[must_use]
    pub fn union(&self, other: Self) -> Self {
        Self { from_s: self.from_s.min(other.from_s), to_s: self.to_s.max(other.to_s) }
    }

    /// What both have in common, where that is anything.
    #[must_use]
    pub fn common(&self, other: Self) -> Option<Self> {
        let (from_s, to_s) = (self.from_s.max(other.from_s), self.to_s.min(other.to_s));
        (from_s <= to_s).then_some(Self { from_s, to_s })
    }
}
