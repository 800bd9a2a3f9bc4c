//! The span that is seen, from the span of data and what the user did.

use grip_scope::Span;

/// Shortest span that can be seen (s): a few samples at 20 kHz.
const SHORTEST_S: f64 = 2e-4;
/// Longest span that can be seen (s).
const LONGEST_S: f64 = 1e7;

/// Whether the view moves with the data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Following {
    /// The newest data stay at the right edge.
    #[default]
    Newest,
    /// All data are seen, however much there is.
    All,
    /// The view stands still; recording goes on.
    Held,
}

/// The part of the time axis that every view shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeWindow {
    from_s: f64,
    length_s: f64,
    following: Following,
}

impl TimeWindow {
    /// A view of so many seconds that follows the newest data.
    #[must_use]
    pub const fn new(length_s: f64) -> Self {
        Self { from_s: 0.0, length_s: clamp(length_s), following: Following::Newest }
    }

    /// What is seen of data that span so much; `data` is `None` before there are any.
    #[must_use]
    pub fn visible(&self, data: Option<Span>) -> Span {
        match (self.following, data) {
            (Following::All, Some(data)) => {
                let length_s = clamp(data.to_s - data.from_s);
                Span { from_s: data.from_s, to_s: data.from_s + length_s }
            }
            (Following::Newest, Some(data)) => {
                Span { from_s: data.to_s - self.length_s, to_s: data.to_s }
            }
            _ => Span { from_s: self.from_s, to_s: self.from_s + self.length_s },
        }
    }

    /// Whether the view moves with the data.
    #[must_use]
    pub const fn following(&self) -> Following {
        self.following
    }

    /// Seconds seen, but for [`Following::All`].
    #[must_use]
    pub const fn length_s(&self) -> f64 {
        self.length_s
    }

    /// Stops the view where it is.
    pub fn hold(&mut self, data: Option<Span>) {
        self.show(self.visible(data));
    }

    /// Lets the view move with the newest data again.
    pub fn follow(&mut self) {
        self.following = Following::Newest;
    }

    /// Shows everything, also what comes later.
    pub fn all(&mut self) {
        self.following = Following::All;
    }

    /// Shows this span and stands still. What is not finite changes nothing.
    pub fn show(&mut self, span: Span) {
        if !(span.from_s.is_finite() && span.to_s.is_finite()) {
            return;
        }
        self.from_s = span.from_s;
        self.length_s = clamp(span.to_s - span.from_s);
        self.following = Following::Held;
    }

    /// Moves the view by so many seconds, later for positive ones.
    pub fn pan(&mut self, by_s: f64, data: Option<Span>) {
        let span = self.visible(data);
        self.show(Span { from_s: span.from_s + by_s, to_s: span.to_s + by_s });
    }

    /// Shows `factor` times as much and keeps `at_s` where it is on the screen. A view that follows goes on following.
    pub fn zoom(&mut self, at_s: f64, factor: f64, data: Option<Span>) {
        if !(factor > 0.0 && factor.is_finite() && at_s.is_finite()) {
            return;
        }
        let span = self.visible(data);
        let old_s = span.to_s - span.from_s;
        let length_s = clamp(old_s * factor);
        if self.following == Following::Newest {
            self.length_s = length_s;
            return;
        }
        let from_s = at_s - (at_s - span.from_s) * length_s / old_s;
        self.show(Span { from_s, to_s: from_s + length_s });
    }

    /// Shows so many seconds around the middle of what is seen, or up to the newest data where the view follows them.
    pub fn resize(&mut self, length_s: f64, data: Option<Span>) {
        let span = self.visible(data);
        let length_s = clamp(length_s);
        match self.following {
            Following::Newest | Following::All => {
                *self = Self { length_s, following: Following::Newest, ..*self }
            }
            Following::Held => {
                let from_s = f64::midpoint(span.from_s, span.to_s) - length_s / 2.0;
                self.show(Span { from_s, to_s: from_s + length_s });
            }
        }
    }

    /// Puts the place `t_s` a third from the left edge.
    pub fn centre(&mut self, t_s: f64, data: Option<Span>) {
        let length_s = match self.following {
            Following::All => (data.map_or(1.0, |data| data.to_s - data.from_s) / 10.0).min(1.0),
            _ => self.length_s,
        };
        let from_s = t_s - clamp(length_s) / 3.0;
        self.show(Span { from_s, to_s: from_s + clamp(length_s) });
    }
}

const fn clamp(length_s: f64) -> f64 {
    if length_s.is_nan() { 1.0 } else { length_s.clamp(SHORTEST_S, LONGEST_S) }
}

#[cfg(test)]
mod tests {
    use super::{Following, TimeWindow};
    use grip_scope::Span;

    fn span(from_s: f64, to_s: f64) -> Option<Span> {
        Some(Span { from_s, to_s })
    }

    #[test]
    fn it_follows_until_it_is_held() {
        let mut window = TimeWindow::new(2.0);
        assert_eq!(window.visible(span(0.0, 10.0)), span(8.0, 10.0).unwrap());
        window.hold(span(0.0, 10.0));
        assert_eq!(window.visible(span(0.0, 99.0)), span(8.0, 10.0).unwrap());
        window.follow();
        assert_eq!(window.visible(span(0.0, 99.0)), span(97.0, 99.0).unwrap());
        window.all();
        assert_eq!(window.visible(span(3.0, 99.0)), span(3.0, 99.0).unwrap());
    }

    #[test]
    fn zoom_keeps_the_place_under_the_pointer() {
        let mut window = TimeWindow::new(2.0);
        window.show(Span { from_s: 4.0, to_s: 6.0 });
        window.zoom(4.5, 0.5, None);
        assert_eq!(window.visible(None), span(4.25, 5.25).unwrap());
        let mut live = TimeWindow::new(2.0);
        live.zoom(9.0, 2.0, span(0.0, 10.0));
        assert_eq!(live.following(), Following::Newest);
        assert_eq!(live.visible(span(0.0, 10.0)), span(6.0, 10.0).unwrap());
    }

    #[test]
    fn nonsense_changes_nothing() {
        let mut window = TimeWindow::new(f64::NAN);
        window.show(Span { from_s: 1.0, to_s: 2.0 });
        let before = window;
        window.zoom(f64::NAN, 2.0, None);
        window.zoom(1.0, -2.0, None);
        window.show(Span { from_s: f64::NAN, to_s: 2.0 });
        assert_eq!(window, before);
        for _ in 0..200 {
            window.zoom(1.5, 0.1, None);
        }
        let seen = window.visible(None);
        assert!(seen.to_s > seen.from_s);
    }
}
