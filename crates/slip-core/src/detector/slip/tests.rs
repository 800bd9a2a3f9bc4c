extern crate std;
use super::{DetectorConfig, KnownFloors, SlipDetector, SlipState};
use crate::{floor::FloorConfig, sample::Sample, units::Micros};

/// Uniform noise of deviation 0.1 um, seeded.
fn noise(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let unit = f64::from(state) / f64::from(u32::MAX) - 0.5;
        #[expect(clippy::cast_possible_truncation, reason = "test signal")]
        let x = (unit * 3.4641e-7) as f32;
        x
    }
}

fn sample(stylus: f32) -> Sample {
    Sample::stylus(Micros(0), stylus)
}

fn detector(rate_hz: f32) -> SlipDetector {
    let known = KnownFloors::default();
    SlipDetector::new(&DetectorConfig::default(), FloorConfig::default(), known, rate_hz).unwrap()
}

#[test]
fn rest_is_quiet_and_a_texture_is_gross_slip_within_milliseconds() {
    for rate in [1000_u16, 2200, 10_000, 20_000] {
        let mut detector = detector(f32::from(rate));
        let mut noise = noise(7);
        for _ in 0..20 * u32::from(rate) {
            if let Some((_, state)) = detector.step(&sample(1e-3 + noise())) {
                assert_eq!(state, SlipState::Quiet, "at {rate} Hz");
            }
        }
        assert!(!detector.is_learning());
        let mut found = None;
        for i in 0..rate {
            let phase = core::f32::consts::TAU * 250.0 * f32::from(i) / f32::from(rate);
            let verdict = detector.step(&sample(1e-3 + 3e-6 * libm::sinf(phase) + noise()));
            if verdict.is_some_and(|(_, state)| state == SlipState::Gross) {
                found = Some(f32::from(i) / f32::from(rate));
                break;
            }
        }
        assert!(found.unwrap() < 0.006, "at {rate} Hz: {found:?}");
    }
}

/// A piezo on loose wires: the mains, with two harmonics, at up to a hundred times the noise, and a scrape of 1.5 kHz at thirty times of it. Shear
/// and vibration see little but the hum. Prints when the alarm comes (docs/results/detection.md).
#[test]
fn hum_of_the_mains_hides_no_scrape() {
    let mains = [(10_000_u16, 50.0), (10_000, 60.0), (48_000, 50.0)];
    let cases =
        mains.into_iter().flat_map(|(rate, hz)| [0.0, 5.0, 20.0, 100.0].map(|n| (rate, hz, n)));
    for (rate, mains_hz, times) in cases {
        let (mut detector, mut noise) = (detector(f32::from(rate)), noise(11));
        let seconds = 10;
        let scrape_from = (seconds - 1) * u32::from(rate);
        let mut found = None;
        for i in 0..seconds * u32::from(rate) {
            let t = f64::from(i) / f64::from(rate);
            let wave = |hz: f64| libm::sin(core::f64::consts::TAU * (hz * t).fract());
            let hum = wave(mains_hz) + 0.2 * wave(2.0 * mains_hz) + 0.2 * wave(3.0 * mains_hz);
            let scrape = if i < scrape_from { 0.0 } else { 3e-6 * wave(1500.0) };
            #[expect(clippy::cast_possible_truncation, reason = "test signal")]
            let signal = (1e-7 * times * hum + scrape) as f32;
            let step = detector.step(&sample(signal + noise()));
            let state = step.map_or(SlipState::Quiet, |(_, state)| state);
            if i < scrape_from {
                assert_eq!(state, SlipState::Quiet, "at {rate} Hz, {t} s, mains {mains_hz} Hz");
            } else if state == SlipState::Gross {
                found = found.or(Some(t));
            }
        }
        let late = found.map(|t| t - f64::from(scrape_from) / f64::from(rate));
        std::println!(
            "{rate} Hz, mains {mains_hz} Hz at {times} times the noise: gross after {late:?} s"
        );
        assert!(late.is_some_and(|late| late < 0.005), "at {rate} Hz: {late:?}");
    }
}

/// A converter of 12 bits over 2 mm hides the noise that the floor is learned from: all readings are equal, until the load comes and moves the stylus
/// within a step or two.
#[test]
fn readings_that_step_by_more_than_their_noise_are_no_slip_and_a_texture_of_some_steps_is() {
    for rate in [1000_u16, 10_000] {
        let step_m = 4.9e-7;
        let coarse = |stylus_m: f32| step_m * libm::roundf(stylus_m / step_m);
        let (mut detector, mut noise) = (detector(f32::from(rate)), noise(9));
        for _ in 0..rate {
            detector.step(&sample(coarse(1e-3)));
        }
        assert!(!detector.is_learning());
        for i in 0..10 * u32::from(rate) {
            let creep_m = 1e-7 * i as f32 / f32::from(rate);
            let verdict = detector.step(&sample(coarse(1e-3 + creep_m + noise())));
            assert!(verdict.is_none_or(|(_, state)| state == SlipState::Quiet), "{i} at {rate} Hz");
        }
        let found = (0..rate).find(|i| {
            let phase = core::f32::consts::TAU * 250.0 * f32::from(*i) / f32::from(rate);
            let texture_m = coarse(1e-3 + 4e-6 * libm::sinf(phase) + noise());
            let verdict = detector.step(&sample(texture_m));
            verdict.is_some_and(|(_, state)| state == SlipState::Gross)
        });
        assert!(found.is_some_and(|i| i < rate / 100), "{found:?} at {rate} Hz");
    }
}

/// A tone of 5 um on stylus and reference is motion; the same on the stylus alone is a slip.
#[test]
fn what_the_reference_shows_too_is_motion() {
    let (mut detector, mut noise) = (detector(1e4), noise(5));
    let mut run = |stylus_m: f32, reference_m: f32| {
        let mut worst = 0.0_f32;
        for i in 0..10_000_u16 {
            // Swells within 0.1 s, as motion does.
            let swell = (f32::from(i) / 1000.0).min(1.0);
            let tone = swell * libm::sinf(0.1 * f32::from(i));
            let reference = Some(reference_m * tone + 0.5 * noise());
            let verdict = detector.step(&Sample { reference, ..sample(stylus_m * tone + noise()) });
            worst = worst.max(verdict.map_or(0.0, |(statistic, _)| statistic));
        }
        (worst, detector.is_moving())
    };
    assert!(run(0.0, 0.0).0 < 1.0, "rest");
    let (motion, moving) = run(5e-6, 5e-6);
    assert!(motion < 1.0 && moving, "motion {motion}");
    run(0.0, 0.0);
    assert!(run(5e-6, 0.0).0 > 1.0, "slip");
}

#[test]
fn a_slip_ends_after_the_release_time() {
    let mut detector = detector(1000.0);
    let mut noise = noise(3);
    for _ in 0..1000 {
        detector.step(&sample(noise()));
    }
    for i in 0..100_u16 {
        detector.step(&sample(noise() + if i % 4 < 2 { 3e-6 } else { -3e-6 }));
    }
    let mut lasted = 0_u32;
    while detector.step(&sample(noise())).is_some_and(|(_, state)| state != SlipState::Quiet) {
        lasted += 1;
    }
    assert!((50..200).contains(&lasted), "{lasted} ms");
}

#[test]
fn an_offset_does_not_look_like_a_step_when_the_filters_start() {
    let mut detector = detector(20_000.0);
    let mut noise = noise(11);
    for _ in 0..20_000 {
        detector.step(&sample(noise()));
    }
    for start in 0..50_u8 {
        detector.prime();
        let offset = 1e-4 * f32::from(start);
        for _ in 0..2000 {
            let verdict = detector.step(&sample(offset + noise()));
            assert!(verdict.is_none_or(|(statistic, _)| statistic < 1.0), "start {start}");
        }
    }
}

/// A reference that dies while the object is held: reported, and from then on as if there had never been one.
#[test]
fn a_dead_reference_is_reported_and_blinds_no_more_than_none() {
    use crate::health::SensorHealth;
    for frozen in [true, false] {
        let (mut detector, mut bare, mut noise) =
            (detector(10_000.0), detector(10_000.0), noise(9));
        let mut step = |reference: Option<f32>, stylus: f32| {
            let state = |verdict: Option<(f32, SlipState)>| verdict.map(|(_, state)| state);
            let without = state(bare.step(&sample(stylus)));
            let with = state(detector.step(&Sample { reference, ..sample(stylus) }));
            (with, without, detector.reference_health())
        };
        for _ in 0..10_000 {
            let (x, r) = (noise(), noise());
            assert_eq!(step(Some(r), x).2, SensorHealth::Good);
        }
        let dead = frozen.then_some(3e-8);
        let last = (0..5000).map(|_| step(dead, noise()).2).last().unwrap();
        assert_eq!(last, if frozen { SensorHealth::Frozen } else { SensorHealth::Lost });
        let mut seen = false;
        for i in 0..5000_u16 {
            let texture = 4e-7 * libm::sinf(0.1 * f32::from(i));
            let (with, without, _) = step(dead, texture + noise());
            assert_eq!(with, without, "sample {i}");
            seen |= with == Some(SlipState::Incipient);
        }
        assert!(seen, "a fine slip");
        assert_eq!(step(Some(noise()), noise()).2, SensorHealth::Good);
    }
}

/// Twenty seconds of motion that the reference shows with other gains than the stylus does: alarms, and whether a slip after them is noticed.
/// `motion` gives readings of both (m) from the time within every two seconds (s).
fn alarms_in(motion: impl Fn(f32) -> (f32, f32)) -> (usize, bool) {
    let (mut detector, mut noise) = (detector(1e4), noise(5));
    let mut step = |time_s: f32, moves: f32, slip_m: f32| {
        let (stylus_m, reference_m) = motion(time_s % 2.0);
        let reference = Some(moves * reference_m + 0.5 * noise());
        let stylus_m = moves * stylus_m + slip_m + noise();
        let verdict = detector.step(&Sample { reference, ..sample(stylus_m) });
        verdict.is_some_and(|(_, state)| state != SlipState::Quiet)
    };
    (0..10_000).for_each(|_| {
        step(0.0, 0.0, 0.0);
    });
    let (mut alarms, mut before) = (0, false);
    for i in 0..200_000_u32 {
        let alarm = step(1e-4 * (i % 20_000) as f32, 1.0, 0.0);
        alarms += usize::from(alarm && !before);
        before = alarm;
    }
    let texture = |i: u16| 5e-6 * libm::sinf(0.2 * f32::from(i));
    let noticed = (0..2000_u16).any(|i| step(0.5 + 1e-4 * f32::from(i), 1.0, texture(i)));
    (alarms, noticed)
}

fn tone(hz: f32, time_s: f32) -> f32 {
    libm::sinf(core::f32::consts::TAU * hz * time_s)
}

/// A knock has ways of its own to stylus and reference.
#[test]
fn a_knock_that_the_reference_shows_less_than_motion_is_no_slip() {
    let knock = |time_s: f32| {
        let stylus_m = 8e-6 * libm::expf(-time_s / 5e-3) * tone(400.0, time_s);
        (stylus_m, 0.42 * stylus_m)
    };
    assert_eq!(alarms_in(knock), (0, true));
}

/// Two or three alarms of ten swings show that this robot's motion shows more at the stylus than the gate assumes.
#[test]
fn motion_that_shows_more_at_the_stylus_is_learned() {
    let swing = |time_s: f32| {
        let burst_m = if time_s < 0.03 { 2e-5 * tone(0.5 / 0.03, time_s) } else { 0.0 };
        let (stylus_m, both_m) = (burst_m * tone(60.0, time_s), 1e-7 * tone(25.0, time_s));
        (stylus_m + both_m, 0.3 * stylus_m + both_m)
    };
    let (alarms, noticed) = alarms_in(swing);
    assert!((1..=3).contains(&alarms) && noticed, "{alarms}");
}
