//! Python bindings on NumPy arrays: slip events, statistics, E_sc, force commands and simulated grasps. Glue alone: every algorithm stands in the
//! crates below. Names, shapes and units are those of `python/slipgrip/_core.pyi`.

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
        stream::{Detection, Detector, Pipeline, detect, trace},
        surface::{Profile, esc, profile},
    };
}
