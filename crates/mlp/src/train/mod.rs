//! CSV rows in, a trained model file out: data sets, trainers, runs, metrics and the model file.
//!
//! ```text
//! CSV bytes -> DataSet -> Patterns (scaled) -> NetworkObjective -> Trainer steps -> Run -> ModelFile -> Model
//! ```
//! Everything is sans-IO: bytes come as arguments, nothing reads a clock, randomness comes from seeds.
//! Training runs in `f64` or `f32` on the machine's vectors; saved weights are `f32`, and reported errors are those
//! of the saved model.

mod aligned;
pub mod column;
mod csv_file;
pub mod data;
pub mod ensemble_file;
pub mod file;
pub mod fit;
pub mod init;
pub mod lanes;
mod linear;
pub mod metrics;
pub mod objective;
pub mod real;
pub mod run;
pub mod scaling;
pub mod setting;
pub mod split;
pub mod topology;
pub mod trainer;
mod vector;

pub use column::{ColumnSpec, ColumnSpecError};
pub use data::{DataSet, DataSetError, Patterns};
pub use ensemble_file::EnsembleFile;
pub use file::{FileError, ModelFile};
pub use fit::{Choice, Fit, FitConfig, FitError, Fitting, Precision, fit};
pub use lanes::Isa;
pub use metrics::{EvaluateError, Evaluation, evaluate};
pub use objective::{NetworkObjective, Objective};
pub use real::Real;
pub use run::{Run, RunConfig, Stop, Training, run};
pub use scaling::{Method, Scaling};
pub use setting::SettingError;
pub use split::{Split, SplitError};
pub use topology::Topology;
pub use trainer::{Algorithm, Finish, StepReport, Trainer};

/// Nearest `f32`; what is too large becomes infinite and is caught where finite values are required.
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the precision of the model is meant"
)]
pub(crate) fn rounded(value: f64) -> f32 {
    value as f32
}
