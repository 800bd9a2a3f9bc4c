//! Estimator of the grip force from raw features of a slip.
//!
//! Small feed-forward networks of 32-bit floats. The crate is `no_std`, allocates
//! nothing and never panics, so that the same [`Model`] runs in the daemon and on a microcontroller:
//!
//! | type | job |
//! |---|---|
//! | [`Model`] | raw features to raw targets, reports when it has to extrapolate |
//! | [`Scaler`] | raw values to `[-1, 1]` and back |
//! | [`Network`] | forward pass for any number of hidden layers, weights in one flat slice |
//!
//! [`Network`] also computes with an exact tanh and in double precision ([`tanh`] has the errors).
//!
//! With the feature `file` (std) the modules [`mod@file`] and [`ensemble_file`] read and write model files. Trainers are in the crate
//! `mlp`, which exports all of this again.
//!
#![doc = include_str!("../README.md")]
#![cfg_attr(not(any(test, feature = "file")), no_std)]

pub mod activation;
#[cfg(feature = "file")]
pub mod column;
#[cfg(feature = "file")]
pub mod ensemble_file;
#[cfg(feature = "file")]
pub mod file;
#[cfg(feature = "file")]
pub mod interval;
pub mod model;
pub mod named;
pub mod network;
pub mod tanh;
#[cfg(feature = "file")]
pub mod topology;

pub use activation::Activation;
pub use model::{
    Column, Coverage, Estimate, MAX_IO, Model, PredictError, ScaleError, Scaler, Transform,
};
pub use network::{MAX_LAYERS, MAX_WIDTH, Network, ShapeError, weight_count};
