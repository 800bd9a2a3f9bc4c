//! The strongest wavelength of a roughness profile.

use core::f64::consts::TAU;

/// Frequencies tried per resolution cell 1/length: the peak of a Hann window is four cells wide.
const OVERSAMPLING: f64 = 8.0;

/// The wavelength (m) between `shortest_m` and `longest_m` (m) at which `heights` at equal steps of `step_m` (m) have most power
/// under a Hann window, refined by a parabola through the three strongest frequencies.
///
/// For a surface with one period (a ridged board, a turned part) it is that period, where single ridges may be missed or doubled by
/// the valleys between. Exact to about 0.1 % with ten periods or more. `None` where fewer than two steps or half a profile would
/// make a wave, or the bounds are not in order.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of steps and frequencies, not negative, far below 2^53"
)]
pub fn dominant_wavelength(
    heights: &[f64],
    step_m: f64,
    shortest_m: f64,
    longest_m: f64,
) -> Option<f64> {
    let n = heights.len() as f64;
    let (shortest, longest) = ((shortest_m / step_m).max(2.0), (longest_m / step_m).min(0.5 * n));
    // Also false where a bound is NaN.
    let in_order = shortest < longest && step_m > 0.0;
    if !in_order {
        return None;
    }
    let spacing = 1.0 / (OVERSAMPLING * n);
    let (first, last) = (1.0 / (longest * spacing), 1.0 / (shortest * spacing));
    let frequency = |k: u32| (libm::floor(first) + f64::from(k)) * spacing;
    let count = (last - first) as u32 + 2;
    let strongest = (0..count)
        .map(|k| (k, power(heights, frequency(k))))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, power)| *power > 0.0)?;
    let f = frequency(strongest.0);
    let (left, right) = (power(heights, f - spacing), power(heights, f + spacing));
    let bend = left - 2.0 * strongest.1 + right;
    let shift = if bend < 0.0 { 0.5 * (left - right) / bend } else { 0.0 };
    Some(step_m / (f + shift.clamp(-1.0, 1.0) * spacing))
}

/// Power of the windowed heights at `frequency` (per step), by Goertzel's recurrence.
fn power(heights: &[f64], frequency: f64) -> f64 {
    let turn = 2.0 * libm::cos(TAU * frequency);
    let window = Hann::new(heights.len() as f64);
    let (mut s1, mut s2) = (0.0, 0.0);
    for (height, weight) in heights.iter().zip(window) {
        let s = height * weight + turn * s1 - s2;
        s2 = s1;
        s1 = s;
    }
    s1 * s1 + s2 * s2 - turn * s1 * s2
}

/// The weights 1 - cos(2 pi (i + 1/2) / n), by rotation.
struct Hann {
    cos: f64,
    sin: f64,
    step: (f64, f64),
}

impl Hann {
    fn new(n: f64) -> Self {
        let half = 0.5 * TAU / n;
        let step = (libm::cos(2.0 * half), libm::sin(2.0 * half));
        Self { cos: libm::cos(half), sin: libm::sin(half), step }
    }
}

impl Iterator for Hann {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let weight = 1.0 - self.cos;
        let (c, s) = self.step;
        (self.cos, self.sin) = (self.cos * c - self.sin * s, self.sin * c + self.cos * s);
        Some(weight)
    }
}

#[cfg(test)]
mod tests {
    use super::dominant_wavelength;
    use core::f64::consts::TAU;

    #[test]
    fn a_period_is_found_among_others() {
        for period in [7.3, 23.45, 41.0] {
            let wave = |i: u32| {
                let x = TAU * f64::from(i);
                (x / period).sin()
                    + 0.4 * (x / (0.37 * period)).cos()
                    + 0.2 * f64::from(i * 7919 % 1013) / 1013.0
            };
            let heights: Vec<f64> = (0..500).map(wave).collect();
            let found = dominant_wavelength(&heights, 0.1, 0.25, 10.0).unwrap();
            assert!((found / (0.1 * period) - 1.0).abs() < 2e-3, "{period}: {found}");
        }
    }

    #[test]
    fn without_waves_or_room_there_is_none() {
        assert_eq!(dominant_wavelength(&[0.0; 100], 1.0, 2.0, 50.0), None);
        assert_eq!(dominant_wavelength(&[1.0, -1.0, 1.0], 1.0, 2.0, 50.0), None);
        let wave = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        assert_eq!(dominant_wavelength(&wave, 1.0, 9.0, 3.0), None);
        assert_eq!(dominant_wavelength(&wave, 0.0, 2.0, 3.0), None);
        assert_eq!(dominant_wavelength(&[], 1.0, 2.0, 3.0), None);
    }
}
