use super::*;
use crate::GRAVITY_M_S2;
use crate::scene::{self, Object, SceneConfig};

fn scene(text: &str) -> Scene {
    let fixed = "name = \"test\"\nmass_kg = 0.4\nfriction = 0.3\nfriction_ratio = 1.0\nroughness_ra_um = 1.6\n";
    Scene::from_toml(&format!("{fixed}{text}")).unwrap()
}

/// Runs at a constant target until `seconds` or until the object is gone.
fn run(grasp: &mut Grasp, target_n: f64, seconds: f64) -> Vec<(Sample, Truth)> {
    let mut out = Vec::new();
    while grasp.truth().time_s < seconds && !grasp.truth().dropped() {
        let sample = grasp.step_sample(target_n);
        out.push((sample, grasp.truth()));
    }
    out
}

#[test]
fn without_friction_the_object_falls_freely() {
    let scene = scene("lift_at_s = 0.1\nlift_ramp_s = 0.0\nfinger_length_mm = 400.0\n");
    let object = Object { friction: 0.0, ..scene.object() };
    let mut grasp = Grasp::new(&scene.with_object(object));
    let rows = run(&mut grasp, 5.0, 0.45);
    let first = rows.iter().find(|(_, t)| t.travel_m > 0.0).unwrap().1;
    let lifted = first.time_s - first.speed_m_s / GRAVITY_M_S2;
    let last = rows.last().unwrap().1;
    let fallen = 0.5 * GRAVITY_M_S2 * (last.time_s - lifted).powi(2);
    assert!(last.travel_m > 0.25, "{last:?}");
    assert!((last.travel_m / fallen - 1.0).abs() < 1e-4, "{} {fallen}", last.travel_m);
}

#[test]
fn enough_force_allows_elastic_travel_and_creep_only() {
    // Loaded slowly to the share q of what it can hold, a LuGre pad of z_ss = mu N / sigma0 shears by q z_ss and
    // travels z_ss ln(1 / (1 - q)): the difference is creep (incipient slip).
    let mut grasp = Grasp::new(&scene("lift_ramp_s = 2.0\n"));
    let needed = grasp.truth().force_needed_n;
    assert!((needed - 0.4 * GRAVITY_M_S2 / 0.6).abs() < 1e-12);
    let last = run(&mut grasp, 1.2 * needed, 4.0).last().unwrap().1;
    let (share, saturated) = (1.0 / 1.2, 0.3 * 1.2 * needed / 1e5);
    assert!(last.phase == Phase::Lifted && last.speed_m_s.abs() < 1e-6, "{last:?}");
    assert!((last.shear_m / (share * saturated) - 1.0).abs() < 1e-3, "{last:?}");
    let travel = saturated * (1.0 / (1.0 - share)).ln();
    assert!((last.travel_m / travel - 1.0).abs() < 0.01, "{} {travel}", last.travel_m);
}

#[test]
fn a_quick_lift_with_enough_force_never_becomes_gross_slip() {
    let mut grasp = Grasp::new(&scene(""));
    let target = 1.2 * grasp.truth().force_needed_n;
    let rows = run(&mut grasp, target, 1.5);
    let last = rows.last().unwrap().1;
    let fastest = rows.iter().map(|r| r.1.speed_m_s).fold(0.0, f64::max);
    println!(
        "shear {:.1} um, creep {:.1} um, fastest {fastest:.1e} m/s",
        last.shear_m * 1e6,
        last.slip_mm() * 1e3
    );
    assert!(last.phase == Phase::Lifted && last.speed_m_s.abs() < 1e-6, "{last:?}");
    assert!(last.travel_m < 0.1e-3 && fastest < 5e-3, "{last:?} {fastest}");
}

#[test]
fn too_little_force_drops_and_too_much_crushes() {
    let mut weak = Grasp::new(&scene(""));
    let target = 0.5 * weak.truth().force_needed_n;
    let rows = run(&mut weak, target, 3.0);
    let (sample, truth) = rows.last().unwrap();
    assert!(truth.dropped() && !truth.crushed && truth.applied_n <= 0.0);
    assert!(sample.normal_force_n.unwrap().abs() < 0.05);

    let mut strong = Grasp::new(&scene(""));
    let target = 3.0 * strong.truth().force_needed_n;
    let rows = run(&mut strong, target, 1.0);
    assert!(rows.last().unwrap().1.crushed && !rows.last().unwrap().1.dropped());
}

#[test]
fn impulse_balance_gives_the_needed_force() {
    for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
        let scene = scene("lift_ramp_s = 0.0\n");
        let object = Object { friction_ratio: 1.1, ..scene.object() };
        let mut grasp = Grasp::new(&scene.with_object(object));
        let needed = grasp.truth().force_needed_n;
        let rows = run(&mut grasp, share * needed, 3.0);
        let slip: Vec<Truth> =
            rows.iter().map(|r| r.1).filter(|t| t.slipping && t.travel_m > 1e-3).collect();
        let (first, last) = (slip.first().unwrap(), slip.last().unwrap());
        let impulse: f64 =
            slip.windows(2).map(|w| 0.5 * (w[0].applied_n + w[1].applied_n) * 1e-4).sum();
        let duration = last.time_s - first.time_s;
        let found =
            GRAVITY_M_S2 * impulse / (GRAVITY_M_S2 * duration - (last.speed_m_s - first.speed_m_s));
        println!("rho {share}: F_req from impulse / true {:.5}", found / needed);
        assert!((found / needed - 1.0).abs() < 0.01, "rho {share}: {found} {needed}");
    }
}

#[test]
fn viscous_friction_ends_in_a_steady_speed() {
    for (viscous, mass_kg, target_n) in [(60.0, 0.4, 5.0), (150.0, 0.4, 5.6), (1000.0, 0.05, 0.2)] {
        let text = format!(
            "lift_ramp_s = 0.0\nviscous_n_s_m = {viscous:?}\nfinger_length_mm = 400.0\n[channels]\ntangential = true\n"
        );
        let mut config = scene(&text).config().clone();
        config.mass_kg = scene::Draw::Fixed(mass_kg);
        let mut grasp = Grasp::new(&Scene::new(config).unwrap());
        let load_n = mass_kg * GRAVITY_M_S2;
        let (sample, last) = run(&mut grasp, target_n, 1.4).pop().unwrap();
        let steady_m_s = (load_n - 2.0 * 0.3 * target_n) / viscous;
        assert!((last.speed_m_s / steady_m_s - 1.0).abs() < 1e-6, "{steady_m_s} {last:?}");
        assert!(last.slipping && last.phase == Phase::Lifted, "{last:?}");
        let tangential_n = f64::from(sample.tangential_n.unwrap());
        assert!((tangential_n - 0.5 * load_n).abs() < 0.03, "{tangential_n} of {load_n}");
        // What holds it does not depend on it.
        assert!((last.force_needed_n - load_n / 0.6).abs() < 1e-12, "{last:?}");
    }
}

#[test]
fn halving_the_step() {
    for (target, ratio) in [(2.0, 1.0), (4.0, 1.2), (6.0, 1.2), (7.0, 1.0)] {
        let path = |step_us: f64| -> Vec<f64> {
            let base = scene("");
            let config = SceneConfig { step_us, ..base.config().clone() };
            let scene = Scene::new(config).unwrap();
            let object = Object { friction_ratio: ratio, ..scene.object() };
            let mut grasp = Grasp::new(&scene.with_object(object));
            run(&mut grasp, target, 0.6).iter().map(|r| r.1.travel_m).collect()
        };
        let (coarse, fine) = (path(10.0), path(5.0));
        let worst = coarse.iter().zip(&fine).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let reach = fine.iter().copied().fold(0.0, f64::max);
        println!("{target} N: travel {reach:.2e} m moves by {worst:.2e} m ({:.2e})", worst / reach);
        assert!(worst < 2e-3 * reach, "{target} N: {worst} of {reach}");
        assert!(coarse.len().abs_diff(fine.len()) <= 1);
    }
}

#[test]
fn sensors_carry_the_noise_asked_for() {
    let mut grasp = Grasp::new(&scene("lift_at_s = 10.0\n"));
    run(&mut grasp, 5.0, 1.0);
    let (mut stylus, mut force) = (Vec::new(), Vec::new());
    for (sample, truth) in run(&mut grasp, 5.0, 3.0) {
        stylus.push(f64::from(sample.stylus));
        force.push(f64::from(sample.normal_force_n.unwrap()) - truth.applied_n);
        let steps = f64::from(sample.travel_m.unwrap()) / 1e-6;
        assert!((steps - steps.round()).abs() < 1e-4);
    }
    assert!((rms_about_mean(&stylus) / 1e-7 - 1.0).abs() < 0.03, "{}", rms_about_mean(&stylus));
    assert!((rms_about_mean(&force) / 5e-3 - 1.0).abs() < 0.03, "{}", rms_about_mean(&force));
}

fn rms_about_mean(values: &[f64]) -> f64 {
    let n = f64::from(u32::try_from(values.len()).unwrap());
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[test]
fn channels_can_be_absent_without_changing_the_others() {
    let mut all = Grasp::new(&scene(""));
    let mut bare = Grasp::new(&scene("[channels]\nforce = false\ntravel = false\n"));
    for _ in 0..6000 {
        let (a, b) = (all.step_sample(3.0), bare.step_sample(3.0));
        assert!(b.normal_force_n.is_none() && b.travel_m.is_none());
        assert_eq!((a.t, a.stylus.to_bits()), (b.t, b.stylus.to_bits()));
    }
}

/// FNV-1a over the bits of all readings.
fn fingerprint(seed: u64) -> u64 {
    let scene = scene::load("default").unwrap().reseeded(seed).unwrap();
    let mut grasp = Grasp::new(&scene);
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for _ in 0..8000 {
        let s = grasp.step_sample(2.0);
        let words = [s.stylus, s.normal_force_n.unwrap(), s.travel_m.unwrap()].map(f32::to_bits);
        for byte in words.iter().flat_map(|w| w.to_le_bytes()).chain(s.t.0.to_le_bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[test]
fn same_seed_same_samples() {
    assert_eq!(fingerprint(1), fingerprint(1));
    assert_ne!(fingerprint(1), fingerprint(2));
}

#[test]
fn sample_times_do_not_drift() {
    let clock = SampleClock::new(3000);
    assert_eq!((clock.ahead(1), clock.ahead(3000 * 3600)), (Micros(333), Micros(3_600_000_000)));
    let mut grasp = Grasp::new(&scene("sample_rate_hz = 3000\n"));
    let next = grasp.next_sample_at();
    assert_eq!(grasp.step_sample(0.0).t, next);
}

#[test]
fn another_sample_rate_changes_the_reading_not_the_fall() {
    let fall = |rates: [u32; 2]| {
        let mut grasp = Grasp::new(&scene(""));
        grasp.set_sample_rate(rates[0]);
        run(&mut grasp, 3.0, 0.2 - 1e-9);
        grasp.set_sample_rate(rates[1]);
        run(&mut grasp, 3.0, 0.5 - 1e-9);
        assert_eq!(grasp.now(), Micros(500_000));
        grasp.truth()
    };
    let (plain, mixed) = (fall([10_000, 10_000]), fall([20_000, 500]));
    assert!(plain.travel_m > 2e-3);
    assert!((mixed.travel_m / plain.travel_m - 1.0).abs() < 2e-3, "{mixed:?} {plain:?}");
}

#[test]
fn a_target_that_changes_within_a_period_is_followed() {
    let mut grasp = Grasp::new(&scene(""));
    grasp.set_sample_rate(20);
    let mut asked = Vec::new();
    grasp.step_sample_with(|t| {
        asked.push(t);
        5.0
    });
    assert_eq!(asked.len(), 50);
    assert!(asked.windows(2).all(|w| w[1] == w[0].plus(Micros(1000))) && asked[0] == Micros(0));
}

#[test]
fn faster_slip_shakes_the_stylus_more() {
    let dissipated = |target: f64| {
        let mut grasp = Grasp::new(&scene(""));
        run(&mut grasp, target, 0.4);
        let before = grasp.stylus_dissipated_j();
        run(&mut grasp, target, 1.4);
        (grasp.stylus_dissipated_j() - before, grasp.truth())
    };
    let (held, _) = dissipated(8.0);
    let (slipped, truth) = dissipated(3.0);
    assert!(truth.dropped());
    assert!(slipped > 100.0 * held.max(1e-12), "{slipped} {held}");
}

#[test]
fn a_clairvoyant_controller_holds_the_built_in_scenes() {
    for (name, _) in scene::BUILT_IN {
        let base = scene::load(name).unwrap();
        for (slew_n_s, delay_s) in [(500.0, 5e-3), (2000.0, 20e-3)] {
            // A light touch where 2 N would already crush.
            let trial_n = if name == "foam" { 1.0 } else { 2.0 };
            let controller = Clairvoyant { trial_n, slew_n_s, delay_s };
            let mut slips: Vec<f64> = (0..8)
                .map(|seed| {
                    let scene = base.reseeded(seed).unwrap();
                    assert!(perfect_controller_can_hold(&scene, controller), "{name} seed {seed}");
                    controller.play(&scene).slip_mm()
                })
                .collect();
            slips.sort_by(f64::total_cmp);
            println!(
                "{name}: {slew_n_s} N/s, {delay_s} s: slip mm p50 {:.2} max {:.2}",
                slips[4], slips[7]
            );
        }
    }
}

#[test]
fn a_slow_drive_cannot_hold_what_falls_almost_freely() {
    let heavy =
        Scene::from_toml("name = \"x\"\nmass_kg = 1.0\nfriction = 0.2\nlift_ramp_s = 0.0\n")
            .unwrap();
    let controller = |slew_n_s| Clairvoyant { trial_n: 2.0, slew_n_s, delay_s: 2e-3 };
    assert!(perfect_controller_can_hold(&heavy, controller(2000.0)));
    assert!(!perfect_controller_can_hold(&heavy, controller(200.0)));
}

#[test]
fn a_second_stylus_meets_the_same_places_later_and_changes_no_other_channel() {
    let text = "noise = { stylus_um = 0.0 }\n";
    let mut alone = Grasp::new(&scene(text));
    let mut both = Grasp::new(&scene(&format!("second_stylus_mm = 0.5\n{text}")));
    let (mut first, mut second, mut travel) = (Vec::new(), Vec::new(), Vec::new());
    while !both.truth().dropped() {
        let (a, b) = (alone.step_sample(2.0), both.step_sample(2.0));
        assert_eq!(
            (a.normal_force_n, a.travel_m, a.second_stylus),
            (b.normal_force_n, b.travel_m, None)
        );
        first.push(f64::from(b.stylus));
        second.push(f64::from(b.second_stylus.unwrap()));
        travel.push(both.truth().travel_m);
    }
    // Slow enough for both to ride the profile: compare at places 0.5 mm apart.
    let mut compared = 0;
    for (i, &x) in travel.iter().enumerate() {
        let j = travel.partition_point(|&later| later < x + 0.5e-3);
        if x > 1e-5 && x < 1e-3 && j < second.len() {
            assert!((first[i] - second[j]).abs() < 4e-6, "{} {}", first[i], second[j]);
            compared += 1;
        }
    }
    assert!(compared > 50, "{compared}");
}

/// Needed force from the impulse balance over a stretch of sliding under `target_n`, as a share of what `needed` states of the stretch.
fn balance(text: &str, target_n: f64, from_s: f64, needed: impl Fn(f64) -> f64) -> f64 {
    let scene = scene(&format!(
        "lift_at_s = 0.1\nlift_ramp_s = 0.0\nfinger_length_mm = 400.0\n[pad]\ndamping_n_s_m = 0.0\n{text}"
    ));
    let mut grasp = Grasp::new(&scene);
    let rows = run(&mut grasp, target_n, from_s + 0.3);
    let lift = rows.iter().find(|(_, t)| t.phase == Phase::Lifted).unwrap().1.time_s;
    let slide: Vec<Truth> =
        rows.iter().map(|r| r.1).filter(|t| t.time_s - lift > from_s && t.slipping).collect();
    let mut speed = slide[0].speed_m_s;
    for pair in slide.windows(2) {
        let middle = 0.5 * (pair[0].time_s + pair[1].time_s) - lift;
        let share = 0.5 * (pair[0].applied_n + pair[1].applied_n) / needed(middle);
        speed += (1.0 - share) * GRAVITY_M_S2 * (pair[1].time_s - pair[0].time_s);
    }
    speed / slide.last().unwrap().speed_m_s
}

#[test]
fn a_wet_contact_slides_as_its_friction_states() {
    let text = "[wet]\nfriction_ratio = 0.5\nstart_s = 0.0\nspread_s = 0.1\n";
    let weight = 0.4 * GRAVITY_M_S2 / 0.6;
    let ratio = balance(text, 6.6, 0.02, |t| weight / (0.5 + 0.5 * (-t / 0.1).exp()));
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn a_pull_and_what_is_poured_in_accelerate_as_newton_states() {
    // At a force that almost holds: m dv/dt = m g + P + m' (u - v) - 2 mu N, integrated by hand.
    let text = "[tug]\nforce_n = 2.0\nstart_s = 0.0\nrise_ms = 1.0\nhold_ms = 1000.0\n[fill]\nmass_kg = 0.4\nstart_s = 0.0\nduration_s = 1.0\nheight_mm = 200.0\n";
    let scene =
        scene(&format!("lift_at_s = 0.1\nlift_ramp_s = 0.0\nfinger_length_mm = 400.0\n{text}"));
    let mut grasp = Grasp::new(&scene);
    let rows = run(&mut grasp, 6.0, 0.5);
    let lift = rows.iter().find(|(_, t)| t.phase == Phase::Lifted).unwrap().1.time_s;
    let slide: Vec<Truth> = rows.iter().map(|r| r.1).filter(|t| t.time_s > lift + 0.05).collect();
    assert!(slide.len() > 1000 && slide.iter().all(|t| t.slipping));
    let poured_m_s = (2.0 * GRAVITY_M_S2 * 0.2).sqrt();
    let mut speed = slide[0].speed_m_s;
    for pair in slide.windows(2) {
        let mass = 0.4 + 0.4 * (pair[0].time_s - lift);
        let force =
            mass * GRAVITY_M_S2 + 2.0 + 0.4 * (poured_m_s - speed) - 0.6 * pair[0].applied_n;
        speed += force / mass * (pair[1].time_s - pair[0].time_s);
    }
    let last = slide.last().unwrap();
    assert!((speed / last.speed_m_s - 1.0).abs() < 0.005, "{speed} {last:?}");
    let mass = 0.4 + 0.4 * (last.time_s - lift);
    let needed = (mass * GRAVITY_M_S2 + 2.0 + 0.4 * poured_m_s) / 0.6;
    assert!((last.needed_now_n / needed - 1.0).abs() < 1e-4, "{needed} {last:?}");
    assert!((last.force_needed_n / last.needed_now_n - 1.0).abs() < 1e-3);
}

#[test]
fn a_bump_that_exceeds_the_grip_slips_by_its_excess() {
    // Held with 1.5 times the weight, hit by 20 m/s^2 over 20 ms: it slides while g + a exceeds 1.5 g, and brakes with 0.5 g after.
    let text = "[bump]\nacceleration_m_s2 = 20.0\nstart_s = 0.5\nduration_ms = 20.0\n";
    let mut grasp = Grasp::new(&scene(text));
    let weight = grasp.truth().force_needed_n;
    let rows = run(&mut grasp, 1.5 * weight, 1.6);
    let last = rows.last().unwrap().1;
    let (mut speed, mut slid, mut t) = (0.0_f64, 0.0, 0.0);
    while t < 0.5 {
        let bump = if t < 0.02 { 20.0 * (core::f64::consts::PI * t / 0.02).sin() } else { 0.0 };
        speed = (speed + (bump - 0.5 * GRAVITY_M_S2) * 1e-6).max(0.0);
        slid += speed * 1e-6;
        t += 1e-6;
    }
    // Touch after 0.1 s, lift 0.3 s later.
    let before = rows.iter().rev().find(|(_, t)| t.time_s < 0.895).unwrap().1;
    let slip = last.slip_mm() - before.slip_mm();
    // The pad's elastic shear takes up a part of the way.
    assert!((slip * 1e-3 / slid - 1.0).abs() < 0.15, "{slip} mm, {slid} m");
    assert!((last.force_needed_n / weight - 3.04).abs() < 0.01, "{last:?}");
    assert!((last.needed_now_n / weight - 1.0).abs() < 1e-12 && last.stable_after_s > 0.5);
}

#[test]
fn the_needed_force_of_a_hold_is_that_of_its_worst_moment() {
    let scene = scene("[tug]\nforce_n = 2.0\nstart_s = 1.0\nrise_ms = 50.0\nhold_ms = 300.0\n");
    let weight = scene.object().force_needed_n();
    assert_eq!((scene.force_needed_n(0.9), scene.force_needed_n(0.0)), (weight, weight));
    assert!((scene.force_needed_n(3.0) - weight - 2.0 / 0.6).abs() < 1e-9);
}

#[test]
fn the_tangential_force_of_a_finger_is_half_the_weight_and_gains_are_errors_of_scale() {
    let text =
        "[channels]\ntangential = true\n[gain]\nforce = 0.8\ntravel = 1.2\ntangential = 1.1\n";
    let mut wrong = Grasp::new(&scene(text));
    let mut right = Grasp::new(&scene("[channels]\ntangential = true\n"));
    let mean = |rows: &[(Sample, Truth)], of: fn(&Sample) -> f32| {
        let last = &rows[rows.len() - 2000..];
        last.iter().map(|(sample, _)| f64::from(of(sample))).sum::<f64>() / 2000.0
    };
    let of = |grasp: &mut Grasp| {
        let rows = run(grasp, 10.0, 1.5);
        assert!(rows[100].0.tangential_n.unwrap().abs() < 0.05, "before the lift");
        (
            mean(&rows, |s| s.normal_force_n.unwrap()),
            mean(&rows, |s| s.travel_m.unwrap()),
            mean(&rows, |s| s.tangential_n.unwrap()),
        )
    };
    let (right, wrong) = (of(&mut right), of(&mut wrong));
    assert!((right.2 - 0.2 * GRAVITY_M_S2).abs() < 1e-3, "{right:?}");
    for (name, ratio, gain) in [
        ("force", wrong.0 / right.0, 0.8),
        ("travel", wrong.1 / right.1, 1.2),
        ("tangential", wrong.2 / right.2, 1.1),
    ] {
        assert!((ratio / gain - 1.0).abs() < 0.01, "{name}: {ratio}");
    }
}

#[test]
fn rubber_and_a_tilted_hand_slide_as_their_friction_and_gravity_state() {
    let weight = 0.4 * GRAVITY_M_S2 / 0.6;
    // The balance of the forces, by hand: m x'' = m g cos(tilt) - 2 mu N (N / 10 N)^(p - 1).
    for (power, tilt_deg, target_n) in
        [(1.0, 60.0, 2.0), (2.0 / 3.0, 0.0, 3.0), (2.0 / 3.0, 30.0, 2.0)]
    {
        let scene = scene(&format!(
            "friction_power = {power}\ntilt_deg = {tilt_deg}\nlift_at_s = 0.1\nlift_ramp_s = 0.0\nfinger_length_mm = 400.0\n"
        ));
        let slide = run(&mut Grasp::new(&scene), target_n, 0.4);
        let slide: Vec<Truth> =
            slide.iter().map(|row| row.1).filter(|t| t.speed_m_s > 0.1).collect();
        let (first, last) = (slide[0], slide[slide.len() - 1]);
        let gained = (last.speed_m_s - first.speed_m_s) / (last.time_s - first.time_s);
        let friction_n = 2.0 * 0.3 * target_n * (target_n / 10.0).powf(power - 1.0);
        let along = GRAVITY_M_S2 * f64::to_radians(tilt_deg).cos();
        let expected = along - friction_n / 0.4;
        assert!((gained / expected - 1.0).abs() < 1e-3, "{power} {tilt_deg}: {gained} {expected}");
        // What holds it, by bisection of the same balance.
        let (mut low, mut high) = (0.0, 100.0);
        for _ in 0..60 {
            let middle: f64 = 0.5 * (low + high);
            let holds = 0.6 * middle * (middle / 10.0).powf(power - 1.0) > 0.4 * along;
            (low, high) = if holds { (low, middle) } else { (middle, high) };
        }
        let needed = scene.object().force_needed_n();
        assert!(
            (needed - low).abs() < 1e-9 && (first.force_needed_n - low).abs() < 1e-9,
            "{needed} {low}"
        );
        assert!(needed < weight, "less than upright with Coulomb friction: {needed}");
    }
}

#[test]
fn sensors_are_read_as_seldom_late_and_coarse_as_the_scene_states() {
    let ideal =
        "[noise]\nstylus_um = 0.0\nforce_mn = 0.0\ntravel_um = 0.0\ntravel_step_um = 0.001\n";
    let read = |reading: &str| {
        run(&mut Grasp::new(&scene(&format!("lift_at_s = 0.0\n{ideal}{reading}"))), 3.0, 0.3)
    };
    let (exact, read) = (
        read(""),
        read(
            "[reading]\ntravel_hz = 500.0\ntravel_delay_ms = 3.0\nforce_hz = 250.0\nforce_drift_mn_s = 100.0\nadc_bits = 12\n",
        ),
    );
    let step = 150.0 / 4096.0;
    for (i, (sample, truth)) in read.iter().enumerate() {
        let travel_m = i.checked_sub(30).map_or(0.0, |i| exact[i / 20 * 20].0.travel_m.unwrap());
        assert!((sample.travel_m.unwrap() - travel_m).abs() < 1e-9, "{i}");
        let at = read[i / 40 * 40].1;
        let force_n = f64::from(sample.normal_force_n.unwrap());
        assert!(
            (force_n - at.applied_n - 0.1 * at.time_s).abs() <= 0.5 * step + 1e-5,
            "{i} {force_n}"
        );
        assert!(((force_n / step).round() * step - force_n).abs() < 1e-5);
        assert!((sample.stylus - exact[i].0.stylus).abs() <= 0.5 * 2e-3 / 4096.0 + 1e-9);
        assert_eq!(*truth, exact[i].1);
    }
}
