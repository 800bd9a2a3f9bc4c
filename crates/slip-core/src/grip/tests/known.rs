//! Objects of which something is known before they are grasped.

use super::{DT_S, calm, config, held_with, rest, slipping};
use crate::{
    grip::{GripConfig, GripController, GripEvent, GripInput, GripState, SlipNow},
    need::Felt,
};

/// Closes on an object that is known to be held with `force_n`.
fn grasped(config: GripConfig, force_n: f32) -> GripController {
    let mut grip = GripController::new(config);
    grip.expect(force_n);
    grip.grasp(None);
    let mut before_n = 0.0;
    for _ in 0..400 {
        let force_n = grip.step(&GripInput { applied_n: Some(before_n), ..calm() });
        assert!(force_n - before_n <= config.slew_n_s * DT_S + 1e-4);
        before_n = force_n;
    }
    grip
}

/// Steps until `event`, at most `steps`; the command then.
fn until(grip: &mut GripController, event: GripEvent, steps: u32) -> Option<f32> {
    for _ in 0..steps {
        let force_n = grip.step(&calm());
        if grip.event() == Some(event) {
            return Some(force_n);
        }
    }
    None
}

#[test]
fn a_known_object_is_grasped_with_what_it_is_known_to_need() {
    for (known_n, held_n) in [(9.0, 9.0), (0.5, 0.5), (0.01, 0.2), (1e9, 60.0), (0.0, 2.0)] {
        let grip = grasped(config(), known_n);
        assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, held_n), "{known_n}");
    }
    let mut grip = grasped(config(), 9.0);
    for nonsense in [f32::NAN, -1.0] {
        grip.expect(nonsense);
    }
    grip.release();
    grip.close_again();
    grip.grasp(None);
    rest(&mut grip, 400);
    assert_eq!(grip.command_n(), 9.0, "until another one is expected");
}

#[test]
fn what_is_in_hand_is_not_concerned_by_what_is_expected_next() {
    let mut grip = grasped(config(), 5.0);
    grip.expect(20.0);
    rest(&mut grip, 1000);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 5.0));
}

#[test]
fn nothing_is_pressed_with_what_is_expected_before_touch() {
    let mut grip = GripController::new(config());
    grip.expect(30.0);
    grip.grasp(None);
    for _ in 0..1000 {
        let force_n = grip.step(&GripInput { touching: false, ..calm() });
        assert!(force_n <= config().least_force_n, "{force_n}");
    }
}

#[test]
fn what_is_found_is_reported_once_with_the_force_it_is_held_with() {
    let mut grip = grasped(GripConfig { relax_per_s: 0.0, ..config() }, 0.0);
    for _ in 0..40 {
        grip.step(&slipping(1e-3, Some(6.0)));
        assert_eq!(grip.event(), None);
    }
    let held_n = until(&mut grip, GripEvent::Found, 2000);
    assert!(held_n.is_some_and(|held_n| (5.0..8.0).contains(&held_n)), "{held_n:?}");
    assert!(grip.is_steady());
    assert_eq!(until(&mut grip, GripEvent::Found, 2000), None);
}

#[test]
fn what_is_held_with_the_largest_force_is_not_found() {
    for limit in
        [GripConfig { f_max_n: 6.0, ..config() }, GripConfig { fragile_n: 6.0, ..config() }]
    {
        let mut grip = grasped(GripConfig { relax_per_s: 0.0, ..limit }, 0.0);
        for _ in 0..400 {
            grip.step(&slipping(1e-3, Some(20.0)));
        }
        assert_eq!(until(&mut grip, GripEvent::Limited, 2000), Some(6.0));
        for event in [GripEvent::Limited, GripEvent::Found] {
            assert_eq!(until(&mut grip, event, 1000), None, "once, and it is not known");
        }
    }
}

#[test]
fn the_end_of_the_search_is_found_too() {
    let config = GripConfig { relax_per_s: 1.0, ..config() };
    let mut grip = grasped(config, 0.0);
    let found = (0..10_000).find_map(|_| {
        let force_n = grip.step(&GripInput { travel: true, ..calm() });
        (grip.event() == Some(GripEvent::Found)).then_some(force_n)
    });
    assert_eq!(found, Some(config.least_force_n));
}

/// Slides by `step_m` with each of `steps` samples, with estimates of `estimate_n`; the highest command.
fn slide(grip: &mut GripController, steps: u16, step_m: f32, estimate_n: f32) -> f32 {
    (1..=steps).fold(0.0, |highest: f32, i| {
        let slips = slipping(f32::from(i) * step_m, Some(estimate_n));
        highest.max(grip.step(&GripInput { applied_n: Some(grip.command_n()), ..slips }))
    })
}

#[test]
fn pads_that_give_way_as_the_load_comes_are_no_slip_of_a_known_object() {
    let mut grip = grasped(config(), 9.0);
    assert_eq!(slide(&mut grip, 8, 2e-5, 15.0), 9.0);
    rest(&mut grip, 3000);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 9.0));
    assert_eq!(grip.trials().trials, 1);
}

#[test]
fn a_known_object_that_slides_further_than_pads_give_way_gets_what_is_estimated() {
    let mut grip = grasped(config(), 9.0);
    let highest_n = slide(&mut grip, 60, 2e-5, 15.0);
    assert!(highest_n >= 15.0, "{highest_n}");
    let held_n = until(&mut grip, GripEvent::Found, 3000);
    assert!(held_n.is_some_and(|held_n| held_n >= 14.0), "{held_n:?}");
}

#[test]
fn a_known_object_that_creeps_on_is_not_excused_for_ever() {
    let mut grip = grasped(config(), 9.0);
    for _ in 0..3 {
        assert_eq!(slide(&mut grip, 8, 2e-5, 15.0), 9.0);
        rest(&mut grip, 100);
    }
    assert!(slide(&mut grip, 8, 2e-5, 15.0) > 9.0);
}

/// A vibration has no peaks to count.
#[test]
fn a_known_object_that_only_a_vibration_feels_is_answered_too() {
    let mut grip = grasped(config(), 9.0);
    let felt = Felt {
        moves: true,
        from_n: 9.0,
        first: 1.2,
        low_n: 15.0,
        median_n: 15.0,
        vibrates: true,
        ..Felt::default()
    };
    let step = |grip: &mut GripController, ms: u16| {
        let felt = Some(Felt { since_s: 1e-3 * f32::from(ms), ..felt });
        let input = GripInput { slip: SlipNow::Evident, felt, ..calm() };
        grip.step(&GripInput { applied_n: Some(grip.command_n()), ..input })
    };
    let after = |ms: u16, grip: &mut GripController| (0..ms).fold(0.0, |_, i| step(grip, i));
    assert_eq!(after(35, &mut grip), 9.0, "pads may give way");
    assert!(after(30, &mut grip) > 12.0, "{}", grip.command_n());
}

/// Slips in 10 ms by 1 mm with estimates of `estimate_n` where the moved distance is measured.
fn slips_once(grip: &mut GripController, estimate_n: f32) {
    for _ in 0..40 {
        let slips = slipping(1e-3, Some(estimate_n));
        grip.step(&GripInput { travel: true, applied_n: Some(grip.command_n()), ..slips });
    }
}

/// Until the force is found, at most 5 s; what it is then (N).
fn found_n(grip: &mut GripController) -> Option<f32> {
    (0..5000).find_map(|_| {
        let force_n = grip.step(&GripInput { travel: true, ..calm() });
        (grip.event() == Some(GripEvent::Found)).then_some(force_n)
    })
}

#[test]
fn what_holds_a_blow_is_not_what_the_object_needs() {
    let mut grip = held_with(GripConfig { relax_per_s: 0.1, ..config() });
    slips_once(&mut grip, 6.0);
    rest(&mut grip, 100);
    slips_once(&mut grip, 15.0);
    assert_eq!(found_n(&mut grip), None);
    assert!(grip.command_n() >= 14.0, "what was needed once is kept: {}", grip.command_n());
}

#[test]
fn a_known_object_that_is_hit_or_heavier_is_searched_for_anew() {
    let mut grip = grasped(GripConfig { relax_per_s: 1.0, ..config() }, 9.0);
    slips_once(&mut grip, 20.0);
    assert!(grip.command_n() >= 19.0);
    for _ in 0..700 {
        grip.step(&GripInput { travel: true, ..calm() });
        assert_ne!(grip.event(), Some(GripEvent::Found));
    }
    assert!(grip.command_n() < 11.0, "{}", grip.command_n());
    slips_once(&mut grip, 12.0);
    let found_n = found_n(&mut grip);
    assert!(found_n.is_some_and(|found_n| (11.0..14.0).contains(&found_n)), "{found_n:?}");
}

/// In a search one alarm is believed, moved or not. Nothing is learned of a weight by one in which nothing moved.
#[test]
fn alarms_without_movement_do_not_add_up_on_a_known_object() {
    let config = GripConfig { relax_per_s: 1.0, reflex_step: 0.5, ..config() };
    let mut grip = grasped(config, 9.0);
    // Searched down to just below what counts as held with what is known.
    while grip.command_n() >= 0.8 * 9.0 {
        grip.step(&GripInput { travel: true, ..calm() });
    }
    for _ in 0..3 {
        for _ in 0..60 {
            grip.step(&GripInput { travel: true, ..slipping(0.0, None) });
        }
        grip.step(&GripInput { travel: true, ..calm() });
    }
    for _ in 0..5000 {
        grip.step(&GripInput { travel: true, ..calm() });
    }
    let most_n = 1.11 * (1.0 + config.reflex_step) * 0.8 * 9.0;
    assert!(grip.command_n() <= most_n, "{} N", grip.command_n());
}

/// What is expected next, and settings that change, show nothing of the object in hand: it is answered like any other.
#[test]
fn what_is_held_is_no_known_object_because_another_one_is_named_or_settings_change() {
    let mut named = held_with(config());
    named.expect(2.1);
    let mut carried = GripController::holding(config(), 2.0);
    carried.expect(2.0);
    for grip in [&mut named, &mut carried] {
        assert!(slide(grip, 2, 1e-5, 6.0) > 2.0);
    }
}
