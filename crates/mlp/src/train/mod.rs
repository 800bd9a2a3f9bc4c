//! Training from rows to a model file: data sets, trainers, runs, metrics and the model file.
//!
//! ```text
//! CSV bytes or arrays -> DataSet -> scaled arrays -> NetworkObjective -> Trainer steps -> Run -> ModelFile -> Model
//! ```
//! Everything is sans-IO: bytes come as arguments, nothing reads a clock, randomness comes from seeds.
//! Training runs in `f64` or `f32` on the machine's vectors; saved weights are `f32`, and reported errors are those
//! of the saved model.
//!
//! Rows are [`ndarray`] arrays, rows x columns, of any memory layout:
//!
//! ```
//! use mlp::train::{Algorithm, ColumnSpec, DataSet, FitConfig, fit, predict};
//! use ndarray::{Array2, Axis, arr2};
//!
//! // Speed (m/s), mass (kg) and force (N) of 64 grasps.
//! let grasps = Array2::from_shape_fn((64, 3), |(row, column)| {
//!     let (v, m) = (0.01 + 0.03 * (row / 8) as f64, 0.2 * 1.22_f64.powi((row % 8) as i32));
//!     [v, m, m * (11.8 + 38.6 * v)][column]
//! });
//! let (features, force) = grasps.view().split_at(Axis(1), 2);
//!
//! let inputs: [ColumnSpec; 2] = ["v_m_s".parse()?, "m_kg:ln".parse()?];
//! let targets: [ColumnSpec; 1] = ["f_n:ln".parse()?];
//! let rows = DataSet::from_values("grasps", &inputs, &targets, features.to_owned(), force.to_owned())?;
//! let config = FitConfig { algorithm: Algorithm::Lm(Default::default()), ..FitConfig::default() };
//! let fit = fit(&rows, None, None, &config)?;
//! assert!(fit.train.within_fraction(0.01) > 0.99);
//!
//! let (forces, _) = predict(&*fit.model, &arr2(&[[0.05, 0.3], [0.1, 0.5]]))?;
//! assert!((forces[[0, 0]] - 4.1).abs() < 0.1 && forces.dim() == (2, 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod aligned;
pub mod data;
mod data_error;
pub mod fit;
pub mod init;
pub mod interval;
pub mod lanes;
pub mod linear;
pub mod metrics;
pub mod objective;
pub mod run;
pub mod scaling;
pub mod setting;
pub mod split;
pub mod trainer;
mod vector;

pub use mlp_core::{column, ensemble_file, file, topology};

pub use column::{ColumnSpec, ColumnSpecError};
pub use data::{Classes, DataSet, DataSetError, sha256};
pub use ensemble_file::EnsembleFile;
pub use file::{FileError, LargeModel, ModelFile};
pub use fit::{Choice, Fit, FitConfig, FitError, Fitting, Precision, fit};
pub use interval::Interval;
pub use lanes::{Isa, Real};
pub use metrics::{Classified, EvaluateError, Evaluation, evaluate, predict};
pub use objective::{NetworkObjective, Objective};
pub use run::{Run, RunConfig, Stop, Training, run};
pub use scaling::{Method, Scaling};
pub use setting::SettingError;
pub use split::{Split, SplitError};
pub use topology::Topology;
pub use trainer::{Algorithm, Finish, Hyper, StepReport, Trainer};

pub(crate) use file::rounded;
