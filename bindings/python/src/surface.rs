//! Every reading of E_sc with its enclosure, of irregularities or a height profile.

use crate::{
    input::{positive, refused, vector},
    output::dictionary,
};
use grip_eval::{
    esc::readings,
    profile::{Evaluation, ProfileLine, ProfileOptions, evaluate},
    roughness::FilterKind,
};
use grip_record::HeightProfile;
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyArrayMethods as _, ToPyArray as _};
use pyo3::{prelude::*, types::PyDict};
use slip_core::esc::{Reading, Trial};

/// A cutoff longer than so many profiles shows nothing, and its filter takes the memory of as many.
const MOST_CUTOFF: f64 = 100.0;

fn trial(force: f64, speed: f64, noise: f64) -> PyResult<Trial> {
    let force = positive("force", force, false)?;
    let speed = positive("speed", speed, false)?;
    Ok(Trial::new(force, speed).with_noise(positive("noise", noise, true)?))
}

/// Every reading of the scattered energy E_sc of irregularities, by name; `literal` is the equation as printed.
///
/// delta, s: heights and lengths (m), both (irregularities,); force: trial force (N); speed: of the slip (m/s);
/// noise: relative, of each delta/s. The exact value of each formula lies within lo to hi.
#[pyfunction]
#[pyo3(signature = (delta, s, force, speed, *, noise=0.01))]
pub(crate) fn esc<'py>(
    py: Python<'py>,
    delta: &Bound<'py, PyAny>,
    s: &Bound<'py, PyAny>,
    force: f64,
    speed: f64,
    noise: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let trial = trial(force, speed, noise)?;
    let (heights, spacings) = (vector("delta", delta)?, vector("s", s)?);
    if heights.len() != spacings.len() {
        return Err(refused(format!(
            "delta has {} values and s has {}: each irregularity has one of both",
            heights.len(),
            spacings.len()
        )));
    }
    let lines = py.detach(|| readings(heights.into_iter().zip(spacings), &trial));
    let all = PyDict::new(py);
    for (line, reading) in lines.iter().zip(Reading::ALL) {
        // Not by JSON, which has no infinite bounds.
        let one = PyDict::new(py);
        one.set_item("value", line.value)?;
        one.set_item("lo", line.lo)?;
        one.set_item("hi", line.hi)?;
        one.set_item("unit", line.unit)?;
        one.set_item("n", line.n)?;
        one.set_item("degenerate", line.degenerate)?;
        one.set_item("condition", line.condition)?;
        one.set_item("sigma_s", line.sigma_s)?;
        one.set_item("flags", &line.flags)?;
        one.set_item("formula", reading.formula())?;
        all.set_item(line.reading, one)?;
    }
    Ok(all)
}

/// An evaluated height profile.
#[pyclass(frozen, get_all, module = "slipgrip")]
pub(crate) struct Profile {
    /// The line of `gripctl profile --json`: ra_um, rz_um, rsm_um, esc and so on.
    parameters: Py<PyDict>,
    /// The roughness profile (m), as long as the heights.
    roughness_m: Py<PyArray1<f64>>,
    /// Peaks and valleys: place and height (m), (turns, 2).
    turns_m: Py<PyArray2<f64>>,
    /// Irregularities: height delta and length s (m), (irregularities, 2).
    irregularities_m: Py<PyArray2<f64>>,
}

/// Roughness, irregularities and E_sc of a surface, as `gripctl profile`.
///
/// heights: (points,) in m, step (m) apart; speed (m/s), force (N) and noise as for `esc`; cutoff, lambda_s, low_pass,
/// hysteresis: lengths of the filters (m); gaussian: the filter of ISO 16610-21; level: takes the tilt away first.
#[pyfunction]
#[pyo3(signature = (
    heights, step, *, speed=0.05, force=1.0, noise=0.01, cutoff=2.5e-3, lambda_s=None, low_pass=None, hysteresis=None,
    gaussian=false, level=false
))]
pub(crate) fn profile(
    py: Python<'_>,
    heights: &Bound<'_, PyAny>,
    step: f64,
    speed: f64,
    force: f64,
    noise: f64,
    cutoff: f64,
    lambda_s: Option<f64>,
    low_pass: Option<f64>,
    hysteresis: Option<f64>,
    gaussian: bool,
    level: bool,
) -> PyResult<Profile> {
    let trial = trial(force, speed, noise)?;
    let usual = ProfileOptions::new(positive("cutoff", cutoff, false)?);
    let or = |name, given: Option<f64>, usual| given.map_or(Ok(usual), |m| positive(name, m, true));
    let options = ProfileOptions {
        short_cutoff_m: or("lambda_s", lambda_s, usual.short_cutoff_m)?,
        low_pass_m: or("low_pass", low_pass, usual.low_pass_m)?,
        filter: if gaussian { FilterKind::Gaussian } else { FilterKind::MovingAverage },
        level,
        hysteresis_m: hysteresis.map(|m| positive("hysteresis", m, true)).transpose()?,
        ..usual
    };
    let heights_m = vector("heights", heights)?;
    let step_m = positive("step", step, false)?;
    if heights_m.len() < HeightProfile::FEWEST {
        let (got, fewest) = (heights_m.len(), HeightProfile::FEWEST);
        return Err(refused(format!("heights: {got} of them; a profile needs at least {fewest}")));
    }
    if let Some(at) = heights_m.iter().position(|height| !height.is_finite()) {
        return Err(refused(format!(
            "heights: number {at} is {}, which is no height",
            heights_m[at]
        )));
    }
    let length_m = heights_m.len() as f64 * step_m;
    if options.cutoff_m > MOST_CUTOFF * length_m {
        return Err(refused(format!(
            "cutoff = {cutoff} m: more than {MOST_CUTOFF} times the length of the profile, {length_m:e} m"
        )));
    }
    let (evaluation, line) = py
        .detach(|| {
            let evaluation = evaluate(&HeightProfile::new(heights_m, step_m), &options)?;
            let line = ProfileLine::new(&evaluation, &options, &trial);
            Ok::<_, grip_eval::profile::ProfileError>((evaluation, line))
        })
        .map_err(refused)?;
    arrays(py, &evaluation, &line)
}

fn arrays(py: Python<'_>, evaluation: &Evaluation, line: &ProfileLine) -> PyResult<Profile> {
    let pairs = |values: Vec<f64>| {
        let rows = values.len() / 2;
        values.into_pyarray(py).reshape([rows, 2]).map(Bound::unbind)
    };
    let turns = evaluation.turns.iter().flat_map(|turn| [turn.position_m, turn.height_m.into()]);
    let irregularities = evaluation.irregularities.iter();
    let irregularities = irregularities.flat_map(|i| [i.delta_m.into(), i.spacing_m.into()]);
    Ok(Profile {
        parameters: dictionary(py, line)?.unbind(),
        roughness_m: evaluation.roughness_m.to_pyarray(py).unbind(),
        turns_m: pairs(turns.collect())?,
        irregularities_m: pairs(irregularities.collect())?,
    })
}
