//! Slip events, features and grip-force commands from stylus samples.
//!
//! [`Pipeline`] is the data path. Its parts can be used alone: filters, floor, detector, irregularities,
//! E_sc, estimator and controller. `no_std`, no allocation, no panic; time comes with the samples.
//!
#![doc = include_str!("../README.md")]
#![no_std]

pub mod alarm;
pub mod config;
pub mod course;
pub mod crosscheck;
pub mod detector;
pub mod distance;
pub mod drift;
pub mod drive;
mod error;
pub mod esc;
pub mod estimate;
pub mod filter;
pub mod floor;
pub mod freshness;
pub mod fusion;
pub mod grip;
pub mod health;
pub mod irregularity;
pub mod isolated;
pub mod load;
pub mod need;
mod needed;
pub mod observation;
pub mod pipeline;
pub mod pressure;
pub mod sample;
mod settings;
mod turns;
pub mod velocity;

pub use alarm::{Cause, CauseSet, Causes};
pub use config::PipelineConfig;
pub use error::ConfigError;
pub use needed::NeededForce;
pub use pipeline::{Pipeline, StageCounters, Step};
pub use sample::{Arrival, Sample, Signal};
pub use slip_msg::{ClientCommand, Phase, PipelineState, SlipReport, named, units};
