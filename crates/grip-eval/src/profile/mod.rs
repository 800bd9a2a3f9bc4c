//! Evaluation of a height profile: its form, waviness and roughness, irregularities and every reading of E_sc.
//!
//! The parameters of the roughness are those of the profile without half a lambda_c at either end, where the mean line knows one
//! side only, as far as a sampling length is left; everything else is of the whole profile.
//!
//! Two filters split the profile: what is longer than lambda_c is form and waviness, what is shorter than lambda_s is
//! noise; what is left is the roughness profile, on which Ra, Rq, Rz and RSm are measured. Form is the least-squares polynomial
//! ([`form`]), and what lambda_c leaves of the heights above it, less what is longer than lambda_f where that is given, is the
//! waviness profile, with Wa and Wz (ISO 4287; order of the steps as in ISO 16610-1).
//!
//! Where the form is not taken away before the roughness ([`ProfileOptions::level`]), the three parts add up to the
//! profile but for its ends. The irregularities are
//! found on that profile after one more low-pass ([`ProfileOptions::low_pass_m`]), which keeps noise from raising the peaks, and with a
//! hysteresis that noise does not decide about ([`batch::widest_gap`]). Those of the primary profile, in which form and waviness still are, are found in the
//! same way with the same hysteresis.

pub mod batch;
pub mod form;
mod report;
mod warnings;

pub use report::{Agreement, IrregularityLine, ProfileLine, Spread};

use crate::roughness::{
    BufferTooShort, FilterKind, ProfileFilter, Roughness, Waviness, dominant_wavelength,
    noise_deviation,
};
use core::ops::Range;
use grip_record::HeightProfile;
use slip_core::irregularity::{Irregularity, SpatialLowPass, Turn};

/// How a profile is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileOptions {
    /// Cutoff wavelength lambda_c (m), which is also the sampling length.
    pub cutoff_m: f64,
    /// Cutoff wavelength lambda_s (m); 0 for none.
    pub short_cutoff_m: f64,
    /// Cutoff wavelength of the low-pass before peaks and valleys are looked for (m); 0 for none.
    pub low_pass_m: f64,
    /// How the filters weight.
    pub filter: FilterKind,
    /// Cutoff wavelength lambda_f (m), longer than lambda_c: longer waves are form; `None` for no such limit.
    pub long_cutoff_m: Option<f64>,
    /// Degree of the polynomial that is the form; 1 is a line.
    pub form_degree: u8,
    /// Whether the form is taken away before anything else. Otherwise the waviness alone goes without it.
    pub level: bool,
    /// Hysteresis of peaks and valleys (m), instead of one chosen from the profile.
    pub hysteresis_m: Option<f64>,
}

impl ProfileOptions {
    /// The usual evaluation at `cutoff_m` (m): lambda_s is that of the nearest pair of ISO 3274 (2.5 um to 0.8 mm, 8 um for 2.5 mm,
    /// 25 um for 8 mm), the low-pass a thirtieth.
    #[must_use]
    pub fn new(cutoff_m: f64) -> Self {
        Self {
            cutoff_m,
            short_cutoff_m: warnings::pair(cutoff_m).lambda_s_m,
            low_pass_m: cutoff_m / 30.0,
            filter: FilterKind::default(),
            long_cutoff_m: None,
            form_degree: 1,
            level: false,
            hysteresis_m: None,
        }
    }
}

/// Why a profile was not evaluated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// The cutoff is shorter than the profile can show, or longer than is sensible.
    #[error("a cutoff of {} mm on steps of {} mm: it must span 5 to 1000000000 steps", cutoff_m * 1e3, step_m * 1e3)]
    Cutoff {
        /// The cutoff (m).
        cutoff_m: f64,
        /// The step (m).
        step_m: f64,
    },
    /// lambda_f leaves no room for waviness.
    #[error("lambda_f of {} mm: it must be longer than lambda_c of {} mm and span at most 1000000000 steps", long_cutoff_m * 1e3, cutoff_m * 1e3)]
    LongCutoff {
        /// lambda_f (m).
        long_cutoff_m: f64,
        /// lambda_c (m).
        cutoff_m: f64,
    },
    /// Too long a stretch without heights.
    #[error(
        "no heights from {:.4} to {:.4} mm: up to {:.4} mm, a {MOST_GAPS}th of lambda_c, are bridged; split the file there",
        from_m * 1e3, to_m * 1e3, most_m * 1e3
    )]
    Gap {
        /// The first place without a height (m).
        from_m: f64,
        /// The next one with a height (m).
        to_m: f64,
        /// What is bridged (m).
        most_m: f64,
    },
    /// A buffer of the evaluation was too short.
    #[error(transparent)]
    Buffer(#[from] BufferTooShort),
}

/// A profile and what was measured on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Distance between two heights (m).
    pub step_m: f64,
    /// The form (m): the least-squares polynomial of the heights.
    pub form_m: Vec<f64>,
    /// The waviness profile (m).
    pub waviness_m: Vec<f64>,
    /// Its parameters; `None` where the profile is too short ([`Waviness::shortest_m`]).
    pub waviness: Option<Waviness>,
    /// The roughness profile (m).
    pub roughness_m: Vec<f64>,
    /// The heights that its parameters are of.
    pub evaluated: Range<usize>,
    /// Its parameters.
    pub parameters: Roughness,
    /// Wavelength of the most power between the low-pass and lambda_c (m).
    pub period_m: Option<f64>,
    /// Deviation of the noise of the heights (m), an upper bound where the surface is coarse against the step.
    pub noise_m: f64,
    /// Slope of the least-squares line of the heights.
    pub tilt: f64,
    /// Hysteresis of the peaks and valleys (m).
    pub hysteresis_m: f64,
    /// Peaks and valleys in order, at their places on the profile.
    pub turns: Vec<Turn>,
    /// Irregularities of the roughness profile in order.
    pub irregularities: Vec<Irregularity>,
    /// Irregularities of the primary profile in order: lambda_s alone, with waviness, and with form unless that was taken away.
    pub primary: Vec<Irregularity>,
    /// What a user should know before trusting any of it.
    pub warnings: Vec<String>,
}

/// A stretch without heights is bridged up to this part of lambda_c.
const MOST_GAPS: f64 = 20.0;
/// Hysteresis over the noise that is left after the low-pass, at least.
const NOISE_SIGMAS: f64 = 6.0;
/// The hysteresis lies between these parts of Rz, where noise allows: about the tenth that ISO 21920-2 discriminates by.
const HYSTERESIS_OF_RZ: (f64, f64) = (0.05, 0.15);

/// Evaluates a profile.
///
/// # Errors
/// Where the cutoff does not suit the step of the profile.
pub fn evaluate(
    profile: &HeightProfile,
    options: &ProfileOptions,
) -> Result<Evaluation, ProfileError> {
    let (cutoff_m, step_m) = (options.cutoff_m, profile.step_m);
    let unsuitable = ProfileError::Cutoff { cutoff_m, step_m };
    if cutoff_m.is_nan() || cutoff_m < 5.0 * step_m {
        return Err(unsuitable);
    }
    check_gaps(profile, cutoff_m)?;
    let tilt = slope(&profile.heights_m) / step_m;
    let form_m = form::least_squares(&profile.heights_m, options.form_degree);
    let levelled = difference(&profile.heights_m, &form_m);
    let heights = if options.level { &levelled } else { &profile.heights_m };
    let noise_m = noise_deviation(heights, &mut vec![0.0; heights.len()]).unwrap_or(0.0);
    let filter = |cutoff_m| ProfileFilter::new(options.filter, cutoff_m, step_m);
    let lambda_c = filter(cutoff_m).ok_or(unsuitable)?;
    let primary_m = low_passed(heights, filter(options.short_cutoff_m))?;
    let roughness_m = difference(&primary_m, &low_passed(heights, Some(lambda_c))?);
    let waviness_m = waviness(&levelled, step_m, lambda_c, options)?;
    let evaluated = without_ends(roughness_m.len(), cutoff_m / step_m);
    let parameters = roughness_m.get(evaluated.clone()).unwrap_or_default();
    let parameters = Roughness::measure(parameters, step_m, cutoff_m).ok_or(unsuitable)?;
    let low_pass = SpatialLowPass::new(options.low_pass_m);
    let smooth = smoothed(&roughness_m, step_m, low_pass);
    let smooth_primary = smoothed(&primary_m, step_m, low_pass);
    let noise_left = noise_m * low_pass.noise_gain(step_m);
    let hysteresis =
        options.hysteresis_m.map_or_else(|| chosen(&smooth, &parameters, noise_left), narrow);
    let mut evaluation = Evaluation {
        step_m,
        tilt,
        period_m: dominant_wavelength(&roughness_m, step_m, options.low_pass_m, cutoff_m),
        noise_m,
        hysteresis_m: f64::from(hysteresis),
        turns: batch::turns(&smooth, step_m, hysteresis)
            .map(|turn| Turn { position_m: turn.position_m - low_pass.lag_m(), ..turn })
            .collect(),
        irregularities: batch::irregularities(&smooth, step_m, hysteresis).collect(),
        primary: batch::irregularities(&smooth_primary, step_m, hysteresis).collect(),
        waviness: Waviness::measure(&waviness_m, step_m, cutoff_m, options.long_cutoff_m),
        form_m,
        waviness_m,
        roughness_m,
        evaluated,
        parameters,
        warnings: Vec::new(),
    };
    evaluation.warnings = warnings::of(profile, options, &evaluation);
    Ok(evaluation)
}

fn check_gaps(profile: &HeightProfile, cutoff_m: f64) -> Result<(), ProfileError> {
    let most_m = cutoff_m / MOST_GAPS;
    for gap in &profile.filled {
        let [from_m, to_m] = [gap.start, gap.end].map(|place| count(place) * profile.step_m);
        if to_m - from_m > most_m {
            return Err(ProfileError::Gap { from_m, to_m, most_m });
        }
    }
    Ok(())
}

/// What is left of `n` heights without half a cutoff of `cutoff` steps at either end; all of them where that is less than one cutoff.
fn without_ends(n: usize, cutoff: f64) -> Range<usize> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let end = (0.5 * cutoff).round() as usize;
    let left = n.saturating_sub(end.saturating_mul(2));
    if count(left) + 1.0 < cutoff { 0..n } else { end..n - end }
}

fn count(n: usize) -> f64 {
    n as f64
}

/// What `lambda_c` leaves of the levelled heights, less what is longer than lambda_f where the profile holds that.
fn waviness(
    levelled: &[f64],
    step_m: f64,
    lambda_c: ProfileFilter,
    options: &ProfileOptions,
) -> Result<Vec<f64>, ProfileError> {
    let waves = low_passed(levelled, Some(lambda_c))?;
    let Some(long_cutoff_m) = options.long_cutoff_m else { return Ok(waves) };
    let cutoff_m = options.cutoff_m;
    let lambda_f = ProfileFilter::new(options.filter, long_cutoff_m, step_m);
    let lambda_f = lambda_f
        .filter(|_| long_cutoff_m > cutoff_m)
        .ok_or(ProfileError::LongCutoff { long_cutoff_m, cutoff_m })?;
    let length_m = count(levelled.len() + 1) * step_m;
    if length_m < long_cutoff_m {
        return Ok(waves);
    }
    let long = low_passed(levelled, Some(lambda_f))?;
    Ok(difference(&waves, &long))
}

fn difference(from: &[f64], less: &[f64]) -> Vec<f64> {
    from.iter().zip(less).map(|(a, b)| a - b).collect()
}

fn chosen(smooth: &[f32], parameters: &Roughness, noise_left_m: f64) -> f32 {
    let (low, high) = HYSTERESIS_OF_RZ;
    let low_m = (low * parameters.rz_m).max(NOISE_SIGMAS * noise_left_m);
    let high_m = (high * parameters.rz_m).max(2.0 * low_m);
    batch::widest_gap(smooth, narrow(low_m), narrow(high_m))
}

#[expect(clippy::cast_possible_truncation, reason = "a threshold needs no more than f32")]
fn narrow(value: f64) -> f32 {
    value as f32
}

/// `heights` as the streaming low-pass gives them, so that a profile and its play-back are treated alike.
#[expect(
    clippy::cast_possible_truncation,
    reason = "heights of peaks need no more than f32; indices are far below 2^53"
)]
fn smoothed(heights: &[f64], step_m: f64, mut filter: SpatialLowPass) -> Vec<f32> {
    let placed = heights.iter().enumerate();
    placed.map(|(i, z)| filter.push(i as f64 * step_m, *z as f32)).collect()
}

/// The mean line of `heights` by `filter`, or `heights` without one.
fn low_passed(heights: &[f64], filter: Option<ProfileFilter>) -> Result<Vec<f64>, BufferTooShort> {
    let mut line = heights.to_vec();
    if let Some(filter) = filter {
        let mut scratch = vec![0.0; filter.scratch_len(heights.len())];
        filter.mean_line(heights, &mut line, &mut scratch)?;
    }
    Ok(line)
}

/// The slope of the least-squares line of `heights`, a step.
fn slope(heights: &[f64]) -> f64 {
    let n = count(heights.len());
    let mean = heights.iter().sum::<f64>() / n;
    let place = |i: usize| count(i) - 0.5 * (n - 1.0);
    let product: f64 = heights.iter().enumerate().map(|(i, z)| place(i) * (z - mean)).sum();
    product * 12.0 / (n * (n * n - 1.0))
}

#[cfg(test)]
mod tests;
