//! The search for the smallest force that is enough.

use super::{DT_S, answer, calm, config, ended, slipping, slips, stopped};
use crate::grip::{GripConfig, GripController, GripInput, GripState, Trials};
use crate::load::Forecast;

/// Calm, with a sensor of the moved distance.
fn watched() -> GripInput {
    GripInput { travel: true, ..calm() }
}

/// As [`config`], but less and less is tried.
fn searching() -> GripConfig {
    GripConfig { relax_per_s: 1.0, ..config() }
}

/// Holds 2 N, of which nothing has been taken back yet.
fn held(config: GripConfig) -> GripController {
    held_by(config, &watched())
}

fn held_by(config: GripConfig, input: &GripInput) -> GripController {
    let mut grip = GripController::new(config);
    grip.grasp(None);
    while grip.state() != GripState::Holding {
        grip.step(input);
    }
    assert_eq!(grip.command_n(), 2.0);
    grip
}

fn wait(grip: &mut GripController, seconds: f32) {
    let mut left_s = seconds;
    while left_s > 0.0 {
        grip.step(&watched());
        left_s -= DT_S;
    }
}

/// An alarm of `ms` in which nothing needs more than it has.
fn alarm(grip: &mut GripController, ms: u32) {
    let from_n = grip.command_n();
    let alarm = Forecast { p_null: 0.9, ..slips(from_n, from_n) };
    answer(grip, &GripInput { travel: true, ..slipping(alarm) }, ms);
    answer(grip, &GripInput { travel: true, ..ended(alarm, None) }, 1);
    assert_eq!(grip.state(), GripState::Holding);
}

/// A slip that is answered until it stops, in which the posterior finds `need_n` (N), known or `unsure` by half of it each way.
fn slip(grip: &mut GripController, need_n: f32, unsure: bool) {
    let known = grip.trials().trials > 1;
    let share = if unsure { 0.5 } else { 0.0 };
    let (whole_low_n, whole_high_n) = (need_n * (1.0 - share), need_n * (1.0 + share));
    let slip = Forecast { known, whole_low_n, whole_high_n, ..slips(grip.command_n(), need_n) };
    answer(grip, &GripInput { travel: true, ..slipping(slip) }, 50);
    answer(grip, &GripInput { travel: true, ..ended(slip, Some(need_n)) }, 1);
    assert_eq!(grip.state(), GripState::Holding);
}

#[test]
fn the_search_ends_where_touch_would() {
    for (touch_n, least_n) in [(0.05, searching().least_force_n), (0.7, 0.7)] {
        let mut grip = held(searching());
        for _ in 0..20_000 {
            grip.step(&GripInput { touch_n, ..watched() });
        }
        assert!((grip.command_n() - least_n).abs() < 1e-3, "{} N", grip.command_n());
    }
}

/// What a client asked for and an alarm have raised moves the pads on its way back.
#[test]
fn an_alarm_on_the_way_back_from_an_alarm_does_not_end_the_search() {
    let mut grip = held(searching());
    grip.at_least(6.0);
    wait(&mut grip, 0.15);
    alarm(&mut grip, 10);
    grip.at_least(0.0);
    grip.step(&watched());
    assert!(grip.command_n() > 4.0 && grip.state() == GripState::Holding, "{grip:?}");
    alarm(&mut grip, 1);
    wait(&mut grip, 3.0);
    assert!(grip.command_n() < 0.5, "{}", grip.command_n());
}

#[test]
fn an_object_that_never_slips_is_held_with_less_down_to_the_least_force() {
    let mut grip = held(searching());
    wait(&mut grip, 1.0);
    let after = grip.command_n();
    assert!((after / 2.0 - (-1.0_f32).exp()).abs() < 0.01, "by e in a second: {after}");
    assert!(!grip.is_steady());
    wait(&mut grip, 3.0);
    assert_eq!((grip.command_n(), grip.is_steady()), (0.2, true));
}

#[test]
fn without_travel_or_where_it_is_not_wanted_the_trial_force_stays() {
    let mut unmeasured = held_by(searching(), &calm());
    let mut unwanted = held(config());
    for _ in 0..3000 {
        unmeasured.step(&calm());
        unwanted.step(&watched());
    }
    assert_eq!((unmeasured.command_n(), unwanted.command_n()), (2.0, 2.0));
    assert!(unmeasured.is_steady() && unwanted.is_steady());
}

/// What was asked for has been tried, and less has not: the search begins there.
#[test]
fn a_wish_that_is_taken_back_is_searched_from() {
    let mut grip = held(searching());
    grip.at_least(6.0);
    wait(&mut grip, 3.0);
    assert_eq!((grip.command_n(), grip.is_steady()), (6.0, true));
    grip.at_least(0.0);
    wait(&mut grip, 0.5);
    let over = grip.command_n() / 6.0;
    assert!((over - (-0.5_f32).exp()).abs() < 0.01, "{over}");
}

#[test]
fn a_grip_that_is_carried_on_is_not_searched() {
    let mut grip = GripController::holding(searching(), 5.0);
    wait(&mut grip, 3.0);
    assert_eq!(grip.command_n(), 5.0);
}

/// Static friction gives way first: by how much is not known before the object has slid.
#[test]
fn what_just_slips_is_held_with_three_tenths_more_and_that_is_kept() {
    let mut grip = held(searching());
    wait(&mut grip, 1.0);
    let before = grip.command_n();
    slip(&mut grip, before, false);
    wait(&mut grip, 3.0);
    let over = grip.command_n() / before;
    assert!((over - 1.3).abs() < 1e-3 && grip.is_steady(), "{over}");
    assert_eq!(grip.trials(), Trials { trials: 2, moved_m: 1e-4 });
}

/// The object swings on its pads, as in a hand that shakes: the posterior takes it for held.
#[test]
fn a_swing_on_the_pads_does_not_end_the_search() {
    let mut grip = held(searching());
    wait(&mut grip, 1.0);
    let before = grip.command_n();
    alarm(&mut grip, 200);
    wait(&mut grip, 0.5);
    assert!(grip.state() == GripState::Holding && grip.command_n() < before, "{grip:?}");
}

#[test]
fn what_slips_in_a_lift_is_searched_once_more_above_what_it_may_need() {
    let mut grip = held(searching());
    slip(&mut grip, 12.0, true);
    wait(&mut grip, 0.5);
    assert!((7.0..9.1).contains(&grip.command_n()), "1.5 of 6 at most: {}", grip.command_n());
    wait(&mut grip, 5.0);
    assert!((grip.command_n() - 6.0 / 1.7).abs() < 1e-3, "not below: {}", grip.command_n());
}

#[test]
fn a_need_that_one_slip_has_shown_is_not_searched_for() {
    let mut grip = held(searching());
    slip(&mut grip, 12.0, false);
    wait(&mut grip, 3.0);
    assert!((grip.command_n() - 12.72).abs() < 0.01 && grip.is_steady(), "{}", grip.command_n());
}

/// What its static friction held until now is stopped by what sliding needs, whatever the ratio of both.
#[test]
fn what_slips_again_is_given_time_to_slide_and_then_held_with_what_that_needs() {
    let mut grip = held(searching());
    slip(&mut grip, 12.0, true);
    wait(&mut grip, 0.5);
    let before = grip.command_n();
    assert!((5.0..8.5).contains(&before), "{before}");
    let slow = Forecast { known: true, since_s: 0.005, travel_m_s: 2e-3, ..slips(before, 12.0) };
    let input = GripInput { travel: true, ..slipping(slow) };
    assert!((answer(&mut grip, &input, 7) / before - 1.0).abs() < 1e-3, "{}", grip.command_n());
    let fast = Forecast { since_s: 0.012, travel_m_s: 7e-3, best_n: 13.2, ..slow };
    answer(&mut grip, &GripInput { travel: true, ..slipping(fast) }, 20);
    assert!((grip.command_n() - 13.2).abs() < 0.1, "{}", grip.command_n());
    // What a slow fall has shown is known well: more than has stopped it while a slip still shows.
    let still = GripInput { travel: true, ..slipping(stopped(fast, Some(12.0))) };
    answer(&mut grip, &still, 200);
    answer(&mut grip, &GripInput { travel: true, ..ended(fast, Some(12.0)) }, 1);
    wait(&mut grip, 3.0);
    assert!((grip.command_n() - 15.0).abs() < 0.1 && grip.is_steady(), "{}", grip.command_n());
}

#[test]
fn an_alarm_without_movement_is_none_where_nothing_is_searched() {
    let mut grip = held(config());
    for _ in 0..5 {
        alarm(&mut grip, 50);
        wait(&mut grip, 0.3);
        assert_eq!(grip.command_n(), 2.0);
    }
}

#[test]
fn a_grip_that_others_began_is_not_searched() {
    let mut grip = GripController::new(searching());
    grip.grasp(Some(5.0));
    for _ in 0..3000 {
        grip.step(&GripInput { applied_n: Some(5.0), ..watched() });
    }
    assert_eq!((grip.command_n(), grip.state()), (5.0, GripState::Holding));
}

#[test]
fn a_distance_that_is_no_longer_measured_ends_the_search() {
    let mut grip = held(searching());
    wait(&mut grip, 0.5);
    for _ in 0..50 {
        grip.step(&calm());
    }
    let held = grip.command_n();
    for _ in 0..1000 {
        grip.step(&calm());
    }
    assert!(grip.command_n() == held && held > 1.0 && grip.is_steady(), "{held}");
    wait(&mut grip, 0.5);
    assert!(grip.command_n() < 0.7 * held, "it goes on with the next reading");
}

#[test]
fn the_fingers_touch_lightly_before_they_press() {
    let mut grip = GripController::new(config());
    grip.grasp(None);
    for _ in 0..500 {
        let command_n = grip.step(&GripInput { touching: false, applied_n: Some(0.0), ..calm() });
        assert!(command_n <= 0.2, "{command_n}");
    }
    for _ in 0..200 {
        grip.step(&calm());
    }
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
}
