//! The small detector of the Arduino library (C99) beside [`Guard`] and [`SlipDetector`] in a still scene: the same states at the same
//! readings.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "test code"
)]

use slip_core::{
    Sample,
    detector::{DetectorConfig, KnownFloors, SlipDetector, SlipState},
    floor::FloorConfig,
    isolated::Guard,
    units::{Hertz, Micros},
};
use std::{
    env, fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::OnceLock,
};

fn arduino() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol/arduino")
}

fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c-detector");
        let result = Command::new("cc")
            .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O2"])
            .args(["-ffp-contract=off", "-I"])
            .arg(arduino().join("src"))
            .arg("-o")
            .arg(&program)
            .args(["src/slip_detector.c", "test/detector.c"].map(|source| arduino().join(source)))
            .arg("-lm")
            .output()
            .unwrap_or_else(|e| panic!("cc, which links Rust programs too, does not start: {e}"));
        assert!(result.status.success(), "{}", String::from_utf8_lossy(&result.stderr));
        program
    })
}

/// State (0 while the floor is learned, then 1 + [`SlipState`]), statistic, and noise of the vibration band after each reading.
type Steps = Vec<(u8, f32, f32)>;

/// Stands for a restart among readings.
const RESTART: f32 = f32::NEG_INFINITY;
/// Readings as large are left out.
const HUGE: f32 = 1e15;

fn in_c(rate_hz: f32, min_rms: f32, readings: &[f32]) -> Option<Steps> {
    let mut command = Command::new(program());
    command.args([rate_hz.to_string(), min_rms.to_string()]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let bytes: Vec<u8> = readings.iter().flat_map(|x| x.to_ne_bytes()).collect();
    // One that refuses its arguments reads nothing.
    let writer = std::thread::spawn(move || stdin.write_all(&bytes).is_ok());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    let figure = |bytes: &[u8]| f32::from_ne_bytes(bytes.try_into().unwrap());
    let step = |bytes: &[u8]| (bytes[0], figure(&bytes[1..5]), figure(&bytes[5..]));
    output.status.success().then(|| output.stdout.chunks_exact(9).map(step).collect())
}

fn in_rust(rate_hz: f32, min_rms: f32, readings: &[f32]) -> Steps {
    let floor = FloorConfig { min_rms, ..FloorConfig::default() };
    let config = DetectorConfig::default();
    let mut detector = SlipDetector::new(&config, floor, KnownFloors::default(), rate_hz).unwrap();
    let mut guard = Guard::new(Hertz(rate_hz));
    let mut last = (0, 0.0);
    let mut step = |x: &f32| {
        let code =
            |state| 1 + u8::from(state != SlipState::Quiet) + u8::from(state == SlipState::Gross);
        if *x == RESTART {
            detector.prime();
            guard.forget();
            last = (last.0.min(1), 0.0);
        } else if x.abs() < HUGE {
            guard.set_open(last.0 > 1);
            let x = guard.step([*x, 0.0, 0.0]).map_or(*x, |[x, ..]| x);
            if let Some((statistic, state)) = detector.step(&Sample::stylus(Micros(0), x)) {
                last = (code(state), statistic);
            }
        }
        (last.0, last.1, detector.noise_rms())
    };
    readings.iter().map(&mut step).collect()
}

const SAME: &str = "protocol/arduino/src/slip_detector.c has the detector, its thresholds and its floor once more: change both";

/// Asserts that both agree; gives how often the state changed.
fn compare(name: &str, rate_hz: f32, min_rms: f32, readings: &[f32]) -> usize {
    let (c, rust) =
        (in_c(rate_hz, min_rms, readings).unwrap(), in_rust(rate_hz, min_rms, readings));
    assert_eq!(c.len(), rust.len());
    for (at, (in_c, in_rust)) in c.iter().zip(&rust).enumerate() {
        let ((c_state, c_statistic, c_noise), (state, statistic, noise)) = (in_c, in_rust);
        assert_eq!(
            c_state, state,
            "{name}: reading {at} of {rate_hz} Hz, statistic {c_statistic} and {statistic}: {SAME}"
        );
        assert!(
            (c_statistic - statistic).abs() <= 1e-5 * statistic.abs() + 1e-12,
            "{name}: reading {at}, {c_statistic} and {statistic}: {SAME}"
        );
        assert!(
            (c_noise - noise).abs() <= 1e-5 * noise,
            "{name}: reading {at}, {c_noise}, {noise}: {SAME}"
        );
    }
    rust.windows(2).filter(|pair| pair[0].0 != pair[1].0).count()
}

/// Noise of deviation `rms` about `mean`, with tones of `amplitude` in two stretches of 0.2 s; rounded to `step` where that is above 0.
fn signal(rate_hz: f32, rms: f32, amplitude: f32, mean: f32, step: f32) -> Vec<f32> {
    let mut state = 12_345_u32;
    let mut uniform = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    // At low rates the floor takes longer.
    let slow = (400.0 / rate_hz).max(1.0);
    (0..(3.5 * slow * rate_hz) as usize)
        .map(|i| {
            let t = i as f32 / rate_hz;
            let slides = [1.0, 2.0].iter().any(|begin| (0.0..0.2).contains(&(t / slow - begin)));
            let tone = if slides {
                amplitude * (2.0 * core::f32::consts::PI * (0.25 * rate_hz).min(500.0) * t).sin()
            } else {
                0.0
            };
            let noise = rms * (0..12).map(|_| uniform()).sum::<f32>();
            let x = mean + noise + tone;
            if step > 0.0 { (x / step).round() * step } else { x }
        })
        .collect()
}

#[test]
fn states_are_those_of_slip_core_at_every_rate_unit_and_resolution() {
    for rate_hz in [65.0, 100.0, 250.0, 500.0, 1000.0, 1600.0, 3200.0, 4999.0, 10_000.0, 50_000.0] {
        for (rms, amplitude, mean, step) in [
            (1.0, 20.0, 0.0, 0.0),
            (3e-8, 4e-7, 1e-3, 0.0),
            (0.3, 9.0, 512.0, 1.0),
            (2e6, 9e6, -4e7, 0.0),
        ] {
            let readings = signal(rate_hz, rms, amplitude, mean, step);
            let changes = compare("signal", rate_hz, 0.0, &readings);
            // Learned, and two slips, of which low rates see one.
            assert!(changes >= 3, "{rate_hz} Hz, noise {rms}: {changes} changes");
        }
    }
}

#[test]
fn what_is_no_reading_is_left_out_and_a_sensor_that_shows_nothing_is_waited_for() {
    let mut readings = signal(1600.0, 1.0, 20.0, 0.0, 0.0);
    for (at, x) in readings.iter_mut().enumerate().filter(|(at, _)| at % 97 == 0) {
        *x = [f32::NAN, f32::INFINITY, 3e38, -1e15][at % 4];
    }
    assert!(compare("gaps", 1600.0, 0.0, &readings) >= 4);
    let silent = [vec![7.0; 3200], readings].concat();
    assert!(compare("silent", 1600.0, 0.0, &silent) >= 1);
    assert!(compare("resolution", 1600.0, 0.5, &silent) >= 1);
    // The largest that is taken is forgotten.
    let mut burst = signal(1600.0, 1.0, 0.0, 0.0, 0.0);
    burst[2000..2002].fill(9e14);
    assert_eq!(compare("burst", 1600.0, 0.0, &burst), 3, "learned, gross, quiet");
}

/// Single wrong readings, pairs and runs of three, 20 and 4000 deviations high, at every rate that holds some back.
#[test]
fn isolated_readings_are_held_back_as_by_the_guard() {
    for rate_hz in [500.0, 1000.0, 1600.0, 2200.0, 10_000.0, 50_000.0] {
        for (rms, height, step) in [(1.0, 20.0, 0.0), (3e-8, 1.2e-4, 0.0), (0.3, 1200.0, 1.0)] {
            let mut readings = signal(rate_hz, rms, 0.0, 5.0 * rms, step);
            for (at, x) in readings.iter_mut().enumerate() {
                *x += if at % 211 < 1 + at / 211 % 3 { height } else { 0.0 };
            }
            assert!(compare("isolated", rate_hz, 0.0, &readings) >= 1);
            for x in
                readings.chunks_mut(211).skip(1).flat_map(|part| part.iter_mut().skip(1).take(2))
            {
                *x = 5.0 * rms;
            }
            let changes = compare("single", rate_hz, 0.0, &readings);
            assert_eq!(changes == 1, rate_hz >= 1000.0, "{rate_hz} Hz, {rms}: {changes} changes");
        }
    }
}

#[test]
fn a_restart_keeps_the_floor_and_forgets_the_slip() {
    let mut readings = signal(1600.0, 1.0, 20.0, 0.0, 0.0);
    // While it learns, in a slip, and at rest.
    for at in [100, 1700, 4000] {
        readings[at] = RESTART;
    }
    assert!(compare("restart", 1600.0, 0.0, &readings) >= 5);
    let steps = in_c(1600.0, 0.0, &readings).unwrap();
    assert!(steps[1699].0 > 1 && steps[1700].0 == 1 && steps[1700].2 > 0.0);
}

#[test]
fn rates_and_noises_out_of_range_are_refused() {
    for (rate_hz, min_rms) in [
        (64.0, 0.0),
        (60_000.0, 0.0),
        (f32::NAN, 0.0),
        (1000.0, -1.0),
        (1000.0, f32::NAN),
        (1000.0, 1e30),
    ] {
        assert!(in_c(rate_hz, min_rms, &[0.0; 9]).is_none(), "{rate_hz} Hz, {min_rms}");
    }
    assert_eq!(in_c(1000.0, 0.0, &[0.0; 9]).unwrap(), vec![(0, 0.0, 0.0); 9]);
}

/// 2200 Hz, rectified vibration of a fingertip in column 1.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn recordings_give_the_states_of_slip_core() {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = env::var_os("GRIP_DATA").map_or_else(beside, PathBuf::from).join("biotac_slide");
    let mut files: Vec<PathBuf> =
        fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.file_stem().is_some_and(|stem| stem.len() == 6 && stem != "labels"));
    files.sort();
    let (mut changes, mut readings) = (0, 0);
    for file in &files {
        let text = fs::read_to_string(file).unwrap();
        let column: Vec<f32> =
            text.lines().filter_map(|line| line.split(',').nth(1)?.trim().parse().ok()).collect();
        readings += column.len();
        changes += compare(&file.display().to_string(), 2200.0, 0.0, &column);
    }
    println!("{} recordings, {readings} readings, {changes} changes of the state", files.len());
    assert!(files.len() >= 100 && changes >= files.len());
}
