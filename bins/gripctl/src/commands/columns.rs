//! Rows for a learner, from a file and the names of its columns.

use super::read;
use crate::{cli::learn::ColumnArgs, output};
use grip_record::{Npz, NpzError, is_npz};
use grip_session::exit::{Exit, WrongArgument};
use mlp::train::{Classes, ColumnSpec, DataSet, ModelFile};
use ndarray::Array2;
use std::path::Path;

/// How a command ends that has used `rows`: with loss of data where a file of them was cut off.
pub(crate) fn exit(rows: &DataSet) -> Exit {
    let is_lost = rows.left_out.iter().any(|loss| loss.is_data());
    if is_lost { Exit::DataLost } else { Exit::Done }
}

/// The columns asked for.
pub(crate) struct Columns {
    inputs: Vec<ColumnSpec>,
    target: Target,
}

/// What is learned of a row.
enum Target {
    Numbers(Vec<ColumnSpec>),
    Class(Classes),
}

impl Columns {
    pub(crate) fn new(args: &ColumnArgs) -> anyhow::Result<Self> {
        let inputs = specs(&args.inputs)?;
        let target = match &args.target[..] {
            [column] if args.classify => {
                Target::Class(Classes { column: column.clone(), names: Vec::new() })
            }
            _ if args.classify => {
                let message = "--classify: expected one column in --target, that of the class";
                return Err(WrongArgument(message.to_owned()).into());
            }
            numbers => Target::Numbers(specs(numbers)?),
        };
        Ok(Self { inputs, target })
    }

    /// Those of `model`.
    pub(crate) fn of(model: &ModelFile) -> Self {
        let (inputs, targets) = model.specs();
        let target = match &model.classes {
            None => Target::Numbers(targets),
            Some(column) => {
                let names = targets.into_iter().map(|target| target.name).collect();
                Target::Class(Classes { column: column.clone(), names })
            }
        };
        Self { inputs, target }
    }

    /// Numbers to be learned from numbers.
    pub(crate) fn of_numbers(inputs: Vec<ColumnSpec>, targets: Vec<ColumnSpec>) -> Self {
        Self { inputs, target: Target::Numbers(targets) }
    }

    /// The same, with the classes of the rows in `train`.
    pub(crate) fn with_classes_of(self, train: &DataSet) -> Self {
        let Target::Class(classes) = self.target else { return self };
        let names = train.targets.iter().map(|class| class.name.clone()).collect();
        Self { target: Target::Class(Classes { names, ..classes }), ..self }
    }

    pub(crate) fn load(&self, file: &Path) -> anyhow::Result<DataSet> {
        self.load_grouped(file, None)
    }

    /// With the labels of the column `group`, if there is one.
    pub(crate) fn load_grouped(&self, file: &Path, group: Option<&str>) -> anyhow::Result<DataSet> {
        let (name, bytes) = (file.display().to_string(), read(file)?);
        if is_npz(file) {
            return self.load_npz(file, &name, bytes, group);
        }
        let inputs = &self.inputs[..];
        let rows = match &self.target {
            Target::Class(classes) => {
                DataSet::from_class_csv(&name, &bytes, inputs, classes, group)?
            }
            Target::Numbers(targets) => {
                DataSet::from_grouped_csv(&name, &bytes, inputs, targets, group)?
            }
        };
        for loss in &rows.left_out {
            output::remark(&name, loss);
        }
        Ok(rows)
    }

    /// An array for each column.
    fn load_npz(
        &self,
        file: &Path,
        name: &str,
        bytes: Vec<u8>,
        group: Option<&str>,
    ) -> anyhow::Result<DataSet> {
        let hash = mlp::train::sha256(&bytes);
        let mut npz = Npz::parse(file, bytes)?;
        let labels = group.map(|group| npz.texts(group)).transpose()?;
        let inputs = matrix(&mut npz, &self.inputs)?;
        let mut rows = match &self.target {
            Target::Class(classes) => {
                let texts = npz.texts(&classes.column)?;
                DataSet::from_classes(name, &self.inputs, inputs, classes, &texts)?
            }
            Target::Numbers(targets) => {
                let values = matrix(&mut npz, targets)?;
                DataSet::from_values(name, &self.inputs, targets, inputs, values)?
            }
        };
        if let Some(labels) = labels {
            rows = rows.with_labels(labels)?;
        }
        rows.sha256 = hash;
        Ok(rows)
    }
}

/// The named columns side by side.
fn matrix(npz: &mut Npz, specs: &[ColumnSpec]) -> Result<Array2<f64>, NpzError> {
    let columns =
        specs.iter().map(|spec| npz.numbers(&spec.name)).collect::<Result<Vec<_>, _>>()?;
    let mut values = Array2::zeros((npz.rows(), columns.len()));
    for (mut place, column) in values.columns_mut().into_iter().zip(&columns) {
        place.assign(column);
    }
    Ok(values)
}

fn specs(names: &[String]) -> anyhow::Result<Vec<ColumnSpec>> {
    names
        .iter()
        .map(|name| name.parse().map_err(|error| WrongArgument(format!("{error}")).into()))
        .collect()
}
