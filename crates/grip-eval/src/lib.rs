//! What judges a gripper and prepares it, never beside one: scores of labelled recordings, simulated grasps of gripd and of older
//! laws, calibration and its certificate, training rows, accuracy of models, profiles and readings of E_sc.

pub mod accuracy;
pub mod calibrate;
pub mod certify;
pub mod collect;
mod dice;
pub mod esc;
pub mod grasp;
pub mod poisson;
pub mod profile;
pub mod roughness;
pub mod score;
mod taxels;

pub use grasp::trial;
