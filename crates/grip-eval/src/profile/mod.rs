//! A height profile in; its roughness, irregularities and every reading of E_sc out.
//!
//! Two filters split the profile: what is longer than lambda_c is shape and waviness, what is shorter than lambda_s is
//! noise; what is left is the roughness profile, on which Ra, Rq, Rz and RSm are measured. The irregularities are
//! found on that profile after one more low-pass ([`ProfileOptions::low_pass_m`]), which keeps noise from raising the peaks, and with a
//! hysteresis that noise does not decide about ([`batch::widest_gap`]).

pub mod batch;
mod report;

pub use report::{Agreement, ProfileLine, Spread};

use crate::roughness::{
    BufferTooShort, FilterKind, ProfileFilter, Roughness, dominant_wavelength, noise_deviation,
};
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
    /// Whether the least-squares line is taken away before anything else.
    pub level: bool,
    /// Hysteresis of peaks and valleys (m), instead of one chosen from the profile.
    pub hysteresis_m: Option<f64>,
}

impl ProfileOptions {
    /// The usual evaluation at `cutoff_m` (m): lambda_s is a hundredth of it, the low-pass a thirtieth.
    #[must_use]
    pub fn new(cutoff_m: f64) -> Self {
        Self {
            cutoff_m,
            short_cutoff_m: cutoff_m / 100.0,
            low_pass_m: cutoff_m / 30.0,
            filter: FilterKind::default(),
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
    /// A buffer of the evaluation was too short.
    #[error(transparent)]
    Buffer(#[from] BufferTooShort),
}

/// A profile and what was measured on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Distance between two heights (m).
    pub step_m: f64,
    /// The roughness profile (m).
    pub roughness_m: Vec<f64>,
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
    /// Irregularities in order.
    pub irregularities: Vec<Irregularity>,
}

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
    let mut heights = profile.heights_m.clone();
    let tilt = level(&mut heights, step_m, options.level);
    let noise_m = noise_deviation(&heights, &mut vec![0.0; heights.len()]).unwrap_or(0.0);
    let filter = |cutoff_m| ProfileFilter::new(options.filter, cutoff_m, step_m);
    let mean_line = low_passed(&heights, Some(filter(cutoff_m).ok_or(unsuitable)?))?;
    let mut roughness_m = low_passed(&heights, filter(options.short_cutoff_m))?;
    roughness_m.iter_mut().zip(&mean_line).for_each(|(z, line)| *z -= line);
    let parameters = Roughness::measure(&roughness_m, step_m, cutoff_m).ok_or(unsuitable)?;
    let low_pass = SpatialLowPass::new(options.low_pass_m);
    let smooth = smoothed(&roughness_m, step_m, low_pass);
    let noise_left = noise_m * low_pass.noise_gain(step_m);
    let hysteresis =
        options.hysteresis_m.map_or_else(|| chosen(&smooth, &parameters, noise_left), narrow);
    Ok(Evaluation {
        step_m,
        tilt,
        period_m: dominant_wavelength(&roughness_m, step_m, options.low_pass_m, cutoff_m),
        noise_m,
        hysteresis_m: f64::from(hysteresis),
        turns: batch::turns(&smooth, step_m, hysteresis)
            .map(|turn| Turn { position_m: turn.position_m - low_pass.lag_m(), ..turn })
            .collect(),
        irregularities: batch::irregularities(&smooth, step_m, hysteresis).collect(),
        roughness_m,
        parameters,
    })
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
    clippy::cast_precision_loss,
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

/// The slope of the least-squares line of `heights`, which is taken away if `remove`.
#[expect(clippy::cast_precision_loss, reason = "lengths of profiles are far below 2^53")]
fn level(heights: &mut [f64], step_m: f64, remove: bool) -> f64 {
    let n = heights.len() as f64;
    let mean = heights.iter().sum::<f64>() / n;
    let place = |i: usize| i as f64 - 0.5 * (n - 1.0);
    let product: f64 = heights.iter().enumerate().map(|(i, z)| place(i) * (z - mean)).sum();
    let slope = product * 12.0 / (n * (n * n - 1.0));
    if remove {
        heights.iter_mut().enumerate().for_each(|(i, z)| *z -= mean + slope * place(i));
    }
    slope / step_m
}

#[cfg(test)]
mod tests;
