//! `gripctl eval`: a model file of any kind against rows of data.

use super::{
    columns::{self, Columns},
    train::worse_than_mean,
};
use crate::{cli::learn::EvalArgs, output};
use anyhow::Context as _;
use grip_session::{ModelError, exit::Exit, model};
use grip_study::outlook::{Ensemble, Predict, Score, answers, columns as learner, ensemble, score};
use mlp::train::{
    DataSet, FileError, LargeModel, ModelFile, Scaling, evaluate,
    file::FileColumn,
    fit::no_better_than_the_mean,
    interval::{Interval, coverage},
    predict,
};
use ndarray::Array2;
use serde::Serialize;

#[derive(Serialize)]
#[serde(tag = "type", rename = "eval")]
struct Result {
    rows: usize,
    mse: f64,
    scaled_mse: f64,
    within_10pct: f64,
    r2: Option<f64>,
    worse_than_mean: Option<bool>,
    /// Of the interval that the model states, and the share of the rows whose truth it holds; absent where it states none.
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coverage: Option<f64>,
    /// Known of one network only.
    extrapolated: Option<usize>,
    /// Of classes: the share that is right, and the mean of -ln p of the right ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cross_entropy: Option<f64>,
}

pub(crate) fn run(args: &EvalArgs) -> anyhow::Result<Exit> {
    let text = model::read_text(&args.model)?;
    let fault = |fault| ModelError::File { file: args.model.display().to_string(), fault };
    let load = |(inputs, targets)| Columns::of_numbers(inputs, targets).load(&args.data);
    let (result, exit) = match Kind::of(&text) {
        Kind::Learner(read) => {
            let learner::Read { columns, predict } = read.map_err(fault)?;
            let rows = load(columns.specs())?;
            let result = scored(predict.as_ref(), &rows, &columns.targets)?;
            let held =
                |interval| covered(interval, &rows, || Ok(answers(predict.as_ref(), &rows)?));
            (result.with(columns.interval.as_ref().map(held).transpose()?), columns::exit(&rows))
        }
        Kind::Ensemble => {
            let ensemble = Ensemble::from_json(&text).map_err(fault)?;
            let rows = load(ensemble.specs())?;
            let result = scored(&ensemble, &rows, ensemble.targets())?;
            let held = |interval| covered(interval, &rows, || Ok(answers(&ensemble, &rows)?));
            (result.with(ensemble.interval.as_ref().map(held).transpose()?), columns::exit(&rows))
        }
        Kind::Network => {
            let file = ModelFile::from_json(&text).map_err(fault)?;
            let rows = Columns::of(&file).load(&args.data)?;
            let model = file.large_model().map_err(fault)?;
            let result = evaluated(&model, &rows)?;
            let held = |interval| {
                covered(interval, &rows, || Ok(predict(&model, &rows.input_values())?.0))
            };
            (result.with(file.interval.as_ref().map(held).transpose()?), columns::exit(&rows))
        }
    };
    if let Some(warning) = no_better_than_the_mean("given", result.r2) {
        output::remark(args.data.display(), warning);
    }
    report(args, &result)?;
    Ok(exit)
}

/// What a model file holds.
enum Kind {
    Network,
    Ensemble,
    /// Support vectors, a Gaussian process or a polynomial.
    Learner(core::result::Result<learner::Read, FileError>),
}

impl Kind {
    /// By the field `format`; what has none is left to the reader of networks, who states what is wrong with it.
    fn of(text: &str) -> Self {
        #[derive(serde::Deserialize)]
        struct Head {
            format: String,
        }
        if let Some(read) = learner::read(text) {
            return Self::Learner(read);
        }
        match serde_json::from_str::<Head>(text).map(|head| head.format).as_deref() {
            Ok(ensemble::FORMAT) => Self::Ensemble,
            _ => Self::Network,
        }
    }
}

/// Level and coverage of an interval around the answers.
fn covered(
    interval: &Interval,
    data: &DataSet,
    answers: impl Fn() -> anyhow::Result<Array2<f64>>,
) -> anyhow::Result<[f64; 2]> {
    Ok([interval.level, coverage(interval, data, &answers()?)])
}

impl Result {
    fn with(self, held: Option<[f64; 2]>) -> Self {
        let [interval, coverage] = [0, 1].map(|at| held.map(|held| held[at]));
        Self { interval, coverage, ..self }
    }
}

fn evaluated(model: &LargeModel, data: &DataSet) -> anyhow::Result<Result> {
    let evaluation = evaluate(model, data).with_context(|| data.file.clone())?;
    Ok(Result {
        rows: evaluation.rows,
        mse: evaluation.mse,
        scaled_mse: evaluation.scaled_mse,
        within_10pct: evaluation.within_fraction(0.1),
        r2: evaluation.r2,
        worse_than_mean: worse_than_mean([evaluation.r2, None, None], None),
        interval: None,
        coverage: None,
        extrapolated: Some(evaluation.extrapolated),
        accuracy: evaluation.classes.map(|classes| classes.accuracy),
        cross_entropy: evaluation.classes.map(|classes| classes.cross_entropy),
    })
}

fn scored(learner: &dyn Predict, data: &DataSet, targets: &[FileColumn]) -> anyhow::Result<Result> {
    let limits: Vec<Scaling> = targets.iter().map(|target| target.column().into()).collect();
    let Score { rows, mse, scaled_mse, within_10pct, r2 } = score(learner, data, &limits)?;
    Ok(Result {
        rows,
        mse,
        scaled_mse,
        within_10pct,
        r2,
        worse_than_mean: worse_than_mean([r2, None, None], None),
        interval: None,
        coverage: None,
        extrapolated: None,
        accuracy: None,
        cross_entropy: None,
    })
}

fn report(args: &EvalArgs, result: &Result) -> anyhow::Result<()> {
    if args.json {
        return output::json(result);
    }
    let outside = result
        .extrapolated
        .map_or(String::new(), |rows| format!("; {rows} rows outside the training range"));
    if let (Some(accuracy), Some(cross_entropy)) = (result.accuracy, result.cross_entropy) {
        return Ok(output::line(&format!(
            "{} rows: {:.1} % of the classes right, cross-entropy {cross_entropy:.4}, mean squared error of the probabilities {:.6}{outside}",
            result.rows,
            100.0 * accuracy,
            result.mse
        ))?);
    }
    let interval = result.interval.zip(result.coverage).map_or(String::new(), |(level, held)| {
        format!("; the {} % interval holds {:.1} %", 100.0 * level, 100.0 * held)
    });
    Ok(output::line(&format!(
        "{} rows: mean squared error {:.6} (target unit squared), {:.6} (scaled); {}{outside}{interval}",
        result.rows,
        result.mse,
        result.scaled_mse,
        output::share(result.within_10pct, result.r2),
    ))?)
}
