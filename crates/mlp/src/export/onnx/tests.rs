//! ONNX files decoded again, checked and run by a small interpreter.

use std::collections::BTreeMap;

use ndarray::{Array2, Axis as Along, Zip};
use prost::Message as _;

use super::super::{agreement, test_models};
use super::*;

type Rows = Array2<f64>;

fn tensor(tensor: &TensorProto) -> Rows {
    let values: Vec<f64> = match tensor.data_type {
        FLOAT => {
            let (words, rest) = tensor.raw_data.as_chunks::<4>();
            assert!(rest.is_empty(), "{}", tensor.name);
            words.iter().map(|&word| f32::from_le_bytes(word).into()).collect()
        }
        _ => tensor.raw_data.iter().map(|&byte| byte.into()).collect(),
    };
    let width = usize::try_from(*tensor.dims.last().unwrap()).unwrap();
    let count: i64 = tensor.dims.iter().product();
    assert_eq!(usize::try_from(count).unwrap(), values.len(), "{}", tensor.name);
    Array2::from_shape_vec((values.len() / width, width), values).unwrap()
}

/// Element by element; a single row on the right stands for any number of rows.
fn each(left: &Rows, right: &Rows, f: impl Fn(f64, f64) -> f64) -> Rows {
    Zip::from(left).and_broadcast(right).map_collect(|&a, &b| f(a, b))
}

fn compute(operator: &str, inputs: &[&Rows]) -> Rows {
    let truth = |flag: bool| f64::from(u8::from(flag));
    match (operator, inputs) {
        ("Log", [x]) => x.mapv(f64::ln),
        ("Exp", [x]) => x.mapv(f64::exp),
        ("Identity", [x]) => (*x).clone(),
        ("Tanh", [x]) => x.mapv(f64::tanh),
        ("Sigmoid", [x]) => x.mapv(|x| 1.0 / (1.0 + (-x).exp())),
        ("Relu", [x]) => x.mapv(|x| x.max(0.0)),
        ("Softmax", [x]) => {
            let exponentials = x.mapv(f64::exp);
            let sums = exponentials.sum_axis(Along(1)).insert_axis(Along(1));
            exponentials / sums
        }
        ("Sub", [a, b]) => *a - *b,
        ("Div", [a, b]) => *a / *b,
        ("Mul", [a, b]) => *a * *b,
        ("Add", [a, b]) => *a + *b,
        ("Min", [a, b]) => each(a, b, f64::min),
        ("And", [a, b]) => each(a, b, |a, b| truth(a + b > 1.5)),
        ("GreaterOrEqual", [a, b]) => each(a, b, |a, b| truth(a >= b)),
        ("LessOrEqual", [a, b]) => each(a, b, |a, b| truth(a <= b)),
        ("Where", [mask, a, b]) => {
            let pick = |&a: &f64, &b: &f64, &mask: &f64| if mask > 0.5 { a } else { b };
            Zip::from(*a).and(*b).and_broadcast(*mask).map_collect(pick)
        }
        ("Gemm", [x, weights, biases]) => x.dot(&weights.t()) + *biases,
        (other, _) => panic!("operator {other}"),
    }
}

/// Runs a graph in double precision; every name must have been computed before it is used.
fn run(graph: &GraphProto, features: Rows) -> BTreeMap<String, Rows> {
    let mut values: BTreeMap<String, Rows> =
        graph.initializer.iter().map(|t| (t.name.clone(), tensor(t))).collect();
    values.insert(graph.input[0].name.clone(), features);
    for node in &graph.node {
        let inputs: Vec<&Rows> = node.input.iter().map(|name| &values[name]).collect();
        let result = compute(&node.op_type, &inputs);
        assert!(
            values.insert(node.output[0].clone(), result).is_none(),
            "{} twice",
            node.output[0]
        );
    }
    values
}

fn rows(features: &[Vec<f32>]) -> Rows {
    Array2::from_shape_fn((features.len(), features[0].len()), |(row, at)| features[row][at].into())
}

fn decoded(file: &ModelFile) -> ModelProto {
    let bytes = bytes(file, "m.json").unwrap();
    ModelProto::decode(&bytes[..]).unwrap()
}

#[test]
fn the_graph_computes_what_the_model_computes() {
    for file in test_models::all() {
        let (model, onnx) = (file.model().unwrap(), decoded(&file));
        let features = test_models::features(file.inputs.len());
        let values = run(onnx.graph.as_ref().unwrap(), rows(&features));
        for (at, raw) in features.iter().enumerate() {
            let mut out = vec![0.0; file.targets.len()];
            model.predict(raw, &mut out).unwrap();
            let bounds = agreement::bounds(&model, raw);
            for (target, ours) in out.iter().enumerate() {
                let theirs = rounded(values["targets"][[at, target]]);
                let found = agreement::difference(&model, target, *ours, theirs);
                assert!(found <= bounds[target], "{raw:?} {target}: {ours} {theirs}");
            }
            for (column, flag) in values["in_range"].row(at).iter().enumerate() {
                let covered = model.inputs().axes()[column].covers(raw[column]);
                assert_eq!(*flag > 0.5, covered, "{raw:?} column {column}");
            }
        }
    }
}

/// As Rust and C, which refuse it.
#[test]
fn what_has_no_reciprocal_or_logarithm_has_no_answer() {
    for transform in [Transform::Ln, Transform::Reciprocal] {
        let mut file = test_models::all()[0].clone();
        let input = &mut file.inputs[0];
        (input.transform, input.min, input.max) = (transform, 0.5, 2.0);
        let (model, onnx) = (file.model().unwrap(), decoded(&file));
        let answer = |x: f32| {
            let row = (0..file.inputs.len()).map(|at| if at == 0 { x } else { 0.1 });
            let row: Vec<f32> = row.collect();
            let refused = model.predict(&row, &mut vec![0.0; file.targets.len()]).is_err();
            let values = run(onnx.graph.as_ref().unwrap(), rows(&[row]));
            (refused, values["targets"][[0, 0]].is_nan())
        };
        assert_eq!(
            [answer(1.0), answer(-1.0), answer(0.0)].map(|(refused, _)| refused),
            [false, true, true]
        );
        assert!(!answer(1.0).1 && answer(-1.0).1, "{transform:?}");
    }
}

#[test]
fn a_classifier_gives_probabilities() {
    let file = test_models::classifier();
    let (model, onnx) = (file.large_model().unwrap(), decoded(&file));
    let features = test_models::features(40);
    let values = run(onnx.graph.as_ref().unwrap(), rows(&features));
    for (raw, theirs) in features.iter().zip(values["targets"].rows()) {
        let mut out = [0.0; 3];
        model.predict(raw, &mut out).unwrap();
        let mut ours = out.map(f64::from);
        crate::train::metrics::softmax(&mut ours);
        let bound = agreement::probability_bound(&agreement::bounds(&model, raw));
        assert!(
            ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() <= bound),
            "{ours:?} {theirs:?}"
        );
        assert!((theirs.sum() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn versions_shapes_and_units_are_stated() {
    let file = &test_models::all()[3];
    let onnx = decoded(file);
    assert_eq!((onnx.ir_version, onnx.opset_import[0].version), (8, 17));
    let graph = onnx.graph.as_ref().unwrap();
    let shape = |value: &ValueInfoProto| {
        let tensor = value.r#type.as_ref().unwrap().tensor_type.as_ref().unwrap();
        let dims = &tensor.shape.as_ref().unwrap().dim;
        (value.name.clone(), tensor.elem_type, dims[1].value.clone().unwrap())
    };
    assert_eq!(shape(&graph.input[0]), ("features".into(), FLOAT, Length::Value(5)));
    assert_eq!(shape(&graph.output[0]), ("targets".into(), FLOAT, Length::Value(2)));
    assert_eq!(shape(&graph.output[1]), ("in_range".into(), BOOL, Length::Value(5)));
    let inputs = &onnx.metadata_props.iter().find(|entry| entry.key == "inputs").unwrap().value;
    let inputs: Vec<FileColumn> = serde_json::from_str(inputs).unwrap();
    assert_eq!(inputs, file.inputs);
    let gain = graph.initializer.iter().find(|tensor| tensor.name == "features_gain").unwrap();
    let gain = tensor(gain);
    assert!(gain[[0, 3]] == 0.0 && gain[[0, 1]] != 0.0, "constant column 3");
}

#[test]
fn the_bytes_are_those_of_the_format() {
    // Field 1 (ir_version), a varint of 8; then field 2 (producer_name), 7 bytes.
    let bytes = bytes(&test_models::all()[0], "m.json").unwrap();
    assert_eq!(&bytes[..11], b"\x08\x08\x12\x07gripctl");
}
