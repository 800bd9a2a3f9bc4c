//! One block of scaled rows in, its sum of squared residuals and their derivatives out.

use super::super::topology::{Layer, Topology};
use super::tanh::tanh;
use crate::activation::Activation;

/// Rows advanced together: they stay in the first-level cache for the usual widths.
pub(super) const ROWS: usize = 128;

const LANES: usize = 8;

/// Values of one neuron for eight rows.
type Group = [f64; LANES];

/// Up to [`ROWS`] rows, transposed: for each column the values of all rows. Empty lanes of the last group
/// hold zeros and count for nothing.
#[derive(Debug, Clone)]
pub(super) struct Block {
    rows: usize,
    inputs: Vec<Group>,
    targets: Vec<Group>,
}

impl Block {
    pub(super) fn new(inputs: &[f64], width: usize, targets: &[f64], outputs: usize) -> Self {
        Self {
            rows: inputs.len() / width,
            inputs: transposed(inputs, width),
            targets: transposed(targets, outputs),
        }
    }

    fn groups(&self) -> usize {
        self.rows.div_ceil(LANES)
    }
}

fn transposed(values: &[f64], width: usize) -> Vec<Group> {
    let groups = (values.len() / width).div_ceil(LANES);
    let mut columns = vec![[0.0; LANES]; groups * width];
    for (row, fields) in values.chunks_exact(width).enumerate() {
        for (column, &value) in fields.iter().enumerate() {
            columns[column * groups + row / LANES][row % LANES] = value;
        }
    }
    columns
}

/// What one backward pass yields for one weight: the derivative of the residuals' sum along the block.
pub(super) struct Derivative<'a> {
    deltas: &'a [Group],
    /// Values of the neuron the weight comes from, none for a bias.
    values: Option<&'a [Group]>,
}

impl Derivative<'_> {
    /// Sum over the rows.
    #[inline]
    pub(super) fn sum(&self) -> f64 {
        let mut sums = [0.0; LANES];
        match self.values {
            Some(values) => {
                for (deltas, values) in self.deltas.iter().zip(values) {
                    for lane in 0..LANES {
                        sums[lane] += deltas[lane] * values[lane];
                    }
                }
            }
            None => {
                for deltas in self.deltas {
                    for lane in 0..LANES {
                        sums[lane] += deltas[lane];
                    }
                }
            }
        }
        sums.iter().sum()
    }

    /// One value per row.
    fn write(&self, rows: &mut [Group]) {
        match self.values {
            Some(values) => {
                for ((row, deltas), values) in rows.iter_mut().zip(self.deltas).zip(values) {
                    for lane in 0..LANES {
                        row[lane] = deltas[lane] * values[lane];
                    }
                }
            }
            None => rows.copy_from_slice(self.deltas),
        }
    }
}

/// Memory of one forward and backward pass over a block.
#[derive(Debug, Clone)]
pub(super) struct Tape {
    layers: Vec<Layer>,
    /// Per layer, inputs first: the values of all neurons for all rows.
    values: Vec<Vec<Group>>,
    /// Per layer of weights: derivatives with respect to the neurons' sums.
    deltas: Vec<Vec<Group>>,
    residuals: Vec<Group>,
    jacobian: Vec<Group>,
    groups: usize,
    /// Used lanes of a block's last group.
    last_lanes: usize,
}

impl Tape {
    pub(super) fn new(topology: &Topology) -> Self {
        let room = |width: &usize| vec![[0.0; LANES]; width * ROWS.div_ceil(LANES)];
        let values: Vec<_> = topology.sizes().iter().map(room).collect();
        Self {
            layers: topology.layers().collect(),
            deltas: values[1..].to_vec(),
            residuals: room(&topology.outputs()),
            values,
            jacobian: Vec::new(),
            groups: 0,
            last_lanes: LANES,
        }
    }

    /// Computes all neurons and residuals; returns the sum of squared residuals.
    pub(super) fn forward(&mut self, block: &Block, weights: &[f64]) -> f64 {
        let groups = block.groups();
        self.groups = groups;
        self.last_lanes = block.rows - (groups - 1) * LANES;
        self.values[0][..block.inputs.len()].copy_from_slice(&block.inputs);
        for (at, layer) in self.layers.iter().enumerate() {
            let (before, after) = self.values.split_at_mut(at + 1);
            let from = &before[at][..layer.from * groups];
            let matrix = weights[layer.start..layer.biases()].chunks_exact(layer.from);
            let biases = &weights[layer.biases()..layer.end()];
            let neurons = after[0].chunks_exact_mut(groups);
            for ((neuron, row), &bias) in neurons.zip(matrix).zip(biases) {
                for (group, place) in neuron.iter_mut().enumerate() {
                    let mut sums = [bias; LANES];
                    for (weight, column) in row.iter().zip(from.chunks_exact(groups)) {
                        let values = &column[group];
                        for lane in 0..LANES {
                            sums[lane] += weight * values[lane];
                        }
                    }
                    *place = sums;
                }
                activate(layer.activation, neuron);
            }
        }
        self.subtract_targets(block)
    }

    fn subtract_targets(&mut self, block: &Block) -> f64 {
        let groups = self.groups;
        let outputs = &self.values[self.layers.len()];
        let mut sums = [0.0; LANES];
        for (at, (residual, (output, target))) in
            self.residuals.iter_mut().zip(outputs.iter().zip(&block.targets)).enumerate()
        {
            for lane in 0..LANES {
                residual[lane] = output[lane] - target[lane];
            }
            if at % groups == groups - 1 {
                residual[self.last_lanes..].fill(0.0);
            }
            for lane in 0..LANES {
                sums[lane] += residual[lane] * residual[lane];
            }
        }
        sums.iter().sum()
    }

    /// The next backward pass sums residual times derivative.
    pub(super) fn start_at_residuals(&mut self) {
        let last = self.layers.len() - 1;
        let used = self.layers[last].to * self.groups;
        self.deltas[last][..used].copy_from_slice(&self.residuals[..used]);
        self.through_activation(last);
    }

    /// The next backward pass gives the derivatives of `output` alone.
    pub(super) fn start_at_output(&mut self, output: usize) {
        let last = self.layers.len() - 1;
        let (groups, used) = (self.groups, self.layers[last].to * self.groups);
        self.deltas[last][..used].fill([0.0; LANES]);
        let deltas = &mut self.deltas[last][output * groups..(output + 1) * groups];
        deltas.fill([1.0; LANES]);
        deltas[groups - 1][self.last_lanes..].fill(0.0);
        self.through_activation(last);
    }

    /// Turns derivatives by a layer's values into derivatives by its sums.
    fn through_activation(&mut self, layer: usize) {
        let Layer { to, activation, .. } = self.layers[layer];
        let used = to * self.groups;
        let values = &self.values[layer + 1][..used];
        for (deltas, values) in self.deltas[layer].iter_mut().zip(values) {
            for lane in 0..LANES {
                deltas[lane] *= slope(activation, values[lane]);
            }
        }
    }

    /// Visits every weight with its derivative, last layer first.
    pub(super) fn backward(
        &mut self,
        weights: &[f64],
        visit: &mut impl FnMut(usize, Derivative<'_>),
    ) {
        for at in (0..self.layers.len()).rev() {
            self.visit_layer(at, visit);
            if at > 0 {
                self.carry_back(at, weights);
                self.through_activation(at - 1);
            }
        }
    }

    fn visit_layer(&self, at: usize, visit: &mut impl FnMut(usize, Derivative<'_>)) {
        let layer = self.layers[at];
        let neurons = self.deltas[at].chunks_exact(self.groups).take(layer.to);
        for (neuron, deltas) in neurons.enumerate() {
            let columns = self.values[at].chunks_exact(self.groups).take(layer.from);
            for (column, values) in columns.enumerate() {
                let weight = layer.start + neuron * layer.from + column;
                visit(weight, Derivative { deltas, values: Some(values) });
            }
            visit(layer.biases() + neuron, Derivative { deltas, values: None });
        }
    }

    /// Derivatives by the values of the layer before layer `at`, written to its deltas.
    fn carry_back(&mut self, at: usize, weights: &[f64]) {
        let (layer, groups) = (self.layers[at], self.groups);
        let (before, after) = self.deltas.split_at_mut(at);
        let deltas = &after[0][..layer.to * groups];
        let matrix = &weights[layer.start..layer.biases()];
        let targets = before[at - 1].chunks_exact_mut(groups).take(layer.from);
        for (column, target) in targets.enumerate() {
            for (group, place) in target.iter_mut().enumerate() {
                let mut sums = [0.0; LANES];
                let column_weights = matrix.iter().skip(column).step_by(layer.from);
                for (weight, neuron) in column_weights.zip(deltas.chunks_exact(groups)) {
                    for lane in 0..LANES {
                        sums[lane] += weight * neuron[group][lane];
                    }
                }
                *place = sums;
            }
        }
    }

    /// One backward pass kept row by row: for each weight the derivatives of all rows.
    pub(super) fn jacobian(&mut self, weights: &[f64]) {
        let groups = self.groups;
        let mut jacobian = core::mem::take(&mut self.jacobian);
        jacobian.clear();
        jacobian.resize(weights.len() * groups, [0.0; LANES]);
        self.backward(weights, &mut |weight, derivative| {
            derivative.write(&mut jacobian[weight * groups..(weight + 1) * groups]);
        });
        self.jacobian = jacobian;
    }

    /// Adds the Jacobian's products to the lower triangle of `normal` and to `projected`.
    pub(super) fn add_normal_equations(
        &self,
        output: usize,
        normal: &mut [f64],
        projected: &mut [f64],
    ) {
        let groups = self.groups;
        let residuals = &self.residuals[output * groups..(output + 1) * groups];
        let size = projected.len();
        let columns = || self.jacobian.chunks_exact(groups);
        for (place, (at, column)) in projected.iter_mut().zip(columns().enumerate()) {
            *place += dot(column, residuals);
            let row = &mut normal[at * size..=at * size + at];
            for (product, other) in row.iter_mut().zip(columns()) {
                *product += dot(column, other);
            }
        }
    }
}

#[inline]
fn dot(left: &[Group], right: &[Group]) -> f64 {
    Derivative { deltas: left, values: Some(right) }.sum()
}

fn activate(activation: Activation, sums: &mut [Group]) {
    let all = sums.as_flattened_mut().iter_mut();
    match activation {
        Activation::Tanh => all.for_each(|x| *x = tanh(*x)),
        Activation::Linear => {}
        Activation::Logistic => all.for_each(|x| *x = 0.5 + 0.5 * tanh(0.5 * *x)),
        Activation::Relu => all.for_each(|x| *x = if *x < 0.0 { 0.0 } else { *x }),
    }
}

/// Derivative of the activation function where it has the value `y`.
#[inline]
fn slope(activation: Activation, y: f64) -> f64 {
    match activation {
        Activation::Tanh => 1.0 - y * y,
        Activation::Linear => 1.0,
        Activation::Logistic => y * (1.0 - y),
        Activation::Relu => {
            if y > 0.0 {
                1.0
            } else {
                0.0
            }
        }
    }
}
