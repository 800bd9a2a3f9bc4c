//! The controller on hand-made evidence.

use super::{GripConfig, GripController, GripEvent, GripInput, GripState, SlipNow, Trials};
use crate::load::Forecast;

mod known;
mod search;

const DT_S: f32 = 1e-3;

fn calm() -> GripInput {
    GripInput {
        dt_s: DT_S,
        healthy: true,
        applied_n: Some(2.0),
        touching: true,
        ..GripInput::default()
    }
}

/// What the posterior states of an object that slips under `from_n` (N) by a trusted travel and needs `need_n` (N).
fn slips(from_n: f32, need_n: f32) -> Forecast {
    Forecast {
        slips: true,
        moves: true,
        informed: true,
        trusted: true,
        by_stylus: true,
        since_s: 0.02,
        moved_m: Some(1e-4),
        from_n,
        best_n: 1.06 * need_n,
        median_n: need_n,
        whole_low_n: need_n,
        whole_n: need_n,
        whole_high_n: need_n,
        slips_seen: 1,
        ..Forecast::default()
    }
}

/// The same once it has stopped; `held_n` (N) is `None` where it needs no more than it had.
fn stopped(slip: Forecast, held_n: Option<f32>) -> Forecast {
    Forecast { slips: false, moves: false, held_n, ..slip }
}

fn slipping(forecast: Forecast) -> GripInput {
    GripInput {
        slip: SlipNow::Evident,
        moved_m: forecast.moved_m,
        forecast: Some(forecast),
        applied_n: None,
        ..calm()
    }
}

/// Nothing slips any longer, of which this is what the posterior states.
fn ended(slip: Forecast, held_n: Option<f32>) -> GripInput {
    GripInput { slip: SlipNow::No, ..slipping(stopped(slip, held_n)) }
}

/// Takes `input` for `steps`, of a drive that follows the command at once; the command then.
fn answer(grip: &mut GripController, input: &GripInput, steps: u32) -> f32 {
    for _ in 0..steps {
        let before_n = grip.command_n();
        grip.step(&GripInput { predicted_n: before_n, ..*input });
    }
    grip.command_n()
}

/// Nothing happens for `steps`.
fn rest(grip: &mut GripController, steps: u32) {
    for _ in 0..steps {
        grip.step(&calm());
    }
}

/// Tries 2 N and keeps that until something slips.
fn config() -> GripConfig {
    GripConfig { trial_force_n: 2.0, relax_per_s: 0.0, ..GripConfig::default() }
}

fn holding() -> GripController {
    held_with(config())
}

fn held_with(config: GripConfig) -> GripController {
    let mut grip = GripController::new(config);
    grip.grasp(None);
    rest(&mut grip, 300);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
    grip
}

#[test]
fn nothing_moves_without_grasp() {
    let mut grip = GripController::new(config());
    for _ in 0..1000 {
        assert_eq!(grip.step(&slipping(slips(2.0, 10.0))), 0.0);
    }
}

/// The friction of a tendon keeps the force at 0.7 of what is commanded: the object is held, and watched, as soon as it stands there.
#[test]
fn fingers_that_get_no_closer_to_the_trial_force_hold_the_object() {
    let mut grip = GripController::new(config());
    grip.grasp(None);
    let mut force_n = 0.0_f32;
    let steps = (0..1000_u16).find(|_| {
        force_n += 0.03 * (0.7 * grip.command_n() - force_n);
        grip.step(&GripInput { applied_n: Some(force_n), ..calm() });
        grip.state() == GripState::Settling
    });
    assert!(steps.is_some_and(|steps| (200..300).contains(&steps)), "{steps:?} ms");
    // Each closing waits anew.
    grip.release();
    grip.close_again();
    grip.grasp(None);
    let mut waited = 0;
    for _ in 0..1000 {
        grip.step(&GripInput { applied_n: Some(1.4), ..calm() });
        let pressed = grip.command_n() >= config().trial_force_n;
        waited += u32::from(pressed && grip.state() == GripState::Closing);
    }
    assert!((70..90).contains(&waited), "{waited} ms");
}

#[test]
fn a_wish_raises_within_the_limits_and_is_taken_back_slowly() {
    let mut grip = holding();
    for (wish, then) in [(10.0, 10.0), (f32::NAN, 10.0), (-3.0, 10.0), (1e9, 60.0)] {
        grip.at_least(wish);
        let before = grip.command_n();
        assert!(grip.step(&calm()) <= before + 20.0 * DT_S + 1e-4);
        rest(&mut grip, 3000);
        assert_eq!((grip.command_n(), grip.is_steady()), (then, true), "{wish}");
    }
    grip.at_least(0.0);
    assert!(!grip.is_steady());
    assert!(grip.step(&calm()) > 59.9);
    rest(&mut grip, 3000);
    assert_eq!((grip.command_n(), grip.is_steady()), (2.0, true));
    assert!(!grip.drive().is_settled(), "its force has not come yet");
    rest(&mut grip, 250);
    assert!(grip.drive().is_settled());
}

#[test]
fn a_release_holds_until_it_is_ended_whatever_slips() {
    let mut grip = holding();
    grip.release();
    for _ in 0..100 {
        grip.grasp(Some(5.0));
        assert_eq!(grip.step(&slipping(slips(2.0, 10.0))), 0.0);
    }
    assert_eq!(grip.state(), GripState::Released);
    grip.close_again();
    grip.grasp(None);
    rest(&mut grip, 300);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
}

#[test]
fn a_grip_is_carried_on_within_the_limit_and_nothing_is_no_grip() {
    for (carried, state, command_n) in [
        (7.0, GripState::Holding, 7.0),
        (1.0, GripState::Closing, 1.0 + 20.0 * DT_S),
        (1e6, GripState::Holding, 60.0),
        (0.0, GripState::Open, 0.0),
        (-2.0, GripState::Open, 0.0),
        (f32::NAN, GripState::Open, 0.0),
    ] {
        let mut grip = GripController::holding(config(), carried);
        assert_eq!((grip.state(), grip.step(&calm())), (state, command_n), "{carried}");
    }
}

#[test]
fn an_object_that_is_held_already_stays_held() {
    let mut grip = GripController::new(config());
    grip.grasp(Some(12.0));
    for _ in 0..500 {
        assert_eq!(grip.step(&GripInput { applied_n: Some(12.0), ..calm() }), 12.0);
    }
    assert_eq!(grip.state(), GripState::Holding);
}

#[test]
fn a_light_touch_is_one_that_a_noisy_sensor_feels() {
    let light_n = |touch_n| {
        let mut grip = GripController::new(config());
        grip.grasp(None);
        let open = GripInput { applied_n: Some(0.0), touching: false, touch_n, ..calm() };
        (0..500).map(|_| grip.step(&open)).fold(0.0, f32::max)
    };
    let least_n = config().least_force_n;
    assert_eq!([0.0, 0.05, 0.3].map(light_n), [least_n, least_n, 0.6]);
    assert_eq!(light_n(5.0), config().trial_force_n, "no more than the trial force");
}

#[test]
fn closing_waits_for_the_measured_force() {
    let mut grip = GripController::new(config());
    grip.grasp(None);
    let mut weak_n = 0.2;
    let mut rise = |grip: &mut GripController, steps: u16| {
        for _ in 0..steps {
            weak_n += 0.002;
            grip.step(&GripInput { applied_n: Some(weak_n), ..calm() });
        }
    };
    rise(&mut grip, 300);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Closing, 2.0), "1.6 N are enough");
    // A gripper that is that slow, or a sensor that shows too little: the object is watched all the same.
    rise(&mut grip, 200);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
}

/// Fingers that follow the command with a lag of 5 ms, for `steps` of `input`.
fn press(grip: &mut GripController, input: &GripInput, applied_n: &mut f32, steps: u32) {
    for _ in 0..steps {
        let before_n = grip.command_n();
        let (applied, predicted_n) = (Some(*applied_n), *applied_n);
        let input = GripInput { applied_n: applied, predicted_n, lag_s: 5e-3, ..*input };
        let command_n = grip.step(&input);
        assert!((command_n - before_n).abs() <= 2000.0 * DT_S + 1e-4 && command_n <= 60.0);
        *applied_n += 0.2 * (command_n - *applied_n);
    }
}

#[test]
fn the_force_follows_what_is_needed_and_what_the_slip_has_shown_is_held() {
    let (mut grip, mut applied_n) = (holding(), 2.0);
    press(&mut grip, &slipping(slips(2.0, 2.0)), &mut applied_n, 100);
    assert!((applied_n - 2.12).abs() < 0.01, "the force of the least loss: {applied_n}");
    press(&mut grip, &slipping(slips(2.0, 8.0)), &mut applied_n, 25);
    assert!((applied_n - 8.48).abs() < 0.1, "{applied_n}");
    press(&mut grip, &slipping(slips(2.0, 6.0)), &mut applied_n, 100);
    assert!((applied_n - 6.36).abs() < 0.1, "it is lighter than it seemed: {applied_n}");
    let less = Forecast { best_n: 0.1, ..slips(2.0, 6.0) };
    press(&mut grip, &slipping(less), &mut applied_n, 300);
    assert!((applied_n - 2.04).abs() < 0.1, "no less than what it slipped under: {applied_n}");
    let doubted = Forecast { trusted: false, ..slips(2.0, 6.0) };
    press(&mut grip, &slipping(doubted), &mut applied_n, 100);
    assert!((applied_n - 6.36).abs() < 0.1, "{applied_n}");
    press(&mut grip, &slipping(slips(2.0, 5.0)), &mut applied_n, 48);
    assert!((applied_n - 6.36).abs() < 0.1, "nothing falls with a change of trust: {applied_n}");
    press(&mut grip, &slipping(slips(2.0, 5.2)), &mut applied_n, 150);
    assert!((applied_n - 5.512).abs() < 0.1, "{applied_n}");
    let end = ended(slips(2.0, 4.4), Some(4.4));
    press(&mut grip, &end, &mut applied_n, 1);
    assert_eq!(grip.state(), GripState::Holding);
    press(&mut grip, &calm(), &mut applied_n, 500);
    assert!((grip.command_n() - 5.5).abs() < 1e-3, "a quarter more: {}", grip.command_n());
    assert_eq!(grip.trials(), Trials { trials: 2, moved_m: 1e-4 });
}

/// A first slip is held with at most what stopped it.
#[test]
fn what_has_stopped_an_object_is_enough() {
    let (mut grip, mut applied_n) = (holding(), 2.0);
    press(&mut grip, &slipping(slips(2.0, 6.0)), &mut applied_n, 100);
    press(&mut grip, &ended(slips(2.0, 6.0), Some(6.0)), &mut applied_n, 1);
    press(&mut grip, &calm(), &mut applied_n, 500);
    assert!((grip.command_n() - 6.36).abs() < 0.01, "{}", grip.command_n());
}

/// The first answer, and how fast it rises from there, whatever is stated to be needed.
#[test]
fn a_rise_begins_with_a_share_and_never_runs_far_ahead_of_what_is_on_its_way() {
    let first = |slip: Forecast| {
        let mut grip = GripController::holding(config(), 2.0);
        grip.step(&GripInput { predicted_n: 2.0, ..slipping(slip) });
        grip.answer.target_n()
    };
    let needs = slips(2.0, 40.0);
    assert!((2.8..3.8).contains(&first(needs)), "{}", first(needs));
    let by_travel = Forecast { by_stylus: false, ..needs };
    assert!((2.3..3.3).contains(&first(by_travel)), "{}", first(by_travel));
    let known = Forecast { known: true, ..needs };
    assert!((2.0..2.9).contains(&first(known)), "{}", first(known));
    let mut grip = holding();
    for _ in 0..200 {
        grip.step(&GripInput { predicted_n: 2.0, ..slipping(needs) });
    }
    assert!(grip.answer.target_n() < 4.0, "2 N are on their way: {}", grip.answer.target_n());
}

#[test]
fn without_a_sensor_of_the_slip_the_force_grows_only_while_it_shows() {
    let blind = Forecast { informed: false, trusted: false, moved_m: None, ..slips(2.0, 0.0) };
    let (mut grip, mut applied_n) = (holding(), 2.0);
    press(&mut grip, &slipping(blind), &mut applied_n, 20);
    let grown = grip.answer.target_n();
    assert!(grown > 4.0 && grown < 8.0, "{grown}");
    let fading = Forecast { moves: false, ..blind };
    press(&mut grip, &GripInput { slip: SlipNow::Fading, ..slipping(fading) }, &mut applied_n, 60);
    assert!((grip.command_n() - grown).abs() < 0.01, "{} {grown}", grip.command_n());
    press(&mut grip, &ended(blind, Some(grown)), &mut applied_n, 1);
    press(&mut grip, &calm(), &mut applied_n, 500);
    assert!((grip.command_n() - grown).abs() < 0.01, "what stopped the slip is kept");
}

#[test]
fn an_alarm_without_movement_is_forgotten() {
    let mut grip = holding();
    let alarm = slips(2.0, 2.0);
    assert!(answer(&mut grip, &slipping(alarm), 5) > 2.3);
    answer(&mut grip, &ended(alarm, None), 1);
    rest(&mut grip, 100);
    assert_eq!((grip.command_n(), grip.trials().trials), (2.0, 1));
}

/// The force on its way back moves the pads: alarms by that begin from the force to hold with.
#[test]
fn alarms_do_not_add_up() {
    let mut grip = holding();
    let alarm = slips(2.0, 2.0);
    for _ in 0..20 {
        assert!(answer(&mut grip, &slipping(alarm), 5) <= 4.2);
        answer(&mut grip, &ended(alarm, None), 1);
        rest(&mut grip, 3);
    }
    rest(&mut grip, 100);
    assert_eq!(grip.command_n(), 2.0);
}

/// The first answer is a share of what is really held, whoever asked for it.
#[test]
fn what_slips_although_a_client_asked_for_more_is_answered_from_there() {
    let mut grip = holding();
    grip.at_least(10.0);
    rest(&mut grip, 1000);
    assert_eq!(grip.command_n(), 10.0);
    answer(&mut grip, &slipping(slips(10.0, 12.0)), 40);
    assert!((13.0..15.7).contains(&grip.command_n()), "{}", grip.command_n());
}

/// Lifting shears the pads: an alarm, but no need of what a client asked for.
#[test]
fn a_wish_is_taken_back_although_something_moved_meanwhile() {
    let mut grip = holding();
    grip.at_least(15.0);
    rest(&mut grip, 1000);
    assert!(answer(&mut grip, &slipping(slips(15.0, 4.0)), 40) >= 15.0);
    answer(&mut grip, &ended(slips(15.0, 4.0), None), 1);
    grip.at_least(0.0);
    rest(&mut grip, 2000);
    assert_eq!((grip.command_n(), grip.trials().trials), (2.0, 1));
}

#[test]
fn what_slips_although_more_was_asked_for_is_held_with_what_it_needs() {
    let mut grip = holding();
    grip.at_least(5.0);
    rest(&mut grip, 1000);
    let mut applied_n = 5.0;
    press(&mut grip, &slipping(slips(5.0, 9.0)), &mut applied_n, 40);
    grip.at_least(0.0);
    press(&mut grip, &ended(slips(5.0, 9.0), Some(9.0)), &mut applied_n, 1);
    press(&mut grip, &calm(), &mut applied_n, 1000);
    assert!((9.0..=11.7).contains(&grip.command_n()), "{}", grip.command_n());
}

/// A stylus with a loose contact alarms and fails, again and again.
#[test]
fn faults_in_alarms_do_not_add_up() {
    for since_s in [0.001, 0.02] {
        let mut grip = holding();
        for _ in 0..50 {
            let from_n = grip.command_n();
            let alarm = Forecast {
                since_s,
                p_null: if since_s > 0.01 { 0.9 } else { 0.0 },
                ..slips(from_n, from_n)
            };
            answer(&mut grip, &slipping(alarm), 1);
            grip.step(&GripInput { healthy: false, ..calm() });
            rest(&mut grip, 1);
        }
        rest(&mut grip, 3000);
        assert_eq!(grip.command_n(), 2.0, "{since_s}");
    }
}

#[test]
fn a_force_on_its_way_back_goes_on_after_a_fault() {
    let mut grip = holding();
    answer(&mut grip, &slipping(slips(2.0, 2.0)), 5);
    answer(&mut grip, &ended(slips(2.0, 2.0), None), 1);
    let before = grip.step(&calm());
    assert!(before > 2.3, "{before}");
    for _ in 0..100 {
        assert_eq!(grip.step(&GripInput { healthy: false, ..calm() }), before);
    }
    rest(&mut grip, 100);
    assert_eq!(grip.command_n(), 2.0);
}

#[test]
fn a_fault_in_a_slip_keeps_the_command_and_the_lead_is_given_back_after_it() {
    // The lag is learned while the fingers close.
    let (mut grip, mut applied_n) = (GripController::new(config()), 0.0);
    grip.grasp(None);
    press(&mut grip, &calm(), &mut applied_n, 400);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
    press(&mut grip, &slipping(slips(2.0, 8.0)), &mut applied_n, 6);
    let (led_n, target_n) = (grip.command_n(), grip.answer.target_n());
    assert!(led_n > target_n + 1.0, "led: {applied_n} N are measured");
    for _ in 0..100 {
        assert_eq!(grip.step(&GripInput { healthy: false, ..calm() }), led_n);
    }
    rest(&mut grip, 600);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, target_n));
}

#[test]
fn a_bad_sensor_freezes_the_force() {
    let mut grip = holding();
    for _ in 0..100 {
        let force = grip.step(&GripInput { healthy: false, ..slipping(slips(2.0, 50.0)) });
        assert_eq!(force, 2.0);
    }
    assert_eq!(grip.state(), GripState::Fault);
    grip.step(&calm());
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
}

#[test]
fn a_bad_sensor_interrupts_the_closing() {
    let mut grip = GripController::new(config());
    grip.grasp(None);
    rest(&mut grip, 20);
    let reached = grip.command_n();
    for _ in 0..1000 {
        assert_eq!(grip.step(&GripInput { healthy: false, ..calm() }), reached);
    }
    rest(&mut grip, 200);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 2.0));
}

#[test]
fn the_limit_stands() {
    let mut grip = holding();
    assert_eq!(answer(&mut grip, &slipping(slips(2.0, 1e30)), 1000), 60.0);
}

#[test]
fn a_fragile_object_has_a_ceiling_of_its_own() {
    let config = GripConfig { fragile_n: 3.0, ..config() };
    let mut grip = GripController::holding(config, 2.0);
    grip.at_least(50.0);
    for _ in 0..1000 {
        assert!(answer(&mut grip, &slipping(slips(2.0, 40.0)), 1) <= 3.0);
    }
    assert_eq!(grip.command_n(), 3.0);
    assert_eq!(GripController::holding(config, 20.0).command_n(), 3.0);
    assert!(GripConfig { fragile_n: 1.0, ..config }.check().is_err(), "below the trial force");
}

/// Evidence that has ended 20 ms ago raises nothing, though the target was not reached.
#[test]
fn old_evidence_raises_nothing() {
    let mut grip = GripController::holding(GripConfig { slew_n_s: 50.0, ..config() }, 2.0);
    let slip = slipping(slips(2.0, 30.0));
    answer(&mut grip, &slip, 10);
    let fading = GripInput { slip: SlipNow::Fading, ..slip };
    let reached = answer(&mut grip, &fading, 20);
    assert!(reached > 2.0 && reached < 30.0, "{reached}");
    assert!((0..1000).all(|_| answer(&mut grip, &fading, 1) <= reached));
    let stale = GripInput { stale: true, ..slip };
    assert!((0..1000).all(|_| answer(&mut grip, &stale, 1) <= reached));
}

/// Closes while the fingers are still on their way, since they can do no less than 20 N; the force comes behind a lag of 15 ms from touch on.
#[test]
fn the_way_to_the_object_is_no_delay_of_the_force() {
    const LEAST_N: f32 = 20.0;
    let config = GripConfig {
        trial_force_n: LEAST_N,
        least_force_n: LEAST_N,
        close_rate_n_s: 333.0,
        ..GripConfig::default()
    };
    let mut grip = GripController::new(config);
    grip.grasp(None);
    for _ in 0..100 {
        grip.step(&GripInput { touching: false, applied_n: Some(0.0), ..calm() });
    }
    let mut applied_n = 0.0;
    for _ in 0..300 {
        applied_n += (LEAST_N - applied_n) / 15.0;
        grip.step(&GripInput { applied_n: Some(applied_n), ..calm() });
    }
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, LEAST_N));
    let lag_s = grip.drive().delay_s();
    assert!((0.03..0.04).contains(&lag_s), "{lag_s}");
}

/// The command falls with the target in a slip, but fingers that hold something are never opened.
#[test]
fn a_force_on_its_way_down_keeps_the_touch() {
    let mut grip = GripController::holding(config(), 2.0);
    for _ in 0..200 {
        grip.step(&GripInput { predicted_n: 9.0, ..slipping(slips(0.1, 0.1)) });
        assert!(grip.command_n() >= config().least_force_n, "{}", grip.command_n());
    }
}

#[test]
fn a_lost_object_is_reported_once_and_keeps_the_force_until_it_is_touched_again() {
    let air = GripInput { applied_n: Some(0.01), touching: false, ..slipping(slips(2.0, 9.0)) };
    let mut grip = holding();
    for _ in 0..29 {
        grip.step(&air);
        assert_eq!((grip.state(), grip.event()), (GripState::Slipping, None));
    }
    grip.step(&air);
    assert_eq!((grip.state(), grip.event()), (GripState::Holding, Some(GripEvent::Lost)));
    let kept = grip.command_n();
    for _ in 0..1000 {
        assert_eq!((grip.step(&air), grip.event()), (kept, None), "nothing slips in the air");
    }
    assert!(grip.is_steady());
    grip.step(&GripInput { slip: SlipNow::No, ..calm() });
    assert_eq!((grip.state(), grip.event()), (GripState::Settling, Some(GripEvent::Regrasped)));
    assert_eq!(grip.trials(), Trials { trials: 1, moved_m: 0.0 });
    rest(&mut grip, 60);
    assert_eq!((grip.state(), grip.event()), (GripState::Holding, None));
}

#[test]
fn fingers_that_close_on_nothing_say_so_once() {
    let mut grip = GripController::new(config());
    grip.grasp(None);
    let mut reported = 0;
    for _ in 0..10_000 {
        grip.step(&GripInput { applied_n: Some(0.0), touching: false, ..calm() });
        reported += u32::from(grip.event() == Some(GripEvent::Empty));
    }
    assert_eq!((reported, grip.state(), grip.command_n()), (1, GripState::Closing, 0.2));
    let mut unmeasured = GripController::new(config());
    unmeasured.grasp(None);
    for _ in 0..10_000 {
        unmeasured.step(&GripInput { applied_n: None, ..calm() });
        assert_eq!(unmeasured.event(), None);
    }
    assert_eq!(unmeasured.state(), GripState::Holding);
}
