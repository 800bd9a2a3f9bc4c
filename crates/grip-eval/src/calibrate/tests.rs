use super::{Calibrated, CalibrationError, STEADY, calibrate};
use core::f64::consts::TAU;
use grip_record::{Recording, Rows};
use grip_session::{
    HostConfig,
    calibration::{Calibration, Evidence, StylusCalibration},
    replay::{Replay, pipeline_config},
    report::EventLog,
};
use grip_sim::disturbance::Disturbance;
use slip_core::units::Micros;

const RATE_HZ: u32 = 2000;

/// Noise of a law, its sequence the same everywhere.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 31)
    }

    fn gauss(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// Student's with three degrees of freedom.
    fn t3(&mut self) -> f64 {
        let squares: f64 = (0..3).map(|_| self.gauss().powi(2)).sum();
        self.gauss() / (squares / 3.0).sqrt()
    }
}

/// What is beside the noise of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    White,
    T3,
    Clicks,
    Bursts,
    Steps,
    Hum,
    Coarse,
}

const KINDS: [Kind; 7] =
    [Kind::White, Kind::T3, Kind::Clicks, Kind::Bursts, Kind::Steps, Kind::Hum, Kind::Coarse];

/// A recording in which nothing slips.
#[derive(Clone, Copy, Debug)]
struct Work {
    kind: Kind,
    seconds: u32,
    /// With a robot that moves, and its reference.
    moves: bool,
    gaps: bool,
    seed: u64,
}

impl Work {
    fn reading(&self, noise: &mut Noise, t: f64, i: u32) -> f64 {
        let x = noise.gauss();
        let (second, within) = (i / RATE_HZ, i % RATE_HZ);
        match self.kind {
            Kind::White => x,
            Kind::T3 => noise.t3(),
            Kind::Clicks if within == 700 => x + 25.0,
            Kind::Bursts if (300..306).contains(&within) => 12.0 * x,
            Kind::Steps if second / 7 % 3 == 2 => 5.0 * x,
            Kind::Hum if second % 8 == 7 => x + 4.0 * (TAU * 50.0 * t).sin(),
            Kind::Coarse => (0.7 * x).round(),
            _ => x,
        }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "test data")]
    fn recording(&self) -> Recording {
        let mut noise = Noise(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut robot = Disturbance::new(1.0, 0.2, f64::from(RATE_HZ), self.seed);
        let names: &[&str] = if self.moves { &["stylus", "reference"] } else { &["stylus"] };
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        let mut rows = Rows::new("work", &names, RATE_HZ as f32).unwrap();
        let mut gap_s = 0.0;
        for i in 0..self.seconds * RATE_HZ {
            let t = f64::from(i) / f64::from(RATE_HZ);
            if self.gaps && i % (9 * RATE_HZ) == 0 {
                gap_s += 0.5;
            }
            let mut x_m = 1e-7 * self.reading(&mut noise, t, i);
            let motion = robot.next_sample();
            x_m += if self.moves { motion.stylus_m } else { 0.0 };
            let row = [x_m as f32, motion.reference_m as f32];
            rows.keep(Some(Micros((1e6 * (t + gap_s)) as u64)), &row[..names.len()]).unwrap();
        }
        rows.finish().unwrap()
    }
}

/// The slips of `gripctl replay`, with `calibration` or without.
fn replayed(recording: &Recording, calibration: Option<StylusCalibration>) -> u64 {
    let calibrated = calibration.map(Calibration::Stylus);
    let config = HostConfig { calibrated, ..HostConfig::default() };
    let pipeline = pipeline_config(recording, &config, false);
    let mut log = EventLog::default();
    Replay::new(recording, pipeline, None).unwrap().for_each(|step| {
        log.events(&step);
    });
    log.slips()
}

fn calibrated(recording: &Recording, interval_s: f64) -> StylusCalibration {
    let Calibrated { calibration, .. } =
        calibrate(recording, &HostConfig::default(), interval_s).unwrap();
    *calibration.stylus().unwrap()
}

/// Of every kind of recording, calibration counts what a replay shows, and leaves one slip at most.
#[test]
fn what_is_seen_is_what_a_replay_shows() {
    let (mut before, mut after) = (0, 0);
    for kind in KINDS {
        for (seed, moves, gaps) in [(1, false, false), (2, true, false), (3, false, true)] {
            let work = Work { kind, seconds: 40, moves, gaps, seed };
            let recording = work.recording();
            let made = calibrated(&recording, 600.0);
            let seen = replayed(&recording, Some(made));
            assert_eq!(made.evidence.seen, seen, "{work:?}");
            assert!(seen <= 1, "{work:?}: {seen}");
            assert!(made.evidence.interval_low_s <= made.evidence.judged_s / 2.99, "{work:?}");
            before += replayed(&recording, None);
            after += seen;
        }
    }
    assert!(before > 50 && after <= 3, "{before} before, {after} after");
}

/// The half that judges is not the half that the slack is from: what is promised of a recording is kept on the next of
/// its kind.
#[test]
fn the_promise_is_kept_on_another_recording() {
    let mut broken = Vec::new();
    for kind in KINDS {
        let work = Work { kind, seconds: 60, moves: false, gaps: false, seed: 11 };
        let made = calibrated(&work.recording(), 600.0);
        let slips = replayed(&Work { seed: 12, ..work }.recording(), Some(made));
        // 60 s at one in 10 s, and chance.
        if slips > 10 {
            broken.push((kind, slips));
        }
        assert!((9.0..11.0).contains(&made.evidence.interval_low_s), "{:?}", made.evidence);
    }
    assert!(broken.is_empty(), "{broken:?}");
}

#[test]
fn white_noise_needs_the_least_slack_and_hum_is_stated() {
    let of = |kind| {
        let work = Work { kind, seconds: 40, moves: false, gaps: false, seed: 5 };
        calibrated(&work.recording(), 60.0)
    };
    let (white, hum) = (of(Kind::White), of(Kind::Hum));
    assert!(white.slack_still[0] <= 1.6 && white.slack_still[1] <= 1.6, "{white:?}");
    // What does not decide at rest, and motion that was not recorded, keep what is shipped.
    assert_eq!(white.slack_still[2..4], [8.0; 2]);
    assert_eq!(white.slack_moving, [8.0, 3.0, 8.0, 8.0, 3.0, 3.0, 1.0]);
    assert!(white.evidence.unsteady < STEADY && white.evidence.unexplained_s == 0.0, "{white:?}");
    let Evidence { unsteady, unexplained_s, .. } = hum.evidence;
    assert!(unsteady > 10.0 && (4.5..6.5).contains(&unexplained_s), "{hum:?}");
    assert!(hum.slack_still[0] > 5.0, "{hum:?}");
    // The floor is that of the noise alone.
    let ratio = hum.floor[0] / white.floor[0];
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
    // Deafer by that, and no more.
    let smallest = |made: &StylusCalibration| made.evidence.smallest_rest.unwrap();
    assert!(smallest(&hum) >= smallest(&white), "{hum:?}");
}

/// A robot that moves from the first sample on is no unsteady rest; its motion has slack of its own.
#[test]
fn motion_has_slack_of_its_own() {
    for seed in [2, 4, 7] {
        let work = Work { kind: Kind::White, seconds: 60, moves: true, gaps: false, seed };
        let made = calibrated(&work.recording(), 60.0);
        let Evidence { unsteady, smallest_rest, smallest_motion, .. } = made.evidence;
        assert!(made.gain.is_some() && smallest_motion > smallest_rest, "{made:?}");
        assert!(unsteady < STEADY && made.evidence.unexplained_s == 0.0, "{made:?}");
        assert_eq!(made.slack_still[2..4], [8.0; 2], "they do not decide at rest");
        assert_ne!(made.slack_moving, [8.0, 3.0, 8.0, 8.0, 3.0, 3.0, 1.0]);
    }
}

/// A sensor that is silent for most of the recording is no sensor; one that was silent for a while is one.
#[test]
fn only_what_shows_nothing_is_refused() {
    let work = Work { kind: Kind::White, seconds: 20, moves: false, gaps: false, seed: 1 };
    let with = |dead_s: u32| {
        let mut recording = work.recording();
        for sample in recording.samples.iter_mut().take((dead_s * RATE_HZ) as usize) {
            sample.stylus = 1e-6;
        }
        calibrate(&recording, &HostConfig::default(), 60.0)
    };
    assert!(matches!(with(14), Err(CalibrationError::Unhealthy { health: "frozen", .. })));
    let made = with(5).unwrap();
    let rest_s = made.calibration.stylus().unwrap().evidence.rest_s;
    assert!((13.0..15.1).contains(&rest_s), "{rest_s}");
    let short = Work { seconds: 3, ..work }.recording();
    let refused = calibrate(&short, &HostConfig::default(), 60.0);
    assert!(matches!(refused, Err(CalibrationError::Short { .. })), "{refused:?}");
}
