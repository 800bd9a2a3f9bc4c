//! Names of columns and a file in, rows for a learner out.

use super::read;
use crate::cli::learn::ColumnArgs;
use grip_record::{Npz, NpzError, is_npz};
use grip_session::exit::WrongArgument;
use mlp::train::{ColumnSpec, DataSet};
use ndarray::Array2;
use std::path::Path;

/// The columns asked for.
pub(crate) struct Columns {
    inputs: Vec<ColumnSpec>,
    targets: Vec<ColumnSpec>,
}

impl Columns {
    pub(crate) fn new(args: &ColumnArgs) -> anyhow::Result<Self> {
        Ok(Self { inputs: specs(&args.inputs)?, targets: specs(&args.target)? })
    }

    pub(crate) fn load(&self, file: &Path) -> anyhow::Result<DataSet> {
        self.load_grouped(file, None)
    }

    /// With the labels of the column `group`, if there is one.
    pub(crate) fn load_grouped(&self, file: &Path, group: Option<&str>) -> anyhow::Result<DataSet> {
        load(file, (&self.inputs, &self.targets), group)
    }
}

/// The rows of a CSV file, or of an `.npz` with an array for each column, with the labels of the column `group`.
pub(super) fn load(
    file: &Path,
    columns: (&[ColumnSpec], &[ColumnSpec]),
    group: Option<&str>,
) -> anyhow::Result<DataSet> {
    let (name, bytes) = (file.display().to_string(), read(file)?);
    if !is_npz(file) {
        return Ok(DataSet::from_grouped_csv(&name, &bytes, columns, group)?);
    }
    let hash = mlp::train::sha256(&bytes);
    let mut npz = Npz::parse(file, bytes)?;
    let labels = group.map(|group| npz.texts(group)).transpose()?;
    let values = (matrix(&mut npz, columns.0)?, matrix(&mut npz, columns.1)?);
    let mut rows = DataSet::from_values(&name, columns.0, columns.1, values)?;
    if let Some(labels) = labels {
        rows = rows.with_labels(labels)?;
    }
    rows.sha256 = hash;
    Ok(rows)
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
