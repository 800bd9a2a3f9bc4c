//! Pads that give way under a known law.

use super::*;
use crate::{sample::Sample, units::Micros};

const DT_S: f32 = 1e-4;

/// Noise between -1 and 1.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let value = (self.0 >> 8) as f32;
        value / 8_388_608.0 - 1.0
    }
}

fn sample(stylus: f32, force_n: f32) -> Sample {
    Sample { normal_force_n: Some(force_n), ..Sample::stylus(Micros(0), stylus) }
}

/// The fingers close to 1.2 N on pads that give way by `way` (m of N), the stylus has a noise of 0.1 um.
fn closed(noise: &mut Noise, way: impl Fn(f32) -> f32) -> Sink {
    let mut sink = Sink::default();
    sink.close(&sample(0.0, 0.0), false);
    for step in 0_u16..1000 {
        let force_n = (1.2 * f32::from(step) / 600.0).min(1.2);
        let reading = way(force_n) + 2e-7 * noise.next();
        assert!(
            sink.level(&sample(reading, force_n)).is_none(),
            "before a slip nothing is taken away"
        );
        sink.close(&sample(reading, force_n + 0.01 * noise.next()), true);
    }
    sink.settle();
    sink
}

/// A slip in which the force rises to 20 N in 40 ms over a surface of `height` (m); the largest error that is left of the levelled readings (m).
fn slip(sink: &mut Sink, noise: &mut Noise, height: f32, way: impl Fn(f32) -> f32) -> f32 {
    sink.begin(Some(1.2), 1.2, 1e-7, DT_S);
    let mut worst = 0.0_f32;
    let mut place = 0.0_f32;
    for step in 0_u16..600 {
        let force_n = 1.2 + 18.8 * (f32::from(step) / 400.0).min(1.0);
        place += if step % 20 == 0 { height * noise.next() } else { 0.0 };
        let reading = place + way(force_n) + 2e-7 * noise.next();
        let level = sink.level(&sample(reading, force_n)).map_or(reading, |level| level.stylus);
        worst = worst.max((level - place - way(1.2)).abs());
        sink.follow(force_n, force_n, DT_S);
    }
    sink.end();
    worst
}

#[test]
fn what_the_force_pushes_the_stylus_in_by_is_taken_away_in_a_slip() {
    for (um_per_n, left_um) in [(0.5, 1.0), (2.0, 1.5), (5.0, 3.0), (-2.0, 1.5)] {
        let way = |force_n: f32| 1e-6 * um_per_n * force_n;
        let noise = &mut Noise(7);
        let mut sink = closed(noise, way);
        let worst = slip(&mut sink, noise, 0.0, way);
        assert!(worst < 1e-6 * left_um, "{um_per_n} um/N: {worst}");
    }
}

/// The force of a Hertzian contact and less.
#[test]
fn pads_that_get_stiffer_are_followed_over_a_rough_surface() {
    let way = |force_n: f32| 4e-6 * force_n.powf(0.6);
    let pushed = way(20.0) - way(1.2);
    let noise = &mut Noise(11);
    let mut sink = closed(noise, way);
    let worst = slip(&mut sink, noise, 1e-6, way);
    // The slope at the trial force alone would leave 2.5 times of what they are pushed in by.
    assert!(worst < 0.6 * pushed, "{worst} of {pushed}");
}

#[test]
fn a_stylus_that_is_not_pushed_is_left_as_it_is() {
    let noise = &mut Noise(3);
    let mut sink = closed(noise, |_| 0.0);
    sink.begin(Some(1.2), 1.2, 1e-7, DT_S);
    for step in 0_u16..500 {
        let force_n = 1.2 + 0.1 * f32::from(step);
        assert_eq!(sink.level(&sample(3e-6, force_n)), None);
        sink.follow(force_n, force_n, DT_S);
    }
}

#[test]
fn after_a_slip_and_in_the_next_one_the_reading_does_not_jump() {
    let way = |force_n: f32| 2e-6 * force_n;
    let noise = &mut Noise(5);
    let mut sink = closed(noise, way);
    slip(&mut sink, noise, 0.0, way);
    let stylus = |sink: &mut Sink| sink.level(&sample(way(20.0), 20.0)).map(|level| level.stylus);
    let ended = stylus(&mut sink);
    assert!(ended.is_some_and(|stylus| (stylus - way(1.2)).abs() < 1.5e-6), "{ended:?}");
    sink.begin(Some(20.0), 20.0, 1e-7, DT_S);
    sink.follow(20.0, 20.0, DT_S);
    assert_eq!(stylus(&mut sink), ended);
    assert_eq!(sink.raw(), way(20.0));
}

/// A deviation of 0.1 N is 0.2 um at the stylus: taken away as it comes it would double the noise.
#[test]
fn the_noise_of_the_force_does_not_come_into_the_reading() {
    let (way, noise) = (|force_n: f32| 2e-6 * force_n, &mut Noise(17));
    let mut sink = Sink::default();
    for step in 0_u16..1000 {
        let force_n = (1.2 * f32::from(step) / 600.0).min(1.2);
        sink.close(&sample(way(force_n), force_n + 0.17 * noise.next()), true);
    }
    sink.settle();
    sink.begin(Some(1.2), 1.2, 1e-7, DT_S);
    let (mut squares, mut last) = (0.0, None);
    for step in 0_u16..1000 {
        // The command is known, the drive is a tenth slower than thought.
        let commanded_n = 1.2 + 10.0 * (f32::from(step) / 400.0).min(1.0);
        let force_n = 1.2 + 10.0 * (f32::from(step) / 440.0).min(1.0);
        let reading = way(force_n);
        let level = sink.level(&sample(reading, force_n)).map_or(reading, |level| level.stylus);
        squares += last.map_or(0.0, |last: f32| (level - last).powi(2));
        last = Some(level);
        sink.follow(force_n + 0.17 * noise.next(), commanded_n, DT_S);
    }
    let rms = (squares / 999.0).sqrt();
    assert!(rms < 1e-7, "from one reading to the next {rms}");
    let left = last.map(|level| level - way(1.2));
    assert!(left.is_some_and(|left| left.abs() < 4e-6), "{left:?} of 20 um");
}

#[test]
fn a_glitch_of_the_force_hardly_moves_the_reading() {
    let (way, noise) = (|force_n: f32| 2e-6 * force_n, &mut Noise(19));
    let mut sink = closed(noise, way);
    sink.begin(Some(1.2), 1.2, 1e-7, DT_S);
    for force_n in [1.2, 500.0, f32::NAN, 1.2, 1.2] {
        let level = sink.level(&sample(way(1.2), 1.2)).map_or(way(1.2), |level| level.stylus);
        assert!((level - way(1.2)).abs() < 2.5e-6, "{force_n} N: {level}");
        sink.follow(force_n, 1.2, DT_S);
    }
}

#[test]
fn a_force_that_is_none_or_never_changes_tells_nothing() {
    let mut sink = Sink::default();
    for force_n in [Some(f32::NAN), Some(f32::INFINITY), None, Some(1.2)] {
        for step in 0_u16..200 {
            let stylus = 1e-6 * f32::from(step);
            let still = Sample { normal_force_n: force_n, ..Sample::stylus(Micros(0), stylus) };
            sink.close(&still, true);
        }
        sink.settle();
        sink.begin(Some(1.0), 1.0, 1e-7, DT_S);
        sink.follow(30.0, 30.0, DT_S);
        assert_eq!(sink.level(&sample(1e-6, 30.0)), None, "{force_n:?}");
    }
}

/// The sums against the slow formula of two passes.
#[test]
fn the_slope_is_that_of_least_squares() {
    let noise = &mut Noise(13);
    let mut sink = Sink::default();
    let mut pairs = [(0.0_f64, 0.0_f64); 300];
    for (step, pair) in (0_u16..).zip(&mut pairs) {
        let force_n = 0.2 + f32::from(step) / 300.0;
        let reading = 3e-6 * force_n + 1e-7 * noise.next();
        sink.close(&sample(reading, force_n), true);
        *pair = (f64::from(force_n), f64::from(reading));
    }
    sink.settle();
    let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / 300.0;
    let (force_n, reading) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let product: f64 = pairs.iter().map(|(n, r)| (n - force_n) * (r - reading)).sum();
    let square: f64 = pairs.iter().map(|(n, _)| (n - force_n).powi(2)).sum();
    assert!((f64::from(sink.per_n) / (product / square) - 1.0).abs() < 1e-3, "{}", sink.per_n);
}
