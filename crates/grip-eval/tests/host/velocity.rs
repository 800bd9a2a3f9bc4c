//! The slip speed against what the simulator knows.

use grip_sim::{Grasp, Scene};
use slip_core::{
    units::Micros,
    velocity::{Measured, SpeedSource, Velocity, VelocityConfig, VelocityMeter},
};

/// An object that is let slip to `speed_m_s` and then carried by sliding friction at that speed: estimate and truth each millisecond.
fn slide(seed: u64, speed_m_s: f64) -> Vec<(Velocity, f64)> {
    let text = "name = \"slide\"\nmass_kg = 0.5\nfriction = 0.3\nfriction_ratio = 1.0\nroughness_ra_um = 1.6\n\
                second_stylus_mm = 0.5\nfinger_length_mm = 60.0\nlift_ramp_s = 0.0\n[drive]\nlag_ms = 0.5\nslew_max_n_s = 50000.0\n";
    let scene = Scene::from_toml(text).unwrap().reseeded(seed).unwrap();
    let mut grasp = Grasp::new(&scene);
    let config = VelocityConfig { spacing_m: 5e-4, ..VelocityConfig::default() };
    let mut meter = VelocityMeter::new(config, 10_000.0).unwrap();
    let needed_n = grasp.truth().force_needed_n;
    let (mut fast, mut out, mut begun) = (false, Vec::new(), Micros(0));
    while !grasp.truth().dropped() {
        fast |= grasp.truth().speed_m_s >= speed_m_s;
        let sample = grasp.step_sample(if fast { needed_n } else { 0.7 * needed_n });
        if !fast {
            meter.begin();
            begun = sample.t;
            continue;
        }
        meter.push(&sample);
        let velocity = meter.velocity(Measured::default(), sample.t.since(begun));
        let styli = velocity.filter(|v| v.source == SpeedSource::TwoStyli);
        if let Some(velocity) = styli.filter(|_| !grasp.truth().dropped()) {
            out.push((velocity, grasp.truth().speed_m_s));
        }
    }
    out
}

#[test]
fn two_styli_on_a_simulated_surface_report_the_speed_within_their_uncertainty() {
    for speed_m_s in [0.03, 0.06, 0.12] {
        let (mut squares, mut scaled, mut n) = (0.0, 0.0, 0.0);
        for seed in 0..5 {
            for (velocity, truth) in slide(seed, speed_m_s) {
                let error = f64::from(velocity.speed_m_s) - truth;
                squares += (error / truth).powi(2);
                scaled += (error / f64::from(velocity.sigma_m_s)).powi(2);
                n += 1.0;
            }
        }
        let (relative, sigmas) = (f64::sqrt(squares / n), f64::sqrt(scaled / n));
        println!(
            "{speed_m_s} m/s: {n} readings, error {relative:.4} of the speed, {sigmas:.2} sigma"
        );
        assert!(n > 500.0, "{speed_m_s} m/s: {n} readings");
        assert!(relative < 0.05 && sigmas < 2.0, "{speed_m_s} m/s: {relative}, {sigmas}");
    }
}
