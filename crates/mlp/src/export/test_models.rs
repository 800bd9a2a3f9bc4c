//! Model files of every shape that can be exported, for the tests.

use crate::activation::Activation;
use crate::model::Transform;
use crate::train::file::FileColumn;
use crate::train::{ModelFile, Topology};

/// Columns alternate between `first` and another transform; the last of four or more is constant.
fn columns(kind: &str, count: usize, first: Transform) -> Vec<FileColumn> {
    let other = if first == Transform::Identity { Transform::Ln } else { Transform::Identity };
    let column = |at: usize| FileColumn {
        name: format!("{kind} {at} */"),
        unit: "m/s".to_owned(),
        transform: if at.is_multiple_of(2) { first } else { other },
        min: 0.25,
        max: if at == 3 { 0.25 } else { 30.0 },
        noise: if kind == "target" { 0.3 } else { 0.0 },
    };
    (0..count).map(column).collect()
}

fn file(sizes: &[usize], activations: &[Activation], first: Transform) -> ModelFile {
    let topology = Topology::new(sizes, activations).unwrap();
    let weights: Vec<f64> =
        (0..topology.weights()).map(|at| 1.1 * (at as f64 * 1.31).sin()).collect();
    let (inputs, outputs) = (topology.inputs(), topology.outputs());
    let targets = columns("target", outputs, first);
    ModelFile::new(&columns("input", inputs, first), &targets, &topology, &weights)
}

/// Each activation, one to three hidden layers and none, every transform, constant columns.
pub(super) fn all() -> Vec<ModelFile> {
    use Activation::{Linear, Logistic, Relu, Tanh};
    vec![
        file(&[1, 1], &[Linear], Transform::Identity),
        file(&[2, 10, 1], &[Tanh, Linear], Transform::Identity),
        file(&[1, 3, 1], &[Logistic, Linear], Transform::Ln),
        file(&[5, 7, 2], &[Relu, Logistic], Transform::Identity),
        file(&[4, 6, 5, 4], &[Tanh, Relu, Linear], Transform::Ln),
        file(&[16, 32, 16, 3, 16], &[Tanh, Logistic, Tanh, Tanh], Transform::Identity),
        file(&[3, 64, 1], &[Tanh, Tanh], Transform::Identity),
        file(&[3, 8, 2], &[Tanh, Tanh], Transform::Reciprocal),
        file(&[1, 3, 1], &[Tanh, Linear], Transform::Reciprocal),
    ]
}

/// A classifier of three classes with more inputs than gripd takes.
pub(super) fn classifier() -> ModelFile {
    let activations = [Activation::Tanh, Activation::Linear];
    let mut file = file(&[40, 5, 3], &activations, Transform::Identity);
    for class in &mut file.targets {
        (class.transform, class.min, class.max) = (Transform::Identity, -1.0, 1.0);
    }
    file.classes = Some("side".to_owned());
    file
}

/// Raw features inside and beyond the ranges, all of which have an answer.
pub(super) fn features(inputs: usize) -> Vec<Vec<f32>> {
    let value = |step: usize, at: usize| 0.2 + 32.0 * (((step * 37 + at * 101) % 97) as f32 / 96.0);
    (0..40).map(|step| (0..inputs).map(|at| value(step, at)).collect()).collect()
}
