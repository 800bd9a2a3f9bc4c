//! Readings of a slip that another sensor measures in; the same, in order, out, once that sensor is lost.

/// Readings that are kept: 0.1 s at 10 kHz. A slip that was measured for longer is not made up for.
const KEPT: usize = 1024;

/// Stylus (m) and force (N) since the alarm.
#[derive(Clone, Copy, Debug)]
pub(super) struct History {
    readings: [(f32, f32); KEPT],
    kept: usize,
    taken: usize,
    lost: bool,
}

impl Default for History {
    fn default() -> Self {
        Self { readings: [(0.0, 0.0); KEPT], kept: 0, taken: 0, lost: false }
    }
}

impl History {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        (self.kept, self.taken, self.lost) = (0, 0, false);
    }

    /// Whether everything that was kept has been taken, and nothing was lost.
    pub(super) fn is_empty(&self) -> bool {
        self.kept == self.taken && !self.lost
    }

    /// Keeps another one; where there is no room the slip cannot be made up for.
    #[inline]
    pub(super) fn keep(&mut self, x_m: f32, force_n: f32) {
        match self.readings.get_mut(self.kept) {
            Some(place) => {
                *place = (x_m, force_n);
                self.kept += 1;
            }
            None => self.lost = true,
        }
    }

    /// The oldest one that was not taken.
    pub(super) fn next(&mut self) -> Option<(f32, f32)> {
        let next = self.readings.get(self.taken).filter(|_| self.taken < self.kept && !self.lost);
        let next = next.copied();
        self.taken += usize::from(next.is_some());
        next
    }
}
