//! The clock estimate against a known clock.

use grip_link::clock::{ClockSync, PongVerdict};
use grip_link::message::Pong;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// MCU of 1 MHz nominal that runs `ppm` fast and was at `tick0` at host time 0.
struct Mcu {
    ppm: f64,
    tick0: f64,
}

impl Mcu {
    fn tick(&self, host_us: f64) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive test times"
        )]
        let tick = (self.tick0 + host_us * (1.0 + self.ppm * 1e-6)) as u64;
        tick
    }

    fn pong(&self, t1: u64, there_us: f64, inside_us: f64, back_us: f64) -> (Pong, u64) {
        let arrival = t1 as f64 + there_us;
        let departure = arrival + inside_us;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive test times"
        )]
        let t4 = (departure + back_us) as u64;
        (Pong { t1_us: t1, rx_tick: self.tick(arrival), tx_tick: self.tick(departure) }, t4)
    }
}

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    f64::from(random.next_u32()) / f64::from(u32::MAX)
}

fn error_us(clock: &ClockSync, mcu: &Mcu, host_us: u64) -> f64 {
    let reported = clock.host_us(mcu.tick(host_us as f64)).unwrap();
    reported as f64 - host_us as f64
}

#[test]
fn converges_within_the_published_uncertainty() {
    for (seed, ppm) in [(1, 80.0), (2, -95.0), (3, 0.0), (4, 12.5)] {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mcu = Mcu { ppm, tick0: 5e9 };
        let mut clock = ClockSync::new(1_000_000, 1);
        let mut now = 1_000_000;
        for i in 0..120 {
            let jitter = if uniform(&mut random) < 0.1 { 3000.0 } else { 60.0 };
            let (pong, t4) = mcu.pong(
                now,
                80.0 + jitter * uniform(&mut random),
                40.0,
                80.0 + 30.0 * uniform(&mut random),
            );
            clock.push(&pong, t4);
            let error = error_us(&clock, &mcu, t4);
            assert!(
                error.abs() <= clock.uncertainty_us() + 2.0,
                "seed {seed}, pong {i}: {error} us"
            );
            now += if i < 8 { 50_000 } else { 1_000_000 };
        }
        assert!(
            (clock.drift_ppm().unwrap() - ppm).abs() < 1.0,
            "{:?} for {ppm}",
            clock.drift_ppm()
        );
        assert!((75.0..110.0).contains(&clock.uncertainty_us()), "{}", clock.uncertainty_us());
        assert!(error_us(&clock, &mcu, now + 10_000_000).abs() < 30.0);
        let tick = mcu.tick(now as f64);
        assert!(clock.tick(now).unwrap().abs_diff(tick) < 30);
    }
}

#[test]
fn slow_pongs_are_not_believed() {
    let mcu = Mcu { ppm: 0.0, tick0: 0.0 };
    let mut clock = ClockSync::new(1_000_000, 1);
    let (pong, t4) = mcu.pong(1000, 100.0, 10.0, 100.0);
    assert_eq!(clock.push(&pong, t4), PongVerdict::Kept);
    let (pong, t4) = mcu.pong(51_000, 16_000.0, 10.0, 100.0);
    assert_eq!(clock.push(&pong, t4), PongVerdict::Slow);
    assert!(error_us(&clock, &mcu, 51_000).abs() < 2.0);
}

#[test]
fn a_shorter_round_trip_throws_the_slow_ones_out() {
    let mcu = Mcu { ppm: 0.0, tick0: 0.0 };
    let mut clock = ClockSync::new(1_000_000, 1);
    for t1 in [1000, 51_000, 101_000] {
        let (pong, t4) = mcu.pong(t1, 900.0, 10.0, 100.0);
        clock.push(&pong, t4);
    }
    assert!(error_us(&clock, &mcu, 101_000).abs() > 300.0);
    let (pong, t4) = mcu.pong(151_000, 100.0, 10.0, 100.0);
    clock.push(&pong, t4);
    assert_eq!(clock.points(), 1);
    assert!(error_us(&clock, &mcu, 151_000).abs() < 2.0);
}

#[test]
fn outliers_are_rejected_and_a_stepped_clock_restarts() {
    let mcu = Mcu { ppm: 20.0, tick0: 1e6 };
    let mut clock = ClockSync::new(1_000_000, 1);
    let mut now = 0;
    for _ in 0..40 {
        let (pong, t4) = mcu.pong(now, 100.0, 10.0, 100.0);
        assert_eq!(clock.push(&pong, t4), PongVerdict::Kept);
        now += 1_000_000;
    }
    let stepped = Mcu { ppm: 20.0, tick0: 1e6 + 50_000.0 };
    for i in 0..8 {
        let (pong, t4) = stepped.pong(now, 100.0, 10.0, 100.0);
        let expected = if i < 7 { PongVerdict::Outlier } else { PongVerdict::Restarted };
        assert_eq!(clock.push(&pong, t4), expected, "{i}");
        if i < 7 {
            assert!(error_us(&clock, &mcu, now).abs() < 5.0, "outliers move nothing");
        }
        now += 1_000_000;
    }
    assert!(error_us(&clock, &stepped, now).abs() < 110.0);
}

#[test]
fn impossible_times_are_refused() {
    let mut clock = ClockSync::new(1_000_000, 1);
    let backwards = Pong { t1_us: 100, rx_tick: 50, tx_tick: 40 };
    assert_eq!(clock.push(&backwards, 200), PongVerdict::Impossible);
    assert_eq!(
        clock.push(&Pong { t1_us: 300, rx_tick: 40, tx_tick: 50 }, 200),
        PongVerdict::Impossible
    );
    assert_eq!(
        clock.push(&Pong { t1_us: 100, rx_tick: 0, tx_tick: 5000 }, 200),
        PongVerdict::Impossible
    );
    assert_eq!(clock.host_us(5), None);
}

#[test]
fn other_tick_rates_and_far_times() {
    let mut clock = ClockSync::new(168_000_000, 1);
    let base = 1_u64 << 62;
    for i in 0..100_u64 {
        let t1 = (1 << 53) + i * 1_000_000;
        let rx = base + (i * 1_000_000 + 100) * 168;
        assert_eq!(
            clock.push(&Pong { t1_us: t1, rx_tick: rx, tx_tick: rx + 1680 }, t1 + 210),
            PongVerdict::Kept
        );
    }
    let t = (1_u64 << 53) + 99_000_000;
    assert!(clock.host_us(base + 99_000_000 * 168).unwrap().abs_diff(t) <= 1);
    assert!(clock.drift_ppm().unwrap().abs() < 0.01);
}

/// A clock that runs 5 % off, from the start or from some time on, is followed within eight outliers: its rate is known to 0.3 % then and
/// the mapping is right to a millisecond, whatever the round trip.
#[test]
fn a_clock_of_another_rate_is_followed() {
    for ppm in [50_000.0, -50_000.0, 15_000.0, -15_000.0] {
        for (begins_us, trip_us) in
            [(0, 100.0), (0, 1000.0), (3_000_000, 100.0), (3_000_000, 1000.0)]
        {
            let (right, off) = (Mcu { ppm: 0.0, tick0: 1e9 }, Mcu { ppm, tick0: 1e9 });
            let mut random = ChaCha8Rng::seed_from_u64(7);
            let mut clock = ClockSync::new(1_000_000, 1);
            let (mut now, mut quick, mut followed_us) = (0, 8, None);
            while now < 8_000_000 {
                let mcu = if now < begins_us { &right } else { &off };
                let (there, back) =
                    (0.9 + 0.1 * uniform(&mut random), 0.9 + 0.1 * uniform(&mut random));
                let (pong, t4) = mcu.pong(now, trip_us * there, 20.0, trip_us * back);
                let verdict = clock.push(&pong, t4);
                quick = if verdict == PongVerdict::Outlier { 8 } else { quick - 1 };
                let known =
                    now >= begins_us && clock.rate_error().is_some_and(|error| error.abs() > 0.01);
                if followed_us.is_none() && known {
                    followed_us = Some(t4 - begins_us);
                }
                now += if quick > 0 { 50_000 } else { 1_000_000 };
                if let Some(after_us) = followed_us {
                    let error = error_us(&clock, &off, now);
                    assert!(
                        error.abs() < 3000.0,
                        "{ppm} ppm, {begins_us}, {trip_us}: {error} us after {after_us} us"
                    );
                }
                quick = quick.max(0);
            }
            let drift = clock.drift_ppm().unwrap();
            assert!((drift - ppm).abs() < 3000.0, "{drift} for {ppm}");
            assert!(
                followed_us.is_some_and(|us| us < 1_800_000),
                "{ppm} ppm, {begins_us}, {trip_us}: {followed_us:?}"
            );
        }
    }
}

#[test]
fn a_jitter_of_the_line_is_no_rate() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mcu = Mcu { ppm: 100.0, tick0: 0.0 };
    let mut clock = ClockSync::new(1_000_000, 1);
    let mut now = 0;
    for i in 0..200 {
        let late = if uniform(&mut random) < 0.3 { 8000.0 } else { 500.0 };
        let (pong, t4) =
            mcu.pong(now, late * uniform(&mut random), 20.0, late * uniform(&mut random));
        clock.push(&pong, t4);
        assert!(
            clock.rate_error().is_none_or(|error| error.abs() < 0.005),
            "{i}: {:?}",
            clock.rate_error()
        );
        now += if i < 8 { 50_000 } else { 1_000_000 };
    }
}

/// One quick answer and slow ones ever after, on a busy machine: a jump is found all the same.
#[test]
fn slow_answers_show_a_jump_too() {
    let mcu = Mcu { ppm: 0.0, tick0: 1e9 };
    let mut clock = ClockSync::new(1_000_000, 1);
    let (pong, t4) = mcu.pong(0, 20.0, 10.0, 20.0);
    clock.push(&pong, t4);
    for i in 1..20 {
        let (pong, t4) = mcu.pong(50_000 * i, 300.0, 10.0, 300.0);
        assert_eq!(clock.push(&pong, t4), PongVerdict::Slow);
    }
    let jumped = Mcu { ppm: 0.0, tick0: 1e9 + 5000.0 };
    for i in 20..28 {
        let (pong, t4) = jumped.pong(50_000 * i, 300.0, 10.0, 300.0);
        let wanted = if i < 27 { PongVerdict::Outlier } else { PongVerdict::Restarted };
        assert_eq!(clock.push(&pong, t4), wanted);
    }
    assert!(error_us(&clock, &jumped, 1_400_000).abs() < 310.0);
}
