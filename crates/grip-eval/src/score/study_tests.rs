//! `esc` and `nn` on labelled recordings.

use super::{
    Detector, Floors, Rules, Score, ScoreError, Watch, compare,
    tests::{RULES, folder, recording},
};
use core::sync::atomic::{AtomicU64, Ordering};
use grip_record::CsvOptions;
use grip_session::config::HostConfig;
use std::{fs, path::Path, sync::Mutex};

const LABELS: &str =
    "recording,kind,material,onset_s\na,onset,x,0.3\nb,onset,x,0.3\ns,steady,y,\nr,rest,y,\n";

fn run_with(dir: &Path, name: &str, rules: Rules) -> Result<Score, ScoreError> {
    let detectors = [Detector::named(name).unwrap()];
    let scores = compare(
        dir,
        &CsvOptions::default(),
        &HostConfig::default(),
        rules,
        &detectors,
        Watch::default(),
    )?;
    scores.into_iter().next().unwrap()
}

fn run(dir: &Path, name: &str) -> Result<Score, ScoreError> {
    run_with(dir, name, RULES)
}

/// When alarms of a recording begin and end (s).
fn alarms(score: &Score, recording: &str) -> Vec<(f64, Option<f64>)> {
    let one = score.recordings.iter().find(|one| one.recording == recording).unwrap();
    one.alarms_at.iter().map(|alarm| (alarm.t_s, alarm.end_s)).collect()
}

#[test]
fn both_find_a_loud_slip_and_no_slip_at_rest() {
    let dir = folder(LABELS);
    for (name, floors) in [("esc", Floors::Folds), ("esc", Floors::Live), ("nn", Floors::Folds)] {
        let score = run_with(dir.path(), name, Rules { floors, ..RULES }).unwrap();
        let [a, .., r] = score.recordings.as_slice() else { panic!() };
        assert_eq!((a.detector, a.missed, a.early), (name, false, false), "{a:?}");
        assert!((0.0..40.0).contains(&a.latency_ms.unwrap()), "{a:?}");
        assert_eq!(r.alarms, 0, "{r:?}");
    }
}

/// Live, the floor of `s` would be learned on the slide.
#[test]
fn what_slides_from_the_start_teaches_nothing_live() {
    let rules = Rules { floors: Floors::Live, ..RULES };
    let error = run_with(folder(LABELS).path(), "nn", rules).unwrap_err().to_string();
    assert!(error.contains("material x") && error.contains("0 rows of labelled slip"), "{error}");
}

/// Neither labels nor signals of a material have a part in what judges it.
#[test]
fn the_network_has_not_seen_what_it_judges() {
    let dir = folder(LABELS);
    let before = run(dir.path(), "nn").unwrap();
    assert!(!alarms(&before, "a").is_empty());
    // Other onsets, and a slip that counts as rest: the alarms of this material stay, to the digit.
    let labels =
        LABELS.replace("a,onset,x,0.3", "a,rest,x,").replace("b,onset,x,0.3", "b,onset,x,0.11");
    fs::write(dir.path().join("labels.csv"), &labels).unwrap();
    let after = run(dir.path(), "nn").unwrap();
    for name in ["a", "b"] {
        assert_eq!(alarms(&before, name), alarms(&after, name));
    }
    // The same change is seen by what judges the other material.
    assert!(matches!(
        run(folder(&labels.replace("b,onset,x,0.11", "b,rest,x,")).path(), "nn"),
        Err(ScoreError::Untrained { .. })
    ));
    let swapped = LABELS.replace("s,steady,y", "s,rest,y").replace("r,rest,y", "r,steady,y");
    fs::write(dir.path().join("labels.csv"), swapped).unwrap();
    let other = run(dir.path(), "nn").unwrap();
    assert_ne!(alarms(&before, "a"), alarms(&other, "a"), "its teachers were changed");
}

/// The recordings of [`folder`] in another unit.
fn folder_in(unit: f64) -> tempfile::TempDir {
    let dir = folder(LABELS);
    for (name, from_ms, amplitude, seed) in
        [("a", 300, 200.0, 1), ("b", 225, 60.0, 2), ("s", 0, 200.0, 3), ("r", 1000, 0.0, 4)]
    {
        let text = recording(from_ms, amplitude, seed);
        let scaled = text.lines().map(|line| match line.split_once(',') {
            Some((t, x)) if x != "vibration" => {
                format!("{t},{}\n", unit * x.parse::<f64>().unwrap())
            }
            _ => format!("{line}\n"),
        });
        fs::write(dir.path().join(format!("{name}.csv")), scaled.collect::<String>()).unwrap();
    }
    dir
}

/// A power of two changes no digit, neither of a statistic nor of a training; a thousandth rounds each reading anew.
#[test]
fn the_same_folder_gives_the_same_alarms_in_any_unit() {
    for (name, unit, apart_s) in [
        ("esc", 1.0 / 1024.0, 0.0),
        ("esc", 1e-3, 1e-3),
        ("nn", 1.0, 0.0),
        ("nn", 1.0 / 1024.0, 0.0),
    ] {
        let plain = run(folder(LABELS).path(), name).unwrap();
        let scaled = run(folder_in(unit).path(), name).unwrap();
        assert!(plain.recordings[0].alarm_s.is_some());
        for (one, other) in plain.recordings.iter().zip(&scaled.recordings) {
            let apart = one.alarm_s.unwrap_or(-1.0) - other.alarm_s.unwrap_or(-1.0);
            assert!(apart.abs() <= apart_s, "{name} times {unit}: {one:?} {other:?}");
        }
    }
}

#[test]
fn what_cannot_train_a_network_is_refused_with_what_is_missing() {
    let refused = |labels: &str| run(folder(labels).path(), "nn").unwrap_err().to_string();
    let header = "recording,kind,material,onset_s\n";
    // One material: nothing else to learn from.
    let alone = refused(&format!("{header}a,onset,x,0.3\nr,rest,x,\n"));
    assert!(alone.contains("material x") && alone.contains("0 rows of labelled rest"), "{alone}");
    let no_rest = refused(&format!("{header}a,onset,x,0.3\ns,steady,y,\n"));
    assert!(no_rest.contains("0 rows of labelled rest"), "{no_rest}");
    let no_slip = refused(&format!("{header}a,rest,x,\nr,rest,y,\n"));
    assert!(no_slip.contains("0 rows of labelled slip"), "{no_slip}");
}

#[test]
fn a_clock_gives_the_shortest_run_time() {
    let dir = folder(LABELS);
    let calls = AtomicU64::new(0);
    // Readings 0, 1, 3, 6, .. ms: each recording takes longer than the one before.
    let clock = || {
        let n = calls.fetch_add(1, Ordering::Relaxed);
        core::time::Duration::from_millis(n * (n + 1) / 2)
    };
    let detectors = [Detector::named("esc").unwrap()];
    let (options, config) = (CsvOptions::default(), HostConfig::default());
    let done = Mutex::new((0, 0));
    let report = |now, of| *done.lock().unwrap() = (now, of);
    let watch = Watch { clock: Some(&clock), done: Some(&report) };
    let scores = compare(dir.path(), &options, &config, RULES, &detectors, watch).unwrap();
    let (now, of) = *done.lock().unwrap();
    assert!(now > 1 && now == of, "{now} of {of}");
    let ns = scores[0].as_ref().unwrap().ns_per_sample.unwrap();
    assert!((ns - 1e6 / 1320.0).abs() < 1e-6, "{ns}");
    assert_eq!(run(dir.path(), "esc").unwrap().ns_per_sample, None);
}

#[test]
fn recordings_without_a_stylus_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("labels.csv"), "recording,kind,material,onset_s\np,rest,x,\n")
        .unwrap();
    let rows: String = (0..50).map(|i| format!("{},1,2\n", f64::from(i) * 0.01)).collect();
    fs::write(dir.path().join("p.csv"), format!("t_s,pressure_0,pressure_1\n{rows}")).unwrap();
    for name in ["esc", "esc_literal", "nn"] {
        let error = run(dir.path(), name).unwrap_err();
        assert!(matches!(error, ScoreError::NoInput { .. }), "{error}");
    }
}
