//! The data sets, networks and starting weights on which other libraries are compared.

use core::fmt::Write as _;

use mlp::{
    ShapeError,
    train::{Topology, init::nguyen_widrow},
};
use ndarray::{Array2, ArrayView1, Axis, aview1};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

/// A network, its rows and its starting weights.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in tables and file names.
    pub name: &'static str,
    /// Shape: tanh, then linear.
    pub topology: Topology,
    /// Inputs of the rows in [-1, 1].
    pub inputs: Array2<f64>,
    /// Their targets in [-1, 1].
    pub targets: Array2<f64>,
    /// Starting weights.
    pub weights: Vec<f64>,
}

/// Uniform in [-1, 1).
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    f64::from(rng.next_u32()) / 2_147_483_648.0 - 1.0
}

/// A smooth surface over two inputs with noise: 100 rows, 2-10-1.
///
/// # Errors
/// Never: the shape is possible.
pub fn surface() -> Result<Case, ShapeError> {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (mut inputs, mut targets) = (Array2::zeros((100, 2)), Array2::zeros((100, 1)));
    for row in 0..100 {
        let (x, y) = (uniform(&mut rng), uniform(&mut rng));
        let smooth = 0.6 * (core::f64::consts::PI * x).sin() * y + 0.4 * (2.5 * y).cos() + 0.3 * x;
        inputs.row_mut(row).assign(&aview1(&[x, y]));
        targets[[row, 0]] = smooth + 0.08 * uniform(&mut rng);
    }
    Ok(Case::rounded("surface2", Topology::regression(2, &[10], 1)?, inputs, targets))
}

/// Made-up rows in the shape of Proben1's building1: 2104 rows, 14-16-3.
///
/// # Errors
/// Never: the shape is possible.
pub fn building() -> Result<Case, ShapeError> {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let inputs = Array2::from_shape_simple_fn((2104, 14), || uniform(&mut rng));
    let mut targets = Array2::zeros((2104, 3));
    for (row, mut target) in inputs.rows().into_iter().zip(targets.rows_mut()) {
        let sum = |step: usize| row.iter().step_by(step).sum::<f64>() / 4.0;
        let wanted = [sum(2).tanh(), (sum(3) * row[1]).sin(), 0.5 * (sum(5) - row[7])];
        target.assign(&aview1(&wanted));
    }
    Ok(Case::rounded("building1", Topology::regression(14, &[16], 3)?, inputs, targets))
}

/// Made-up rows in the shape of kin32fm, a table of FANN's distribution: 2048 rows, 32-16-1.
///
/// # Errors
/// Never: the shape is possible.
pub fn kinematics() -> Result<Case, ShapeError> {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let inputs = Array2::from_shape_simple_fn((2048, 32), || uniform(&mut rng));
    let target = |row: ArrayView1<'_, f64>| {
        let angle = row.iter().step_by(4).sum::<f64>();
        0.5 * (angle.sin() + row[1] * angle.cos())
    };
    let targets = inputs.map_axis(Axis(1), target).insert_axis(Axis(1));
    Ok(Case::rounded("kin32fm", Topology::regression(32, &[16], 1)?, inputs, targets))
}

/// The nearest number of nine decimals, so that what is written is what we train on.
fn nine_decimals(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

impl Case {
    fn rounded(
        name: &'static str,
        topology: Topology,
        mut inputs: Array2<f64>,
        mut targets: Array2<f64>,
    ) -> Self {
        let weights = nguyen_widrow(&topology, 1).into_iter().map(nine_decimals).collect();
        inputs.mapv_inplace(nine_decimals);
        targets.mapv_inplace(nine_decimals);
        Self { name, topology, inputs, targets, weights }
    }

    /// The rows as FANN reads them: a line of counts, then inputs and targets on alternate lines.
    #[must_use]
    pub fn fann(&self) -> String {
        let (inputs, outputs) = (self.topology.inputs(), self.topology.outputs());
        let rows = self.inputs.nrows();
        let mut text = format!("{rows} {inputs} {outputs}\n");
        for (x, y) in self.inputs.rows().into_iter().zip(self.targets.rows()) {
            for line in [x, y] {
                let fields: Vec<String> = line.iter().map(|field| format!("{field:.9}")).collect();
                let _infallible = writeln!(text, "{}", fields.join(" "));
            }
        }
        text
    }

    /// Weights in flat order, neuron by neuron: its weights, then its bias.
    #[must_use]
    pub fn by_neuron(&self, weights: &[f64]) -> String {
        let mut text = String::new();
        for layer in self.topology.layers() {
            for neuron in 0..layer.to {
                let row = layer.start + neuron * layer.from;
                for weight in
                    weights[row..row + layer.from].iter().chain([&weights[layer.biases() + neuron]])
                {
                    let _infallible = writeln!(text, "{weight}");
                }
            }
        }
        text
    }
}
