//! Repeated trainings of a net on the rows of a condition, and the run that is reported.

use super::net::Net;
use super::{Progress, StudyConfig};
use crate::{Condition, Scores, Sets, StudyError};
use mlp::train::{
    Algorithm, Choice, DataSet, EvaluateError, Fit, FitConfig, FitError, NetworkObjective,
    Objective as _, Run, RunConfig, Topology, evaluate,
    fit::{Fitting, by_evidence},
    init::nguyen_widrow,
};
use ndarray::ArrayRef1;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use serde::Serialize;

/// How the training of one net went: a row of Table 1. Errors are mean squares in scaled units, where the training
/// targets span -1 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Training error of the chosen run.
    pub mse: f64,
    /// Its error on the small test set.
    pub test_mse: f64,
    /// Mean training error of all runs.
    pub mean: f64,
    /// Standard deviation of it.
    pub deviation: f64,
    /// Lowest.
    pub best: f64,
    /// Highest.
    pub worst: f64,
    /// Seed of the chosen run.
    pub seed: u64,
    /// Its epochs.
    pub epochs: usize,
    /// Its gradients, the honest cost: SCG takes two an epoch, a Jacobian counts as one.
    pub gradients: usize,
    /// Why it stopped.
    pub stop: String,
}

/// Errors against epochs of the chosen run, in scaled units.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Curve {
    /// Epochs done.
    pub epoch: Vec<usize>,
    /// Training error after them.
    pub train: Vec<f64>,
    /// Error on the small test set; the training never saw it.
    pub test: Vec<f64>,
}

/// One net on one draw of rows.
#[derive(Clone, Debug)]
pub(super) struct Trained {
    pub(super) summary: Summary,
    pub(super) scores: Scores,
    pub(super) fit: Fit,
}

/// The settings of every training.
pub(super) fn fit_config(net: &Net, config: &StudyConfig) -> FitConfig {
    let algorithm = net.algorithm(&config.hyper);
    FitConfig {
        hidden: vec![config.hidden],
        algorithm,
        run: RunConfig {
            epochs: config.epochs,
            goal: config.goal,
            min_gradient: algorithm.min_gradient(),
            ..RunConfig::default()
        },
        seed: config.seed,
        repeats: net.starts(config.repeats),
        // Choosing the start by its evidence is part of Bayesian regularisation.
        choice: match algorithm {
            Algorithm::Br => Choice::Best,
            _ => Choice::NearestAverage,
        },
        ..FitConfig::default()
    }
}

/// Trains from every start and keeps the run nearest the average; of Bayesian regularisation the one with the highest evidence, which
/// decides too whether the target, its logarithm or its reciprocal is learned.
pub(super) fn train(
    condition: &Condition,
    net: &Net,
    sets: &Sets,
    config: &StudyConfig,
    progress: Progress<'_>,
) -> Result<Trained, StudyError> {
    let fault = |source| StudyError::Fit { condition: condition.name, learner: net.name, source };
    let fit_config = fit_config(net, config);
    let mut forms = sets.train.target_forms();
    if fit_config.algorithm != Algorithm::Br {
        forms.truncate(1);
    }
    let fittings: Vec<Fitting<'_>> = (forms.iter())
        .map(|form| Fitting::new(form, None, &fit_config))
        .collect::<Result<_, _>>()
        .map_err(fault)?;
    let start = |start| -> Vec<Run> {
        let runs = fittings.iter().map(|fitting| fitting.run(start)).collect();
        progress();
        runs
    };
    let runs: Vec<Vec<Run>> = (0..fit_config.repeats).into_par_iter().map(start).collect();
    let fit = best(&forms, &fittings, &runs).map_err(fault)?;
    let test = evaluate(&*fit.model, &sets.test)
        .map_err(|source: EvaluateError| FitError::Evaluate {
            file: sets.test.file.clone(),
            source,
        })
        .map_err(fault)?;
    let scores = sets.score(|features| answer(&fit, features));
    let summary = summary(&fit, test.scaled_mse, config);
    Ok(Trained { summary, scores, fit })
}

/// Of the form of the target that the evidence of its runs speaks for. Apart from [`train`], which waits for other trainings on the same
/// stack: models are large.
fn best(forms: &[DataSet], fittings: &[Fitting<'_>], runs: &[Vec<Run>]) -> Result<Fit, FitError> {
    let finished = fittings.iter().zip(forms).enumerate().map(|(at, (fitting, form))| {
        let runs = runs.iter().map(|runs| runs[at].clone()).collect();
        Ok((form.clone(), fitting.finish(runs, None)?))
    });
    let mut fits = finished.collect::<Result<Vec<_>, FitError>>()?;
    Ok(fits.swap_remove(by_evidence(&fits)).1)
}

/// The saved model's answer (N); NaN where it has none.
#[expect(clippy::cast_possible_truncation, reason = "the saved model computes in f32")]
fn answer(fit: &Fit, features: &ArrayRef1<f64>) -> f64 {
    let features: Vec<f32> = features.iter().map(|&value| value as f32).collect();
    let mut answer = [f32::NAN];
    match fit.model.predict(&features, &mut answer) {
        Ok(_) => answer[0].into(),
        Err(_) => f64::NAN,
    }
}

fn summary(fit: &Fit, test_mse: f64, config: &StudyConfig) -> Summary {
    let errors: Vec<f64> =
        fit.runs.iter().map(|run| run.mse).filter(|mse| mse.is_finite()).collect();
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let variance = errors.iter().map(|mse| (mse - mean).powi(2)).sum::<f64>() / count;
    let chosen = &fit.runs[fit.chosen];
    Summary {
        mse: chosen.mse,
        test_mse,
        mean,
        deviation: variance.sqrt(),
        best: errors.iter().copied().fold(f64::INFINITY, f64::min),
        worst: errors.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        seed: config.seed.wrapping_add(fit.chosen as u64),
        epochs: chosen.epochs,
        gradients: chosen.gradient_evaluations,
        stop: chosen.stop.to_string(),
    }
}

/// Goes through the chosen run once more, epoch by epoch, and looks at the test rows on the way.
pub(super) fn curve(
    net: &Net,
    sets: &Sets,
    trained: &Trained,
    config: &StudyConfig,
) -> Result<Curve, FitError> {
    // In the form of the target that was learned.
    let form = |rows: &DataSet| {
        let target = trained.fit.file.targets.first();
        target.and_then(|target| rows.with_target(target.transform)).unwrap_or_else(|| rows.clone())
    };
    let data = form(&sets.train);
    let topology = Topology::regression(data.inputs.len(), &[config.hidden], data.targets.len())?;
    let objective = |rows: &DataSet| {
        let [inputs, targets] = rows.scaled(&data.input_scalings(), &data.target_scalings());
        NetworkObjective::<f64>::new(&topology, &inputs, &targets)
    };
    let (mut train, mut test) = (objective(&data)?, objective(&form(&sets.test))?);
    let mut weights = nguyen_widrow(&topology, trained.summary.seed);
    let mut trainer = net.algorithm(&config.hyper).trainer(weights.len());
    let history = &trained.fit.runs[trained.fit.chosen].history;
    let mut curve = Curve::default();
    for (epoch, &mse) in history.iter().enumerate() {
        if shown(epoch) || epoch + 1 == history.len() {
            curve.epoch.push(epoch);
            curve.train.push(mse);
            curve.test.push(test.mse(&weights));
        }
        trainer.step(&mut train, &mut weights);
    }
    Ok(curve)
}

/// Every epoch at first, then about forty to a decade: the axis is logarithmic.
fn shown(epoch: usize) -> bool {
    let mut step = 1;
    while epoch >= 40 * step {
        step *= 2;
    }
    epoch.is_multiple_of(step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::PAPER;
    use crate::study::net::NETS;

    #[test]
    fn the_curve_is_that_of_the_chosen_run() {
        let config = StudyConfig { repeats: 3, epochs: 60, ..StudyConfig::quick(5) };
        let sets = PAPER.sets(5, 0).unwrap();
        for net in &NETS {
            let trained = train(&PAPER, net, &sets, &config, &|| ()).unwrap();
            let curve = curve(net, &sets, &trained, &config).unwrap();
            let last = curve.epoch.len() - 1;
            assert!(curve.epoch[last] <= 60 && curve.epoch.starts_with(&[0, 1, 2]), "{curve:?}");
            let first = curve.train[0];
            assert!(curve.train[last] < first && curve.test.iter().all(|mse| mse.is_finite()));
            // The saved model is in f32 and of the best epoch; these rules are at their best at the end.
            if net.trainer == "LM" || net.trainer == "GD" {
                let (end, reported) = (curve.test[last], trained.summary.test_mse);
                assert!((end / reported - 1.0).abs() < 1e-3, "{}: {end} {reported}", net.name);
            }
        }
    }

    #[test]
    fn a_thousand_epochs_show_few_points_but_all_early_ones() {
        let epochs: Vec<usize> = (0..=1000).filter(|&epoch| shown(epoch)).collect();
        assert!(epochs.len() < 160 && epochs[..40].iter().copied().eq(0..40), "{epochs:?}");
    }
}
