extern crate std;
use super::{Measured, SpeedSource, TwoStylusDelay, VelocityConfig, VelocityMeter};
use crate::units::Micros;
use std::vec::Vec;

/// A rough surface: rounded asperities of seeded height and spacing (median 100 um), and seeded sensor noise.
struct Surface {
    ends_m: Vec<f64>,
    heights_m: Vec<f64>,
    seed: u32,
}

impl Surface {
    fn new(seed: u32) -> Self {
        let mut surface = Self { ends_m: Vec::new(), heights_m: Vec::new(), seed };
        let mut end = -0.02;
        while end < 0.8 {
            end += 1e-4 * (1.0 + 0.5 * surface.uniform());
            let height = 5e-6 * (1.0 + 0.6 * surface.uniform());
            surface.ends_m.push(end);
            surface.heights_m.push(height);
        }
        surface
    }

    /// Between -1 and 1.
    fn uniform(&mut self) -> f64 {
        self.seed = self.seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.seed >> 8) / 8_388_608.0 - 1.0
    }

    #[expect(clippy::cast_possible_truncation, reason = "a sensor reading")]
    fn read(&mut self, x_m: f64, noise_m: f64) -> f32 {
        let i = self.ends_m.partition_point(|end| *end <= x_m).max(1);
        let (from, to) = (self.ends_m[i - 1], self.ends_m[i]);
        let phase = core::f64::consts::TAU * (x_m - from) / (to - from);
        let noise = noise_m * (self.uniform() + self.uniform() + self.uniform());
        (2e-4 + 0.5 * self.heights_m[i] * (1.0 - libm::cos(phase)) + noise) as f32
    }
}

const SPACING_M: f64 = 1e-3;

/// Speed and deviation every 10 ms over 0.4 s of a slip at 10 kHz; `moved` gives the distance at a time.
fn run(seed: u32, noise_m: f64, moved: impl Fn(f64) -> f64) -> Vec<(f64, f32, f32)> {
    let config = VelocityConfig { spacing_sigma_m: 0.0, ..VelocityConfig::default() };
    let mut surface = Surface::new(seed);
    let mut styli = TwoStylusDelay::new(10_000.0, config.least_correlation);
    let mut out = Vec::new();
    for i in 0..8000_u32 {
        let t = f64::from(i) * 1e-4;
        let x = moved(t);
        let first = surface.read(x, noise_m);
        let second = surface.read(x - SPACING_M, noise_m);
        styli.push(first, second);
        if i % 100 == 99
            && let Some(delay) = styli.delay()
        {
            let velocity = config.two_styli(delay);
            out.push((t, velocity.speed_m_s, velocity.sigma_m_s));
        }
    }
    out
}

#[test]
fn two_styli_report_the_speed_within_their_uncertainty() {
    // Delays that are no whole number of samples.
    for (speed, noise_m) in [
        (0.0113, 1e-7),
        (0.0227, 1e-7),
        (0.0531, 1e-7),
        (0.107, 1e-7),
        (0.213, 1e-7),
        (0.0531, 1e-6),
        (0.107, 1e-6),
    ] {
        let (mut squares, mut errors, mut n) = (0.0, 0.0, 0.0);
        for seed in 0..8 {
            // The first readings of a level that is being filled count too.
            for (_, v, sigma) in run(seed, noise_m, |t| speed * t) {
                let error = f64::from(v) - speed;
                squares += (error / f64::from(sigma)).powi(2);
                errors += (error / speed).powi(2);
                n += 1.0;
            }
        }
        let (scaled, relative) = ((squares / n).sqrt(), (errors / n).sqrt());
        std::println!(
            "{speed} m/s, noise {noise_m}: {n} readings, error {relative:.4}, {scaled:.2} sigma"
        );
        assert!(n > 100.0, "{speed} m/s: {n} readings");
        assert!(
            relative < 0.05 && (0.1..1.5).contains(&scaled),
            "{speed} m/s: {relative}, {scaled}"
        );
    }
}

/// Waves must line up over the whole memory, which limits the acceleration to about v^2 / (48 spacing).
#[test]
fn a_slow_change_of_speed_is_followed_and_a_fast_one_reports_nothing_wrong() {
    let worst = |a: f64| {
        let readings = run(3, 1e-7, |t| 0.05 * t + 0.5 * a * t * t);
        let errors = readings.iter().map(|(t, v, _)| (f64::from(*v) / (0.05 + a * t) - 1.0).abs());
        (readings.len(), errors.fold(0.0, f64::max))
    };
    let (slow, fast) = (worst(0.01), worst(2.0));
    std::println!("0.01 m/s2: {slow:?}, 2 m/s2: {fast:?}");
    assert!(slow.0 > 30 && slow.1 < 0.05, "{slow:?}");
    assert_eq!(fast.0, 0);
}

#[test]
fn styli_that_see_different_things_report_nothing() {
    let mut noise = Surface::new(1);
    let mut styli = TwoStylusDelay::new(10_000.0, 0.7);
    for _ in 0..40_000 {
        let (a, b) = (noise.uniform(), noise.uniform());
        #[expect(clippy::cast_possible_truncation, reason = "test signal")]
        styli.push(a as f32, b as f32);
        assert_eq!(styli.delay(), None);
    }
}

/// Against the plain mean of products over the whole signal.
#[test]
fn the_delay_agrees_with_a_plain_correlation() {
    let mut surface = Surface::new(5);
    let (mut first, mut second) = (Vec::new(), Vec::new());
    let mut styli = TwoStylusDelay::new(10_000.0, 0.7);
    for i in 0..4000_u32 {
        let x = 0.2 * f64::from(i) * 1e-4;
        first.push(surface.read(x, 1e-7));
        second.push(surface.read(x - SPACING_M, 1e-7));
        styli.push(first[first.len() - 1], second[second.len() - 1]);
    }
    let mean = |v: &[f32]| v.iter().sum::<f32>() / 4000.0;
    let (m1, m2) = (mean(&first), mean(&second));
    let plain =
        |lag: usize| -> f32 { (64..4000).map(|i| (second[i] - m2) * (first[i - lag] - m1)).sum() };
    let best = (0..64).max_by(|a, b| plain(*a).total_cmp(&plain(*b))).unwrap();
    let found = f64::from(styli.delay().unwrap().seconds) * 1e4;
    let best = best as f64;
    assert!(
        (found - best).abs() < 1.0 && (found - SPACING_M / 0.2 * 1e4).abs() < 0.5,
        "{found} {best}"
    );
}

#[test]
fn travel_speed_is_as_uncertain_as_stated() {
    // 4 ms of a 1 um encoder with 0.3 um of jitter, 10,000 windows.
    let config = VelocityConfig::default();
    let mut noise = Surface::new(7);
    let mut squares = 0.0;
    for i in 0..10_000_u32 {
        let from = 1e-3 + 3.3e-8 * f64::from(i);
        let mut read = |x: f64| {
            let jitter = 3e-7 * (noise.uniform() + noise.uniform() + noise.uniform());
            ((x + jitter) / 1e-6).round() * 1e-6
        };
        let speed = (read(from + 0.05 * 0.004) - read(from)) / 0.004;
        squares += (speed - 0.05).powi(2);
    }
    let rms = (squares / 10_000.0).sqrt();
    let stated = f64::from(config.travel(0.05, 0.004, 1e-6).sigma_m_s);
    assert!((rms / stated - 1.0).abs() < 0.1, "{rms} of {stated}");
}

#[test]
fn gravity_covers_what_slips_do() {
    let config = VelocityConfig::default();
    // Accelerations between 0 and g, onsets known to some milliseconds.
    let mut draw = Surface::new(11);
    let mut within = 0;
    for _ in 0..1000 {
        let a = 4.903 * (1.0 + draw.uniform());
        let late = 0.005 * draw.uniform();
        let truth = a * (0.02 + late);
        let model = config.gravity(Micros(20_000)).unwrap();
        within +=
            i32::from((truth - f64::from(model.speed_m_s)).abs() < f64::from(model.sigma_m_s));
    }
    assert!((500..800).contains(&within), "{within} of 1000 within a deviation");
    assert_eq!(config.gravity(Micros(60_000)), None);
}

#[test]
fn the_rule_takes_the_fixed_then_the_surest_then_gravity() {
    let meter = VelocityMeter::new(VelocityConfig::default(), 10_000.0).unwrap();
    let source = |measured| meter.velocity(measured, Micros(10_000)).unwrap().source;
    assert_eq!(source(Measured::default()), SpeedSource::Gravity);
    let travel = Measured { travel: Some((0.05, 0.004, 1e-6)), ..Measured::default() };
    assert_eq!(source(travel), SpeedSource::Travel);
    let both = Measured { direct_m_s: Some(0.05), ..travel };
    assert_eq!(source(both), SpeedSource::Travel, "0.15 mm/s against 1 mm/s");
    let coarse = Measured { travel: Some((0.05, 0.004, 1e-4)), ..both };
    assert_eq!(source(coarse), SpeedSource::Direct);
    let fixed = Measured { fixed_m_s: Some(0.05), ..both };
    let velocity = meter.velocity(fixed, Micros(10_000)).unwrap();
    assert_eq!((velocity.source, velocity.sigma_m_s), (SpeedSource::Fixed, 0.05 * 0.02));
    assert_eq!(meter.velocity(Measured::default(), Micros(100_000)), None);
}
