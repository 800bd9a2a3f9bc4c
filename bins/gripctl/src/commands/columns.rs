//! Names of columns and a file in, rows for a learner out.

use super::read;
use crate::cli::learn::ColumnArgs;
use grip_host::exit::WrongArgument;
use mlp::train::{ColumnSpec, DataSet};
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
        let (name, columns) = (file.display().to_string(), (&self.inputs[..], &self.targets[..]));
        Ok(DataSet::from_grouped_csv(&name, &read(file)?, columns, group)?)
    }
}

fn specs(names: &[String]) -> anyhow::Result<Vec<ColumnSpec>> {
    names
        .iter()
        .map(|name| name.parse().map_err(|error| WrongArgument(format!("{error}")).into()))
        .collect()
}
