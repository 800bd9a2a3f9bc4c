//! Round trips and refusals of model files.

use super::*;

const TEXT: &str = r#"{
  "format": "mlp-model", "version": 1,
  "inputs": [{ "name": "v_m_s", "unit": "m/s", "transform": "identity", "min": 0.0, "max": 2.0 }],
  "targets": [{ "name": "f_n", "unit": "N", "transform": "ln", "min": 1.0, "max": 4.0 }],
  "layers": [
    { "activation": "relu", "weights": [[1.0], [-1.0]], "biases": [0.0, 0.0] },
    { "activation": "linear", "weights": [[1.0, -1.0]], "biases": [0.0] }
  ],
  "training": null
}"#;

fn refusal(from: &str, to: &str) -> FileError {
    assert!(TEXT.contains(from), "{from}");
    ModelFile::from_json(&TEXT.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn the_documented_text_is_a_model() {
    let model = ModelFile::from_json(TEXT).unwrap().model().unwrap();
    // The network is the identity: the middle of the range is the geometric mean of the targets.
    let estimate = model.estimate(&[1.0]).unwrap();
    assert!((estimate.value - 2.0).abs() < 1e-6, "{estimate:?}");
}

#[test]
fn weights_come_back_bit_for_bit() {
    let mut file = ModelFile::from_json(TEXT).unwrap();
    let mut bits = 1_u32;
    for value in file.layers.iter_mut().flat_map(|l| l.weights.iter_mut().flatten()) {
        bits = bits.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        *value = f32::from_bits(bits & 0xBF7F_FFFF);
    }
    file.layers[0].biases = vec![f32::MAX, 1e-45];
    file.layers[1].biases = vec![-0.1];
    let again = ModelFile::from_json(&file.to_json().unwrap()).unwrap();
    assert_eq!(again, file);
    let bits = |file: &ModelFile| {
        file.model().unwrap().network().weights().iter().map(|w| w.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(&again), bits(&file));
}

#[test]
fn syntax_errors_have_line_and_column() {
    let error = refusal("[[1.0], [-1.0]]", "[[1.0], [NaN]]");
    assert!(matches!(error, FileError::Json { line: 6, column: 49, .. }), "{error:?}");
    let error = ModelFile::from_json(&TEXT[..TEXT.len() - 3]).unwrap_err();
    assert!(matches!(error, FileError::Json { line: 9, .. }), "{error:?}");
    assert!(matches!(ModelFile::from_json(""), Err(FileError::Json { .. })));
}

#[test]
fn other_formats_and_versions_are_named() {
    let error = refusal("mlp-model", "onnx");
    assert_eq!(error.to_string(), "format is Some(\"onnx\"), not \"mlp-model\"");
    let error = refusal("\"version\": 1", "\"version\": 2");
    assert_eq!(error, FileError::Version { found: Some(2) });
    assert!(matches!(ModelFile::from_json("{}"), Err(FileError::Format { found: None })));
}

#[test]
fn weights_that_are_no_finite_floats_are_refused() {
    for text in ["null", "1e999", "-1e39", "\"x\""] {
        let error = refusal("[[1.0], [-1.0]]", &format!("[[1.0], [{text}]]"));
        assert!(matches!(error, FileError::Json { line: 6, .. }), "{text}: {error:?}");
    }
    let error = refusal("[[1.0], [-1.0]]", "[[1.0], [1e999]]");
    assert_eq!(error.to_string(), "line 6, column 53: number out of range");
}

#[test]
fn shapes_that_do_not_fit_are_named() {
    for (from, to, message) in [
        ("[[1.0, -1.0]]", "[[1.0]]", "layer 2: 1 weights of neuron 1 where 2 are needed"),
        ("[0.0, 0.0]", "[0.0]", "layer 1: 1 biases where 2 are needed"),
    ] {
        assert_eq!(refusal(from, to).to_string(), message);
    }
    assert_eq!(
        refusal("[[1.0, -1.0]], \"biases\": [0.0]", "[], \"biases\": []"),
        FileError::Shape(ShapeError::Width { layer: 2, given: 0, limit: 1024 })
    );
}

#[test]
fn columns_that_can_not_be_scaled_are_named() {
    let error = refusal("\"min\": 1.0", "\"min\": 0.0");
    assert!(error.to_string().starts_with("target \"f_n\": "), "{error}");
    let error = refusal("\"max\": 4.0", "\"max\": 4.0, \"noise\": -0.5");
    let wanted = "target \"f_n\": column 0: its noise is -0.5: it must be 0 or a positive number";
    assert_eq!(error.to_string(), wanted);
    let error = refusal("\"ln\"", "\"log\"");
    assert!(matches!(error, FileError::Json { line: 4, .. }), "{error:?}");
    assert!(
        error.to_string().contains("unknown variant `log`, expected one of `identity`"),
        "{error}"
    );
    let error = refusal("\"relu\"", "\"gelu\"");
    assert!(
        error.to_string().contains("unknown variant `gelu`, expected one of `tanh`"),
        "{error}"
    );
}

#[test]
fn a_model_with_overflowing_weights_is_not_saved() {
    let topology = Topology::regression(1, &[1], 1).unwrap();
    let column = ModelFile::from_json(TEXT).unwrap().inputs;
    let file = ModelFile::new(&column, &column, &topology, &[1.0, 2.0, 1e60, 4.0]);
    assert_eq!(file.to_json(), Err(ShapeError::NotFinite { index: 2 }.into()));
}

/// A network of `inputs`, 3 and as many outputs as there are `targets`.
fn sized(inputs: usize, targets: usize) -> ModelFile {
    let topology = Topology::regression(inputs, &[3], targets).unwrap();
    let columns = |kind: &str, count: usize| -> Vec<FileColumn> {
        let column = |at: usize| FileColumn {
            name: format!("{kind}{at}"),
            unit: String::new(),
            transform: Transform::Identity,
            min: -1.0,
            max: 1.0,
            noise: 0.0,
        };
        (0..count).map(column).collect()
    };
    let weights = vec![0.01; topology.weights()];
    ModelFile::new(&columns("x", inputs), &columns("y", targets), &topology, &weights)
}

#[test]
fn large_models_are_read_and_refused_where_memory_is_fixed() {
    let file = sized(1024, 64);
    let again = ModelFile::from_json(&file.to_json().unwrap()).unwrap();
    assert_eq!(again, file);
    let mut out = [0.0; 64];
    again.large_model().unwrap().predict(&[1.0; 1024], &mut out).unwrap();
    assert!(out.iter().all(|y| (0.03..0.05).contains(y)), "{out:?}");
    for (file, message) in [
        (file, "layer 0 has 1024 neurons: it may have 1 to 64"),
        (sized(17, 1), "input: 17 columns: 1 to 16 are possible"),
    ] {
        assert_eq!(file.model().unwrap_err().to_string(), message);
    }
    assert!(Topology::regression(1025, &[3], 1).is_err());
    assert!(Topology::regression(1, &[3], 65).is_err());
    assert!(sized(16, 1).model().is_ok());
}

#[test]
fn noise_is_written_where_answers_need_it_and_may_be_missing() {
    let mut file = sized(2, 1);
    file.targets[0].min = 0.5;
    for transform in Transform::ALL {
        file.targets[0].transform = transform;
        file.targets[0].set_noise(0.04);
        let text = file.to_json().unwrap();
        let reciprocal = transform == Transform::Reciprocal;
        assert_eq!(text.contains("noise"), reciprocal, "files of other forms stay as they were");
        assert_eq!(ModelFile::from_json(&text).unwrap(), file);
    }
    assert!((file.targets[0].noise - 0.1).abs() < 1e-6, "a fifth of half the span from 1 to 2");
    let without = file.to_json().unwrap().replace("\"noise\": 0.1", "\"about\": 0.1");
    assert_eq!(ModelFile::from_json(&without).unwrap().targets[0].noise, 0.0);
}

#[test]
fn a_reciprocal_states_the_deviation_of_its_largest_answer() {
    let mut file = sized(2, 1);
    let target = &mut file.targets[0];
    (target.transform, target.min, target.max) = (Transform::Reciprocal, 1.0, 20.0);
    file.training = Some(TrainingNote { train_scaled_mse: 1e-4, ..TrainingNote::default() });
    // 1/f off by a hundredth of half the span of 0.95: 9.5 % of 20.
    let Some(Deviation::Relative(share)) = file.deviation() else { panic!("no share") };
    assert!((share - 0.095).abs() < 1e-6, "{share}");
}

#[test]
fn a_classifier_estimates_no_number() {
    let mut file = sized(2, 3);
    assert!(!file.to_json().unwrap().contains("classes"), "files of estimators stay as they were");
    file.classes = Some("direction".to_owned());
    let again = ModelFile::from_json(&file.to_json().unwrap()).unwrap();
    assert_eq!(again, file);
    assert_eq!(again.model().unwrap_err(), FileError::Classifier { classes: 3 });
}

#[test]
fn an_interval_is_kept_and_refused_where_it_can_not_hold() {
    let mut file = sized(2, 2);
    assert!(!file.to_json().unwrap().contains("interval"));
    file.targets[1].transform = Transform::Ln;
    file.targets[1].min = 0.5;
    let interval = |level: f64, widths: &[f32]| {
        Some(Interval { level, widths: widths.to_vec(), from: "10 parts of 100 rows".to_owned() })
    };
    file.interval = interval(0.9, &[0.0, 1.5]);
    assert_eq!(ModelFile::from_json(&file.to_json().unwrap()).unwrap(), file);
    assert_eq!(Interval::around(Transform::Identity, 0.5, 3.0), [2.5, 3.5]);
    assert_eq!(Interval::around(Transform::Ln, 1.5, 3.0), [2.0, 4.5]);
    assert_eq!(Interval::around(Transform::Reciprocal, 1.5, 3.0), [2.0, 4.5]);
    for (level, widths) in [
        (0.0, &[0.1, 1.5][..]),
        (1.0, &[0.1, 1.5]),
        (f64::NAN, &[0.1, 1.5]),
        (0.9, &[0.1]),
        (0.9, &[-0.1, 1.5]),
        (0.9, &[0.1, 0.9]),
        (0.9, &[f32::INFINITY, 1.5]),
    ] {
        file.interval = interval(level, widths);
        assert_eq!(file.to_json(), Err(FileError::Interval), "{level} {widths:?}");
    }
}
