//! A pipeline with the embedded model on an object of which the needed force is known: no simulator, only the law
//! of the falling object, a ramp of force and a texture.

use grip_session::{HostConfig, model};
use slip_core::{
    Pipeline, Sample, Signal,
    units::{Hertz, Micros},
};

const G: f64 = 9.806_65;
/// The adequate force that the model was trained for, over the needed one.
const SAFETY: f64 = 1.2;

/// What became of one object.
#[derive(Debug)]
struct Held {
    /// Estimates that were used, over the true adequate force, in order.
    ratios: Vec<f64>,
    applied_n: f64,
    travel_m: f64,
    speed_m_s: f64,
    ended: bool,
}

/// Steps of the law of motion between two samples.
const SUBSTEPS: u32 = 50;

impl Held {
    /// Fingers that follow with a lag of 5 ms, and an object that falls where friction needs `needed_n`.
    fn advance(&mut self, dt_s: f64, command_n: f64, needed_n: Option<f64>) {
        self.applied_n += (command_n - self.applied_n) * dt_s / 0.005;
        let Some(needed_n) = needed_n else { return };
        let speed = (self.speed_m_s + G * (1.0 - self.applied_n / needed_n) * dt_s).max(0.0);
        self.travel_m += 0.5 * (self.speed_m_s + speed) * dt_s;
        self.speed_m_s = speed;
    }
}

/// Grips, lifts at 0.7 s and holds until 1.6 s an object that needs `needed_n`.
fn hold(rate_hz: f64, needed_n: f64) -> Held {
    let mut config = HostConfig::default();
    // The object slips once, in its fall, and nothing is searched after it.
    (config.grip.trial_force_n, config.grip.relax_per_s) = (2.0, 0.0);
    let config = config.pipeline(Signal::Displacement, Hertz(rate_hz as f32));
    let estimator = model::default_estimator().unwrap();
    let mut pipeline = Pipeline::new(config, Some(estimator)).unwrap();
    let mut held =
        Held { ratios: Vec::new(), applied_n: 0.0, travel_m: 0.0, speed_m_s: 0.0, ended: false };
    let (mut command_n, mut noise) = (0.0, 1_u32);
    let dt_s = 1.0 / rate_hz;
    for i in 0..(1.6 * rate_hz) as u32 {
        let t_s = f64::from(i) * dt_s;
        for _ in 0..SUBSTEPS {
            held.advance(dt_s / f64::from(SUBSTEPS), command_n, (t_s > 0.7).then_some(needed_n));
        }
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise_m = 3.4e-7 * (f64::from(noise) / f64::from(u32::MAX) - 0.5);
        let phase = (held.travel_m / 3e-4).fract();
        let triangle_m = 1.2e-5 * (phase - 0.5).abs();
        let step = pipeline.handle(&Sample {
            normal_force_n: Some(held.applied_n as f32),
            travel_m: Some(held.travel_m as f32),
            ..Sample::stylus(Micros((t_s * 1e6).round() as u64), (triangle_m + noise_m) as f32)
        });
        command_n = f64::from(step.command.unwrap().0);
        let used = step.estimate.filter(|estimate| !estimate.extrapolated);
        held.ratios.extend(used.map(|estimate| f64::from(estimate.force_n) / (SAFETY * needed_n)));
        held.ended |= step.event.is_some_and(|slip| slip.phase == slip_core::Phase::Ended);
    }
    held
}

/// The network itself is off by up to 2.8 % at 2.2 kHz and 3.7 % at 1 kHz, where 25 N are needed and the object is braked hardest; which of these
/// points an estimate meets depends on how the force rises.
#[test]
fn the_estimate_is_off_by_few_percent_and_the_object_is_held_with_it() {
    for rate_hz in [1000.0, 2200.0, 10_000.0, 20_000.0] {
        for needed_n in [3.0, 6.0, 12.0, 25.0] {
            let held = hold(rate_hz, needed_n);
            let case = format!("{rate_hz} Hz, {needed_n} N");
            assert!(held.ratios.len() >= 5, "{case}: {} estimates", held.ratios.len());
            for ratio in &held.ratios {
                assert!(
                    (ratio - 1.0).abs() < if rate_hz > 1000.0 { 0.0315 } else { 0.0375 },
                    "{case}: an estimate of {ratio} times the right one"
                );
            }
            assert!(
                held.ended && held.speed_m_s == 0.0 && held.travel_m < 0.02,
                "{case}: {held:?}"
            );
            let share = held.applied_n / needed_n;
            assert!((1.0..1.3).contains(&share), "{case}: held with {share} of the needed force");
        }
    }
}
