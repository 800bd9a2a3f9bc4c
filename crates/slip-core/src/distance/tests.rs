use super::{Direction, DistanceConfig, Fingers, MovedDistance, TravelReading};
use crate::health::SensorHealth;
use crate::{detector::SlipState, error::ConfigError, units::Micros};

/// An encoder of 1 um with seeded jitter of +-1 um and a drift of 20 um/s, read at 10 kHz.
struct Encoder {
    i: u64,
    seed: u32,
}

impl Encoder {
    fn read(&mut self, true_m: f64) -> (Micros, f32) {
        self.i += 1;
        self.seed = self.seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let jitter = 2e-6 * (f64::from(self.seed) / f64::from(u32::MAX) - 0.5);
        let t_us = 100 * self.i;
        #[expect(clippy::cast_possible_truncation, reason = "test signal")]
        let shown = {
            let drift = 20e-6 * (t_us as f64 * 1e-6);
            (((true_m + jitter + drift) / 1e-6).round() * 1e-6) as f32
        };
        (Micros(t_us), shown)
    }
}

fn method(config: DistanceConfig) -> (MovedDistance, Encoder) {
    (MovedDistance::new(config).unwrap(), Encoder { i: 0, seed: 5 })
}

fn give(method: &mut MovedDistance, reading: (Micros, f32), fingers: Fingers) -> SlipState {
    let (t, travel_m) = reading;
    method.step(TravelReading { t, travel_m, fingers, others_gross: false });
    method.state()
}

#[test]
fn noise_quantisation_and_drift_are_no_slip_for_a_minute() {
    let (mut method, mut encoder) = method(DistanceConfig::default());
    let mut highest = 0.0_f32;
    for _ in 0..600_000 {
        assert_eq!(give(&mut method, encoder.read(0.0), Fingers::Still), SlipState::Quiet);
        highest = highest.max(method.statistic());
    }
    assert!(highest < 0.05, "at most 4 um of noise and resolution: {highest}");
    assert_eq!(method.health(), SensorHealth::Good);
}

#[test]
fn a_slip_is_reported_at_the_limit_and_ends_when_the_object_stands() {
    for sign in [1.0, -1.0] {
        let (mut method, mut encoder) = method(DistanceConfig::default());
        for _ in 0..1000 {
            give(&mut method, encoder.read(0.0), Fingers::Still);
        }
        let mut reported = None;
        for i in 0..1000_u16 {
            let moved = 0.02 * f64::from(i) * 1e-4;
            let state = give(&mut method, encoder.read(sign * moved), Fingers::Still);
            if reported.is_none() && state == SlipState::Gross {
                reported = Some(moved);
            }
        }
        let reported = reported.unwrap();
        assert!((reported - 1e-4).abs() < 5e-6, "{reported} m");
        let mut lasted = 0_u32;
        while give(&mut method, encoder.read(sign * 0.002), Fingers::Still) != SlipState::Quiet {
            lasted += 1;
        }
        assert!((450..560).contains(&lasted), "{lasted} samples");
        assert_eq!(method.statistic(), 0.0);
    }
}

#[test]
fn fingers_that_move_carry_the_roller_with_them() {
    let (mut method, mut encoder) = method(DistanceConfig::default());
    for i in 0..2000_u16 {
        let closing = 1e-6 * f64::from(i);
        assert_eq!(give(&mut method, encoder.read(closing), Fingers::Moving), SlipState::Quiet);
    }
    for _ in 0..1000 {
        assert_eq!(give(&mut method, encoder.read(0.002), Fingers::Still), SlipState::Quiet);
    }
    // A finger whose position is known is subtracted, and a slip in the motion is seen.
    method.prime();
    for i in 0..2000_u16 {
        let finger = 1e-6 * f64::from(i);
        #[expect(clippy::cast_possible_truncation, reason = "test signal")]
        let at = Fingers::At(finger as f32);
        assert_eq!(give(&mut method, encoder.read(finger), at), SlipState::Quiet);
    }
    let seen = (0..200_u16).any(|i| {
        let object = 0.002 + 1e-6 * f64::from(i);
        give(&mut method, encoder.read(object), Fingers::At(0.002)) == SlipState::Gross
    });
    assert!(seen);
}

#[test]
fn leaps_of_the_sensor_are_left_out_and_reported() {
    let (mut method, mut encoder) = method(DistanceConfig::default());
    let mut jumped = 0;
    for i in 0..20_000_u32 {
        let glitch = if i % 1000 == 500 { 0.01 } else { 0.0 };
        let lost_counts = if i >= 10_000 { -0.3 } else { 0.0 };
        let reading = encoder.read(glitch + lost_counts);
        assert_eq!(give(&mut method, reading, Fingers::Still), SlipState::Quiet, "{i}");
        jumped += u32::from(method.health() == SensorHealth::Jumped);
        let kept = method.without_leaps(reading.1);
        assert!((kept - 20e-6 * 2.0).abs() < 5e-5, "{kept} m at {i}");
    }
    assert_eq!((method.leaps(), method.health()), (41, SensorHealth::Good));
    assert!((41..1000).contains(&jumped), "{jumped}");
}

/// Read each 5 ms, asked at 10 kHz; it falls for 0.4 s, up to 3.9 m/s.
#[test]
fn what_moves_on_between_two_readings_is_no_leap() {
    let mut method =
        MovedDistance::new(DistanceConfig { max_speed_m_s: 5.0, ..DistanceConfig::default() })
            .unwrap();
    for i in 0..4000_u16 {
        let t_s = 1e-4 * f32::from(i - i % 50);
        let reading = (Micros(100 * u64::from(i)), 4.9 * t_s * t_s);
        give(&mut method, reading, Fingers::Still);
    }
    assert_eq!((method.leaps(), method.health()), (0, SensorHealth::Good));
    assert_eq!(method.noise().1, Some(Micros(5000)));
}

#[test]
fn a_channel_that_stands_while_the_object_slides_is_frozen() {
    let mut method = MovedDistance::new(DistanceConfig::default()).unwrap();
    let mut at = |i: u64, travel_m, others_gross| {
        let t = Micros(i * 100);
        method.step(TravelReading { t, travel_m, fingers: Fingers::Still, others_gross });
        method.health()
    };
    for i in 0..5000 {
        assert_eq!(at(i, 1e-3, false), SensorHealth::Good, "rest is not frozen");
    }
    let frozen = (5000..7000).find(|&i| at(i, 1e-3, true) == SensorHealth::Frozen).unwrap();
    assert!((5490..5520).contains(&frozen), "{frozen}");
    assert_eq!(at(7001, 1.001e-3, true), SensorHealth::Good);
}

#[test]
fn the_wrong_way_is_backwards_and_no_slip() {
    for (direction, sign) in [(Direction::Rising, -1.0), (Direction::Falling, 1.0)] {
        let (mut method, mut encoder) =
            method(DistanceConfig { direction, ..DistanceConfig::default() });
        for i in 0..200_u16 {
            let moved = sign * 2e-6 * f64::from(i);
            assert_eq!(give(&mut method, encoder.read(moved), Fingers::Still), SlipState::Quiet);
        }
        assert_eq!(method.health(), SensorHealth::Backwards);
        let back = (0..400_u16).any(|i| {
            let moved = sign * (4e-4 - 2e-6 * f64::from(i));
            give(&mut method, encoder.read(moved), Fingers::Still) == SlipState::Gross
        });
        assert!(back);
        assert_eq!(method.health(), SensorHealth::Good);
    }
}

#[test]
fn a_limit_below_the_resolution_is_refused() {
    let config = DistanceConfig { limit_m: 1e-6, ..DistanceConfig::default() };
    let Err(ConfigError::Range { name, .. }) = MovedDistance::new(config) else {
        panic!("accepted")
    };
    assert_eq!(name, "travel.limit_m");
}

/// The sum of four seeded uniform numbers, of deviation 1.
fn normal(encoder: &mut Encoder) -> f32 {
    let mut uniform = || {
        encoder.seed = encoder.seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(encoder.seed) / f64::from(u32::MAX) - 0.5
    };
    #[expect(clippy::cast_possible_truncation, reason = "test signal")]
    let sum = (0..4).map(|_| uniform()).sum::<f64>() as f32;
    1.732 * sum
}

/// A sensor that is noisier than configured: no slip at rest, one that begins is reported, and it ends.
#[test]
fn noise_that_nobody_configured_is_learned_at_rest() {
    for sigma_m in [2e-6_f32, 1e-5, 2e-5] {
        let (mut method, mut encoder) = method(DistanceConfig::default());
        let mut at = |method: &mut MovedDistance, moved_m: f32| {
            encoder.i += 1;
            let shown_m = moved_m + sigma_m * normal(&mut encoder);
            give(method, (Micros(100 * encoder.i), shown_m), Fingers::Still)
        };
        for i in 0..100_000 {
            let state = at(&mut method, 0.0);
            // Before the noise is known twenty micrometres of it may pass the limit.
            assert!(state == SlipState::Quiet || i < 1000, "{sigma_m}: sample {i}");
        }
        let slid =
            (0..1000_u16).filter(|&i| at(&mut method, 2e-6 * f32::from(i)) != SlipState::Quiet);
        assert!(slid.count() > 700, "{sigma_m}: a slip of 2 mm at 20 mm/s");
        let ended = (0..2000).any(|_| at(&mut method, 2e-3) == SlipState::Quiet);
        assert!(ended, "{sigma_m}");
    }
}
