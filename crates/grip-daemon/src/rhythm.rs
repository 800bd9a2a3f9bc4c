//! Prediction of when the next frame is due, from the times of frames: a loop does not sleep then.

/// When frames of samples come.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rhythm {
    /// Time of the last one (ns).
    last_ns: u64,
    /// Time between two, smoothed (ns); 0 where it is not known.
    period_ns: u64,
}

impl Rhythm {
    /// Longer pauses (ns) are no rhythm.
    const LONGEST_NS: u64 = 50_000_000;

    /// A frame has come.
    pub(crate) fn frame(&mut self, now_ns: u64) {
        let gap = now_ns.saturating_sub(self.last_ns);
        self.last_ns = now_ns;
        self.period_ns = match self.period_ns {
            _ if gap > Self::LONGEST_NS => 0,
            0 => gap,
            // Some are missing, or there is another rhythm: the next one shows that.
            known if gap > known + known / 2 => 0,
            known => (7 * known + gap) / 8,
        };
    }

    /// From when to when (ns) the next one is awaited without sleeping, half of the time at most; `None` where none is due.
    pub(crate) fn awaited(&self, now_ns: u64, spin_us: u16) -> Option<(u64, u64)> {
        let spin_ns = (1000 * u64::from(spin_us)).min(self.period_ns / 4);
        let due = self.last_ns + self.period_ns;
        let until = due + spin_ns;
        (spin_ns > 0 && now_ns < until).then_some((due.saturating_sub(spin_ns), until))
    }
}

#[cfg(test)]
mod tests {
    use super::Rhythm;

    #[test]
    fn the_next_frame_is_awaited_where_it_is_due_and_a_pause_is_no_rhythm() {
        let mut rhythm = Rhythm::default();
        rhythm.frame(100_000_000);
        assert_eq!(rhythm.awaited(100_000_001, 50), None, "one frame is no rhythm");
        for frame in 1..=40 {
            rhythm.frame(100_000_000 + 1_000_000 * frame);
        }
        let soon = 140_000_100;
        assert_eq!(rhythm.awaited(soon, 0), None);
        assert_eq!(rhythm.awaited(soon, 50), Some((140_950_000, 141_050_000)));
        assert_eq!(rhythm.awaited(141_050_000, 50), None, "it did not come");
        // One that is missing costs one more.
        rhythm.frame(142_000_000);
        assert_eq!(rhythm.awaited(142_000_001, 50), None);
        rhythm.frame(143_000_000);
        let quarter = Some((143_750_000, 144_250_000));
        assert_eq!(rhythm.awaited(143_000_001, 500), quarter);
        rhythm.frame(240_000_000);
        assert_eq!(rhythm.awaited(240_000_001, 50), None);
    }
}
