//! NumPy arrays in; slip events, statistics, E_sc, force commands and simulated grasps out. Glue alone: every algorithm stands in the
//! crates below. Names, shapes and units are those of `python/slipgrip/_core.pyi`.
#![cfg_attr(
    not(doc),
    expect(clippy::needless_pass_by_value, reason = "pyo3 hands arguments over by value")
)]

mod calibrate;
mod input;
mod learn;
mod output;
mod recording;
mod settings;
mod simulate;
mod stream;
mod surface;

/// What `import slipgrip` shows.
#[pyo3::pymodule(name = "_core")]
mod module {
    #[pymodule_export]
    use crate::{
        calibrate::{Calibration, calibrate},
        learn::{Model, train},
        recording::{Recording, read, replay},
        simulate::Grasp,
        stream::{Detection, Detector, Pipeline, detect},
        surface::{Profile, esc, profile},
    };
}
