//! Amplitude and spacing parameters of a roughness or waviness profile.

use super::elements::Elements;

/// Height discrimination of RSm: peaks and valleys up to this part of Rz are none.
const HEIGHT_DISCRIMINATION: f64 = 0.1;
/// Spacing discrimination of RSm: what is narrower than this part of a section is none.
const SPACING_DISCRIMINATION: f64 = 0.01;

/// Amplitude and spacing parameters of a roughness profile, after ISO 21920-2 (and ISO 4287 before it).
///
/// The evaluation length is the whole profile. Sections are whole sampling lengths (one cutoff wavelength each) from its
/// start; a profile shorter than one is a single section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Ra, the mean of |z| (m).
    pub ra_m: f64,
    /// Rq, the root of the mean of z^2 (m).
    pub rq_m: f64,
    /// Rz, the mean over the sections of highest peak minus deepest valley (m).
    pub rz_m: f64,
    /// RSm, the mean width of the profile elements (m), with peaks and valleys beyond 10 % of Rz from the mean line and at
    /// least 1 % of a section wide; `None` with fewer than three borders between hill and dale.
    pub rsm_m: Option<f64>,
    /// Elements in RSm, overlapping: hill then dale and dale then hill.
    pub elements: u32,
    /// Sections in Rz.
    pub sections: u32,
}

impl Roughness {
    /// Measures the roughness profile `heights` (m, about its mean line, finite) at equal steps of `step_m` (m) with sections
    /// of `section_m` (m). `None` for an empty profile or lengths that are not positive.
    #[must_use]
    pub fn measure(heights: &[f64], step_m: f64, section_m: f64) -> Option<Self> {
        let steps = section_m / step_m;
        if heights.is_empty() || !(section_m > 0.0 && step_m > 0.0 && steps >= 1.0) {
            return None;
        }
        let n = heights.len() as f64;
        let ra_m = heights.iter().map(|z| z.abs()).sum::<f64>() / n;
        let rq_m = libm::sqrt(heights.iter().map(|z| z * z).sum::<f64>() / n);
        let (rz_m, sections) = mean_range(heights, steps);
        let elements = Elements::new(HEIGHT_DISCRIMINATION * rz_m, SPACING_DISCRIMINATION * steps)
            .mean_width(heights);
        Some(Self {
            ra_m,
            rq_m,
            rz_m,
            rsm_m: elements.map(|(width, _)| width * step_m),
            elements: elements.map_or(0, |(_, count)| count),
            sections,
        })
    }
}

/// Sampling lengths of the roughness, lambda_c each, that a profile must have before its waviness is measured.
const FEWEST_CUTOFFS: f64 = 5.0;

/// Amplitude parameters of a waviness profile, after ISO 4287.
///
/// The evaluation length is the whole profile. Sections are whole sampling lengths of lambda_f from its start; without
/// lambda_f the whole profile is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waviness {
    /// Wa, the mean of |z| (m).
    pub wa_m: f64,
    /// Wz, the mean over the sections of highest peak minus deepest valley (m).
    pub wz_m: f64,
    /// Sections in Wz.
    pub sections: u32,
}

impl Waviness {
    /// The shortest profile (m) whose waviness is measured: five cutoffs `cutoff_m` (lambda_c, m), so that the shortest waves
    /// are there five times, and one sampling length `long_cutoff_m` (lambda_f, m) where there is one. A sine that fits less
    /// often is partly taken for form: a least-squares line takes 6 / (pi k)^2 of the power of k periods, 2 % for five.
    #[must_use]
    pub fn shortest_m(cutoff_m: f64, long_cutoff_m: Option<f64>) -> f64 {
        (FEWEST_CUTOFFS * cutoff_m).max(long_cutoff_m.unwrap_or(0.0))
    }

    /// Measures the waviness profile `heights` (m, about its mean line, finite) at equal steps of `step_m` (m), between the
    /// cutoffs `cutoff_m` and `long_cutoff_m` (m). `None` where it is shorter than [`Waviness::shortest_m`] by more than one
    /// step, or a length is not positive.
    #[must_use]
    pub fn measure(
        heights: &[f64],
        step_m: f64,
        cutoff_m: f64,
        long_cutoff_m: Option<f64>,
    ) -> Option<Self> {
        let n = heights.len() as f64;
        let positive = step_m > 0.0 && cutoff_m > 0.0 && long_cutoff_m.is_none_or(|l| l > 0.0);
        // Also where a length is NaN.
        let long_enough = (n + 1.0) * step_m >= Self::shortest_m(cutoff_m, long_cutoff_m);
        if heights.is_empty() || !(positive && long_enough) {
            return None;
        }
        let section_m = long_cutoff_m.unwrap_or(n * step_m);
        let (wz_m, sections) = mean_range(heights, section_m / step_m);
        let wa_m = heights.iter().map(|z| z.abs()).sum::<f64>() / n;
        Some(Self { wa_m, wz_m, sections })
    }
}

/// Mean over the whole sections, `steps` long, of highest minus lowest, and their number. A section may lack one
/// step at the end: a trace of four sections is often one height short.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "lengths of profiles, not negative"
)]
fn mean_range(heights: &[f64], steps: f64) -> (f64, u32) {
    let whole = libm::floor((heights.len() as f64 + 1.0) / steps).max(1.0);
    let sections = whole as u32;
    let range = |k: u32| {
        let border = |k: u32| libm::round(f64::from(k) * steps) as usize;
        let len = if sections == 1 { heights.len() } else { border(k + 1) - border(k) };
        let part = || heights.iter().skip(border(k)).take(len).copied();
        let (low, high) = part().fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(z), h.max(z)));
        high - low
    };
    ((0..sections).map(range).sum::<f64>() / f64::from(sections), sections)
}

#[cfg(test)]
mod tests {
    use super::{Roughness, Waviness};
    use core::f64::consts::{PI, TAU};

    fn close(got: f64, want: f64) {
        assert!((got / want - 1.0).abs() < 1e-4, "{got} {want}");
    }

    #[test]
    fn a_sine_has_its_closed_forms() {
        let wave: Vec<f64> =
            (0..40_000).map(|i| 3e-6 * (TAU * f64::from(i) / 400.0).sin()).collect();
        let got = Roughness::measure(&wave, 1e-6, 2.5e-3).unwrap();
        close(got.ra_m, 2.0 * 3e-6 / PI);
        close(got.rq_m, 3e-6 / 2_f64.sqrt());
        close(got.rz_m, 6e-6);
        close(got.rsm_m.unwrap(), 400e-6);
        assert_eq!((got.sections, got.elements), (16, 198));
    }

    #[test]
    fn a_triangle_has_its_closed_forms() {
        let wave: Vec<f64> = (0..20_000_u32)
            .map(|i| 2.0 * (f64::from((i % 1000).min(1000 - i % 1000)) / 250.0 - 1.0))
            .collect();
        let got = Roughness::measure(&wave, 0.5, 2000.0).unwrap();
        close(got.ra_m, 1.0);
        close(got.rq_m, 2.0 / 3_f64.sqrt());
        close(got.rz_m, 4.0);
        close(got.rsm_m.unwrap(), 500.0);
        assert_eq!(got.sections, 5);
    }

    #[test]
    fn waviness_of_a_sine_has_its_closed_forms_and_needs_its_length() {
        let wave: Vec<f64> =
            (0..10_000).map(|i| 3e-6 * (TAU * f64::from(i) / 2000.0).sin()).collect();
        let whole = Waviness::measure(&wave, 1e-6, 0.8e-3, None).unwrap();
        close(whole.wa_m, 2.0 * 3e-6 / PI);
        close(whole.wz_m, 6e-6);
        assert_eq!(whole.sections, 1);
        let in_sections = Waviness::measure(&wave, 1e-6, 0.8e-3, Some(2.5e-3)).unwrap();
        close(in_sections.wz_m, 6e-6);
        assert_eq!(in_sections.sections, 4);
        let of = |n: usize, cutoff_m, long| Waviness::measure(&wave[..n], 1e-6, cutoff_m, long);
        assert!(of(10_000, 2e-3, None).is_some() && of(9999, 2e-3, None).is_some());
        assert_eq!(of(9998, 2e-3, None), None, "five cutoffs are 10 mm");
        assert_eq!(of(10_000, 2.1e-3, None), None);
        assert_eq!(of(10_000, 0.8e-3, Some(10.1e-3)), None, "one lambda_f");
        for (step, cutoff, long) in
            [(0.0, 1.0, None), (1.0, f64::NAN, None), (1.0, 1.0, Some(f64::NAN)), (1.0, 0.0, None)]
        {
            assert_eq!(Waviness::measure(&wave, step, cutoff, long), None, "{step} {cutoff}");
        }
        assert_eq!(Waviness::measure(&[], 1.0, 1.0, None), None);
    }

    #[test]
    fn rz_is_a_mean_over_sections_and_a_short_profile_is_one() {
        let mut wave = [0.0; 400];
        (wave[50], wave[150], wave[250], wave[350]) = (1.0, 2.0, 3.0, -6.0);
        let rz =
            |n: usize| Roughness::measure(&wave[..n], 1.0, 100.0).map(|r| (r.rz_m, r.sections));
        assert_eq!(rz(400), Some((3.0, 4)));
        assert_eq!(rz(399), Some((3.0, 4)), "one height short");
        assert_eq!(rz(398), Some((2.0, 3)), "a part of a section does not count");
        assert_eq!(rz(60), Some((1.0, 1)));
        assert_eq!(rz(0), None);
        for (step, section) in
            [(0.0, 1.0), (1.0, 0.0), (1.0, 0.5), (f64::NAN, 1.0), (1.0, f64::NAN)]
        {
            assert_eq!(Roughness::measure(&wave, step, section), None, "{step} {section}");
        }
    }
}
