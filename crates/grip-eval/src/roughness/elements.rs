//! The mean width of the elements of a roughness profile.

/// Width of profile elements by crossing the mean line, in steps.
///
/// A hill is a stretch that rises above +`threshold`, a dale one that falls below -`threshold`; what stays between belongs to
/// the stretch before and after it. The border between hill and dale lies where the profile crosses zero, linear between
/// two heights; where it does so several times, in the middle of the first and the last time, so that tracing backwards
/// gives the same borders. The first stretch begins at the last crossing before it, the last one ends at the first crossing
/// after it; without one they are cut off by the end of the profile and do not count. A stretch narrower than `narrowest` steps is left out, the first one where several follow. An element is a hill with the dale
/// beside it: from one border to the next but one. Both kinds (first hill then dale, first dale then hill) are averaged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Elements {
    threshold: f64,
    narrowest: f64,
    side: Option<bool>,
    last: f64,
    crossings: Option<(f64, f64)>,
    /// The last border, which a narrow stretch behind it may still take away.
    pending: Option<f64>,
    /// The two kept before it.
    kept: [Option<f64>; 2],
    count: u32,
    total: f64,
}

impl Elements {
    pub(super) fn new(threshold: f64, narrowest: f64) -> Self {
        Self {
            threshold,
            narrowest,
            side: None,
            last: 0.0,
            crossings: None,
            pending: None,
            kept: [None; 2],
            count: 0,
            total: 0.0,
        }
    }

    /// Mean width in steps and the number of elements, once all of `heights` are taken; `None` without an element.
    pub(super) fn mean_width(mut self, heights: &[f64]) -> Option<(f64, u32)> {
        for (i, height) in heights.iter().enumerate() {
            self.push(i, *height);
        }
        if let (Some((first, _)), true) = (self.crossings, self.side.is_some()) {
            self.border(first);
        }
        if let Some(border) = self.pending.take() {
            self.keep(border);
        }
        (self.count > 0).then(|| (self.total / f64::from(self.count), self.count))
    }

    fn push(&mut self, index: usize, height: f64) {
        if (self.last > 0.0) != (height > 0.0) && index > 0 && self.last != height {
            let at = index as f64 - height / (height - self.last);
            self.crossings = Some((self.crossings.map_or(at, |c| c.0), at));
        }
        self.last = height;
        if height.abs() <= self.threshold {
            return;
        }
        let side = height > 0.0;
        match (self.crossings, self.side) {
            (Some((_, last)), None) => self.border(last),
            (Some((first, last)), Some(before)) if before != side => {
                self.border(0.5 * (first + last))
            }
            _ => {}
        }
        self.side = Some(side);
        self.crossings = None;
    }

    fn border(&mut self, at: f64) {
        match self.pending {
            Some(before) if at - before < self.narrowest => self.pending = None,
            Some(before) => {
                self.keep(before);
                self.pending = Some(at);
            }
            None => self.pending = Some(at),
        }
    }

    fn keep(&mut self, at: f64) {
        if let Some(start) = self.kept[0] {
            self.total += at - start;
            self.count += 1;
        }
        self.kept = [self.kept[1], Some(at)];
    }
}

#[cfg(test)]
mod tests {
    use super::Elements;

    fn width(heights: &[f64], threshold: f64, narrowest: f64) -> Option<(f64, u32)> {
        Elements::new(threshold, narrowest).mean_width(heights)
    }

    fn triangle(n: u32) -> Vec<f64> {
        (0..n).map(|i| f64::from((i % 20).min(20 - i % 20)) - 5.3).collect()
    }

    #[test]
    fn a_triangle_wave_has_its_period() {
        let (mean, count) = width(&triangle(400), 1.0, 1.0).unwrap();
        assert!((mean - 20.0).abs() < 1e-9, "{mean}");
        assert_eq!(count, 38, "40 borders");
        assert_eq!(
            width(&triangle(25), 1.0, 1.0).map(|w| w.1),
            None,
            "two borders make no element"
        );
    }

    #[test]
    fn low_and_narrow_stretches_do_not_count() {
        let mut wave = triangle(400);
        for i in (0..400).step_by(20) {
            // A dip to -0.5 on the flank of each hill, and a needle in each dale.
            wave[i + 6] = -0.5;
            wave[i + 18] = 3.0;
        }
        let (mean, _) = width(&wave, 1.0, 2.5).unwrap();
        assert!((mean - 20.0).abs() < 1e-9, "{mean}");
        let (all, _) = width(&wave, 0.0, 0.0).unwrap();
        assert!(all < 12.0, "without discrimination: {all}");
    }

    #[test]
    fn tracing_backwards_gives_the_same() {
        let wave: Vec<f64> = (0..3000_u32)
            .map(|i| (f64::from(i) / 31.0).sin() + f64::from(i * 7919 % 1013) / 1013.0 - 0.5)
            .collect();
        let back: Vec<f64> = wave.iter().rev().copied().collect();
        let (forth, back) = (width(&wave, 0.3, 0.0).unwrap(), width(&back, 0.3, 0.0).unwrap());
        assert!((forth.0 - back.0).abs() < 1e-9 && forth.1 == back.1, "{forth:?} {back:?}");
    }

    #[test]
    fn a_flat_profile_has_none() {
        assert_eq!(width(&[0.0; 100], 0.0, 1.0), None);
        assert_eq!(width(&[1.0; 100], 0.1, 1.0), None);
        assert_eq!(width(&[], 0.1, 1.0), None);
    }
}
