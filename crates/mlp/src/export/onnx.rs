//! ONNX export: a model file as the bytes of an ONNX model.
//!
//! ```text
//! features [N, inputs] -> (Log or Div of some) -> Sub -> Mul -> Gemm -> Tanh | Sigmoid | Relu -> ... -> Mul -> Add
//!     -> (Exp of some, Min, Div, Add and Div of others) -> targets [N, outputs]
//!     -> GreaterOrEqual, LessOrEqual, And -> in_range [N, inputs]
//! ```
//! Of a classifier the targets are probabilities, from Softmax in place of Mul and Add. Both are raw values. `in_range` reports for
//! each feature whether the training rows covered it. A model with logarithmic and other columns takes the logarithm of all and picks
//! with Where; so with reciprocals. A feature that was constant in training has no influence: its gain is 0. Operator set 17; names,
//! units and ranges stand in `metadata_props`.

use prost::Message as _;
use serde_json::json;

use super::ExportError;
use super::proto::{
    AttributeProto, BOOL, Dimension, FLOAT, GraphProto, Length, ModelProto, NodeProto,
    OperatorSetIdProto, StringStringEntryProto, TensorProto, TensorShapeProto, TensorType,
    TypeProto, ValueInfoProto,
};
use crate::activation::Activation;
use crate::model::{Axis, Transform};
use crate::train::ModelFile;
use crate::train::file::{FileColumn, rounded};

/// Version of the file format, that of ONNX 1.12.
pub const IR_VERSION: i64 = 8;

/// Version of the operator set, that of ONNX 1.12: every runtime since 2022 has it.
pub const OPSET: i64 = 17;

/// Writes `file` as ONNX. `origin` states in the file where the model comes from.
///
/// # Errors
/// [`ExportError::File`] when `file` holds no valid model.
pub fn bytes(file: &ModelFile, origin: &str) -> Result<Vec<u8>, ExportError> {
    let model = file.large_model()?;
    let mut graph = Graph::default();
    let features = "features".to_owned();
    graph.range(&file.inputs);
    let mut current = graph.scale(features.clone(), model.inputs().axes());
    for (at, layer) in file.layers.iter().enumerate() {
        current = graph.layer(at + 1, &current, &layer.weights, &layer.biases);
        current = graph.activate(at + 1, current, layer.activation);
    }
    if file.classes.is_some() {
        // Over the last axis, as is the default.
        graph.node("Softmax", &[&current], "targets");
    } else {
        graph.unscale(&current, model.targets().axes());
    }
    let (inputs, outputs) = (file.inputs.len(), file.targets.len());
    let message = ModelProto {
        ir_version: IR_VERSION,
        opset_import: vec![OperatorSetIdProto { domain: String::new(), version: OPSET }],
        producer_name: "gripctl".to_owned(),
        producer_version: env!("CARGO_PKG_VERSION").to_owned(),
        doc_string: format!("{origin}: raw features in, raw targets out"),
        graph: Some(GraphProto {
            node: graph.nodes,
            name: "model".to_owned(),
            initializer: graph.constants,
            input: vec![value(&features, FLOAT, inputs, &reported(&file.inputs))],
            output: vec![
                value("targets", FLOAT, outputs, &reported(&file.targets)),
                value("in_range", BOOL, inputs, "whether the training rows covered each feature"),
            ],
        }),
        metadata_props: metadata(file, origin),
    };
    Ok(message.encode_to_vec())
}

#[derive(Debug, Default)]
struct Graph {
    nodes: Vec<NodeProto>,
    constants: Vec<TensorProto>,
}

impl Graph {
    /// Adds an operation and returns the name of its output, which is also that of the operation.
    fn node(&mut self, operator: &str, inputs: &[&str], output: &str) -> String {
        self.nodes.push(NodeProto {
            input: inputs.iter().map(ToString::to_string).collect(),
            output: vec![output.to_owned()],
            name: format!("{output}_{}", operator.to_lowercase()),
            op_type: operator.to_owned(),
            attribute: Vec::new(),
        });
        output.to_owned()
    }

    fn floats(&mut self, name: &str, dims: &[usize], values: &[f32]) -> String {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.constant(name, dims, FLOAT, bytes)
    }

    fn constant(&mut self, name: &str, dims: &[usize], kind: i32, bytes: Vec<u8>) -> String {
        self.constants.push(TensorProto {
            dims: dims.iter().map(|&length| integer(length)).collect(),
            data_type: kind,
            name: name.to_owned(),
            raw_data: bytes,
        });
        name.to_owned()
    }

    fn range(&mut self, columns: &[FileColumn]) {
        let dims = [1, columns.len()];
        let lowest: Vec<f32> = columns.iter().map(|column| rounded(column.min)).collect();
        let highest: Vec<f32> = columns.iter().map(|column| rounded(column.max)).collect();
        let lowest = self.floats("lowest", &dims, &lowest);
        let highest = self.floats("highest", &dims, &highest);
        self.node("GreaterOrEqual", &["features", &lowest], "not_below");
        self.node("LessOrEqual", &["features", &highest], "not_above");
        self.node("And", &["not_below", "not_above"], "in_range");
    }

    /// What `all` makes of `current`, in the columns with that transform; nothing is made where there are none.
    fn transform(
        &mut self,
        transform: Transform,
        current: String,
        axes: &[Axis],
        all: impl Fn(&mut Self, &str) -> String,
    ) -> String {
        let mask: Vec<u8> =
            axes.iter().map(|axis| u8::from(axis.column.transform == transform)).collect();
        if !mask.contains(&1) {
            return current;
        }
        let made = all(self, &current);
        if !mask.contains(&0) {
            return made;
        }
        let mask = self.constant(&format!("{made}_mask"), &[1, axes.len()], BOOL, mask);
        self.node("Where", &[&mask, &made, &current], &format!("{made}_some"))
    }

    fn scale(&mut self, features: String, axes: &[Axis]) -> String {
        let current = self.transform(Transform::Ln, features, axes, |graph, current| {
            graph.node("Log", &[current], "features_log")
        });
        let current = self.transform(Transform::Reciprocal, current, axes, |graph, current| {
            let minus = graph.floats("features_minus", &[1, 1], &[-1.0]);
            let made = graph.node("Div", &[&minus, current], "features_negative");
            // Not a number where there is no logarithm, as there.
            let log = graph.node("Log", &[current], "features_positive");
            let none = graph.node("Sub", &[&log, &log], "features_nothing");
            graph.node("Add", &[&made, &none], "features_reciprocal")
        });
        let middle: Vec<f32> = axes.iter().map(|axis| axis.low + axis.half_span).collect();
        let gain: Vec<f32> = axes.iter().map(|axis| axis.gain).collect();
        let middle = self.floats("features_middle", &[1, axes.len()], &middle);
        let gain = self.floats("features_gain", &[1, axes.len()], &gain);
        let current = self.node("Sub", &[&current, &middle], "features_centred");
        self.node("Mul", &[&current, &gain], "features_scaled")
    }

    fn layer(&mut self, number: usize, current: &str, rows: &[Vec<f32>], biases: &[f32]) -> String {
        let flat: Vec<f32> = rows.iter().flatten().copied().collect();
        let from = rows.first().map_or(0, Vec::len);
        let weights = self.floats(&format!("weights_{number}"), &[rows.len(), from], &flat);
        let biases = self.floats(&format!("biases_{number}"), &[biases.len()], biases);
        let output = self.node("Gemm", &[current, &weights, &biases], &format!("sums_{number}"));
        if let Some(gemm) = self.nodes.last_mut() {
            // One row of weights per neuron.
            gemm.attribute.push(AttributeProto { name: "transB".to_owned(), i: 1, kind: 2 });
        }
        output
    }

    fn activate(&mut self, number: usize, current: String, activation: Activation) -> String {
        let operator = match activation {
            Activation::Linear => return current,
            Activation::Tanh => "Tanh",
            Activation::Logistic => "Sigmoid",
            Activation::Relu => "Relu",
        };
        self.node(operator, &[&current], &format!("values_{number}"))
    }

    fn unscale(&mut self, current: &str, axes: &[Axis]) {
        let middle: Vec<f32> = axes.iter().map(|axis| axis.low + axis.half_span).collect();
        let half: Vec<f32> = axes.iter().map(|axis| axis.half_span).collect();
        let half = self.floats("targets_half_range", &[1, axes.len()], &half);
        let middle = self.floats("targets_middle", &[1, axes.len()], &middle);
        let current = self.node("Mul", &[current, &half], "targets_centred");
        let current = self.node("Add", &[&current, &middle], "targets_transformed");
        let current = self.transform(Transform::Ln, current, axes, |graph, current| {
            graph.node("Exp", &[current], "targets_exp")
        });
        let current = self.transform(Transform::Reciprocal, current, axes, |graph, current| {
            let of = |value: fn(f32) -> f32| -> Vec<f32> {
                axes.iter().map(|axis| value(axis.column.noise)).collect()
            };
            let most = graph.floats("targets_most", &[1, axes.len()], &of(|noise| -noise));
            let square =
                graph.floats("targets_noise", &[1, axes.len()], &of(|noise| noise * noise));
            let minus = graph.floats("targets_minus", &[1, 1], &[-1.0]);
            let least = graph.node("Min", &[current, &most], "targets_limited");
            let more = graph.node("Div", &[&square, &least], "targets_shrinking");
            let sum = graph.node("Add", &[&least, &more], "targets_shrunk");
            graph.node("Div", &[&minus, &sum], "targets_reciprocal")
        });
        self.node("Identity", &[&current], "targets");
    }
}

fn integer(length: usize) -> i64 {
    i64::try_from(length).unwrap_or(i64::MAX)
}

/// A matrix of any number of rows.
fn value(name: &str, kind: i32, columns: usize, what: &str) -> ValueInfoProto {
    let dim = |length| Dimension { value: Some(length) };
    let dim = vec![dim(Length::Name("N".to_owned())), dim(Length::Value(integer(columns)))];
    let tensor = TensorType { elem_type: kind, shape: Some(TensorShapeProto { dim }) };
    ValueInfoProto {
        name: name.to_owned(),
        r#type: Some(TypeProto { tensor_type: Some(tensor) }),
        doc_string: what.to_owned(),
    }
}

/// Names, units and ranges in words.
fn reported(columns: &[FileColumn]) -> String {
    let report = |column: &FileColumn| {
        format!("{} [{}] {} to {}", column.name, column.unit, column.min, column.max)
    };
    columns.iter().map(report).collect::<Vec<_>>().join("; ")
}

/// Columns and training note as JSON texts, as they stand in the model file.
fn metadata(file: &ModelFile, origin: &str) -> Vec<StringStringEntryProto> {
    let entry = |key: &str, value: String| StringStringEntryProto { key: key.to_owned(), value };
    let mut entries = vec![
        entry("origin", origin.to_owned()),
        entry("inputs", json!(file.inputs).to_string()),
        entry("targets", json!(file.targets).to_string()),
    ];
    entries.extend(file.classes.iter().map(|column| entry("classes", column.clone())));
    if let Some(note) = &file.training {
        entries.push(entry("training", json!(note).to_string()));
    }
    entries
}

#[cfg(test)]
mod tests;
