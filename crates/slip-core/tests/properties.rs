//! Whatever the sensors send, the steps stay finite and the command stays within its limits.
#![expect(clippy::unwrap_used, reason = "test code")]

use proptest::prelude::*;
use slip_core::{
    Phase, Pipeline, PipelineConfig, Sample,
    grip::{GripConfig, GripController, GripInput, GripState, SlipNow},
    load::Forecast,
    units::{Hertz, Micros},
};

type Bare = Pipeline<&'static [f32]>;

fn any_reading() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -1e-5_f32..1e-5,
        2 => -1e-2_f32..1e-2,
        1 => any::<f32>(),
        1 => prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, 0.0, -0.0, 1e-42]),
    ]
}

fn any_sample() -> impl Strategy<Value = Sample> {
    let channel = || prop::option::of(prop_oneof![3 => 0.0_f32..30.0, 1 => any_reading()]);
    let reference = prop::option::of(any_reading());
    let motion = prop::option::of(prop::sample::select(vec![0.0_f32, 0.0, 0.0, 1.0, f32::NAN]));
    let others = (channel(), channel(), reference, motion);
    (any_reading(), channel(), channel(), channel(), 0_u64..400, others).prop_map(
        |(stylus, force, travel, speed, dt, (second, tangential, reference, motion))| Sample {
            t: Micros(dt),
            stylus,
            normal_force_n: force,
            travel_m: travel,
            velocity_m_s: speed,
            second_stylus: second,
            tangential_n: tangential,
            reference,
            motion,
            ..Sample::default()
        },
    )
}

/// Whatever a posterior states, and what none does.
fn any_forecast() -> impl Strategy<Value = Forecast> {
    let number = || prop_oneof![4 => 0.0_f32..60.0, 1 => any_reading(), 1 => any::<f32>()];
    let forces = [(); 6].map(|()| number());
    (any::<[bool; 8]>(), forces, prop::option::of(number()), 0_u32..4).prop_map(
        |(
            [slips, moves, unexplained, informed, trusted, known, by_stylus, far],
            forces,
            held_n,
            slips_seen,
        )| {
            let [from_n, best_n, median_n, whole_low_n, travel_m_s, since_s] = forces;
            Forecast {
                slips,
                moves,
                unexplained,
                informed,
                trusted,
                known,
                by_stylus,
                far,
                from_n,
                best_n,
                median_n,
                whole_low_n,
                travel_m_s,
                since_s,
                whole_n: median_n,
                whole_high_n: median_n,
                speed_m_s: travel_m_s,
                moved_m: held_n,
                held_n,
                slips_seen,
                ..Forecast::default()
            }
        },
    )
}

/// Turns the time steps into times; some are zero.
fn timed(samples: &[Sample], repeat: usize) -> Vec<Sample> {
    let mut t = 0;
    let mut out = Vec::new();
    for _ in 0..repeat {
        for sample in samples {
            t += sample.t.0;
            out.push(Sample { t: Micros(t), ..*sample });
        }
    }
    out
}

/// Steps as text: equal text means the same bits for every finite number, and NaN equals NaN.
fn steps(config: PipelineConfig, samples: &[Sample]) -> String {
    let mut pipeline = Bare::new(config, None).unwrap();
    let mut frames = 0_u8;
    let step = |sample: &Sample| {
        frames = frames.wrapping_add(1);
        // A frame of three taxels with every fifth sample, made of what the other channels show.
        let taxels = [sample.stylus * 1e6, sample.travel_m.unwrap_or(1.0), f32::from(frames % 7)];
        let taxels: &[f32] = if frames.is_multiple_of(5) { &taxels } else { &[] };
        format!("{:?}\n", pipeline.handle_with(sample, taxels))
    };
    samples.iter().map(step).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_samples_give_finite_steps_and_limited_commands(
        samples in prop::collection::vec(any_sample(), 1..200), repeat in 1_usize..40
    ) {
        let config = PipelineConfig::gripping(Hertz(10_000.0));
        let limit = config.grip.unwrap().f_max_n;
        let mut pipeline = Bare::new(config, None).unwrap();
        for sample in timed(&samples, repeat) {
            let step = pipeline.handle(&sample);
            let command = step.command.unwrap().0;
            prop_assert!((0.0..=limit).contains(&command), "{step:?}");
            prop_assert!(step.statistic.is_finite() && step.statistic >= 0.0, "{step:?}");
            if let Some(estimate) = step.estimate {
                prop_assert!(estimate.force_n.is_finite() && estimate.force_n > 0.0, "{estimate:?}");
                prop_assert!(estimate.sigma_n.is_finite() && estimate.sigma_n >= 0.0, "{estimate:?}");
            }
            if let Some(features) = step.features {
                prop_assert!(features.slip_speed_m_s.is_finite() && features.trial_force_n.is_finite());
                prop_assert!(features.slip_acceleration_m_s2.is_finite(), "{features:?}");
                prop_assert!(features.esc.is_none_or(|esc| esc.value.is_finite()));
            }
        }
    }

    #[test]
    fn the_same_samples_give_the_same_steps_with_and_without_skipping(
        samples in prop::collection::vec(any_sample(), 1..200), repeat in 1_usize..40
    ) {
        let config = PipelineConfig::gripping(Hertz(10_000.0));
        let samples = timed(&samples, repeat);
        let once = steps(config, &samples);
        prop_assert_eq!(&once, &steps(config, &samples));
        prop_assert_eq!(&once, &steps(PipelineConfig { no_skip: true, ..config }, &samples));
    }

    #[test]
    fn the_force_rises_only_on_evidence_from_a_good_sensor_and_within_the_slew(
        inputs in prop::collection::vec(
            (
                0_u8..3, prop::option::of(any_reading()), any::<[bool; 2]>(), -1e-3_f32..0.1,
                prop::option::of(any_forecast()), any_reading()
            ),
            1..400
        )
    ) {
        let config = GripConfig::default();
        let mut grip = GripController::new(config);
        grip.grasp(None);
        let mut last = 0.0;
        let (mut stale_s, mut open) = (1.0_f32, true);
        for (slip, moved_m, [healthy, touching], dt_s, forecast, predicted_n) in inputs {
            let slip = [SlipNow::No, SlipNow::Fading, SlipNow::Evident][usize::from(slip)];
            let closing = grip.state() == GripState::Closing;
            let command = grip.step(&GripInput { dt_s, slip, moved_m, forecast, predicted_n, travel: moved_m.is_some(), applied_n: moved_m, touching, healthy, ..GripInput::default() });
            prop_assert!((0.0..=config.f_max_n).contains(&command), "{command}");
            let rise = command - last;
            prop_assert!(rise <= config.slew_n_s * dt_s.clamp(0.0, 0.01) * 1.000_01 + 1e-5, "{rise} in {dt_s} s");
            let evident = slip == SlipNow::Evident;
            stale_s = if evident || grip.state() != GripState::Slipping { 0.0 } else { stale_s + dt_s.clamp(0.0, 0.01) };
            prop_assert!(rise <= 0.0 || closing || (slip != SlipNow::No && healthy && stale_s < 0.0301));
            // Nothing that a sensor does opens fingers that have closed.
            open &= command <= 0.0;
            prop_assert!(open || command > 0.0);
            prop_assert!(healthy || command <= last);
            last = command;
        }
    }
}

/// A dead sensor in the middle of a slip neither raises nor opens.
#[test]
fn a_sensor_that_dies_in_a_slip_keeps_the_force() {
    let mut pipeline = Bare::new(PipelineConfig::gripping(Hertz(10_000.0)), None).unwrap();
    let mut seen = false;
    let mut at_death = 0.0;
    for i in 0..20_000_u64 {
        let noise = 1e-7 * ((i * 7919 % 101) as f32 / 50.0 - 1.0);
        let slip = if i > 8000 { 5e-6 * (i as f32 * 0.3).sin() } else { 0.0 };
        let stylus = if i < 8100 { noise + slip } else { f32::NAN };
        let force = if i < 2100 { 0.0 } else { 2.0 };
        let sample =
            Sample { normal_force_n: Some(force), ..Sample::stylus(Micros(i * 100), stylus) };
        let step = pipeline.handle(&sample);
        seen |= step.event.is_some_and(|slip| slip.phase != Phase::Ended);
        if i == 8110 {
            at_death = step.command.unwrap().0;
        }
        if i > 8110 {
            assert_eq!(step.command.unwrap().0, at_death);
        }
    }
    assert!(seen && at_death >= 2.2, "{at_death}");
}
