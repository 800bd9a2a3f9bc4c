//! Cross-validation: every part of the rows is the test of a model that never saw it.

use super::rows;
use crate::{cli::learn::TrainArgs, output};
use mlp::train::{DataSet, FitConfig, Split, fit::no_better_than_the_mean, metrics::r_squared};
use ndarray::Array1;
use serde::Serialize;

#[derive(Serialize)]
#[serde(tag = "type", rename = "fold")]
struct Fold {
    fold: usize,
    folds: usize,
    train_rows: usize,
    test_rows: usize,
    train_mse: f64,
    test_mse: f64,
    test_scaled_mse: f64,
    test_within_10pct: f64,
    test_r2: Option<f64>,
    #[serde(flatten)]
    classes: super::Classes,
}

/// Over all rows, each tested once.
#[derive(Serialize)]
#[serde(tag = "type", rename = "folds")]
struct Total {
    folds: usize,
    rows: usize,
    test_mse: f64,
    /// Standard deviation between the folds.
    test_mse_deviation: f64,
    test_within_10pct: f64,
    /// Of all rows, about the mean of all.
    test_r2: Option<f64>,
    /// Mean over the rows; absent where there are no classes.
    #[serde(skip_serializing_if = "Option::is_none")]
    test_accuracy: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    test_cross_entropy: Option<f64>,
}

/// Reports each fold and all of them; R2 of all rows, each tested once.
pub(super) fn run(
    args: &TrainArgs,
    config: &FitConfig,
    data: &DataSet,
    folds: usize,
) -> anyhow::Result<Option<f64>> {
    let splits = Split::folds(data, folds, args.split.split_seed)
        .map_err(|error| rows::wrong("--folds", &folds, &error))?;
    let (mut all, mut mse_per_target) = (Vec::new(), Array1::zeros(data.targets.len()));
    for (at, split) in splits.iter().enumerate() {
        let (train, test) = split.of(data)?;
        let (train, validation) = rows::for_training(&train, &args.split)?;
        let fit = super::fit(&train, validation.as_ref(), Some(&test), config)?;
        let Some(tested) = &fit.test else { continue };
        let fold = Fold {
            fold: at + 1,
            folds,
            train_rows: train.rows(),
            test_rows: test.rows(),
            train_mse: fit.train.mse,
            test_mse: tested.mse,
            test_scaled_mse: tested.scaled_mse,
            test_within_10pct: tested.within_fraction(0.1),
            test_r2: tested.r2,
            classes: super::Classes::of(&fit),
        };
        report(args, &fold)?;
        let weight = test.rows() as f64 / data.rows() as f64;
        mse_per_target = mse_per_target + weight * &tested.mse_per_target;
        all.push(fold);
    }
    let r2 = data.classes.is_none().then(|| r_squared(&mse_per_target, data)).flatten();
    if let Some(warning) = no_better_than_the_mean("held-out", r2) {
        output::remark(&data.file, warning);
    }
    report_total(args, &total(&all, r2))?;
    Ok(r2)
}

fn total(all: &[Fold], test_r2: Option<f64>) -> Total {
    let rows: usize = all.iter().map(|fold| fold.test_rows).sum();
    let mean = |of: &dyn Fn(&Fold) -> f64| {
        all.iter().map(|fold| fold.test_rows as f64 * of(fold)).sum::<f64>() / rows as f64
    };
    let mean_known = |of: &dyn Fn(&Fold) -> Option<f64>| {
        all.iter().all(|fold| of(fold).is_some()).then(|| mean(&|fold| of(fold).unwrap_or(0.0)))
    };
    let test_mse = mean(&|fold| fold.test_mse);
    Total {
        folds: all.len(),
        rows,
        test_mse,
        test_mse_deviation: mean(&|fold| (fold.test_mse - test_mse).powi(2)).sqrt(),
        test_within_10pct: mean(&|fold| fold.test_within_10pct),
        test_r2,
        test_accuracy: mean_known(&|fold| fold.classes.test_accuracy),
        test_cross_entropy: mean_known(&|fold| fold.classes.test_cross_entropy),
    }
}

fn report(args: &TrainArgs, fold: &Fold) -> anyhow::Result<()> {
    if args.json {
        return output::json(fold);
    }
    Ok(output::line(&format!(
        "fold {} of {}: {} rows, tested on {}: mse {:.6} (target unit squared), {}",
        fold.fold,
        fold.folds,
        fold.train_rows,
        fold.test_rows,
        fold.test_mse,
        share(fold.classes.test_accuracy, fold.test_within_10pct, fold.test_r2)
    ))?)
}

/// Of classes, those right; of numbers, those near.
fn share(accuracy: Option<f64>, within_10pct: f64, r2: Option<f64>) -> String {
    match accuracy {
        Some(accuracy) => format!("{:.1} % of the classes right", 100.0 * accuracy),
        None => output::share(within_10pct, r2),
    }
}

fn report_total(args: &TrainArgs, total: &Total) -> anyhow::Result<()> {
    if args.json {
        return output::json(total);
    }
    Ok(output::line(&format!(
        "{} folds: {} rows each tested once: mse {:.6} +- {:.6} between folds, {}",
        total.folds,
        total.rows,
        total.test_mse,
        total.test_mse_deviation,
        share(total.test_accuracy, total.test_within_10pct, total.test_r2)
    ))?)
}
