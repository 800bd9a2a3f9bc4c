//! Objects with known needs slip under a simple law; what the distribution states of them.

use super::{Alarm, Felt, Need};
use crate::{estimate::G_M_S2, sample::Signal};

const DT: f64 = 1e-4;

/// Uniform on 0..1, the same for the same seed.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 >> 33) ^ self.0;
        f64::from(u32::try_from(mixed & 0xffff_ffff).unwrap_or(0)) / f64::from(u32::MAX)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, self.next())
    }

    fn normal(&mut self) -> f64 {
        let r = libm::sqrt(-2.0 * libm::log(self.next().max(1e-12)));
        r * libm::cos(core::f64::consts::TAU * self.next())
    }
}

/// A profile of sines around one wavelength (m), with a mean height (m).
struct Surface([(f64, f64, f64); 12]);

impl Surface {
    fn draw(draw: &mut Draw) -> Self {
        let (wave, ra) = (draw.between(1e-4, 4e-4), draw.between(4e-7, 6e-6));
        let mut sines = [(0.0, 0.0, 0.0); 12];
        for sine in &mut sines {
            let share = 1.0 + 0.35 * draw.normal().clamp(-1.8, 1.8);
            *sine = (ra * 0.45, share * core::f64::consts::TAU / wave, 6.3 * draw.next());
        }
        Self(sines)
    }

    fn height(&self, x: f64) -> f64 {
        self.0.iter().map(|(a, k, phase)| a * libm::sin(k * x + phase)).sum()
    }
}

/// An alarm of a stylus with 0.1 um of noise.
fn alarm(force_n: f32, rested_s: f32) -> Alarm {
    Alarm { signal: Signal::Displacement, sigma: 1e-7, force_n, dt_s: 1e-4, rested_s }
}

/// What an object excites.
#[expect(clippy::large_enum_variant, reason = "one at a time")]
enum Excited {
    Stylus(Surface),
    /// Level at 0.1 m/s over the noise, the noise, and a mode of the finger at 300 Hz.
    Finger {
        level: f64,
        sigma: f64,
        ringing: [f64; 2],
    },
}

impl Excited {
    fn reading(&mut self, draw: &mut Draw, x: f64, v: f64) -> f64 {
        match self {
            Self::Stylus(surface) => surface.height(x) + 1e-7 * draw.normal(),
            Self::Finger { level, sigma, ringing: [last, before] } => {
                // Quality 5, with the gain of white noise.
                let (r, angle) = (0.9813, core::f64::consts::TAU * 0.03);
                let now = 2.0 * r * libm::cos(angle) * *last - r * r * *before
                    + 0.036 * *level * v / 0.1 * draw.normal();
                (*before, *last) = (*last, now);
                *sigma * (now + draw.normal() + 200.0)
            }
        }
    }

    /// Where the movement is noticed (m).
    fn noticed_m(&self) -> f64 {
        match self {
            Self::Stylus(_) => 8e-6,
            Self::Finger { .. } => 5e-5,
        }
    }

    fn alarm(&self, force_n: f32) -> Alarm {
        let stylus = alarm(force_n, f32::INFINITY);
        match self {
            Self::Stylus(_) => stylus,
            #[expect(clippy::cast_possible_truncation, reason = "readings are f32")]
            Self::Finger { sigma, .. } => {
                Alarm { signal: Signal::Vibration, sigma: *sigma as f32, ..stylus }
            }
        }
    }
}

/// A slip of an object that needs `need` (N), under 1.2 N at first and what the distribution asks for from then on, through a lag of 5 ms; the last word,
/// and the highest force over the need.
fn slip(mut draw: Draw, mut excited: Excited, need: f64, ramp_s: f64) -> (Felt, f64) {
    let mut state = Need::default();
    let (mut x, mut v, mut force, mut load) = (0.0_f64, 0.0_f64, 1.2_f64, 1.2 / need);
    let (mut target, mut peak, mut begun) = (1.2_f64, 0.0_f64, false);
    for i in 0..6000_u32 {
        load = if ramp_s > 0.0 { (load + DT / ramp_s).min(1.0) } else { 1.0 };
        v = (v + f64::from(G_M_S2) * (load - force / need) * DT).max(0.0);
        x += v * DT;
        force += (target - force) * DT / 0.005;
        peak = peak.max(force);
        #[expect(clippy::cast_possible_truncation, reason = "readings are f32")]
        let (reading, measured) = (excited.reading(&mut draw, x, v) as f32, force as f32);
        if !begun && x > excited.noticed_m() {
            begun = true;
            state.begin(&excited.alarm(measured));
        }
        if begun {
            state.push(reading, measured);
            let felt = state.felt().unwrap();
            if felt.held_n.is_some() {
                return (felt, peak / need);
            }
            let wanted = (1.35 * felt.median_n).min(1.6 * felt.low_n).min(1.7 * measured + 0.3);
            target = if i % 10 == 0 { f64::from(wanted).max(1.4 * 1.2) } else { target };
        }
    }
    (state.felt().unwrap(), peak / need)
}

/// Sorted ratios of what is reported over the truth.
fn held_over_need(ramp_s: f64, excite: impl Fn(&mut Draw) -> Excited) -> [f64; 60] {
    let mut draw = Draw(77);
    let mut ratios = core::array::from_fn(|seed| {
        let need = draw.between(2.0, 40.0);
        let mut own = Draw(seed as u64 + 1);
        for _ in 0..8 {
            own.next();
        }
        let excited = excite(&mut own);
        let most = if matches!(excited, Excited::Stylus(_)) { 3.0 } else { 4.0 };
        let (felt, peak) = slip(own, excited, need, ramp_s);
        assert!(peak < most, "{seed}: {need} N, {felt:?}, peak {peak}");
        let held_n =
            felt.held_n.unwrap_or_else(|| panic!("{seed}: {need} N never stopped, {felt:?}"));
        f64::from(held_n) / need
    });
    ratios.sort_by(f64::total_cmp);
    ratios
}

#[test]
fn objects_whose_load_is_there_at_once_are_known_after_the_stop() {
    let ratios = held_over_need(0.0, |draw| Excited::Stylus(Surface::draw(draw)));
    let (low, median, high) = (ratios[3], ratios[30], ratios[56]);
    assert!((0.97..1.05).contains(&median) && low > 0.9 && high < 1.35, "{ratios:?}");
}

/// An object that is stopped before its load is there has shown the load that was: the next slip shows the rest.
#[test]
fn a_load_that_comes_in_50_ms_is_not_taken_for_more() {
    let ratios = held_over_need(0.05, |draw| Excited::Stylus(Surface::draw(draw)));
    assert!((0.6..1.05).contains(&ratios[30]) && ratios[56] < 1.3, "{ratios:?}");
}

/// An accelerometer gives the same, in any unit and on top of gravity.
#[test]
fn a_finger_that_vibrates_shows_the_needed_force_in_any_unit() {
    let ratios = [1e-6, 1.0, 1e6].map(|sigma| {
        held_over_need(0.0, |draw| {
            let level = draw.between(5.0, 50.0);
            Excited::Finger { level, sigma, ringing: [0.0; 2] }
        })
    });
    for ratios in &ratios {
        let (low, median, high) = (ratios[3], ratios[30], ratios[56]);
        assert!((0.85..1.15).contains(&median) && low > 0.6 && high < 1.5, "{ratios:?}");
    }
    let median = |i: usize| ratios[i][30];
    assert!((median(0) / median(2) - 1.0).abs() < 0.02, "{} {}", median(0), median(2));
}

#[test]
fn quantiles_are_in_order_and_finite_whatever_is_read() {
    for (signal, sigma) in [
        (Signal::Displacement, 1e-7),
        (Signal::Vibration, 1e-7),
        (Signal::Vibration, 1e-12),
        (Signal::Vibration, 1e9),
    ] {
        let mut need = Need::default();
        let mut draw = Draw(5);
        need.begin(&Alarm { signal, sigma, ..alarm(1.2, f32::INFINITY) });
        for i in 0..20_000_u32 {
            let x = match i / 4000 {
                0 => 0.0,
                1 if signal == Signal::Vibration => 1e12 * draw.normal(),
                1 => 1.0,
                2 => draw.normal() * 1e-3,
                3 => 1e-4 * libm::sin(f64::from(i)),
                _ => draw.normal() * 1e-7,
            };
            #[expect(clippy::cast_possible_truncation, reason = "readings are f32")]
            need.push(x as f32, 60.0 * draw.next() as f32);
            let felt = need.felt().unwrap();
            assert!(
                felt.low_n > 0.0 && felt.low_n <= felt.median_n && felt.median_n < 1e6,
                "{signal:?} {i}: {felt:?}"
            );
            assert!(
                felt.held_n.is_none_or(|held| held >= 1.2 && held.is_finite()),
                "{signal:?} {i}: {felt:?}"
            );
        }
    }
}

#[test]
fn an_alarm_soon_after_a_stop_waits_until_something_moves() {
    let mut need = Need::default();
    let mut draw = Draw(9);
    let surface = Surface::draw(&mut draw);
    need.begin(&alarm(1.2, f32::INFINITY));
    let mut x = 0.0;
    for i in 0..600_u32 {
        x += if i < 300 { 3e-6 } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, reason = "readings are f32")]
        need.push((surface.height(x) + 1e-7 * draw.normal()) as f32, 4.0);
    }
    assert!(
        !need.felt().unwrap().moves && need.felt().unwrap().held_n.is_some(),
        "{:?}",
        need.felt()
    );
    need.begin(&alarm(4.0, 0.05));
    assert!(
        !need.felt().unwrap().moves && need.felt().unwrap().held_n.is_none(),
        "{:?}",
        need.felt()
    );
    for i in 0..300_u32 {
        x += if i > 150 { 3e-6 } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, reason = "readings are f32")]
        need.push((surface.height(x) + 1e-7 * draw.normal()) as f32, 4.0);
        assert!(i > 150 || !need.felt().unwrap().moves, "{i}");
    }
    assert!(
        need.felt().unwrap().moves && (need.felt().unwrap().first - 1.15).abs() < 1e-6,
        "{:?}",
        need.felt()
    );
}

/// What was kept while another sensor was in use is made up for, to the last bit.
#[test]
fn a_slip_that_another_sensor_reported_first_is_caught_up_with() {
    let mut draw = Draw(3);
    let surface = Surface::draw(&mut draw);
    let (mut whole, mut late) = (Need::default(), Need::default());
    whole.begin(&alarm(1.2, f32::INFINITY));
    late.begin(&alarm(1.2, f32::INFINITY));
    for i in 0..600_u32 {
        #[expect(clippy::cast_possible_truncation, reason = "readings are f32")]
        let x = (surface.height(5e-6 * f64::from(i)) + 1e-7 * draw.normal()) as f32;
        whole.push(x, 2.0);
        if i < 300 {
            late.keep(x, 2.0);
        } else {
            late.push(x, 2.0);
        }
    }
    assert_eq!(whole.felt(), late.felt());
    for _ in 0..2000 {
        late.keep(0.0, 2.0);
        assert_eq!(late.felt(), None);
    }
    late.push(0.0, 2.0);
    assert_eq!(late.felt(), None, "too long ago");
}
