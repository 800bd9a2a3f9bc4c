//! Objects of which something is known before they are grasped.

use super::{DT_S, answer, calm, config, ended, held_with, rest, slipping, slips, stopped};
use crate::grip::{GripConfig, GripController, GripEvent, GripInput, GripState};
use crate::load::Forecast;

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

/// A slip in which the posterior finds `need_n` (N), where the moved distance is measured.
fn slips_once(grip: &mut GripController, need_n: f32) {
    let known = grip.trials().trials > 1 || grip.known_n().is_some();
    let slip = Forecast { known, ..slips(grip.command_n(), need_n) };
    answer(grip, &GripInput { travel: true, ..slipping(slip) }, 40);
    // The methods show a slip for some time after it has stopped.
    let stopped = stopped(slip, Some(need_n));
    answer(grip, &GripInput { travel: true, ..slipping(stopped) }, 100);
    answer(grip, &GripInput { travel: true, ..ended(slip, Some(need_n)) }, 1);
}

#[test]
fn what_is_found_is_reported_once_with_the_force_it_is_held_with() {
    let mut grip = grasped(GripConfig { relax_per_s: 0.0, ..config() }, 0.0);
    slips_once(&mut grip, 6.0);
    let held_n = until(&mut grip, GripEvent::Found, 2000);
    assert!(held_n.is_some_and(|held_n| (6.3..6.4).contains(&held_n)), "{held_n:?}");
    assert_eq!(until(&mut grip, GripEvent::Found, 2000), None);
    assert!(grip.is_steady());
}

#[test]
fn what_is_held_with_the_largest_force_is_not_found() {
    for limit in
        [GripConfig { f_max_n: 6.0, ..config() }, GripConfig { fragile_n: 6.0, ..config() }]
    {
        let mut grip = grasped(GripConfig { relax_per_s: 0.0, ..limit }, 0.0);
        slips_once(&mut grip, 20.0);
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

/// Until the force is found, at most 5 s; what it is then (N).
fn found_n(grip: &mut GripController) -> Option<f32> {
    (0..5000).find_map(|_| {
        let force_n = grip.step(&GripInput { travel: true, ..calm() });
        (grip.event() == Some(GripEvent::Found)).then_some(force_n)
    })
}

#[test]
fn a_known_object_that_seems_heavier_is_searched_for_anew() {
    let mut grip = grasped(GripConfig { relax_per_s: 1.0, ..config() }, 9.0);
    let unsure = Forecast { known: true, whole_low_n: 8.0, ..slips(9.0, 20.0) };
    assert!(answer(&mut grip, &GripInput { travel: true, ..slipping(unsure) }, 40) > 19.0);
    answer(&mut grip, &GripInput { travel: true, ..ended(unsure, Some(20.0)) }, 1);
    for _ in 0..1700 {
        grip.step(&GripInput { travel: true, ..calm() });
        assert_ne!(grip.event(), Some(GripEvent::Found));
    }
    assert!(grip.command_n() < 11.0, "{}", grip.command_n());
    slips_once(&mut grip, 9.0);
    let found_n = found_n(&mut grip);
    assert!(found_n.is_some_and(|found_n| (11.0..14.0).contains(&found_n)), "{found_n:?}");
}

/// What the posterior takes for pads that swing raises nothing for good, however often.
#[test]
fn alarms_without_movement_do_not_add_up_on_a_known_object() {
    let mut grip = grasped(GripConfig { relax_per_s: 1.0, ..config() }, 9.0);
    for _ in 0..3 {
        let from_n = grip.command_n();
        let alarm = Forecast { known: true, p_null: 0.9, ..slips(from_n, from_n) };
        answer(&mut grip, &GripInput { travel: true, ..slipping(alarm) }, 60);
        answer(&mut grip, &GripInput { travel: true, ..ended(alarm, None) }, 1);
    }
    for _ in 0..5000 {
        grip.step(&GripInput { travel: true, ..calm() });
    }
    assert!(grip.command_n() <= 9.0, "{} N", grip.command_n());
}

/// What is expected next, and settings that change, show nothing of the object in hand: it is answered like any other.
#[test]
fn what_is_held_is_no_known_object_because_another_one_is_named_or_settings_change() {
    let mut named = held_with(config());
    named.expect(2.1);
    let mut carried = GripController::holding(config(), 2.0);
    carried.expect(2.0);
    assert_eq!((named.known_n(), carried.known_n()), (None, None));
    assert_eq!(grasped(config(), 9.0).known_n(), Some(7.2), "without the margin");
}
