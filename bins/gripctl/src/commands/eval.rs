//! `gripctl eval`: a model file against rows of data.

use super::{model_file, read};
use crate::{cli::EvalArgs, output};
use anyhow::Context as _;
use grip_host::{ModelError, exit::Exit};
use mlp::train::{DataSet, evaluate};
use serde::Serialize;

#[derive(Serialize)]
#[serde(tag = "type", rename = "eval")]
struct Result {
    rows: usize,
    mse: f64,
    scaled_mse: f64,
    within_10pct: f64,
    extrapolated: usize,
}

pub(crate) fn run(args: &EvalArgs) -> anyhow::Result<Exit> {
    let (file, _) = model_file(&args.model)?;
    let model = file.model().map_err(|fault| {
        let file = args.model.display().to_string();
        ModelError::File { file, fault }
    })?;
    let (inputs, targets) = file.specs();
    let data_name = args.data.display().to_string();
    let data = DataSet::from_csv(&data_name, &read(&args.data)?, &inputs, &targets)?;
    let evaluation = evaluate(&model, &data).context(data_name)?;
    let result = Result {
        rows: evaluation.rows,
        mse: evaluation.mse,
        scaled_mse: evaluation.scaled_mse,
        within_10pct: evaluation.within_fraction(0.1),
        extrapolated: evaluation.extrapolated,
    };
    if args.json {
        output::json(&result)?;
    } else {
        output::line(&format!(
            "{} rows: mean squared error {:.6} (target unit squared), {:.6} (scaled); within 10 % of the target: {:.1} %; {} rows outside the training range",
            result.rows,
            result.mse,
            result.scaled_mse,
            100.0 * result.within_10pct,
            result.extrapolated
        ))?;
    }
    Ok(Exit::Done)
}
