//! The regression set `surface2` and its golden curves, read from a folder outside the repository.

use std::path::{Path, PathBuf};

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use mlp::train::{DataSet, NetworkObjective, Objective, Real, Topology, Trainer};
use ndarray::Array2;

/// The folder `learning` of the test data.
pub(crate) fn learning() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("GRIP_DATA").map_or_else(beside, PathBuf::from).join("learning");
    assert!(folder.is_dir(), "no folder {}: set GRIP_DATA", folder.display());
    folder
}

/// Training rows of `surface2` for a 2-10-1 network.
pub(crate) struct Surface2 {
    folder: PathBuf,
    topology: Topology,
    /// Inputs and scaled targets.
    rows: [Array2<f64>; 2],
}

/// The set.
pub(crate) fn surface2() -> Surface2 {
    let folder = learning();
    let bytes = std::fs::read(folder.join("surface2_train.csv")).unwrap();
    let specs = |names: &[&str]| names.iter().map(|name| name.parse().unwrap()).collect::<Vec<_>>();
    let data =
        DataSet::from_csv("surface2_train.csv", &bytes, &specs(&["x1", "x2"]), &specs(&["y"]))
            .unwrap();
    // Inputs lie in [-1, 1] already and are used as they are.
    let [_, targets] = data.scaled(&data.input_scalings(), &data.target_scalings());
    let topology = Topology::regression(2, &[10], 1).unwrap();
    Surface2 { folder, topology, rows: [data.input_values().to_owned(), targets] }
}

impl Surface2 {
    pub(crate) fn objective<T: Real>(&self) -> NetworkObjective<T> {
        let [inputs, targets] = &self.rows;
        NetworkObjective::new(&self.topology, inputs, targets).unwrap()
    }

    /// The same rows, each value moved by up to half a unit of its ninth decimal.
    pub(crate) fn moved_within_rounding(&self, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut shift = || f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5;
        let rows = self.rows.each_ref().map(|values| values.map(|value| value + 1e-9 * shift()));
        Self { folder: self.folder.clone(), topology: self.topology.clone(), rows }
    }

    /// Starting weights number `start`.
    pub(crate) fn start(&self, start: usize) -> Vec<f64> {
        let path = self.folder.join(format!("starts/surface2_2-10-1_{start}.txt"));
        let text = std::fs::read_to_string(path).unwrap();
        text.split_whitespace().map(|number| number.parse().unwrap()).collect()
    }

    /// Start, epoch and training error of each row of the golden file with this label.
    pub(crate) fn golden(&self, label: &str) -> Vec<(usize, usize, f64)> {
        let text = std::fs::read_to_string(self.folder.join("golden.csv")).unwrap();
        let rows: Vec<_> = text
            .lines()
            .map(|line| line.split(',').collect::<Vec<_>>())
            .filter(|fields| fields[0] == label)
            .map(|f| (f[1].parse().unwrap(), f[2].parse().unwrap(), f[3].parse().unwrap()))
            .collect();
        assert!(!rows.is_empty(), "no golden rows for {label}");
        rows
    }
}

/// Training error after `epochs` steps.
pub(crate) fn curve(
    trainer: &mut dyn Trainer,
    objective: &mut NetworkObjective,
    weights: &mut [f64],
    epochs: usize,
) -> f64 {
    for _ in 0..epochs {
        trainer.step(objective, weights);
    }
    objective.mse(weights)
}
