//! What the files of learners beyond one net have in common: format, version, and the columns that scale rows and answers.

use mlp::train::{ColumnSpec, DataSet, FileError, Scaling};
use mlp::train::{file::FileColumn, file::check_head, interval::Interval, scaling::columns};
use mlp::{PredictError, ShapeError};
use ndarray::ArrayRef1;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::score::Predict;
use super::{Gp, Poly, Svr, gp, poly, svr};

/// Value of the field `version` that is read and written.
const VERSION: u64 = 1;

/// Head of a file: its kind, and the columns with their limits over the training rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Columns {
    format: String,
    version: u64,
    /// Features in the order of the training columns.
    pub inputs: Vec<FileColumn>,
    /// Targets.
    pub targets: Vec<FileColumn>,
    /// What its answers may be off by, where rows that were held out have shown it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<Interval>,
}

/// A file of a learner beyond one net.
pub struct Read {
    /// Its columns.
    pub columns: Columns,
    /// What answers.
    pub predict: Box<dyn Predict + Send + Sync>,
}

impl core::fmt::Debug for Read {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Read").field("columns", &self.columns).finish_non_exhaustive()
    }
}

/// Reads a file of support vectors, of a Gaussian process or of a polynomial; none where the text is of another kind.
#[must_use]
pub fn read(text: &str) -> Option<Result<Read, FileError>> {
    fn boxed<T: Predict + Send + Sync + 'static>(read: T, columns: fn(&T) -> &Columns) -> Read {
        Read { columns: columns(&read).clone(), predict: Box::new(read) }
    }
    #[derive(Deserialize)]
    struct Head {
        format: String,
    }
    let head: Head = serde_json::from_str(text).ok()?;
    match head.format.as_str() {
        svr::FORMAT => Some(Svr::from_json(text).map(|svr| boxed(svr, |svr| &svr.columns))),
        gp::FORMAT => Some(Gp::from_json(text).map(|gp| boxed(gp, |gp| &gp.columns))),
        poly::FORMAT => Some(Poly::from_json(text).map(|poly| boxed(poly, |poly| &poly.columns))),
        _ => None,
    }
}

/// The text of a file.
pub(super) fn to_json(file: &impl Serialize) -> Result<String, FileError> {
    Ok(serde_json::to_string_pretty(file)?)
}

/// Reads the text of a file of `format`.
pub(super) fn from_json<T: DeserializeOwned>(text: &str, format: &str) -> Result<T, FileError> {
    check_head(text, format, VERSION)?;
    Ok(serde_json::from_str(text)?)
}

impl Columns {
    pub(super) fn of(format: &str, train: &DataSet) -> Self {
        Self {
            format: format.to_owned(),
            version: VERSION,
            inputs: columns(&train.inputs, &train.input_scalings()),
            targets: columns(&train.targets, &train.target_scalings()),
            interval: None,
        }
    }

    /// The same where reciprocal targets have this noise, a variance in scaled units each: the mean square of what is left of the rows.
    pub(super) fn with_noise(mut self, variances: impl IntoIterator<Item = f64>) -> Self {
        for (target, variance) in self.targets.iter_mut().zip(variances) {
            target.set_noise(variance);
        }
        self
    }

    /// The column specs with which a CSV file is read for it.
    #[must_use]
    pub fn specs(&self) -> (Vec<ColumnSpec>, Vec<ColumnSpec>) {
        let specs = |columns: &[FileColumn]| {
            let spec = |column: &FileColumn| ColumnSpec {
                name: column.name.clone(),
                transform: column.transform,
            };
            columns.iter().map(spec).collect()
        };
        (specs(&self.inputs), specs(&self.targets))
    }

    /// Whether there is something for each target, and each of `instances` has a value for each input.
    pub(super) fn check<'a>(
        &self,
        machines: usize,
        instances: impl IntoIterator<Item = &'a Vec<f64>>,
    ) -> Result<(), FileError> {
        self.interval.as_ref().map_or(Ok(()), |interval| interval.check(&self.targets))?;
        let (needed, given) = (self.targets.len(), machines);
        if needed != given {
            return Err(ShapeError::Outputs { needed, given }.into());
        }
        let needed = self.inputs.len();
        match instances.into_iter().map(Vec::len).find(|given| *given != needed) {
            Some(given) => Err(ShapeError::Inputs { needed, given }.into()),
            None => Ok(()),
        }
    }

    /// Features scaled to -1..1.
    pub(super) fn scaled(&self, inputs: &ArrayRef1<f64>) -> Result<Vec<f64>, PredictError> {
        let (needed, given) = (self.inputs.len(), inputs.len());
        if needed != given {
            return Err(ShapeError::Inputs { needed, given }.into());
        }
        let columns = self.inputs.iter().zip(inputs);
        let scaled: Vec<f64> =
            columns.map(|(column, raw)| Scaling::from(column.column()).scaled(*raw)).collect();
        match scaled.iter().position(|value| !value.is_finite()) {
            Some(column) => Err(PredictError::NotFinite { column }),
            None => Ok(scaled),
        }
    }

    /// The raw answer for each scaled one.
    pub(super) fn answer(
        &self,
        scaled: impl ExactSizeIterator<Item = f64>,
        outputs: &mut [f64],
    ) -> Result<(), PredictError> {
        let (needed, given) = (scaled.len(), outputs.len());
        if needed != given {
            return Err(ShapeError::Outputs { needed, given }.into());
        }
        for (target, ((scaled, column), output)) in
            scaled.zip(&self.targets).zip(outputs).enumerate()
        {
            *output = column.column().raw(scaled);
            if !output.is_finite() {
                return Err(PredictError::Overflow { target });
            }
        }
        Ok(())
    }
}

/// The deviation in raw units of an answer, of one in scaled units.
pub(super) fn raw_deviation(column: &FileColumn, scaled: f64, answer: f64) -> f64 {
    0.5 * scaled * Scaling::from(column.column()).span() / column.transform.slope(answer)
}
