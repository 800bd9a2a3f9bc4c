//! Ensembles of networks that compute known functions, and their deviations.

use super::{Estimator, EstimatorError, ForceEstimate, G_M_S2, NoEstimate};
use super::{Feature, Features};
use mlp_core::{Activation, Column, Model, Network, Scaler, Transform};

type Weights = &'static [f32];

/// A network that answers `slope` times the trial force, which it knows from -2 to 10 N.
fn times(weights: Weights) -> Model<Weights> {
    let column = Column::new(Transform::Identity, -10.0, 10.0);
    ranged(weights, column)
}

fn ranged(weights: Weights, column: Column) -> Model<Weights> {
    let network = Network::new(&[1, 1], &[Activation::Linear], weights).unwrap();
    let scaler = Scaler::new(&[column]).unwrap();
    Model::new(network, scaler.clone(), scaler).unwrap()
}

fn pressed(trial_force_n: f32) -> Features {
    Features {
        slip_speed_m_s: 0.1,
        contact_time_s: 0.01,
        slip_acceleration_m_s2: 0.5 * G_M_S2,
        slip_acceleration_sigma_m_s2: Some(0.05 * G_M_S2),
        micro_displacement_m: 1e-3,
        trial_force_n,
        irregularities: 0,
        mean_slope: None,
        esc: None,
        esc_chosen: None,
    }
}

fn ensemble() -> Estimator<Weights> {
    Estimator::new(times(&[1.0, 0.0]), &[Feature::TrialForce])
        .unwrap()
        .with_member(times(&[1.5, 0.0]))
        .unwrap()
        .with_member(times(&[0.8, 0.0]))
        .unwrap()
}

#[test]
fn the_answer_is_the_mean_and_the_deviation_that_between_the_networks() {
    let estimate = ensemble().estimate(&pressed(2.0)).unwrap();
    assert!((estimate.force_n - 2.2).abs() < 1e-5, "{estimate:?}");
    // 2, 3 and 1.6 N: deviations -0.2, 0.8 and -0.6, variance 1.04 / 2.
    assert!((estimate.sigma_n - 0.52_f32.sqrt()).abs() < 1e-5, "{estimate:?}");
    assert_eq!(ensemble().members(), 3);
    let alone = Estimator::new(times(&[1.0, 0.0]), &[Feature::TrialForce]).unwrap();
    assert_eq!(alone.estimate(&pressed(2.0)).unwrap().sigma_n, 0.0);
}

#[test]
fn what_the_networks_missed_by_is_added_to_what_they_differ_by() {
    let off = ensemble().with_deviation(0.1, 0.3);
    assert_eq!(off.deviation(), (0.1, 0.3));
    let estimate = off.estimate(&pressed(2.0)).unwrap();
    let wanted = (0.52_f32 + 0.22 * 0.22 + 0.09).sqrt();
    assert!((estimate.sigma_n - wanted).abs() < 1e-5, "{estimate:?}");
    assert_eq!(ensemble().with_deviation(f32::NAN, -1.0).deviation(), (0.0, 0.0));
}

#[test]
fn the_noise_of_the_travel_sensor_counts_where_the_acceleration_is_an_input() {
    let features = [Feature::SlipAcceleration];
    let estimator = Estimator::new(times(&[1.0, 0.0]), &features).unwrap();
    let estimate = estimator.estimate(&pressed(2.0)).unwrap();
    assert!((estimate.sigma_n / estimate.force_n - 0.1).abs() < 1e-5, "0.05 g of 0.5 g left");
}

#[test]
fn an_interval_is_stated_within_the_known_range_and_widened_by_the_noise_of_the_sensor() {
    let features = [Feature::TrialForce];
    let plain = Estimator::new(times(&[1.0, 0.0]), &features).unwrap();
    let limits = |estimator: &Estimator<Weights>, force_n: f32| {
        estimator.estimate(&pressed(force_n)).unwrap().limits_n
    };
    assert_eq!(limits(&plain, 2.0), None);
    assert_eq!(limits(&plain.clone().with_interval(0.5, 1.6), 2.0), Some([1.5, 2.5]));
    assert_eq!(limits(&plain.clone().with_interval(5.0, 1.6), 2.0), Some([0.0, 7.0]));
    assert_eq!(limits(&plain.clone().with_interval(0.5, 1.6), 10.5), None, "extrapolated");
    for (width, sigmas) in [(-0.1, 1.6), (f32::NAN, 1.6), (f32::INFINITY, 1.6), (0.5, f32::NAN)] {
        assert_eq!(limits(&plain.clone().with_interval(width, sigmas), 2.0), None);
    }
    // The acceleration as an input: its noise is 0.1 of the force.
    let features = [Feature::SlipAcceleration];
    let noisy = Estimator::new(times(&[1.0, 0.0]), &features).unwrap().with_interval(0.3, 2.0);
    let estimate = noisy.estimate(&pressed(2.0)).unwrap();
    let size_n = 0.3_f32.hypot(0.2 * estimate.force_n);
    let [low_n, high_n] = estimate.limits_n.unwrap();
    assert!((low_n - (estimate.force_n - size_n)).abs() < 1e-5, "{estimate:?}");
    assert!((high_n - (estimate.force_n + size_n)).abs() < 1e-5, "{estimate:?}");
}

#[test]
fn the_interval_of_a_logarithmic_target_is_a_factor() {
    let column = Column::new(Transform::Ln, 0.5, 8.0);
    let model = ranged(&[1.0, 0.0], column);
    let estimator = Estimator::new(model, &[Feature::TrialForce]).unwrap();
    let estimate = estimator.with_interval(1.25, 1.6).estimate(&pressed(2.0)).unwrap();
    let [low_n, high_n] = estimate.limits_n.unwrap();
    assert!((low_n - 1.6).abs() < 1e-5 && (high_n - 2.5).abs() < 1e-5, "{estimate:?}");
}

#[test]
fn an_answer_that_is_unsure_or_a_guess_is_not_trusted() {
    let sure = ForceEstimate { limits_n: Some([0.1, 90.0]), ..ForceEstimate::new(4.0, 2.0) };
    assert!(sure.is_trusted(), "an interval moves nothing");
    assert!(!ForceEstimate { sigma_n: 2.01, ..sure }.is_trusted());
    assert!(!ForceEstimate { sigma_n: f32::NAN, ..sure }.is_trusted());
    assert!(!ForceEstimate { extrapolated: true, ..sure }.is_trusted());
    let beyond = ensemble().estimate(&pressed(10.5)).unwrap();
    assert!(beyond.extrapolated && !beyond.is_trusted(), "{beyond:?}");
    assert!(!ensemble().estimate(&pressed(9.5)).unwrap().extrapolated);
}

#[test]
fn networks_that_do_not_belong_together_are_refused() {
    let narrow = Column::new(Transform::Identity, -1.0, 1.0);
    let other = ensemble().with_member(ranged(&[1.0, 0.0], narrow)).unwrap_err();
    assert_eq!(other, EstimatorError::Ranges);
    let full = ensemble().with_member(times(&[1.0, 0.0])).unwrap();
    assert_eq!(full.with_member(times(&[1.0, 0.0])).unwrap_err(), EstimatorError::Members);
    let refused = ensemble().estimate(&pressed(-2.0)).unwrap_err();
    assert!(matches!(refused, NoEstimate::NotPositive(_)), "{refused}");
}
