use super::*;
use crate::activation::Activation;
use crate::model::{Column, Transform};
use proptest::prelude::*;

/// Linear in ln(x0) and x1: scaled target = (scaled x0 + scaled x1) / 2.
fn mean_model() -> Model<[f32; 3]> {
    let network = Network::new(&[2, 1], &[Activation::Linear], [0.5, 0.5, 0.0]).unwrap();
    let inputs = Scaler::new(&[
        Column::new(Transform::Ln, 0.01, 1.0),
        Column::new(Transform::Identity, -2.0, 2.0),
    ])
    .unwrap();
    let targets = Scaler::new(&[Column::new(Transform::Identity, 0.0, 10.0)]).unwrap();
    Model::new(network, inputs, targets).unwrap()
}

#[test]
fn raw_features_give_a_raw_estimate() {
    let estimate = mean_model().estimate(&[0.1, 1.0]).unwrap();
    assert!((estimate.value - 6.25).abs() < 1e-5, "{estimate:?}");
    assert!(!estimate.extrapolated);
}

#[test]
fn extrapolation_is_reported_and_not_clamped() {
    let model = mean_model();
    let mut out = [0.0];
    let coverage = model.predict(&[0.1, 4.0], &mut out).unwrap();
    assert_eq!(coverage, Coverage::Outside { column: 1 });
    assert!((out[0] - 10.0).abs() < 1e-5, "{out:?}");
    assert!(model.estimate(&[2.0, 0.0]).unwrap().extrapolated);
}

#[test]
fn what_can_not_be_predicted_is_an_error() {
    let model = mean_model();
    let estimate = |raw: &[f32]| model.estimate(raw).unwrap_err();
    assert_eq!(estimate(&[f32::NAN, 0.0]), PredictError::NotFinite { column: 0 });
    assert_eq!(estimate(&[0.1, f32::INFINITY]), PredictError::NotFinite { column: 1 });
    assert_eq!(estimate(&[-1.0, 0.0]), PredictError::OutOfDomain { column: 0, value: -1.0 });
    assert_eq!(estimate(&[0.1]), ShapeError::Inputs { needed: 2, given: 1 }.into());
    assert_eq!(estimate(&[0.1, f32::MAX]), PredictError::Overflow { target: 0 });
}

/// Offsets at which `f32` loses the range: rows in double precision keep it, of samples it is stated that they do not.
#[test]
fn rows_in_double_precision_may_be_large_against_their_range() {
    let network = Network::new(&[1, 1], &[Activation::Linear], [1.0, 0.0]).unwrap();
    let scaler =
        |min: f64, max| Scaler::new(&[Column::new(Transform::Identity, min, max)]).unwrap();
    let model = Model::new(network, scaler(1e6 - 1e-3, 1e6 + 1e-3), scaler(1e9, 1e9 + 3.0));
    let model = model.unwrap();
    let mut out = [0.0];
    for (raw, wanted) in [(-1e-3, 0.0), (0.0, 1.5), (5e-4, 2.25), (1e-3, 3.0)] {
        assert_eq!(model.predict_double(&[1e6 + raw], &mut out), Ok(Coverage::Inside), "{raw}");
        assert!((out[0] - 1e9 - wanted).abs() < 1e-6, "{raw}: {out:?}");
    }
    let outside = Ok(Coverage::Outside { column: 0 });
    assert_eq!(model.predict_double(&[1e6 + 2e-3], &mut out), outside);
    let columns = || model.inputs().columns().chain(model.targets().columns());
    assert!(columns().all(|column| column.is_constant_in_single()));
    let mut single = [0.0];
    assert_eq!(model.predict(&[1e6], &mut single), Ok(Coverage::Inside));
    assert_eq!(single, [1e9]);
    let normal = mean_model();
    normal.predict(&[0.1, 1.0], &mut single).unwrap();
    normal.predict_double(&[0.1, 1.0], &mut out).unwrap();
    assert!((out[0] - f64::from(single[0])).abs() < 1e-5, "{out:?} {single:?}");
    assert_eq!(
        normal.predict_double(&[-1.0, 0.0], &mut out),
        Err(PredictError::OutOfDomain { column: 0, value: -1.0 })
    );
    for raw in [f64::NAN, 1e300] {
        let refused = normal.predict_double(&[raw, 0.0], &mut out);
        assert_eq!(refused, Err(PredictError::NotFinite { column: 0 }));
    }
}

#[test]
fn estimate_wants_a_single_target() {
    let network = Network::new(&[1, 2], &[Activation::Linear], [1.0; 4]).unwrap();
    let column = Column::new(Transform::Identity, 0.0, 1.0);
    let (one, two) = (Scaler::new(&[column]).unwrap(), Scaler::new(&[column; 2]).unwrap());
    let model = Model::new(network.clone(), one.clone(), two).unwrap();
    assert_eq!(model.estimate(&[0.5]), Err(ShapeError::Outputs { needed: 2, given: 1 }.into()));
    assert_eq!(
        Model::new(network, one.clone(), one),
        Err(ShapeError::Outputs { needed: 2, given: 1 })
    );
}

proptest! {
    #[test]
    fn finite_weights_and_any_features_give_a_finite_estimate_or_an_error(
        weights in prop::collection::vec(prop::num::f32::NORMAL | prop::num::f32::ZERO, 9),
        raw in prop::collection::vec(prop::num::f32::ANY, 2),
    ) {
        let activations = [Activation::Tanh, Activation::Linear];
        let network = Network::new(&[2, 2, 1], &activations, weights).unwrap();
        let Model { inputs, targets, .. } = mean_model();
        let model = Model::new(network, inputs, targets).unwrap();
        if let Ok(estimate) = model.estimate(&raw) {
            prop_assert!(estimate.value.is_finite());
        }
    }
}

mod scaler {
    use super::super::*;
    use proptest::prelude::*;

    fn one(transform: Transform, min: f32, max: f32) -> Result<Axis, ScaleError> {
        let scaler: Scaler = Scaler::new(&[Column::new(transform, min.into(), max.into())])?;
        Ok(scaler.axes()[0])
    }

    #[test]
    fn limits_become_minus_one_and_one() {
        for (transform, min, max) in [
            (Transform::Identity, -3.0, 5.0),
            (Transform::Ln, 0.01_f32, 100.0),
            (Transform::Reciprocal, 0.5, 8.0),
        ] {
            let axis = one(transform, min, max).unwrap();
            assert_eq!(axis.scaled(min), Some(-1.0));
            assert!((axis.scaled(max).unwrap() - 1.0).abs() < 1e-6);
            assert!((axis.raw(-1.0) / min - 1.0).abs() < 1e-6);
            assert!((axis.raw(1.0) / max - 1.0).abs() < 1e-6);
        }
        let decades = one(Transform::Ln, 0.01, 100.0).unwrap();
        assert!(decades.scaled(1.0).unwrap().abs() < 1e-6, "the middle of four decades");
    }

    /// By summing over the bell curve, cut off far from 0.
    #[test]
    fn a_reciprocal_comes_back_as_the_answer_of_least_relative_error() {
        let reciprocal = Transform::Reciprocal;
        for (u, noise) in [(0.4, 0.0_f32), (0.4, 0.01), (0.4, 0.1), (2.0, 0.5)] {
            let s = f64::from(noise);
            let mean = |power: i32| -> f64 {
                let at = |step: i32| u + s * f64::from(step) / 100.0;
                let weight = |step: i32| libm::exp(-0.5e-4 * f64::from(step * step));
                let sum = |of: &dyn Fn(i32) -> f64| (-390..=390).map(of).sum::<f64>();
                sum(&|step| weight(step) * at(step).powi(power)) / sum(&weight)
            };
            let (answer, wanted) = (reciprocal.inverse(-u, noise), mean(1) / mean(2));
            assert!((answer / wanted - 1.0).abs() < 1e-3, "{u} {s}: {answer} {wanted}");
            let single = f64::from(reciprocal.inverse(rounded(-u), noise));
            assert!((single / answer - 1.0).abs() < 1e-6, "{u} {s}: {single} {answer}");
        }
        // Where nothing is left the answer is the greatest; without noise there is none.
        let answers = [-0.25_f64, -0.125, 0.0, 7.0].map(|z| reciprocal.inverse(z, 0.125));
        assert!((answers[0] - 3.2).abs() < 1e-12);
        assert!(answers[1..].iter().all(|answer| (answer - 4.0).abs() < 1e-12), "{answers:?}");
        assert_eq!(reciprocal.inverse(-1e-30_f32, 0.0), 1e30);
        assert!([0.0_f32, 2.0].iter().all(|z| !reciprocal.inverse(*z, 0.0).is_finite()));
    }

    #[test]
    fn a_constant_column_becomes_zero_and_comes_back() {
        for transform in Transform::ALL {
            let axis = one(transform, 0.3, 0.3).unwrap();
            assert_eq!(axis.scaled(17.0), Some(0.0));
            assert_eq!(axis.raw(0.7), 0.3);
            assert!(axis.covers(0.3) && !axis.covers(0.31));
        }
    }

    #[test]
    fn the_logarithm_of_what_is_not_positive_is_refused() {
        let axis = one(Transform::Ln, 0.1, 1.0).unwrap();
        for raw in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(axis.scaled(raw), None, "{raw}");
        }
        assert!(matches!(
            one(Transform::Ln, 0.0, 1.0),
            Err(ScaleError::LogOfNonPositive { column: 0, .. })
        ));
    }

    #[test]
    fn ranges_a_float_can_not_scale_are_refused() {
        for (min, max) in [(1.0, 0.0), (f32::NAN, 1.0), (0.0, f32::INFINITY), (0.0, 1e-44)] {
            let error = one(Transform::Identity, min, max).unwrap_err();
            assert!(matches!(error, ScaleError::Limits { column: 0, .. }), "{min}..{max}: {error}");
        }
        assert!(one(Transform::Identity, f32::MIN, f32::MAX).is_err());
        for noise in [-1.0, f32::NAN, f32::INFINITY] {
            let column = Column { noise, ..Column::new(Transform::Reciprocal, 1.0, 2.0) };
            let error = Scaler::new(&[column]).unwrap_err();
            assert!(matches!(error, ScaleError::Noise { column: 0, .. }), "{noise}: {error}");
        }
        assert_eq!(Scaler::new(&[]), Err(ScaleError::Columns { given: 0, limit: 16 }));
        let column = Column::new(Transform::Identity, 0.0, 1.0);
        assert_eq!(Scaler::new(&[column; 17]), Err(ScaleError::Columns { given: 17, limit: 16 }));
    }

    proptest! {
        #[test]
        fn scaling_and_back_returns_the_value(
            min in -1e6_f32..1e6,
            span in 1e-3_f32..1e6,
            place in 0.0_f32..1.0,
        ) {
            let max = min + span;
            prop_assume!(max > min);
            let axis = one(Transform::Identity, min, max).unwrap();
            let raw = min + place * (max - min);
            let back = axis.raw(axis.scaled(raw).unwrap());
            // Two roundings at the size of the span, one at the size of the limits.
            let bound = 4.0 * f32::EPSILON * (min.abs().max(max.abs()) + (max - min));
            prop_assert!((back - raw).abs() <= bound, "{} -> {}", raw, back);
        }

        #[test]
        fn any_value_scales_to_a_number_or_none(
            min in prop::num::f32::ANY,
            max in prop::num::f32::ANY,
            raw in prop::num::f32::ANY,
        ) {
            for transform in Transform::ALL {
                if let Ok(axis) = one(transform, min, max) {
                    prop_assert!(axis.scaled(raw).is_none_or(|scaled| !scaled.is_nan()));
                }
            }
        }
    }
}
