//! Nothing in; the scaled rows of a hundred simulated trial grasps and a network to train on them out.

use grip_sim::{GeneratorConfig, GeneratorError, generator};
use mlp::{
    ShapeError,
    train::{ColumnSpec, ColumnSpecError, DataSet, DataSetError, NetworkObjective, Topology},
};

/// Rows of the data set; two inputs, one target.
pub const ROWS: u32 = 100;

const INPUTS: [&str; 2] = ["slip_acceleration_m_s2", "trial_force_n:ln"];
const TARGET: [&str; 1] = ["adequate_force_n:ln"];

/// Why there is nothing to train on.
#[derive(Debug, thiserror::Error)]
pub enum TrainingError {
    /// No rows were generated.
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    /// A column has no possible name.
    #[error(transparent)]
    Column(#[from] ColumnSpecError),
    /// The rows are refused.
    #[error(transparent)]
    Data(#[from] DataSetError),
    /// Rows and network do not fit.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}

/// The objective of a 2-10-1 network over [`ROWS`] rows.
///
/// # Errors
/// Never, as long as the generator and its columns stay.
pub fn objective() -> Result<NetworkObjective, TrainingError> {
    let mut csv = format!("{}\n", generator::CSV_HEADER);
    for row in grip_sim::rows(GeneratorConfig::default(), 5, ROWS)? {
        csv.push_str(&row.csv());
        csv.push('\n');
    }
    let data = DataSet::from_csv("generated", csv.as_bytes(), &specs(&INPUTS)?, &specs(&TARGET)?)?;
    let patterns = data.patterns(&data.input_scalings(), &data.target_scalings());
    Ok(NetworkObjective::new(&Topology::regression(2, &[10], 1)?, &patterns)?)
}

fn specs(texts: &[&str]) -> Result<Vec<ColumnSpec>, ColumnSpecError> {
    texts.iter().map(|text| text.parse()).collect()
}
