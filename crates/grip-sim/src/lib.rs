//! Simulator of grasps, driven by a scene and force targets: noisy sensor samples, and the truth behind them.
//!
//! Everything is seeded: the same scene, seed and targets give the same samples bit for bit on one machine.
//! Time advances only when asked ([`Grasp::step_sample`]); no part reads a clock.

pub mod actuator;
pub mod disturbance;
pub mod friction;
pub mod generator;
pub mod grasp;
pub mod mcu;
pub mod port;
pub mod pty;
mod random;
pub mod scene;
pub mod shape;
pub mod stylus;
pub mod surface;
mod vibration;

pub use generator::{GeneratorConfig, GeneratorError, Row, rows};
pub use grasp::{Clairvoyant, Grasp, Phase, Truth, perfect_controller_can_hold};
pub use mcu::VirtualMcu;
pub use pty::Pty;
pub use scene::{Scene, SceneConfig, SceneError};

/// Standard acceleration of gravity (m/s^2) (ISO 80000-3).
pub const GRAVITY_M_S2: f64 = 9.80665;
