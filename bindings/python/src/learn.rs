//! Training of a network with rows and targets.

use crate::{
    input::{Names, Number, numbers, refused, shape, unreadable, unwritable},
    output::dictionary,
};
use grip_record::files;
use grip_session::{HostEstimator, model};
use mlp::export::{c, onnx};
use mlp::train::{
    ColumnSpec, DataSet, FitConfig, ModelFile, RunConfig, Split, fit,
    interval::{HeldOut, Interval},
};
use ndarray::Array2;
use numpy::{IntoPyArray as _, PyUntypedArrayMethods as _};
use pyo3::{prelude::*, types::PyDict};
use serde_json::json;
use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
};

/// More repeats than anybody waits for.
const MOST_REPEATS: usize = 10_000;

/// A network with the limits of its columns; its file is that of `gripctl train`.
#[pyclass(frozen, module = "slipgrip")]
pub(crate) struct Model {
    file: ModelFile,
    text: String,
    report: serde_json::Value,
}

impl Model {
    pub(crate) fn estimator(&self) -> PyResult<HostEstimator> {
        model::parse_estimator("model", &self.text).map_err(refused)
    }
}

#[pymethods]
impl Model {
    /// From a file, or the built-in "default" or "paper".
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let text = match model::built_in(&path) {
            Some(text) => text.to_owned(),
            None => files::read_text(&path, files::MOST_MODEL)
                .map_err(|error| unreadable(&path, &error))?,
        };
        let file = ModelFile::from_json(&text);
        let file = file.map_err(|error| refused(format!("{}: {error}", path.display())))?;
        Ok(Self { file, text, report: json!({}) })
    }

    /// Writes the file that --model of gripd and gripctl reads (.json).
    fn save(&self, path: PathBuf) -> PyResult<()> {
        std::fs::write(&path, &self.text).map_err(|error| unwritable(&path, &error))
    }

    /// Writes it as C source and its header beside (.c, .h) or as an ONNX graph (.onnx), as `gripctl export`; what is there is replaced.
    fn export(&self, path: PathBuf) -> PyResult<()> {
        let write = |path: &Path, bytes: &[u8]| {
            std::fs::write(path, bytes).map_err(|error| unwritable(path, &error))
        };
        let named = |error| refused(format!("{}: {error}", path.display()));
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        match path.extension().and_then(OsStr::to_str) {
            Some("c") => {
                let header = path.with_extension("h");
                let include = format!("{stem}.h");
                let code = c::source(&self.file, &c::prefix_of(&stem), &include, &stem);
                let code = code.map_err(|error| named(error.to_string()))?;
                write(&path, code.source.as_bytes())?;
                write(&header, code.header.as_bytes())
            }
            Some("onnx") => {
                let bytes = onnx::bytes(&self.file, &stem);
                write(&path, &bytes.map_err(|error| named(error.to_string()))?)
            }
            _ => Err(named("a model is exported as .c or .onnx".to_owned())),
        }
    }

    fn __repr__(&self) -> String {
        let interval =
            self.interval().map_or_else(String::new, |level| format!(", interval={level}"));
        format!("Model({:?} -> {:?}{interval})", self.inputs(), self.targets())
    }

    /// Targets for features of shape (rows, inputs): float64 of shape (rows, targets), in the units of the training.
    ///
    /// interval: (targets, low, high) instead, with the limits of the interval that the model states.
    #[pyo3(signature = (x, *, interval=false))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        interval: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = matrix::<f64>("x", x, Some(self.file.inputs.len()))?;
        let model = self.file.model().map_err(refused)?;
        let predicted = py.detach(|| mlp::train::predict(&model, &rows)).map_err(refused)?.0;
        if !interval {
            return Ok(predicted.into_pyarray(py).into_any());
        }
        let stated = self.file.interval.as_ref();
        let stated =
            stated.ok_or_else(|| refused("the model states no interval: train it with one"))?;
        let [mut low, mut high] = [0, 1].map(|_| Array2::zeros(predicted.dim()));
        let columns = self.file.targets.iter().zip(&stated.widths).enumerate();
        for (at, (target, &width)) in columns {
            for (row, &answer) in predicted.column(at).iter().enumerate() {
                [low[[row, at]], high[[row, at]]] =
                    Interval::around(target.transform, width, answer);
            }
        }
        let [predicted, low, high] = [predicted, low, high].map(|values| values.into_pyarray(py));
        Ok((predicted, low, high).into_pyobject(py)?.into_any())
    }

    /// The share of the truths that the limits of `predict(x, interval=True)` hold; None where the model states none.
    #[getter]
    fn interval(&self) -> Option<f64> {
        self.file.interval.as_ref().map(|interval| interval.level)
    }

    /// The names of the features, in order.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.file.inputs.iter().map(|column| column.name.clone()).collect()
    }

    /// The names of the targets, in order.
    #[getter]
    fn targets(&self) -> Vec<String> {
        self.file.targets.iter().map(|column| column.name.clone()).collect()
    }

    /// How the training went: epochs, stop, train_mse, train_within_10pct, train_r2, history, warnings; empty after `load`.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        dictionary(py, &self.report)
    }
}

/// Rows x columns; a vector is one column.
fn matrix<T: Number + Clone>(
    what: &str,
    data: &Bound<'_, PyAny>,
    columns: Option<usize>,
) -> PyResult<Array2<T>> {
    let array = numbers::<T>(what, data)?;
    let dim = match *array.shape() {
        [rows] if columns.is_none_or(|columns| columns == 1) => (rows, 1),
        [rows, width] if columns.is_none_or(|columns| columns == width) => (rows, width),
        ref other => {
            let wanted = columns.map_or("(rows, columns)".to_owned(), |n| format!("(rows, {n})"));
            return Err(shape(what, &wanted, other));
        }
    };
    Array2::from_shape_vec(dim, array.as_slice().map_err(refused)?.to_vec()).map_err(refused)
}

/// Names of columns, `given` or numbered.
fn specs(given: Option<Names>, letter: &str, width: usize) -> PyResult<Vec<ColumnSpec>> {
    let names = given
        .map_or_else(|| (0..width).map(|at| format!("{letter}{at}")).collect(), |names| names.0);
    names.iter().map(|name| name.parse::<ColumnSpec>().map_err(refused)).collect()
}

/// Trains a network on features x, (rows, inputs), and targets y, (rows, targets) or (rows,).
///
/// inputs, targets: names of the columns; `name:ln` takes the logarithm, `name:reciprocal` the reciprocal. A model that gripd uses has
/// features of a slip as inputs, and one target in N named so: `adequate_force_n`. validation: (x, y) whose error ends the training.
/// algorithm: gd, gdm, gdx, rprop, scg, lbfgs, lm or br; activation: tanh, logistic or relu. interval: 0.9 makes the model state limits
/// that hold 90 % of the truths, from ten trainings that each leave out a tenth of the rows.
#[pyfunction]
#[pyo3(signature = (
    x, y, *, inputs=None, targets=None, validation=None, hidden=vec![10], activation="tanh", algorithm="rprop",
    epochs=1000, goal=0.0, seed=0, repeats=1, decay=0.0, interval=None
))]
pub(crate) fn train(
    py: Python<'_>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    inputs: Option<Names>,
    targets: Option<Names>,
    validation: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
    hidden: Vec<usize>,
    activation: &str,
    algorithm: &str,
    epochs: usize,
    goal: f64,
    seed: u64,
    repeats: usize,
    decay: f64,
    interval: Option<f64>,
) -> PyResult<Model> {
    let algorithm: mlp::train::Algorithm =
        algorithm.parse().map_err(|error| refused(format!("algorithm {algorithm:?}: {error}")))?;
    let activation: mlp::Activation = activation
        .parse()
        .map_err(|error| refused(format!("activation {activation:?}: {error}")))?;
    if repeats > MOST_REPEATS {
        return Err(refused(format!("repeats = {repeats}: at most {MOST_REPEATS}")));
    }
    let config = FitConfig {
        hidden,
        activation,
        algorithm,
        run: RunConfig {
            epochs,
            goal,
            min_gradient: algorithm.min_gradient(),
            ..RunConfig::default()
        },
        seed,
        repeats,
        decay,
        ..FitConfig::default()
    };
    let (x, y) = (matrix::<f64>("x", x, None)?, matrix::<f64>("y", y, None)?);
    let inputs = specs(inputs, "x", x.ncols())?;
    let targets = specs(targets, "y", y.ncols())?;
    let rows = DataSet::from_values("x and y", &inputs, &targets, x, y).map_err(refused)?;
    let validation = validation
        .map(|(x, y)| {
            let (x, y) = (matrix("validation x", &x, None)?, matrix("validation y", &y, None)?);
            DataSet::from_values("validation", &inputs, &targets, x, y).map_err(refused)
        })
        .transpose()?;
    let mut trained =
        py.detach(|| fit(&rows, validation.as_ref(), None, &config)).map_err(refused)?;
    if let Some(level) = interval {
        let held = HeldOut::new(&rows, level, seed).map_err(refused)?;
        let answers = |split: &Split| -> PyResult<Array2<f64>> {
            let (train, rest) = split.of(&rows).map_err(refused)?;
            let part = fit(&train, validation.as_ref(), None, &config).map_err(refused)?;
            Ok(mlp::train::predict(&part.model, &rest.input_values()).map_err(refused)?.0)
        };
        let answers =
            py.detach(|| held.splits().iter().map(answers).collect::<PyResult<Vec<_>>>())?;
        trained.file.interval = Some(held.shown(&answers).map_err(refused)?.interval);
    }
    let fit = trained;
    let run = fit.runs.get(fit.chosen).ok_or_else(|| refused("no run was chosen"))?;
    let report = json!({
        "epochs": run.epochs,
        "stop": run.stop.to_string(),
        "train_mse": fit.train.mse,
        "train_within_10pct": fit.train.within_fraction(0.1),
        "train_r2": fit.train.r2,
        "warnings": fit.warnings,
        "history": run.history,
        "validation": run.validation,
    });
    let text = fit.file.to_json().map_err(refused)?;
    Ok(Model { file: fit.file, text, report })
}
