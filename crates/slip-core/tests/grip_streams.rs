//! Controllers of any settings in random stretches of slips, faults and wishes: what must hold in each step, and in the end.

use proptest::prelude::*;
use slip_core::{
    estimate::ForceEstimate,
    grip::{GripConfig, GripController, GripInput, GripState, Sliding, SlipNow},
};

const DT_S: f32 = 1e-3;
/// Less than what confirms a slip with the shipped settings (m).
const UNCONFIRMED_M: f32 = 2.9e-5;

/// Some time in which nothing changes but the clock.
#[derive(Clone, Debug)]
struct Stretch {
    input: GripInput,
    steps: u16,
    /// What a client asks for at its begin (N).
    wish_n: Option<f32>,
}

fn any_config() -> impl Strategy<Value = GripConfig> {
    let fragile_n = prop::sample::select(vec![0.0_f32, 8.0]);
    let relax_per_s = prop::sample::select(vec![0.0_f32, 1.0]);
    (fragile_n, relax_per_s, 0.0_f32..4.0, 0.0_f32..4.0, 0.1_f32..0.5, 200.0_f32..5000.0).prop_map(
        |(fragile_n, relax_per_s, lead, ahead, reflex_step, slew_n_s)| GripConfig {
            fragile_n,
            relax_per_s,
            lead,
            ahead,
            reflex_step,
            slew_n_s,
            ..GripConfig::default()
        },
    )
}

/// What is known of the object (N); often nothing.
fn any_expected() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0_f32), 0.01_f32..40.0]
}

fn any_input(furthest_m: f32) -> impl Strategy<Value = GripInput> {
    let slip = prop::sample::select(vec![SlipNow::No, SlipNow::Fading, SlipNow::Evident]);
    let estimate = prop::option::of((0.5_f32..60.0, 0.0_f32..3.0));
    let sliding = prop::option::of((0.1_f32..40.0, -1.0_f32..2.0));
    let applied_n = prop::option::of(0.0_f32..60.0);
    (slip, 0.0..furthest_m, estimate, sliding, applied_n, 0_u8..10).prop_map(
        |(slip, moved_m, estimate, sliding, applied_n, luck)| GripInput {
            dt_s: DT_S,
            slip,
            moved_m: Some(moved_m),
            estimate: estimate.map(|(estimate_n, sigma_n)| ForceEstimate::new(estimate_n, sigma_n)),
            sliding: sliding.map(|(force_n, acceleration_g)| Sliding { force_n, acceleration_g }),
            travel: true,
            applied_n,
            touching: true,
            healthy: luck > 0,
            ..GripInput::default()
        },
    )
}

fn any_stretch(furthest_m: f32, largest_wish_n: f32) -> impl Strategy<Value = Stretch> {
    let wish_n = prop::option::weighted(0.2, 0.0..=largest_wish_n);
    (any_input(furthest_m), 1_u16..150, wish_n).prop_map(|(input, steps, wish_n)| Stretch {
        input,
        steps,
        wish_n,
    })
}

fn calm() -> GripInput {
    let touched =
        GripInput { applied_n: Some(1.2), touching: true, healthy: true, ..GripInput::default() };
    GripInput { dt_s: DT_S, travel: true, ..touched }
}

/// A controller that holds its first object, which is expected to need `expected_n` (N); 0 where nothing is known of it.
fn holding(config: GripConfig, expected_n: f32) -> GripController {
    let mut grip = GripController::new(config);
    grip.expect(expected_n);
    grip.grasp(None);
    while grip.state() != GripState::Holding {
        grip.step(&calm());
    }
    grip
}

/// Lives through the stretches; each step is within the limits.
fn live(grip: &mut GripController, config: &GripConfig, stretches: &[Stretch]) {
    for stretch in stretches {
        if let Some(wish_n) = stretch.wish_n {
            grip.at_least(wish_n);
        }
        for _ in 0..stretch.steps {
            let (before_n, before) = (grip.command_n(), grip.state());
            let command_n = grip.step(&stretch.input);
            let (rise_n, reach_n) = (command_n - before_n, config.slew_n_s * DT_S + 1e-4);
            assert!(
                command_n <= config.ceiling_n() && rise_n <= reach_n,
                "{command_n} {stretch:?}"
            );
            assert!(command_n >= config.least_force_n, "never opened: {command_n} {stretch:?}");
            assert!(stretch.input.healthy || rise_n <= 0.0, "{rise_n} {stretch:?}");
            let left = before == GripState::Slipping && grip.state() != GripState::Slipping;
            assert!(left || rise_n >= -reach_n, "{rise_n} {stretch:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn every_step_is_within_the_limits(
        config in any_config(), expected_n in any_expected(),
        stretches in prop::collection::vec(any_stretch(1e-2, 100.0), 1..40)
    ) {
        config.check().unwrap();
        live(&mut holding(config, expected_n), &config, &stretches);
    }

    /// Alarms, faults and wishes leave nothing behind: only what moved is held with more, and what the search waits for with one step more.
    #[test]
    fn without_movement_nothing_rises_for_good(
        config in any_config(), expected_n in any_expected(),
        stretches in prop::collection::vec(any_stretch(UNCONFIRMED_M, 6.0), 1..40)
    ) {
        let begun_n = if expected_n > 0.0 { expected_n.min(config.ceiling_n()) } else { config.trial_force_n };
        let mut grip = holding(config, expected_n);
        live(&mut grip, &config, &stretches);
        grip.at_least(0.0);
        let searched_from_n = grip.command_n();
        for _ in 0..10_000 {
            grip.step(&calm());
        }
        // The step of a search is 1.11 times that of the reflex.
        let most_n = 1.11 * (1.0 + config.reflex_step) * begun_n.max(6.0);
        prop_assert!(grip.command_n() <= most_n + 1e-3, "{} after {searched_from_n}", grip.command_n());
        if config.relax_per_s == 0.0 {
            prop_assert!(grip.command_n() <= begun_n.max(config.least_force_n) + 1e-3, "{}", grip.command_n());
        }
    }
}
