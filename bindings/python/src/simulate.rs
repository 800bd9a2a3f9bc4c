//! Simulated grasp, of a scene and force targets: sensor rows and the truth, the base of `slipgrip.GraspEnv`.

use crate::input::{positive, refused};
use grip_record::{Channel, ChannelSet, StylusKind};
use grip_sim::{Scene, SceneConfig};
use numpy::{IntoPyArray as _, PyArray2, PyArrayMethods as _};
use pyo3::{prelude::*, types::PyDict};
use slip_core::Sample;

/// Longest step (rows): ten seconds at the highest rate.
const MOST_ROWS: usize = 200_000;

/// A simulated grasp, for loops of one's own; `GraspEnv` is the same as an environment.
///
/// scene: a built-in scene, a file ending in .toml, or the text of one; seed: draws the object.
#[pyclass(module = "slipgrip")]
pub(crate) struct Grasp {
    scene: Scene,
    grasp: grip_sim::Grasp,
    channels: ChannelSet,
}

impl Grasp {
    fn row(&self, sample: &Sample, rows: &mut Vec<f32>) {
        rows.push(sample.stylus);
        let optional = self.channels.optional.keys();
        rows.extend(optional.map(|channel| channel.reading(sample).unwrap_or(f32::NAN)));
    }
}

#[pymethods]
impl Grasp {
    #[new]
    #[pyo3(signature = (scene="default", seed=None))]
    fn new(scene: &str, seed: Option<u64>) -> PyResult<Self> {
        let scene = if scene.contains('=') {
            SceneConfig::from_toml(scene).and_then(Scene::new).map_err(refused)?
        } else {
            grip_sim::scene::open(scene).map_err(refused)?
        };
        let scene = seed.map_or(Ok(scene.clone()), |seed| scene.reseeded(seed)).map_err(refused)?;
        let mut grasp = grip_sim::Grasp::new(&scene);
        let vibration = scene.config().vibration.is_some();
        let kind = if vibration { StylusKind::Vibration } else { StylusKind::Displacement };
        // Which channels there are shows the first sample; the object itself begins anew.
        let first = grasp.step_sample(0.0);
        let present = Channel::ALL.into_iter().filter(|channel| channel.reading(&first).is_some());
        let channels = present.fold(ChannelSet::new(kind), ChannelSet::with);
        grasp = grip_sim::Grasp::new(&scene);
        Ok(Self { scene, grasp, channels })
    }

    /// Aims at a force (N) for so many rows and gives them, float32 of shape (rows, channels).
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        force_n: f64,
        rows: usize,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let force_n = positive("force_n", force_n, true)?;
        if !(1..=MOST_ROWS).contains(&rows) {
            return Err(refused(format!("rows = {rows}: 1 to {MOST_ROWS} are possible")));
        }
        let width = 1 + self.channels.optional.len();
        let values = py.detach(|| {
            let mut values = Vec::with_capacity(rows * width);
            for _ in 0..rows {
                let sample = self.grasp.step_sample(force_n);
                self.row(&sample, &mut values);
            }
            values
        });
        values.into_pyarray(py).reshape([rows, width])
    }

    /// Takes the support away now.
    fn lift(&mut self) {
        self.grasp.lift();
    }

    /// What no sensor knows, at the last row.
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let truth = self.grasp.truth();
        let dict = PyDict::new(py);
        dict.set_item("time_s", truth.time_s)?;
        dict.set_item("needed_n", truth.needed_now_n)?;
        dict.set_item("needed_max_n", truth.force_needed_n)?;
        dict.set_item("crush_n", self.scene.object().crush_n)?;
        dict.set_item("applied_n", truth.applied_n)?;
        dict.set_item("peak_n", truth.force_peak_n)?;
        dict.set_item("slip_m", truth.travel_m - truth.shear_m)?;
        dict.set_item("speed_m_s", truth.speed_m_s)?;
        dict.set_item("slipping", truth.slipping)?;
        dict.set_item("lifted", truth.lifted())?;
        dict.set_item("dropped", truth.dropped())?;
        dict.set_item("crushed", truth.crushed)?;
        Ok(dict)
    }

    /// The names of the columns of the rows.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.channels.columns().into_iter().map(str::to_owned).collect()
    }

    /// Samples per second (Hz).
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.scene.config().sample_rate_hz.into()
    }

    /// The largest force of the drive (N).
    #[getter]
    fn force_max_n(&self) -> f64 {
        self.scene.config().drive.force_max_n
    }

    /// The name of the scene.
    #[getter]
    fn scene(&self) -> &str {
        &self.scene.config().name
    }
}
