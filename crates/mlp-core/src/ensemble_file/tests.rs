//! Round trips, refusals and common ranges of ensembles.

use super::*;
use crate::model::{Estimate, Transform};

/// `f = 2^x` within `min` to `max` of x, by a network that is the identity of scaled values.
fn member(min: f32, max: f32) -> ModelFile {
    let text = format!(
        r#"{{ "format": "mlp-model", "version": 1,
          "inputs": [{{ "name": "x", "unit": "", "transform": "identity", "min": {min:?}, "max": {max:?} }},
                     {{ "name": "c", "unit": "", "transform": "identity", "min": 3.0, "max": 3.0 }}],
          "targets": [{{ "name": "f_n", "unit": "N", "transform": "ln", "min": {:?}, "max": {:?} }}],
          "layers": [
            {{ "activation": "relu", "weights": [[1.0, 5.0], [-1.0, 0.0]], "biases": [0.0, 0.0] }},
            {{ "activation": "linear", "weights": [[1.0, -1.0]], "biases": [0.0] }}
          ],
          "training": null }}"#,
        min.exp2(),
        max.exp2()
    );
    ModelFile::from_json(&text).unwrap()
}

fn ensemble() -> EnsembleFile {
    EnsembleFile::new(vec![member(0.0, 2.0), member(1.0, 3.0), member(0.5, 1.5)]).unwrap()
}

#[test]
fn a_file_comes_back_as_it_was() {
    let text = ensemble().to_json().unwrap();
    assert!(is_ensemble(&text) && !is_ensemble("{}") && !is_ensemble("{"));
    assert_eq!(EnsembleFile::from_json(&text).unwrap(), ensemble());
    assert!(!is_ensemble(&member(0.0, 1.0).to_json().unwrap()));
    let interval = Interval { level: 0.9, widths: vec![1.2], from: "10 parts".to_owned() };
    let with = EnsembleFile { interval: Some(interval), ..ensemble() };
    let text = with.to_json().unwrap();
    assert_eq!(EnsembleFile::from_json(&text).unwrap(), with);
    let error = EnsembleFile::from_json(&text.replace("0.9", "1.9")).unwrap_err();
    assert_eq!(error, FileError::Interval);
}

#[test]
fn reciprocal_targets_share_the_mean_of_their_noise() {
    let members = [0.1, 0.3].map(|noise| {
        let mut file = member(0.0, 2.0);
        (file.targets[0].transform, file.targets[0].noise) = (Transform::Reciprocal, noise);
        file
    });
    let both = EnsembleFile::new(members.to_vec()).unwrap();
    assert_eq!(EnsembleFile::from_json(&both.to_json().unwrap()).unwrap(), both);
    assert!(both.aligned().iter().all(|file| (file.targets[0].noise - 0.2).abs() < 1e-6));
}

#[test]
fn common_ranges_change_no_answer() {
    let own = ensemble().members().to_vec();
    let aligned = ensemble().aligned();
    for (own, common) in own.iter().zip(&aligned) {
        let x = &common.inputs[0];
        assert_eq!((x.min, x.max, common.inputs[1].min), (0.0, 3.0, 3.0));
        assert_eq!((common.targets[0].min, common.targets[0].max), (1.0, 8.0));
        let (own, common) = (own.model().unwrap(), common.model().unwrap());
        for x in [-0.7, 0.3, 1.0, 2.6] {
            let [a, b]: [Estimate; 2] = [&own, &common].map(|m| m.estimate(&[x, 3.0]).unwrap());
            assert!((a.value / x.exp2() - 1.0).abs() < 1e-5, "{a:?} at {x}");
            assert!((b.value / a.value - 1.0).abs() < 1e-5, "{a:?} {b:?} at {x}");
            assert_eq!(b.extrapolated, x < 0.0, "only what no member saw is outside");
        }
    }
}

#[test]
fn what_is_no_ensemble_is_refused() {
    assert_eq!(EnsembleFile::new(Vec::new()), Err(FileError::NoMembers));
    let mut other = member(0.0, 1.0);
    other.inputs[0].name = "y".to_owned();
    let error = EnsembleFile::new(vec![member(0.0, 1.0), other]).unwrap_err();
    assert_eq!(error, FileError::Member { member: 2 });
    assert!(error.to_string().contains("member 2"), "{error}");
    let text = ensemble().to_json().unwrap();
    for (from, to) in [
        ("ensemble-model", "mlp-model"),
        ("\"version\": 1", "\"version\": 2"),
        ("\"transform\": \"ln\"", "\"transform\": \"log\""),
        ("\"activation\": \"relu\"", "\"activation\": \"sine\""),
    ] {
        assert!(text.contains(from), "{from}");
        assert!(EnsembleFile::from_json(&text.replacen(from, to, 1)).is_err(), "{from}");
    }
    assert!(
        EnsembleFile::from_json(r#"{"format":"ensemble-model","version":1,"members":[]}"#).is_err()
    );
}
