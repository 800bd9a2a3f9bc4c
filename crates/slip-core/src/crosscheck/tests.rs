//! Two sensors that agree, or of which one fails.

use super::{CrossCheck, Seen, Whiteness};
use crate::units::Micros;

/// A slip of `ms` at 1 kHz with these statistics and travels (um), seen by `check`.
fn slip(check: &mut CrossCheck, from_ms: u64, ms: u16, both: impl Fn(u16) -> (f32, f32)) {
    check.begin();
    for i in 0..ms {
        let (statistic, um) = both(i);
        check.step(&Seen {
            t: Micros(1000 * (from_ms + u64::from(i))),
            dt_s: 1e-3,
            // A live sensor is never still to the last bit.
            travel_m: Some(1e-6 * um + 1e-7 * f32::from(i % 2)),
            sigma_m: 4e-7,
            leaps: 0,
            force_n: Some(2.0),
            stylus: Some(statistic),
            reading: if i % 2 == 0 { 1e-5 } else { 0.0 },
            noise: 1e-8,
            holds_alone: true,
        });
    }
}

fn verdict(check: &CrossCheck) -> [bool; 3] {
    [check.doubts_travel(), check.doubts_stylus(), check.is_undecided()]
}

#[test]
fn turns_closer_than_those_of_any_surface_leave_the_slip_to_the_stylus() {
    let mut check = CrossCheck::default();
    slip(&mut check, 0, 30, |ms| (100.0, 20.0 * f32::from(ms)));
    assert!(!check.suspects_travel(), "20 um a turn");
    // It falls, and the travel shows the beginning of that.
    let late = |ms: u16| (100.0, 0.05 * f32::from(ms).powi(2));
    slip(&mut check, 1000, 8, late);
    assert!(check.suspects_travel());
    slip(&mut check, 1000, 300, late);
    assert!(check.suspects_travel(), "late up to the end");
    slip(&mut check, 2000, 30, |ms| (100.0, 20.0 * f32::from(ms)));
    assert!(!check.suspects_travel(), "each slip by itself");
    // Pads swing by 12 um, and the stylus turns where they do.
    slip(&mut check, 3000, 48, |ms| (100.0, if ms % 2 == 0 { 0.0 } else { 24.0 }));
    assert!(!check.suspects_travel(), "forth and back");
}

#[test]
fn sensors_that_agree_are_believed() {
    let mut check = CrossCheck::default();
    for i in 0..10 {
        slip(&mut check, 1000 * i, 100, |ms| (50.0, 4.0 * f32::from(ms.min(60))));
        assert_eq!(verdict(&check), [false; 3], "with some ringing");
    }
}

#[test]
fn a_travel_that_never_moves_is_doubted_until_it_follows() {
    let mut check = CrossCheck::default();
    slip(&mut check, 0, 7, |_| (100.0, 0.3));
    assert_eq!(verdict(&check), [false; 3]);
    slip(&mut check, 0, 20, |_| (100.0, 0.3));
    assert_eq!(verdict(&check), [true, false, false]);
    slip(&mut check, 2000, 20, |ms| (100.0, 10.0 * f32::from(ms)));
    assert_eq!(verdict(&check), [false; 3]);
}

#[test]
fn one_that_followed_before_is_only_questioned_and_a_late_one_gives_itself_away() {
    let mut check = CrossCheck::default();
    slip(&mut check, 0, 30, |ms| (100.0, 20.0 * f32::from(ms)));
    slip(&mut check, 1000, 20, |_| (100.0, 0.3));
    assert_eq!(verdict(&check), [false, false, true]);
    slip(&mut check, 1300, 20, |ms| (0.0, 20.0 * f32::from(ms)));
    assert_eq!(verdict(&check), [true, false, false]);
}

#[test]
fn a_stylus_that_feels_nothing_is_doubted_until_it_feels_in_time() {
    let mut check = CrossCheck::default();
    slip(&mut check, 0, 30, |ms| (0.0, 20.0 * f32::from(ms)));
    assert_eq!(verdict(&check), [false, true, false]);
    slip(&mut check, 1000, 60, |ms| (if ms < 40 { 0.0 } else { 90.0 }, 20.0 * f32::from(ms)));
    assert_eq!(verdict(&check), [false, true, false], "too late");
    slip(&mut check, 2000, 60, |ms| (90.0, 20.0 * f32::from(ms)));
    assert_eq!(verdict(&check), [false; 3]);
}

#[test]
fn what_stops_dead_is_no_object() {
    let mut check = CrossCheck::default();
    slip(&mut check, 0, 30, |ms| (90.0, 100.0 * f32::from(ms.min(20))));
    assert_eq!(verdict(&check), [true, false, false]);
    let mut check = CrossCheck::default();
    // From 0.1 m/s at 5 m/s^2.
    let braked = |ms: u16| {
        let t = (1e-3 * f32::from(ms)).min(0.02);
        1e6 * (0.1 * t - 2.5 * t * t)
    };
    slip(&mut check, 0, 50, |ms| (90.0, braked(ms)));
    assert_eq!(verdict(&check), [false; 3]);
}

#[test]
fn noise_is_white_and_a_surface_is_not() {
    let mut random = 1_u32;
    let mut noise = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        6e-6 * (random as f32 / u32::MAX as f32 - 0.5)
    };
    let mut check = Whiteness::default();
    for _ in 0..60 {
        check.step(noise(), 4e-8);
    }
    assert!(check.is_noisy());
    for i in 0..200_u16 {
        check.step(8e-6 * libm::sinf(0.3 * f32::from(i)), 4e-8);
    }
    assert!(!check.is_noisy());
    let mut sound = Whiteness::default();
    for _ in 0..60 {
        sound.step(noise() / 30.0, 4e-8);
    }
    assert!(!sound.is_noisy(), "the noise that it always has");
}
