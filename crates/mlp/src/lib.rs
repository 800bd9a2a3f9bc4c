//! Small feed-forward networks for the estimation of grip forces: [`mlp_core`] (inference, model file), which stands here again under
//! this name, and what makes its models.
//!
//! | module | job |
//! |---|---|
//! | [`train`] | data sets, full-batch trainers, runs, metrics |
//! | `export` (feature) | a model as C source, as ONNX and as a model card |
//!
#![doc = include_str!("../README.md")]

#[cfg(feature = "export")]
pub mod export;
pub mod train;

pub use mlp_core::*;
