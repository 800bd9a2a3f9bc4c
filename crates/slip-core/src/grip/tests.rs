//! The controller on hand-made evidence.

use super::{
    GripConfig, GripController, GripEvent, GripInput, GripState, Sliding, SlipNow, Trials,
};

use crate::estimate::ForceEstimate;

mod hard;
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

fn slipping(moved_m: f32, estimate_n: Option<f32>) -> GripInput {
    let estimate = estimate_n.map(|estimate_n| ForceEstimate::new(estimate_n, 0.0));
    GripInput { slip: SlipNow::Evident, moved_m: Some(moved_m), estimate, ..calm() }
}

/// Nothing happens for `steps`.
fn rest(grip: &mut GripController, steps: u32) {
    for _ in 0..steps {
        grip.step(&calm());
    }
}

/// Tries 2 N and keeps that until something slips.
fn config() -> GripConfig {
    GripConfig {
        trial_force_n: 2.0,
        relax_per_s: 0.0,
        margin_sigmas: 1.0,
        ahead: 1.0,
        ..GripConfig::default()
    }
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
        assert_eq!(grip.step(&slipping(1e-3, Some(10.0))), 0.0);
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
}

#[test]
fn a_release_holds_until_it_is_ended_whatever_slips() {
    let mut grip = holding();
    grip.release();
    for _ in 0..100 {
        grip.grasp(Some(5.0));
        assert_eq!(grip.step(&slipping(1e-3, Some(10.0))), 0.0);
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
        let command_n = grip.step(&GripInput { applied_n: Some(*applied_n), ..*input });
        assert!((command_n - before_n).abs() <= 2000.0 * DT_S + 1e-4 && command_n <= 60.0);
        *applied_n += 0.2 * (command_n - *applied_n);
    }
}

#[test]
fn the_estimate_takes_over_from_the_reflex_and_is_held_after_the_slip() {
    let (mut grip, mut applied_n) = (holding(), 2.0);
    press(&mut grip, &slipping(1e-5, None), &mut applied_n, 100);
    assert!((applied_n - 2.5).abs() < 0.01, "a step of 25 % and no more: nothing has moved");
    press(&mut grip, &slipping(1e-3, Some(8.0)), &mut applied_n, 20);
    assert!((applied_n - 8.0).abs() < 0.1, "the measured force becomes the estimate: {applied_n}");
    press(&mut grip, &slipping(1e-3, Some(7.0)), &mut applied_n, 50);
    assert!((applied_n - 8.0).abs() < 0.01, "braking never lets go");
    press(&mut grip, &calm(), &mut applied_n, 1);
    assert_eq!(grip.state(), GripState::Holding);
    press(&mut grip, &calm(), &mut applied_n, 500);
    assert!(
        (grip.command_n() - 7.6).abs() < 1e-4,
        "what stopped it, less 5 %: {}",
        grip.command_n()
    );
    assert_eq!(grip.trials(), Trials { trials: 2, moved_m: 1e-3 });
}

#[test]
fn the_target_follows_a_load_that_grows_and_an_estimate_that_is_unsure_adds_its_deviation() {
    let target = |estimates: &[f32], sigma_n: f32| {
        let mut grip = holding();
        grip.step(&slipping(1e-3, None));
        for &estimate_n in estimates {
            let estimate = Some(ForceEstimate::new(estimate_n, sigma_n));
            grip.step(&GripInput { estimate, ..slipping(1e-3, None) });
        }
        grip.response.target_n()
    };
    assert_eq!(target(&[4.0; 9], 0.0), 4.0, "a load that stands");
    assert_eq!(target(&[4.0, 4.0, 4.0, 4.0, 4.5, 5.0], 0.0), 5.5, "4.5 N, and 1 N in 4 ms");
    assert_eq!(target(&[4.0, 4.0, 20.0], 0.0), 6.0, "two agree on 4 N: half of that at most");
    assert_eq!(target(&[4.0, 4.0, 20.0, 20.0], 0.0), 30.0, "two agree on 20 N");
    assert_eq!(target(&[4.0, 9.0, 4.0, 9.0, 4.0], 0.0), 6.0, "noise");
    assert_eq!(
        target(&[50.0], 0.0),
        3.125,
        "a first one, which nothing confirms: the reflex and a quarter"
    );
    assert_eq!(target(&[5.0, 5.0, 3.0], 0.0), 5.0, "braking never lets go");
    assert_eq!(target(&[4.0; 9], 0.5), 4.5, "a margin of one deviation");
    assert_eq!(target(&[4.0; 9], 1e9), 8.0, "an estimate that says nothing");
    let blind = target(&[f32::NAN, -3.0, f32::INFINITY], 0.0);
    assert!((2.5..2.6).contains(&blind), "no estimates at all, only the reflex: {blind}");
}

#[test]
fn without_an_estimate_the_reflex_grows_only_while_the_slip_shows() {
    let (mut grip, mut applied_n) = (holding(), 2.0);
    press(&mut grip, &GripInput { moved_m: None, ..slipping(0.0, None) }, &mut applied_n, 20);
    let grown = grip.response.target_n();
    assert!(grown > 4.0 && grown < 8.0, "{grown}");
    let fading = GripInput { slip: SlipNow::Fading, moved_m: None, ..calm() };
    press(&mut grip, &fading, &mut applied_n, 60);
    assert!((grip.command_n() - grown).abs() < 0.01, "{} {grown}", grip.command_n());
    press(&mut grip, &calm(), &mut applied_n, 500);
    assert_eq!(grip.command_n(), grown, "what stopped the slip is kept");
}

#[test]
fn an_alarm_without_movement_is_forgotten() {
    let mut grip = holding();
    for _ in 0..5 {
        grip.step(&slipping(0.0, None));
    }
    rest(&mut grip, 100);
    assert_eq!(grip.command_n(), 2.0);
}

/// The force on its way back moves the pads: alarms by that begin from the force to hold with.
#[test]
fn alarms_do_not_add_up() {
    let mut grip = holding();
    for _ in 0..20 {
        for _ in 0..5 {
            let command_n = grip.step(&GripInput { applied_n: None, ..slipping(0.0, None) });
            assert!(command_n <= 2.5, "{command_n}");
        }
        rest(&mut grip, 3);
        assert!(grip.state() == GripState::Holding && grip.command_n() > 2.2);
    }
    rest(&mut grip, 100);
    assert_eq!(grip.command_n(), 2.0);
}

/// The reflex is a share of what is really held, whoever asked for it.
#[test]
fn what_slips_although_a_client_asked_for_more_is_answered_from_there() {
    let mut grip = holding();
    grip.at_least(10.0);
    rest(&mut grip, 1000);
    assert_eq!(grip.command_n(), 10.0);
    for _ in 0..5 {
        grip.step(&GripInput { applied_n: None, ..slipping(0.0, None) });
    }
    assert_eq!(grip.command_n(), 12.5);
}

/// Lifting shears the pads: an alarm, but no need of what a client asked for.
#[test]
fn a_wish_is_taken_back_although_something_moved_meanwhile() {
    let mut grip = holding();
    grip.at_least(15.0);
    rest(&mut grip, 1000);
    for moved_um in 0..40_u8 {
        let moved_m = 1e-6 * f32::from(moved_um);
        grip.step(&GripInput { applied_n: None, ..slipping(moved_m, Some(4.0)) });
    }
    assert!(grip.command_n() >= 15.0);
    grip.step(&calm());
    assert_eq!(grip.weight_n, None, "nor does it tell the weight");
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
    press(&mut grip, &slipping(1e-3, Some(9.0)), &mut applied_n, 40);
    grip.at_least(0.0);
    press(&mut grip, &calm(), &mut applied_n, 1000);
    assert!((8.5..=9.0).contains(&grip.command_n()), "{}", grip.command_n());
}

/// Pads that swing 30 um forth and back, a little further each time.
#[test]
fn an_object_that_swings_on_its_pads_is_not_held_with_more_and_more() {
    let (mut grip, mut first) = (holding(), 0.0);
    for step in 0..20_000_u16 {
        let swing = 1.5e-5 * (0.05 * f32::from(step)).sin();
        let creep = 4e-8 * f32::from(step);
        let moved_m = Some(1.5e-5 + swing + creep);
        grip.step(&GripInput { moved_m, applied_n: None, ..slipping(0.0, None) });
        if step == 100 {
            first = grip.command_n();
        }
    }
    assert!(first < 4.0 && grip.command_n() == first, "{first} {}", grip.command_n());
}

/// The command (N) after 40 ms of a slip at 5 mm/s in which the acceleration (g) follows from the force.
fn slipped(mut acceleration_g: impl FnMut(f32) -> f32) -> f32 {
    let (mut grip, mut applied_n) = (holding(), 2.0);
    for step in 0..40_u16 {
        applied_n += 0.2 * (grip.command_n() - applied_n);
        let acceleration_g = acceleration_g(applied_n);
        let estimate_n = 1.2 * applied_n / (1.0 - acceleration_g);
        let sliding = Some(Sliding { force_n: applied_n, acceleration_g });
        let slip = slipping(5e-5 + 5e-6 * f32::from(step), Some(estimate_n));
        grip.step(&GripInput { sliding, applied_n: Some(applied_n), ..slip });
    }
    grip.command_n()
}

#[test]
fn pads_that_give_way_are_not_taken_for_a_load_that_grows() {
    let even_n = slipped(|_| -0.02);
    assert!(even_n < 8.0, "{even_n} N where 2 N slow it down");
    let grows_n = slipped(|_| 0.05);
    assert!(grows_n > 15.0, "{grows_n} N where it gets faster and faster");
    // A load of 8 N of an object that needs 10 N.
    let loaded_n = slipped(|force_n| 0.1 * (8.0 - force_n));
    assert!((9.0..12.0).contains(&loaded_n), "{loaded_n}");
}

#[test]
fn what_grew_in_a_pause_does_not_go_on_growing_that_fast() {
    let mut grip = holding();
    for (steps, estimate_n) in [(10, Some(5.0)), (15, None), (3, Some(9.0))] {
        for _ in 0..steps {
            grip.step(&slipping(5e-5, estimate_n));
        }
    }
    let target_n = grip.response.target_n();
    assert!((9.0..11.0).contains(&target_n), "{target_n}");
}

#[test]
fn faults_in_alarms_do_not_add_up() {
    let mut grip = holding();
    for _ in 0..50 {
        grip.step(&GripInput { applied_n: None, ..slipping(1e-6, None) });
        grip.step(&GripInput { healthy: false, ..calm() });
        grip.step(&calm());
    }
    assert!(grip.command_n() <= 2.5, "{}", grip.command_n());
}

#[test]
fn a_force_on_its_way_back_goes_on_after_a_fault() {
    let mut grip = holding();
    for _ in 0..5 {
        grip.step(&slipping(0.0, None));
    }
    grip.step(&calm());
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
    let mut grip = holding();
    for _ in 0..20 {
        grip.step(&slipping(1e-3, Some(8.0)));
    }
    let led_n = grip.command_n();
    assert!(led_n > 8.0, "led: 2 N are measured");
    for _ in 0..100 {
        assert_eq!(grip.step(&GripInput { healthy: false, ..calm() }), led_n);
    }
    rest(&mut grip, 300);
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, 8.0));
}

#[test]
fn a_bad_sensor_freezes_the_force() {
    let mut grip = holding();
    for _ in 0..100 {
        let force = grip.step(&GripInput { healthy: false, ..slipping(1.0, Some(50.0)) });
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
    for _ in 0..1000 {
        grip.step(&slipping(1.0, Some(1e30)));
    }
    assert_eq!(grip.command_n(), 60.0);
}

#[test]
fn a_fragile_object_has_a_ceiling_of_its_own() {
    let config = GripConfig { fragile_n: 3.0, ..config() };
    let mut grip = GripController::holding(config, 2.0);
    grip.at_least(50.0);
    for _ in 0..1000 {
        assert!(grip.step(&slipping(1.0, Some(40.0))) <= 3.0);
    }
    assert_eq!(grip.command_n(), 3.0);
    assert_eq!(GripController::holding(config, 20.0).command_n(), 3.0);
    assert!(GripConfig { fragile_n: 1.0, ..config }.check().is_err(), "below the trial force");
}

/// Evidence that has ended 20 ms ago raises nothing, though the target was not reached.
#[test]
fn old_evidence_raises_nothing() {
    let mut grip = GripController::holding(GripConfig { slew_n_s: 50.0, ..config() }, 2.0);
    for _ in 0..10 {
        grip.step(&slipping(1e-3, Some(30.0)));
    }
    let fading = GripInput { slip: SlipNow::Fading, ..slipping(1e-3, None) };
    for _ in 0..20 {
        grip.step(&fading);
    }
    let reached = grip.command_n();
    assert!(reached > 2.0 && reached < 30.0, "{reached}");
    for _ in 0..1000 {
        assert!(grip.step(&fading) <= reached);
    }
}

#[test]
fn a_lost_object_is_reported_once_and_keeps_the_force_until_it_is_touched_again() {
    let air = GripInput { applied_n: Some(0.01), touching: false, ..slipping(1e-3, Some(9.0)) };
    let mut grip = holding();
    for _ in 0..29 {
        grip.step(&air);
        assert_eq!((grip.state(), grip.event()), (GripState::Slipping, None));
    }
    grip.step(&air);
    assert_eq!((grip.state(), grip.event()), (GripState::Lost, Some(GripEvent::Lost)));
    let kept = grip.command_n();
    for _ in 0..1000 {
        assert_eq!((grip.step(&air), grip.event()), (kept, None), "nothing slips in the air");
        assert!(grip.is_steady());
    }
    // Sensors that fail then bring no object back.
    let mut blind = grip;
    blind.step(&GripInput { healthy: false, ..air });
    assert_eq!((blind.state(), blind.has_lost()), (GripState::Fault, true));
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
