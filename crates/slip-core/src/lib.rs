//! Stylus samples in; slip events, features and grip-force commands out.
//!
//! [`Pipeline`] is the data path. Its parts can be used alone: filters, floor, detector, irregularities,
//! E_sc, estimator and controller. `no_std`, no allocation, no panic; time comes with the samples.
//!
#![doc = include_str!("../README.md")]
#![no_std]

pub mod causes;
pub mod confidence;
pub mod config;
pub mod course;
pub mod crosscheck;
pub mod detector;
pub mod distance;
pub mod drift;
mod error;
pub mod esc;
pub mod estimate;
pub mod event;
pub mod features;
pub mod filter;
pub mod floor;
pub mod fusion;
pub mod grip;
pub mod health;
pub mod irregularity;
pub mod methods;
pub mod need;
pub mod observation;
pub mod pipeline;
pub mod pressure;
mod resolution;
pub mod sample;
pub mod scene;
mod sink;
pub mod stages;
mod travel_noise;
pub mod turns;
pub mod velocity;

pub use causes::{Cause, CauseSet, Causes};
pub use config::PipelineConfig;
pub use error::ConfigError;
pub use event::Step;
pub use pipeline::Pipeline;
pub use sample::{Arrival, Sample, Signal};
pub use slip_msg::{ClientCommand, Phase, PipelineState, SlipReport, units};
