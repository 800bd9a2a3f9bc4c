//! The mean line of a height profile.

/// alpha = sqrt(ln 2 / pi) of ISO 16610-21: a sine of the cutoff wavelength passes with 50 %.
const ALPHA: f64 = 0.469_718_639_349_825_66;

/// Length of each of three moving averages over the cutoff wavelength: the solution of (sin(pi b) / (pi b))^3 = 1/2,
/// so that a sine of the cutoff wavelength passes with 50 %.
const BOX: f64 = 0.366_063_256_638_211_9;

/// How the mean line is weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FilterKind {
    /// Three moving averages in a row, as many instruments approximate the Gaussian; cost O(n) whatever the cutoff.
    /// Its transmission differs from the Gaussian's by at most 0.030 (for sines of 0.54 cutoffs).
    #[default]
    MovingAverage,
    /// The Gaussian of ISO 16610-21, s(x) = exp(-pi (x / (alpha lambda_c))^2) / (alpha lambda_c), summed directly over
    /// one cutoff to either side, where it has fallen to 7e-7 of its peak. Cost O(n lambda_c / step).
    Gaussian,
}

/// A buffer of the caller is too short.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a buffer of {len} values is too short; {needed} are needed")]
pub struct BufferTooShort {
    /// Its length.
    pub len: usize,
    /// The length it must have.
    pub needed: usize,
}

/// A low-pass filter for profiles. Beyond either end the profile is taken to go on at its last height.
///
/// That is how the profilometer behaves whose traces are in `docs/results.md`: over the last 0.55 cutoffs (moving averages) a
/// tilt is not fully followed, so remove the tilt first or do not use the ends, if they matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileFilter {
    kind: FilterKind,
    /// Cutoff wavelength over the step.
    cutoff: f64,
}

impl ProfileFilter {
    /// A filter of the cutoff wavelength `cutoff_m` (m) for profiles at equal steps of `step_m` (m); `None`
    /// unless both are positive and finite and the cutoff spans at most 10^9 steps.
    #[must_use]
    pub fn new(kind: FilterKind, cutoff_m: f64, step_m: f64) -> Option<Self> {
        let cutoff = cutoff_m / step_m;
        let usable = cutoff_m > 0.0 && step_m > 0.0 && cutoff > 0.0 && cutoff <= 1e9;
        usable.then_some(Self { kind, cutoff })
    }

    /// Length of the buffer that [`mean_line`](Self::mean_line) needs for a profile of `n` heights.
    #[must_use]
    pub fn scratch_len(&self, n: usize) -> usize {
        match self.kind {
            FilterKind::MovingAverage => n.saturating_add(2 * self.margin()),
            FilterKind::Gaussian => 0,
        }
    }

    /// Writes the mean line of `heights` (m) to `line` (m), as long as `heights`.
    ///
    /// # Errors
    /// Where `line` or `scratch` is too short.
    pub fn mean_line(
        &self,
        heights: &[f64],
        line: &mut [f64],
        scratch: &mut [f64],
    ) -> Result<(), BufferTooShort> {
        let n = heights.len();
        let line = sized(line, n)?;
        let scratch = sized(scratch, self.scratch_len(n))?;
        let (Some(&first), Some(&last)) = (heights.first(), heights.last()) else { return Ok(()) };
        match self.kind {
            FilterKind::Gaussian => self.gaussian(heights, line),
            FilterKind::MovingAverage => {
                let (before, rest) = scratch.split_at_mut(self.margin());
                let (middle, after) = rest.split_at_mut(n);
                before.fill(first);
                middle.copy_from_slice(heights);
                after.fill(last);
                self.three_averages(scratch);
                line.iter_mut().zip(scratch).for_each(|(l, s)| *l = *s);
            }
        }
        Ok(())
    }

    /// Deviation of white noise of the heights in the mean line, over that in the heights (at most 1).
    #[must_use]
    pub fn noise_gain(&self) -> f64 {
        libm::sqrt(1.0 / (core::f64::consts::SQRT_2 * ALPHA * self.cutoff)).min(1.0)
    }

    /// Whole steps of a box to either side of its middle, and the part of one step beyond.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 10^9, checked in new"
    )]
    fn half_box(&self) -> (usize, f64) {
        let half = 0.5 * (BOX * self.cutoff - 1.0).max(0.0);
        (half as usize, half - libm::floor(half))
    }

    fn margin(&self) -> usize {
        3 * (self.half_box().0 + 1)
    }

    /// Three centred averages in place. Each begins one reach inside of what the one before has left, so that the
    /// result for the first height of the profile stands at index 0.
    fn three_averages(&self, padded: &mut [f64]) {
        let (half, part) = self.half_box();
        let reach = half + 1;
        let mut left = padded.len();
        for _ in 0..3 {
            centred_average(padded.get_mut(..left).unwrap_or_default(), reach, part);
            left = left.saturating_sub(2 * reach);
        }
    }

    fn gaussian(&self, heights: &[f64], line: &mut [f64]) {
        let n = heights.len();
        let scale = 1.0 / (ALPHA * self.cutoff);
        line.copy_from_slice(heights);
        let mut sum = 1.0;
        let (Some(&first), Some(&last)) = (heights.first(), heights.last()) else { return };
        let mut k = 1_usize;
        while k as f64 <= self.cutoff {
            let u = k as f64 * scale;
            let weight = libm::exp(-core::f64::consts::PI * u * u);
            let held = k.min(n);
            add(line.iter_mut().take(held), core::iter::repeat(&first), weight);
            add(line.iter_mut().skip(held), heights.iter(), weight);
            add(line.iter_mut().take(n - held), heights.iter().skip(held), weight);
            add(line.iter_mut().skip(n - held), core::iter::repeat(&last), weight);
            sum += 2.0 * weight;
            k += 1;
        }
        line.iter_mut().for_each(|l| *l /= sum);
    }
}

/// The first `len` values of a buffer of the caller.
fn sized(buffer: &mut [f64], len: usize) -> Result<&mut [f64], BufferTooShort> {
    let short = BufferTooShort { len: buffer.len(), needed: len };
    buffer.get_mut(..len).ok_or(short)
}

/// Replaces z by its average over `reach` - 1 steps to either side and the part `part` of the step beyond. The
/// average about `j + reach` goes to `j`, a place that no later average needs.
fn centred_average(z: &mut [f64], reach: usize, part: f64) {
    let width = (2 * reach - 1) as f64 + 2.0 * part;
    let mut inner: f64 = z.iter().take(2 * reach).skip(1).sum();
    for j in 0..z.len().saturating_sub(2 * reach) {
        let (left, right) = (z[j], z[j + 2 * reach]);
        let average = (inner + part * (left + right)) / width;
        inner += right - z[j + 1];
        z[j] = average;
    }
}

#[inline]
fn add<'a, 'b>(
    to: impl Iterator<Item = &'a mut f64>,
    from: impl Iterator<Item = &'b f64>,
    weight: f64,
) {
    to.zip(from).for_each(|(l, h)| *l += weight * h);
}

#[cfg(test)]
mod tests {
    use super::{ALPHA, BOX, FilterKind, ProfileFilter};
    use core::f64::consts::{PI, TAU};

    const KINDS: [FilterKind; 2] = [FilterKind::MovingAverage, FilterKind::Gaussian];

    fn line(kind: FilterKind, cutoff: f64, step: f64, heights: &[f64]) -> Vec<f64> {
        let filter = ProfileFilter::new(kind, cutoff, step).unwrap();
        let mut line = vec![f64::NAN; heights.len()];
        let mut scratch = vec![f64::NAN; filter.scratch_len(heights.len())];
        filter.mean_line(heights, &mut line, &mut scratch).unwrap();
        line
    }

    fn sinc(x: f64) -> f64 {
        (PI * x).sin() / (PI * x)
    }

    /// Transmission of a sine of `f` cutoffs^-1.
    fn ideal(kind: FilterKind, f: f64) -> f64 {
        match kind {
            FilterKind::Gaussian => (-PI * (ALPHA * f).powi(2)).exp(),
            FilterKind::MovingAverage => sinc(BOX * f).powi(3),
        }
    }

    fn wavy(n: u32) -> Vec<f64> {
        let wave = |i: u32| {
            f64::from(i * 7919 % 1013) / 1013.0 + (f64::from(i) / 40.0).sin() + 0.01 * f64::from(i)
        };
        (0..n).map(wave).collect()
    }

    #[test]
    fn sines_pass_as_the_standard_states() {
        for kind in KINDS {
            for f in [0.1_f64, 0.5, 1.0, 2.0, 3.0] {
                let wave: Vec<f64> =
                    (0..8000).map(|i| (TAU * f * f64::from(i) / 500.0).cos()).collect();
                let line = line(kind, 500.0, 1.0, &wave);
                let (got, want) = (line[4000], ideal(kind, f) * wave[4000]);
                assert!((got - want).abs() < 2e-5, "{kind:?} {f}: {got} {want}");
            }
            assert!((ideal(kind, 1.0) - 0.5).abs() < 1e-12, "{kind:?}");
        }
        let apart = |i: i32| {
            let f = f64::from(i) * 1e-3;
            (ideal(FilterKind::Gaussian, f) - ideal(FilterKind::MovingAverage, f)).abs()
        };
        let most = (1..6000).map(apart).fold(0.0, f64::max);
        assert!((most - 0.030).abs() < 0.0005, "stated: 0.030; {most}");
    }

    /// Convolution with weights computed one by one, over a profile extended by its last heights.
    fn directly(heights: &[f64], weights: &[f64]) -> Vec<f64> {
        let reach = weights.len() / 2;
        let held = |i: usize| heights[i.saturating_sub(reach).min(heights.len() - 1)];
        let total: f64 = weights.iter().sum();
        let at = |i: usize| weights.iter().enumerate().map(|(k, w)| w * held(i + k)).sum::<f64>();
        (0..heights.len()).map(|i| at(i) / total).collect()
    }

    fn convolve(a: &[f64], b: &[f64]) -> Vec<f64> {
        let mut c = vec![0.0; a.len() + b.len() - 1];
        for (i, x) in a.iter().enumerate() {
            b.iter().enumerate().for_each(|(j, y)| c[i + j] += x * y);
        }
        c
    }

    #[test]
    fn the_fast_filters_equal_the_direct_sum() {
        for (cutoff, n) in [(100.0, 700), (37.3, 90), (5.0, 60), (400.0, 50), (1.0, 20), (90.0, 1)]
        {
            let heights = wavy(n);
            let gaussian: Vec<f64> = (-1000..=1000_i32)
                .filter(|k| f64::from(k.abs()) <= cutoff)
                .map(|k| (-PI * (f64::from(k) / (ALPHA * cutoff)).powi(2)).exp())
                .collect();
            let half = (0.5 * (BOX * cutoff - 1.0)).max(0.0);
            let ones: Vec<f64> =
                (-1000..=1000_i32).filter(|k| f64::from(k.abs()) <= half).map(|_| 1.0).collect();
            let one_box = [vec![half.fract()], ones, vec![half.fract()]].concat();
            let three = convolve(&convolve(&one_box, &one_box), &one_box);
            for (kind, weights) in
                [(FilterKind::Gaussian, gaussian), (FilterKind::MovingAverage, three)]
            {
                let fast = line(kind, cutoff, 1.0, &heights);
                for (got, want) in fast.iter().zip(directly(&heights, &weights)) {
                    assert!((got - want).abs() < 1e-12, "{kind:?} {cutoff} {n}: {got} {want}");
                }
            }
        }
    }

    #[test]
    fn constants_stay_and_tiny_cutoffs_change_nothing() {
        for kind in KINDS {
            assert!(
                line(kind, 2.5e-3, 1e-6, &[3e-6; 900]).iter().all(|l| (l - 3e-6).abs() < 1e-18)
            );
            let heights = wavy(100);
            let same = line(kind, 0.3, 1.0, &heights);
            assert!(same.iter().zip(&heights).all(|(a, b)| (a - b).abs() < 1e-12), "{kind:?}");
            assert!(line(kind, 1.0, 1.0, &[]).is_empty());
        }
    }

    #[test]
    fn noise_shrinks_as_stated() {
        let mut seed = 5_u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let noise: Vec<f64> = (0..60_000).map(|_| next()).collect();
        let rms = |z: &[f64]| (z.iter().map(|x| x * x).sum::<f64>() / z.len() as f64).sqrt();
        for kind in KINDS {
            let got = rms(&line(kind, 30.0, 1.0, &noise)) / rms(&noise);
            let stated = ProfileFilter::new(kind, 30.0, 1.0).unwrap().noise_gain();
            assert!((got / stated - 1.0).abs() < 0.1, "{kind:?}: {got}, stated {stated}");
        }
    }

    #[test]
    fn unusable_arguments_are_refused() {
        for (cutoff, step) in [
            (0.0, 1.0),
            (1.0, 0.0),
            (-1.0, -1.0),
            (f64::NAN, 1.0),
            (1.0, f64::INFINITY),
            (1.0, 1e-10),
        ] {
            assert_eq!(
                ProfileFilter::new(FilterKind::Gaussian, cutoff, step),
                None,
                "{cutoff} {step}"
            );
        }
        let filter = ProfileFilter::new(FilterKind::MovingAverage, 10.0, 1.0).unwrap();
        let error = filter.mean_line(&[0.0; 4], &mut [0.0; 3], &mut []).unwrap_err();
        assert_eq!((error.len, error.needed), (3, 4));
        let error = filter.mean_line(&[0.0; 4], &mut [0.0; 4], &mut [0.0; 4]).unwrap_err();
        assert_eq!(error.needed, 4 + 12);
    }
}
