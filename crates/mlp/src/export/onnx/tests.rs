//! ONNX files decoded again, checked and run by a small interpreter.

use std::collections::BTreeMap;

use prost::Message as _;

use super::super::{agreement, test_models};
use super::*;

/// A matrix by rows.
type Rows = Vec<Vec<f64>>;

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
    values.chunks(width).map(<[f64]>::to_vec).collect()
}

/// Element by element; a single row stands for any number of rows.
fn each(left: &Rows, right: &Rows, f: impl Fn(f64, f64) -> f64) -> Rows {
    let row = |at: usize, rows: &Rows| rows[if rows.len() == 1 { 0 } else { at }].clone();
    let pairs = |left: Vec<f64>, right: Vec<f64>| -> Vec<f64> {
        // A single value stands for a row.
        let left = left.iter().cycle().take(left.len().max(right.len()));
        left.zip(&right).map(|(a, b)| f(*a, *b)).collect()
    };
    (0..left.len().max(right.len())).map(|at| pairs(row(at, left), row(at, right))).collect()
}

fn gemm(rows: &Rows, weights: &Rows, biases: &Rows) -> Rows {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    rows.iter()
        .map(|row| weights.iter().zip(&biases[0]).map(|(w, b)| product(w, row) + b).collect())
        .collect()
}

fn compute(operator: &str, inputs: &[&Rows]) -> Rows {
    let map = |f: fn(f64) -> f64| each(inputs[0], inputs[0], |x, _| f(x));
    let truth = |flag: bool| f64::from(u8::from(flag));
    match operator {
        "Log" => map(f64::ln),
        "Exp" => map(f64::exp),
        "Identity" => inputs[0].clone(),
        "Min" => each(inputs[0], inputs[1], f64::min),
        "Tanh" => map(f64::tanh),
        "Sigmoid" => map(|x| 1.0 / (1.0 + (-x).exp())),
        "Relu" => map(|x| x.max(0.0)),
        "Sub" => each(inputs[0], inputs[1], |a, b| a - b),
        "Div" => each(inputs[0], inputs[1], |a, b| a / b),
        "Mul" => each(inputs[0], inputs[1], |a, b| a * b),
        "Add" => each(inputs[0], inputs[1], |a, b| a + b),
        "And" => each(inputs[0], inputs[1], |a, b| truth(a + b > 1.5)),
        "GreaterOrEqual" => each(inputs[0], inputs[1], |a, b| truth(a >= b)),
        "LessOrEqual" => each(inputs[0], inputs[1], |a, b| truth(a <= b)),
        "Where" => {
            let picked =
                each(inputs[0], inputs[1], |mask, x| if mask > 0.5 { x } else { f64::NAN });
            each(&picked, inputs[2], |x, other| if x.is_nan() { other } else { x })
        }
        "Softmax" => {
            let softmax = |row: &Vec<f64>| {
                let sum: f64 = row.iter().map(|x| x.exp()).sum();
                row.iter().map(|x| x.exp() / sum).collect()
            };
            inputs[0].iter().map(softmax).collect()
        }
        "Gemm" => gemm(inputs[0], inputs[1], inputs[2]),
        other => panic!("operator {other}"),
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

fn decoded(file: &ModelFile) -> ModelProto {
    let bytes = bytes(file, "m.json").unwrap();
    ModelProto::decode(&bytes[..]).unwrap()
}

#[test]
fn the_graph_computes_what_the_model_computes() {
    for file in test_models::all() {
        let (model, onnx) = (file.model().unwrap(), decoded(&file));
        let features = test_models::features(file.inputs.len());
        let rows = features.iter().map(|row| row.iter().map(|&x| x.into()).collect()).collect();
        let values = run(onnx.graph.as_ref().unwrap(), rows);
        for (at, raw) in features.iter().enumerate() {
            let mut out = vec![0.0; file.targets.len()];
            model.predict(raw, &mut out).unwrap();
            let bounds = agreement::bounds(&model, raw);
            for (target, ours) in out.iter().enumerate() {
                let theirs = rounded(values["targets"][at][target]);
                let found = agreement::difference(&model, target, *ours, theirs);
                assert!(found <= bounds[target], "{raw:?} {target}: {ours} {theirs}");
            }
            for (column, flag) in values["in_range"][at].iter().enumerate() {
                let covered = model.inputs().covers(column, raw[column]);
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
            let row = row.into_iter().map(f64::from).collect();
            (refused, run(onnx.graph.as_ref().unwrap(), vec![row])["targets"][0][0].is_nan())
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
    let rows = features.iter().map(|row| row.iter().map(|&x| x.into()).collect()).collect();
    let values = run(onnx.graph.as_ref().unwrap(), rows);
    for (raw, theirs) in features.iter().zip(&values["targets"]) {
        let mut out = [0.0; 3];
        model.predict(raw, &mut out).unwrap();
        let mut ours = out.map(f64::from);
        crate::train::metrics::softmax(&mut ours);
        let bound = agreement::probability_bound(&agreement::bounds(&model, raw));
        assert!(
            ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() <= bound),
            "{ours:?} {theirs:?}"
        );
        assert!((theirs.iter().sum::<f64>() - 1.0).abs() < 1e-9);
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
    let first = graph.initializer.iter().find(|tensor| tensor.name == "weights_1").unwrap();
    assert!(tensor(first).iter().all(|row| row[3] == 0.0 && row[1] != 0.0), "constant column 3");
}

#[test]
fn the_bytes_are_those_of_the_format() {
    // Field 1 (ir_version), a varint of 8; then field 2 (producer_name), 7 bytes.
    let bytes = bytes(&test_models::all()[0], "m.json").unwrap();
    assert_eq!(&bytes[..11], b"\x08\x08\x12\x07gripctl");
}
