//! Controllers of any settings in random stretches of slips, faults and wishes: what must hold in each step, and in the end.

use proptest::prelude::*;
use slip_core::{
    grip::{GripConfig, GripController, GripInput, GripState, SlipNow},
    load::Forecast,
};

const DT_S: f32 = 1e-3;
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
    (fragile_n, relax_per_s, 200.0_f32..5000.0).prop_map(|(fragile_n, relax_per_s, slew_n_s)| {
        GripConfig { fragile_n, relax_per_s, slew_n_s, ..GripConfig::default() }
    })
}

/// What is known of the object (N); often nothing.
fn any_expected() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0_f32), 0.01_f32..40.0]
}

/// What a posterior states in a slip that goes on; `held`: whether one that has stopped may state what is needed.
fn any_forecast(held: bool) -> impl Strategy<Value = Forecast> {
    let needs = (0.5_f32..60.0, 0.3_f32..1.0, prop::option::of(0.5_f32..60.0));
    (any::<[bool; 7]>(), needs, 0.0_f32..1.0, 0.0_f32..0.5, 0_u32..4).prop_map(
        move |(flags, (median_n, share, held_n), p_null, speed_m_s, slips_seen)| {
            let [slips, moves, unexplained, informed, trusted, known, by_stylus] = flags;
            let held_n = held_n.filter(|_| held && !slips);
            // What needs no more than it has, or is not known yet.
            let since_s = if held || p_null > 0.4 { 0.05 } else { 0.005 };
            let low_n = share * median_n;
            Forecast {
                slips,
                moves,
                unexplained,
                informed,
                trusted,
                known,
                by_stylus,
                best_n: low_n,
                median_n,
                p_null,
                speed_m_s,
                slips_seen,
                held_n,
                travel_m_s: speed_m_s,
                since_s,
                moved_m: trusted.then_some(0.1 * speed_m_s),
                whole_n: median_n,
                whole_low_n: low_n,
                whole_high_n: median_n / share,
                ..Forecast::default()
            }
        },
    )
}

fn any_input(held: bool) -> impl Strategy<Value = GripInput> {
    let slip = prop::sample::select(vec![SlipNow::No, SlipNow::Fading, SlipNow::Evident]);
    let applied_n = prop::option::of(0.0_f32..60.0);
    let delays = (0.0_f32..0.04, 0.0_f32..0.05);
    (slip, any_forecast(held), applied_n, delays, 0_u8..10).prop_map(
        |(slip, forecast, applied_n, (dead_s, lag_s), luck)| {
            let slips = forecast.slips && slip != SlipNow::No;
            let forecast = Some(Forecast { slips, ..forecast });
            let healthy = luck > 0;
            GripInput {
                dt_s: DT_S,
                slip,
                forecast,
                dead_s,
                lag_s,
                travel: true,
                applied_n,
                touching: true,
                healthy,
                ..GripInput::default()
            }
        },
    )
}

fn any_stretch(held: bool, largest_wish_n: f32) -> impl Strategy<Value = Stretch> {
    let wish_n = prop::option::weighted(0.2, 0.0..=largest_wish_n);
    (any_input(held), 1_u16..150, wish_n).prop_map(|(input, steps, wish_n)| Stretch {
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
        let mut input = stretch.input;
        if let Some(forecast) = &mut input.forecast {
            forecast.from_n = grip.command_n();
        }
        for _ in 0..stretch.steps {
            input.predicted_n = grip.drive().on_way_n();
            let (before_n, before) = (grip.command_n(), grip.state());
            let command_n = grip.step(&input);
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
        stretches in prop::collection::vec(any_stretch(true, 100.0), 1..40)
    ) {
        config.check().unwrap();
        live(&mut holding(config, expected_n), &config, &stretches);
    }

    /// (g): alarms in which nothing needs more than it has, faults and wishes leave nothing behind.
    #[test]
    fn without_movement_nothing_rises_for_good(
        config in any_config(), expected_n in any_expected(),
        stretches in prop::collection::vec(any_stretch(false, 6.0), 1..40)
    ) {
        let begun_n = if expected_n > 0.0 { expected_n.min(config.ceiling_n()) } else { config.trial_force_n };
        let mut grip = holding(config, expected_n);
        live(&mut grip, &config, &stretches);
        grip.at_least(0.0);
        let searched_from_n = grip.command_n();
        for _ in 0..10_000 {
            grip.step(&calm());
        }
        prop_assert!(grip.command_n() <= begun_n.max(6.0) + 1e-3, "{} after {searched_from_n}", grip.command_n());
        if config.relax_per_s == 0.0 {
            prop_assert!(grip.command_n() <= begun_n.max(config.least_force_n) + 1e-3, "{}", grip.command_n());
        }
    }
}
