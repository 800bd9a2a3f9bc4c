//! Machine-readable line of an evaluated profile. Names and units of the JSON fields are a contract.

use super::{Evaluation, ProfileOptions};
use crate::esc::{EscLine, readings};
use crate::roughness::{FilterKind, Waviness};
use serde::Serialize;
use slip_core::{esc::Trial, irregularity::Irregularity};

/// How a quantity is spread over the irregularities (um).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation, over n.
    pub sd: f64,
    /// Least value.
    pub min: f64,
    /// Tenth percentile.
    pub p10: f64,
    /// Median.
    pub p50: f64,
    /// Ninetieth percentile.
    pub p90: f64,
    /// Greatest value.
    pub max: f64,
}

impl Spread {
    /// The spread of `values`; `None` where there are none.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len() as f64;
        let mean = sorted.iter().sum::<f64>() / n;
        let sd = (sorted.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
        let at = |percent: usize| {
            sorted.get((sorted.len().checked_sub(1)? * percent + 50) / 100).copied()
        };
        let (min, max) = (at(0)?, at(100)?);
        Some(Self { mean, sd, min, p10: at(10)?, p50: at(50)?, p90: at(90)?, max })
    }
}

/// How far a roughness profile agrees with that of an instrument.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Correlation of the two profiles.
    pub correlation: f64,
    /// Ra of this profile over that of the instrument's.
    pub ra_ratio: f64,
    /// Root mean square of the difference (um).
    pub rms_um: f64,
}

impl Agreement {
    /// Compares two profiles (m) of the same length; `None` where the lengths differ.
    #[must_use]
    pub fn of(ours: &[f64], theirs: &[f64]) -> Option<Self> {
        if ours.len() != theirs.len() || ours.is_empty() {
            return None;
        }
        let n = ours.len() as f64;
        let mean = |z: &[f64]| z.iter().sum::<f64>() / n;
        let (a, b) = (mean(ours), mean(theirs));
        let product = |f: &dyn Fn(f64, f64) -> f64| {
            ours.iter().zip(theirs).map(|(x, y)| f(*x, *y)).sum::<f64>()
        };
        let covariance = product(&|x, y| (x - a) * (y - b));
        let spread = product(&|x, _| (x - a).powi(2)) * product(&|_, y| (y - b).powi(2));
        Some(Self {
            correlation: covariance / spread.sqrt(),
            ra_ratio: product(&|x, _| x.abs()) / product(&|_, y| y.abs()),
            rms_um: 1e6 * (product(&|x, y| (x - y).powi(2)) / n).sqrt(),
        })
    }
}

/// An evaluated profile, as it is printed. JSON shows what is not known as `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileLine {
    /// Irregularities.
    pub n: usize,
    /// Ra (um).
    pub ra_um: f64,
    /// Rq (um).
    pub rq_um: f64,
    /// Rz (um).
    pub rz_um: f64,
    /// RSm (um).
    pub rsm_um: Option<f64>,
    /// Wa (um); `None` where the profile is shorter than `waviness_needs_mm`.
    pub wa_um: Option<f64>,
    /// Wz (um); `None` with Wa.
    pub wz_um: Option<f64>,
    /// Sections in Wz; `None` with Wa.
    pub waviness_sections: Option<u32>,
    /// The shortest profile whose waviness is measured (mm).
    pub waviness_needs_mm: f64,
    /// Degree of the polynomial that is the form.
    pub form_degree: u8,
    /// Highest minus lowest place of the form (um).
    pub form_um: f64,
    /// Wavelength of the most power (um), whether or not the surface is periodic.
    pub period_um: Option<f64>,
    /// Heights of the irregularities (um).
    pub delta_um: Option<Spread>,
    /// Spacings of the irregularities (um).
    pub s_um: Option<Spread>,
    /// Every reading of E_sc.
    pub esc: Vec<EscLine>,
    /// The same of the primary profile, in which form and waviness still are.
    pub primary: IrregularityLine,
    /// Slip speed of E_sc (m/s).
    pub speed_m_s: f64,
    /// Trial force of E_sc (N).
    pub force_n: f64,
    /// Time to pass the profile at that speed (s).
    pub contact_time_s: f64,
    /// Sections in Rz.
    pub sections: u32,
    /// Length of the profile (mm).
    pub length_mm: f64,
    /// What Ra, Rq, Rz and RSm leave out at either end (mm): half a lambda_c, 0 where the profile is too short for that.
    pub ends_mm: f64,
    /// Distance between two heights (um).
    pub step_um: f64,
    /// `moving_average` or `gaussian`.
    pub filter: &'static str,
    /// lambda_c (mm).
    pub cutoff_mm: f64,
    /// lambda_f (mm); `None` for none.
    pub lambda_f_mm: Option<f64>,
    /// lambda_s (um), 0 for none.
    pub lambda_s_um: f64,
    /// Low-pass before peaks and valleys (um), 0 for none.
    pub low_pass_um: f64,
    /// Noise of the heights (um, rms), an upper bound where the surface is coarse against the step.
    pub noise_um: f64,
    /// Hysteresis of peaks and valleys (um).
    pub hysteresis_um: f64,
    /// What a user should know before trusting any of it.
    pub warnings: Vec<String>,
    /// Agreement with the roughness profile of an instrument, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Agreement>,
}

/// Irregularities of one profile and their E_sc, as they are printed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IrregularityLine {
    /// Irregularities.
    pub n: usize,
    /// Heights of the irregularities (um).
    pub delta_um: Option<Spread>,
    /// Spacings of the irregularities (um).
    pub s_um: Option<Spread>,
    /// Every reading of E_sc.
    pub esc: Vec<EscLine>,
}

impl IrregularityLine {
    fn new(irregularities: &[Irregularity], trial: &Trial) -> Self {
        let pairs = irregularities.iter().map(|i| (f64::from(i.delta_m), f64::from(i.spacing_m)));
        Self {
            n: irregularities.len(),
            delta_um: Spread::of(pairs.clone().map(|(delta_m, _)| 1e6 * delta_m)),
            s_um: Spread::of(pairs.clone().map(|(_, spacing_m)| 1e6 * spacing_m)),
            esc: readings(pairs, trial),
        }
    }
}

impl ProfileLine {
    /// The line of `evaluation` at a slip of `trial`.
    #[must_use]
    pub fn new(evaluation: &Evaluation, options: &ProfileOptions, trial: &Trial) -> Self {
        let parameters = &evaluation.parameters;
        let length_m = evaluation.roughness_m.len() as f64 * evaluation.step_m;
        let of_roughness = IrregularityLine::new(&evaluation.irregularities, trial);
        let waviness = evaluation.waviness;
        let needs_m = Waviness::shortest_m(options.cutoff_m, options.long_cutoff_m);
        let form = evaluation.form_m.iter();
        let (low, high) = form.fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
        Self {
            n: of_roughness.n,
            ra_um: 1e6 * parameters.ra_m,
            rq_um: 1e6 * parameters.rq_m,
            rz_um: 1e6 * parameters.rz_m,
            rsm_um: parameters.rsm_m.map(|rsm_m| 1e6 * rsm_m),
            wa_um: waviness.map(|waviness| 1e6 * waviness.wa_m),
            wz_um: waviness.map(|waviness| 1e6 * waviness.wz_m),
            waviness_sections: waviness.map(|waviness| waviness.sections),
            waviness_needs_mm: 1e3 * needs_m,
            form_degree: options.form_degree,
            form_um: 1e6 * (high - low),
            period_um: evaluation.period_m.map(|period_m| 1e6 * period_m),
            delta_um: of_roughness.delta_um,
            s_um: of_roughness.s_um,
            esc: of_roughness.esc,
            primary: IrregularityLine::new(&evaluation.primary, trial),
            speed_m_s: trial.speed_m_s,
            force_n: trial.force_n,
            contact_time_s: length_m / trial.speed_m_s,
            sections: parameters.sections,
            length_mm: 1e3 * length_m,
            ends_mm: 1e3 * evaluation.evaluated.start as f64 * evaluation.step_m,
            step_um: 1e6 * evaluation.step_m,
            filter: filter_name(options.filter),
            cutoff_mm: 1e3 * options.cutoff_m,
            lambda_f_mm: options.long_cutoff_m.map(|long_m| 1e3 * long_m),
            lambda_s_um: 1e6 * options.short_cutoff_m,
            low_pass_um: 1e6 * options.low_pass_m,
            noise_um: 1e6 * evaluation.noise_m,
            hysteresis_um: 1e6 * evaluation.hysteresis_m,
            warnings: evaluation.warnings.clone(),
            reference: None,
        }
    }
}

fn filter_name(kind: FilterKind) -> &'static str {
    match kind {
        FilterKind::MovingAverage => "moving_average",
        FilterKind::Gaussian => "gaussian",
    }
}
