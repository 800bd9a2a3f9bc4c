//! Grasps of gripd and of older laws, with other sensors and under trouble.

use grip_eval::{
    grasp::{Bench, GraspResult, Law, SensorSet, Stress, Way, total},
    trial,
};
use grip_session::{config::HostConfig, model};
use grip_sim::{Scene, scene};
use slip_core::units::Micros;

fn bench(seconds: f64) -> Bench {
    let estimator = model::default_estimator().unwrap();
    Bench { config: HostConfig::default(), estimator, duration: Micros((1e6 * seconds) as u64) }
}

fn grasp(name: &str, seed: u64, way: &Way) -> GraspResult {
    bench(2.0).grasp(&scene::load(name).unwrap(), seed, way).unwrap()
}

fn law(law: Law) -> Way {
    Way { law, ..Way::default() }
}

fn stress(name: &str) -> Way {
    Way { stress: Stress::named(name).unwrap(), ..Way::default() }
}

#[test]
fn without_trouble_it_is_the_trial_of_one_session() {
    let (bench, scene) = (bench(1.5), scene::load("default").unwrap());
    let seeded = scene.reseeded(3).unwrap();
    let alone =
        trial::grasp(&seeded, &bench.config, bench.estimator.clone(), bench.duration, &mut |_| ())
            .unwrap();
    let grasp = bench.grasp(&scene, 3, &Way::default()).unwrap();
    assert_eq!(grasp.force_final_n, alone.truth.applied_n);
    assert_eq!((grasp.slip_mm, grasp.slips), (alone.truth.slip_mm(), alone.slips));
    assert_eq!(bench.grasp(&scene, 3, &Way::default()).unwrap(), grasp, "the same again");
    assert!(grasp.held && grasp.roomy && grasp.stable_s > 0.0, "{grasp:?}");
    assert_eq!(grasp.needed_end_n, grasp.force_needed_n);
}

#[test]
fn an_object_that_was_never_gripped_counts_as_dropped() {
    let deaf = Scene::from_toml("name = \"deaf\"\n[noise]\nforce_mn = 1000\n").unwrap();
    let result = bench(2.0).grasp(&deaf, 1, &Way::default()).unwrap();
    // A light touch that such a sensor felt would be more than the trial force.
    assert!(result.dropped && !result.held && result.peak_command_n < 1.21, "{result:?}");
}

#[test]
fn a_law_without_feeling_presses_as_it_is_reported() {
    let fixed = grasp("raw_egg", 1, &law(Law::Fixed));
    assert!((fixed.force_final_n - 20.0).abs() < 0.01 && fixed.held, "{fixed:?}");
    assert!(grasp("foam", 1, &law(Law::Fixed)).crushed);
}

#[test]
fn the_oracle_applies_the_trial_force_until_the_slip_and_what_the_hold_needs_from_then_on() {
    for name in ["default", "oily_steel", "paper_cup", "tug", "wet"] {
        let oracle = grasp(name, 2, &law(Law::Oracle));
        assert!(oracle.held && oracle.slip_mm < 10.0, "{oracle:?}");
        let expected = 1.3 * oracle.force_needed_n;
        assert!((oracle.force_peak_n / expected - 1.0).abs() < 0.15, "{name}: {oracle:?}");
        assert!(oracle.slips == 1, "{oracle:?}");
    }
    let unmoved = grasp("raw_egg", 2, &law(Law::Oracle));
    let trial_n = f64::from(HostConfig::default().grip.trial_force_n);
    assert!(unmoved.slips == 0 || unmoved.force_peak_n > trial_n, "{unmoved:?}");
}

#[test]
fn the_oracle_acts_when_the_sample_of_the_slip_has_arrived() {
    let slip = |name: &str| grasp("default", 3, &Way { law: Law::Oracle, ..stress(name) });
    let (at_once, late) = (slip("none"), slip("link"));
    assert!(late.slip_mm > at_once.slip_mm + 0.05, "{at_once:?} {late:?}");
    assert!(late.held && (late.force_ratio - 1.3).abs() < 0.01, "{late:?}");
    // Nothing that the sensors read matters to it.
    let blind = slip("dead-stylus");
    assert_eq!((blind.slip_mm, blind.force_final_n), (at_once.slip_mm, at_once.force_final_n));
}

#[test]
fn laws_that_feel_slip_raise_the_force_and_none_raises_it_without() {
    for (named, seed) in [(Law::Pr2, 1), (Law::Fft, 1)] {
        let quiet = grasp("light_bulb", seed, &law(named));
        assert_eq!(quiet.slips, 0, "{quiet:?}");
        assert!((quiet.force_final_n - 1.2).abs() < 0.01, "{quiet:?}");
        let slipped = grasp("brick", seed, &law(named));
        assert!(slipped.slips > 0 && slipped.force_peak_n > 3.0, "{slipped:?}");
    }
}

#[test]
fn every_sensor_set_holds_a_light_object_by_its_reflex() {
    for sensors in SensorSet::ALL {
        let result = grasp("glass_bottle_empty", 4, &Way { sensors, ..Way::default() });
        assert!(!result.dropped && result.sensors == sensors.name(), "{result:?}");
    }
}

/// The pads of this scene let the stylus sink in by 2 um with each newton: without taking that away 3 of these objects are crushed.
#[test]
fn pads_that_give_way_under_the_force_are_no_surface_that_slips() {
    let sensors = SensorSet::named("stylus").unwrap();
    for seed in 3200..3212 {
        let result = grasp("shaken", seed, &Way { sensors, ..Way::default() });
        assert!(!result.dropped && !result.crushed, "{result:?}");
    }
}

/// The force in a slip is what the command stands for, and not what such a sensor shows: what the pads sink by goes by what is read.
#[test]
fn a_force_sensor_that_shows_too_much_makes_no_step_of_pads_that_sink() {
    let scene = Scene::from_toml("name = \"soft\"\npad.sink_um_n = 5\ngain.force = 1.3\n").unwrap();
    let sensors = SensorSet::named("travel").unwrap();
    for seed in 0..10 {
        let result = bench(2.0).grasp(&scene, seed, &Way { sensors, ..Way::default() }).unwrap();
        assert!(!result.dropped && !result.crushed, "{result:?}");
    }
}

/// What its stylus channel holds a gripper reports by the unit: an accelerometer holds what a stylus does, and needs no setting.
#[test]
fn a_stylus_channel_in_m_s2_is_a_vibration_and_holds() {
    let scene = Scene::from_toml(
        "name = \"finger\"\n[vibration]\nlevel = 20\nexponent = 1\n[channels]\ntravel = false\n",
    )
    .unwrap();
    let (bench, mut signals) = (bench(1.5), Vec::new());
    for seed in 0..6 {
        let scene = scene.reseeded(seed).unwrap();
        let setup = grip_eval::grasp::Setup {
            scene: &scene,
            config: &bench.config,
            duration: bench.duration,
            line: Stress::named("none").unwrap().line(seed),
            incident: None,
        };
        let mut report = |updates: grip_session::Update<'_>| {
            if let grip_session::Update::Began(beginning) = updates {
                signals.push(beginning.config.signal);
            }
        };
        let mut own =
            grip_eval::grasp::Own::new(&bench.config, bench.estimator.clone(), &mut report)
                .unwrap();
        let outcome = grip_eval::grasp::play(&setup, &mut own).unwrap();
        let truth = outcome.truth;
        assert!(!truth.dropped() && truth.slip_mm() < 15.0, "{seed}: {truth:?}");
        assert!(truth.force_peak_n < 3.0 * truth.force_needed_n, "{seed}: {truth:?}");
    }
    assert!(
        signals.len() == 6 && signals.iter().all(|signal| *signal == slip_core::Signal::Vibration)
    );
}

#[test]
fn latency_makes_a_slip_longer_and_losses_are_counted() {
    let slip = |name: &str| -> f64 {
        (0..4).map(|seed| grasp("default", seed, &stress(name)).slip_mm).sum()
    };
    assert!(slip("link") > slip("none") + 1.0);
    let (bench, scene) = (bench(1.0), scene::load("default").unwrap());
    let line = Stress::named("loss").unwrap().line(1);
    let setup = grip_eval::grasp::Setup {
        scene: &scene,
        config: &bench.config,
        duration: bench.duration,
        line,
        incident: None,
    };
    let mut silent = |_: grip_session::Update<'_>| ();
    let mut own =
        grip_eval::grasp::Own::new(&bench.config, bench.estimator.clone(), &mut silent).unwrap();
    let outcome = grip_eval::grasp::play(&setup, &mut own).unwrap();
    let share = outcome.lost as f64 / (outcome.lost + outcome.samples) as f64;
    assert!((0.02..0.08).contains(&share), "{outcome:?}");
}

#[test]
fn what_is_late_is_waited_for_and_not_pressed_harder() {
    for lag_ms in [30, 50] {
        let text = format!("name = \"late\"\n[drive]\nlag_ms = {lag_ms}\n");
        let scene = Scene::from_toml(&text).unwrap();
        for seed in 20..24 {
            let result = bench(2.0).grasp(&scene, seed, &Way::default()).unwrap();
            assert!(result.held && result.force_ratio < 1.4, "drive of {lag_ms} ms: {result:?}");
        }
    }
    // Some fall meanwhile, which no force that is commanded later can change.
    for seed in 20..32 {
        let result = grasp("default", seed, &stress("latency"));
        assert!(!result.crushed, "20 ms either way: {result:?}");
    }
}

/// None falls; of a hundred 4 to 7 are crushed (docs/results.md, under trouble), which is at most two of eighteen.
#[test]
fn a_coarse_travel_sensor_loses_no_object() {
    let mut crushed = Vec::new();
    for noise in ["travel_um = 10\ntravel_step_um = 20", "travel_step_um = 20", "travel_um = 10"] {
        let text = format!("name = \"coarse\"\n[noise]\n{noise}\n");
        let scene = Scene::from_toml(&text).unwrap();
        for seed in 20..26 {
            let result = bench(2.0).grasp(&scene, seed, &Way::default()).unwrap();
            let highest = result.force_peak_n / result.force_needed_n;
            assert!(!result.dropped && highest < 3.0, "{noise}: {result:?}");
            crushed.extend(result.crushed.then_some((noise, seed)));
        }
    }
    assert!(crushed.len() <= 2, "{crushed:?}");
}

/// Travel sensors that are read seldom, are late and have noise, on a gripper with a quick drive and on one driven by tendons.
#[test]
fn a_travel_that_is_read_seldom_crushes_nothing() {
    let noisy = |hz: u32| {
        format!("[noise]\ntravel_um = 10\n[reading]\ntravel_hz = {hz}\ntravel_delay_ms = 3\n")
    };
    let flow = "[noise]\ntravel_um = 2\ntravel_step_um = 5\n[reading]\ntravel_hz = 500\ntravel_delay_ms = 3\n";
    for sensors in
        [noisy(1000), noisy(500), flow.to_owned(), "[reading]\ntravel_hz = 200\n".to_owned()]
    {
        for drive in ["", "[drive]\nslew_max_n_s = 1000\nlag_ms = 15\nhysteresis = 0.15\n"] {
            let text = format!("name = \"seldom\"\n{sensors}{drive}");
            let scene = Scene::from_toml(&text).unwrap();
            for seed in 40..44 {
                let result = bench(2.0).grasp(&scene, seed, &Way::default()).unwrap();
                assert!(!result.dropped && !result.crushed, "{text}, seed {seed}: {result:?}");
            }
        }
    }
}

/// A serial converter whose latency timer was left at 16 ms: the command that a sample led to leaves with the last one of its batch. Such a force
/// sensor is neither late nor wrong.
#[test]
fn a_line_in_batches_crushes_nothing() {
    for drive in ["", "[drive]\nslew_max_n_s = 1000\nlag_ms = 15\nhysteresis = 0.15\n"] {
        let text = format!("name = \"batches\"\n[reading]\nbatch_ms = 16\n{drive}");
        let scene = Scene::from_toml(&text).unwrap();
        for seed in 40..52 {
            let result = bench(2.0).grasp(&scene, seed, &Way::default()).unwrap();
            assert!(!result.crushed, "{text}, seed {seed}: {result:?}");
        }
    }
}

/// The swings of a hand that shakes are felt on the pads while less and less is held, and are no slips.
#[test]
fn a_hand_that_shakes_hard_crushes_nothing() {
    for hz in [4.0, 8.0, 16.0] {
        let text = format!(
            "name = \"swings\"\nmass_kg = 0.5\nfriction = 0.3\nfriction_ratio = 1.0\n\
             [shake]\namplitude_m_s2 = 3.0\nfrequency_hz = {hz}\n"
        );
        let scene = Scene::from_toml(&text).unwrap();
        let grasps = (60..72).map(|seed| bench(6.0).grasp(&scene, seed, &Way::default()).unwrap());
        let grasps: Vec<GraspResult> = grasps.collect();
        assert!(!grasps.iter().any(|grasp| grasp.dropped), "{hz} Hz: {grasps:?}");
        let crushed = grasps.iter().filter(|grasp| grasp.crushed).count();
        assert!(crushed <= 1, "{hz} Hz: {crushed} of 12");
    }
}

#[test]
fn a_stylus_that_dies_during_the_hold_never_opens_the_fingers() {
    for seed in 0..6 {
        let dead = grasp("raw_egg", seed, &stress("dead-stylus"));
        assert!(dead.held, "{dead:?}");
        // It keeps what it held when the stylus died; the search for less ends there, and static friction may hold what sliding would not.
        assert!(dead.force_final_n > 0.8 * dead.force_needed_n, "{dead:?}");
        assert!(dead.force_peak_n < 1.4, "{dead:?}");
    }
}

#[test]
fn a_wrong_force_sensor_shows_in_the_force_at_most_by_its_error() {
    for seed in 0..4 {
        let result = grasp("default", seed, &stress("gain"));
        let calm = grasp("default", seed, &stress("none"));
        assert!(result.held, "{result:?}");
        assert!((result.force_ratio / calm.force_ratio - 1.0).abs() < 0.3, "{result:?} {calm:?}");
    }
}

#[test]
fn a_bump_that_is_over_is_still_in_the_needed_force_and_totals_leave_fallen_objects_out() {
    let scene: Scene = scene::load("bump").unwrap();
    let grasps: Vec<GraspResult> =
        (0..3).map(|seed| bench(2.5).grasp(&scene, seed, &law(Law::Oracle)).unwrap()).collect();
    for grasp in &grasps {
        assert!(grasp.force_needed_n > 1.4 * grasp.needed_end_n, "{grasp:?}");
    }
    let mut fallen = grasps[0].clone();
    fallen.dropped = true;
    fallen.slip_mm = 1e9;
    fallen.force_ratio = 0.0;
    let all: Vec<&GraspResult> = grasps.iter().chain([&fallen]).collect();
    let total = total("bump", &all);
    assert_eq!((total.trials, total.dropped, total.law), (4, 1, "oracle"));
    assert!(total.slip_mm.p95.unwrap() < 1e3 && total.within_1_4 == 3, "{total:?}");
}
