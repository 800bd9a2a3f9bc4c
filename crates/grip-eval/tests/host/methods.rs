//! Moved distance and pressure distribution on real recordings, alone and joined with the stylus.

use core::fmt::Write as _;
use grip_eval::score::{Detector, Floors, Rules, Score, Watch, compare, score};
use grip_record::{CsvOptions, parse_csv};
use grip_session::{
    config::HostConfig,
    replay::{self, Replay},
};
use slip_core::{
    Sample, Step,
    detector::{DetectorConfig, KnownFloors, SlipDetector, SlipState},
    floor::FloorConfig,
    health::SensorHealth,
    pressure::{MAX_TAXELS, PressureConfig, PressurePattern},
    units::Micros,
};
use std::path::{Path, PathBuf};

/// Frames of 24 taxels at 100 Hz under fingers that close within 0.3 s, whose pattern shifts from `slip_s` on.
fn array_alone(slip_s: f64) -> String {
    let mut state = 7_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    let mut text = String::from("t_s,force_n");
    (0..24).for_each(|k| write!(text, ",pressure_{k}").unwrap());
    for i in 0..300 {
        let t = 0.01 * f64::from(i);
        let grip = (t / 0.3).min(1.0);
        let shift = 0.05 * (t - slip_s).max(0.0);
        write!(text, "\n{t:.2},{:.3}", 5.0 * grip).unwrap();
        for k in 0..24 {
            // The contact moves to its place while the fingers close.
            let at = f64::from(k) - 12.0 - 3.0 * (1.0 - grip) - 40.0 * shift;
            let value = 3000.0 + 500.0 * grip * (-at * at / 30.0).exp() + 2.0 * noise();
            write!(text, ",{value:.1}").unwrap();
        }
    }
    text
}

#[test]
fn an_array_without_a_stylus_reports_slips_and_not_the_closing_of_the_fingers() {
    let slips = |slip_s: f64| -> Vec<f64> {
        let text = array_alone(slip_s);
        let recording =
            parse_csv(Path::new("x.csv"), text.as_bytes(), &CsvOptions::default()).unwrap();
        let config = replay::pipeline_config(&recording, &HostConfig::default(), false);
        let steps: Vec<_> = Replay::new(&recording, config, None).unwrap().collect();
        assert!(
            steps
                .iter()
                .all(|step| step.sensors[0] == SensorHealth::Good && step.command.is_none())
        );
        let first = |step: &&Step| step.event.is_some_and(|slip| slip.first);
        steps.iter().filter(first).map(|step| step.t.as_seconds()).collect()
    };
    assert!(slips(10.0).is_empty());
    let found = slips(1.5);
    assert!(matches!(found[..], [at] if (1.5..1.7).contains(&at)), "{found:?}");
}

/// A folder of real recordings.
fn real_data(name: &str) -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("GRIP_DATA").map_or(beside, PathBuf::from).join(name);
    assert!(folder.is_dir(), "no folder {}: set GRIP_DATA", folder.display());
    folder
}

fn scores(folder: &Path, names: &[&str]) -> Vec<Score> {
    let detectors: Vec<_> = names.iter().map(|name| Detector::named(name).unwrap()).collect();
    let (options, config) = (CsvOptions::default(), HostConfig::default());
    let rules = Rules { guard_ms: 60.0, floors: Floors::Folds };
    let scores = compare(folder, &options, &config, rules, &detectors, Watch::default()).unwrap();
    scores.into_iter().map(Result::unwrap).collect()
}

/// The pose begins the label of the onset (0.1 mm), so the delay of `travel` is that of its readings; the electrodes are
/// independent of it.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn travel_and_electrodes_of_a_fingertip_report_every_slip() {
    let folder = real_data("biotac_slide");
    let all = scores(&folder, &["stylus", "travel", "pressure", "fused"]);
    for (score, latest_ms) in all.iter().zip([20.0, 20.0, 30.0, 20.0]) {
        let total = score.total(60.0);
        println!("{total:?}");
        assert!(total.onsets >= 50 && total.missed == 0 && total.early <= 1, "{total:?}");
        assert!(total.latency_ms.p95.unwrap() <= latest_ms, "{total:?}");
        assert_eq!(total.steady_missed, 0, "{total:?}");
    }
    // No recording is reported later by all methods than by the stylus alone.
    let [stylus, _, _, fused] = all.as_slice() else { panic!() };
    for (alone, joined) in stylus.recordings.iter().zip(&fused.recordings) {
        assert!(joined.alarm_s.unwrap() <= alone.alarm_s.unwrap(), "{alone:?} {joined:?}");
    }
}

/// The folder with vibrations and electrodes in a unit that is `unit` times as small.
fn in_unit(folder: &Path, unit: f64) -> tempfile::TempDir {
    let scaled = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = file.file_name().unwrap().to_str().unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        let columns = match name {
            _ if name.ends_with("_electrodes.csv") => 1..usize::MAX,
            _ if name.ends_with("_pose.csv") || !name.starts_with('m') => 0..0,
            _ => 1..2,
        };
        let row = |line: &str| {
            let cells = line.split(',').enumerate().map(|(i, cell)| match cell.parse::<f64>() {
                Ok(value) if columns.contains(&i) => (unit * value).to_string(),
                _ => cell.to_owned(),
            });
            cells.collect::<Vec<_>>().join(",")
        };
        let text: Vec<_> = text.lines().map(row).collect();
        std::fs::write(scaled.path().join(name), text.join("\n")).unwrap();
    }
    scaled
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn vibrations_and_electrodes_in_any_unit_give_the_same_alarms() {
    let folder = real_data("biotac_slide");
    let alarms = |folder: &Path| -> Vec<_> {
        let scores = scores(folder, &["stylus", "fused"]);
        let all = scores.into_iter().flat_map(|score| score.recordings);
        all.map(|recording| (recording.recording, recording.alarm_s)).collect()
    };
    let expected = alarms(&folder);
    assert!(expected.iter().all(|(_, alarm_s)| alarm_s.is_some()));
    for unit in [1e-9, 1e-3, 1e9] {
        let scaled = in_unit(&folder, unit);
        for (got, wanted) in alarms(scaled.path()).iter().zip(&expected) {
            // One block of half a millisecond, a sample long at this rate.
            let apart_s = got.1.unwrap_or(f64::NAN) - wanted.1.unwrap();
            assert!(got.0 == wanted.0 && apart_s.abs() < 1e-3, "{unit}: {got:?} {wanted:?}");
        }
    }
}

/// Arrays without a stylus at the rate of their own, each judged with the rest of other objects.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn arrays_alone_report_slips_and_neither_touches_nor_closing_fingers() {
    let total = |folder| scores(&real_data(folder), &["default"])[0].total(60.0);
    let touches = total("taxels_dos");
    println!("{touches:?}");
    assert!(touches.steady >= 150 && touches.rest_s > 60.0, "{touches:?}");
    assert!(100 * touches.steady_missed <= 6 * touches.steady, "{touches:?}");
    assert!(touches.rest_alarms <= 1, "{touches:?}");
    let grasps = total("papillarray");
    assert!(grasps.rest_s > 60.0 && grasps.rest_alarms == 0, "{grasps:?}");
}

/// A folder with copies of recordings, each changed by `change`, and their labels.
fn changed(
    names: &[(&Path, String)],
    labels: &str,
    change: impl Fn(usize, &[f64], usize) -> Vec<f64>,
) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("labels.csv"), labels).unwrap();
    for (nth, (file, column)) in names.iter().enumerate() {
        let text = std::fs::read_to_string(file).unwrap();
        let mut lines = text.lines();
        let header: Vec<_> = lines.next().unwrap().split(',').collect();
        let place = header.iter().position(|name| name == column).unwrap();
        let rows: Vec<(&str, f64)> = lines
            .map(|line| {
                let cells: Vec<_> = line.split(',').collect();
                (cells[0], cells[place].parse().unwrap())
            })
            .collect();
        let values: Vec<f64> = rows.iter().map(|row| row.1).collect();
        let values = change(nth, &values, rows.len());
        let mut out = String::from("t_s,vibration\n");
        for ((t, _), x) in rows.iter().zip(values) {
            writeln!(out, "{t},{x}").unwrap();
        }
        std::fs::write(folder.path().join(file.file_name().unwrap()), out).unwrap();
    }
    folder
}

/// Gaussian numbers of deviation 1, seeded.
fn gaussian(count: usize) -> Vec<f64> {
    let mut state = 5_u32;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    (0..count).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
}

/// Hands that move an object, at 40 Hz: nothing slips, and a slip put in is found, in m/s2 and in g.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn motion_at_40_hz_is_no_slip_and_a_slip_of_three_times_its_level_is_found() {
    let folder = real_data("imu_manipulation");
    let labels = std::fs::read_to_string(folder.join("labels.csv")).unwrap();
    let files: Vec<PathBuf> = labels
        .lines()
        .skip(1)
        .map(|line| folder.join(format!("{}.csv", line.split(',').next().unwrap())))
        .collect();
    let names: Vec<(&Path, String)> =
        files.iter().map(|file| (file.as_path(), "vibration".to_owned())).collect();
    for unit in [1.0, 1.0 / 9.806_65] {
        let plain = changed(&names, &labels, |_, x, _| x.iter().map(|x| unit * x).collect());
        let total = scores(plain.path(), &["default"])[0].total(60.0);
        println!("{total:?}");
        assert!(total.rest_s > 800.0 && f64::from(total.rest_alarms) <= total.rest_s / 600.0);
    }
    // Two seconds of noise from the middle of each recording of 25 s and more, three times as strong in the band of the
    // detector as the level
    // that it takes motion to have then.
    let long: Vec<_> = names
        .iter()
        .filter(|(file, _)| std::fs::read_to_string(file).unwrap().lines().count() > 1000)
        .cloned()
        .collect();
    let noise = gaussian(4000);
    let onset = |file: &Path, middle: usize| {
        let text = std::fs::read_to_string(file).unwrap();
        text.lines().nth(middle + 1).unwrap().split(',').next().unwrap().to_owned()
    };
    let mut rows = String::from("recording,kind,material,onset_s\n");
    for (file, _) in &long {
        let count = std::fs::read_to_string(file).unwrap().lines().count() - 1;
        let name = file.file_stem().unwrap().to_string_lossy();
        writeln!(rows, "{name},onset,can,{}", onset(file, count / 2)).unwrap();
    }
    for unit in [1.0, 1.0 / 9.806_65] {
        let slips = changed(&long, &rows, |nth, x, count| {
            let known = KnownFloors::default();
            let floor = FloorConfig::default().in_any_unit();
            let mut detector =
                SlipDetector::new(&DetectorConfig::default(), floor, known, 40.0).unwrap();
            for x in &x[..count / 2] {
                detector.step(&Sample::stylus(Micros(0), *x as f32));
            }
            let smallest = f64::from(detector.smallest_over_motion().unwrap());
            // A slip is reported at three times the energy; noise of 0 to 20 Hz has 0.6 of its energy between 4 and 16.
            let rms = 3.0 * smallest / 3.0_f64.sqrt() / 0.6_f64.sqrt();
            let slides = count / 2..count / 2 + 80;
            let put = |i: usize| {
                if slides.contains(&i) { rms * noise[(i + 37 * nth) % 4000] } else { 0.0 }
            };
            x.iter().enumerate().map(|(i, x)| unit * (x + put(i))).collect()
        });
        let score = &scores(slips.path(), &["default"])[0];
        let found = score.recordings.iter().filter(|r| {
            let onset_s = r.onset_s.unwrap();
            r.alarms_at.iter().any(|a| (onset_s..onset_s + 3.0).contains(&a.t_s))
        });
        let found = found.count();
        println!("{found} of {} slips", score.recordings.len());
        assert!(score.recordings.len() >= 10 && 10 * found >= 9 * score.recordings.len());
    }
}

/// A stylus that slides from the first sample to the last, by hand.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn a_stylus_that_always_slides_is_reported_to_slide_or_never_to_have_rested() {
    let folder = real_data("stylus_accel_1k");
    let files: Vec<PathBuf> = (1..=3).map(|i| folder.join(format!("texture{i}.csv"))).collect();
    let names: Vec<(&Path, String)> =
        files.iter().map(|file| (file.as_path(), "acceleration".to_owned())).collect();
    let mut labels = String::from("recording,kind,material,onset_s\n");
    for i in 1..=3 {
        writeln!(labels, "texture{i},steady,texture{i},").unwrap();
    }
    for unit in [1.0, 1e-3] {
        let plain = changed(&names, &labels, |_, x, _| x.iter().map(|x| unit * x).collect());
        let rules = Rules { guard_ms: 60.0, floors: Floors::Live };
        let (options, config) = (CsvOptions::default(), HostConfig::default());
        let score = score(plain.path(), &options, &config, rules).unwrap();
        let total = score.total(60.0);
        assert!(total.steady_share.unwrap() >= 0.76, "{:?}", score.recordings);
    }
}

/// Time (s), taxels.
fn board(file: &Path) -> Vec<(Micros, Vec<f32>)> {
    let text = std::fs::read_to_string(file).unwrap();
    let rows = text.lines().skip(1).map(|line| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let ms: u64 = cells[0].parse().unwrap();
        (Micros(1000 * ms), cells[3..19].iter().map(|cell| cell.parse().unwrap()).collect())
    });
    rows.collect()
}

/// The finger rests for a moment and then slides over ridges at 36 frames a second. There are no labels: the rest before the motion is some frames long, so the
/// noise is given (1.2 counts, as its first frames show), and a slip must be reported in each run.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn a_capacitive_finger_over_ridged_boards_slips_in_every_run() {
    let folder = real_data("fabricslide");
    let mut files: Vec<_> =
        std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "csv"));
    files.sort();
    assert!(files.len() >= 10, "{}", files.len());
    for file in files {
        let config = PressureConfig { known_rms: Some(1.2), ..PressureConfig::default() };
        let mut method = PressurePattern::<MAX_TAXELS>::new(config).unwrap();
        let frames = board(&file);
        let (mut first, mut slipping) = (None, 0);
        for (i, (t, frame)) in frames.iter().enumerate() {
            method.step(*t, frame, false);
            if method.state() != SlipState::Quiet {
                first = first.or(Some(i));
                slipping += 1;
            }
        }
        let share = 100 * slipping / frames.len();
        println!(
            "{}: first frame {first:?} of {}, {share} % slipping",
            file.display(),
            frames.len()
        );
        assert!(first.is_some_and(|i| (1..40).contains(&i)), "{}: {first:?}", file.display());
        assert!(share > 50, "{}: {share} %", file.display());
    }
}
