use super::{
    Detector, Floors, Memory, Rules, ScoreError, Task, UNKNOWN, Watch, compare_within, score,
};
use core::fmt::Write as _;
use grip_record::{CsvError, CsvOptions};
use grip_session::{config::HostConfig, exit::Exit};
use std::{fs, path::Path};

pub(super) const RULES: Rules = Rules { guard_ms: 60.0, floors: Floors::Folds };

/// 300 ms of rest, then 300 ms of a 150 Hz tone; times in the file start at 0.
pub(super) fn recording(slip_from_ms: u32, amplitude: f64, seed: u32) -> String {
    let mut state = seed;
    let mut text = String::from("t_s,vibration\n");
    for i in 0..1320_u32 {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(state >> 8) / f64::from(1 << 24) * 10.0 - 5.0;
        let t = f64::from(i) / 2200.0;
        let tone =
            if t * 1e3 >= f64::from(slip_from_ms) { amplitude * (942.0 * t).sin() } else { 0.0 };
        let _ = writeln!(text, "{t:.6},{}", (noise + tone).round());
    }
    text
}

pub(super) fn folder(labels: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("labels.csv"), labels).unwrap();
    fs::write(dir.path().join("a.csv"), recording(300, 200.0, 1)).unwrap();
    fs::write(dir.path().join("b.csv"), recording(225, 60.0, 2)).unwrap();
    fs::write(dir.path().join("s.csv"), recording(0, 200.0, 3)).unwrap();
    fs::write(dir.path().join("r.csv"), recording(1000, 0.0, 4)).unwrap();
    dir
}

fn run(dir: &Path) -> Result<super::Score, ScoreError> {
    score(dir, &CsvOptions::default(), &HostConfig::default(), RULES)
}

#[test]
fn a_folder_that_does_not_fit_in_memory_has_the_same_scores() {
    let dir = folder(
        "recording,kind,material,onset_s\na,onset,x,0.3\nb,onset,x,0.225\ns,steady,y,\nr,rest,y,\n",
    );
    let task = Task { config: &HostConfig::default(), rules: RULES, watch: Watch::default() };
    let detectors = ["default", "esc", "nn"].map(|name| Detector::named(name).unwrap());
    let options = CsvOptions::default();
    let within = |memory| {
        let scores = compare_within(memory, dir.path(), &options, &detectors, &task).unwrap();
        let all = scores.into_iter().map(|score| {
            let score = score.unwrap();
            (serde_json::to_string(&score.recordings).unwrap(), score.floor, score.floor_s)
        });
        all.collect::<Vec<_>>()
    };
    let whole = within(Memory::DEFAULT);
    // Nothing fits; the rest of some; one whole and the rest of the others.
    for kept in [0, 100_000, 300_000] {
        assert_eq!(within(Memory { kept, open: 1 }), whole, "{kept}");
    }
}

#[test]
fn what_is_scored_reports_nothing_of_its_own_rest() {
    let dir = folder("recording,kind,material,onset_s\na,onset,x,0.3\nr,rest,y,\n");
    let rest_alarms = || run(dir.path()).unwrap().total(60.0).rest_alarms;
    assert_eq!(rest_alarms(), 0);
    // Ten times as loud as the rest of the other material, from beginning to end.
    let quiet = recording(1000, 0.0, 4);
    let louder = quiet.lines().map(|line| match line.split_once(',') {
        Some((t, x)) if x != "vibration" => format!("{t},{}0\n", x.trim_start_matches("-0")),
        _ => format!("{line}\n"),
    });
    fs::write(dir.path().join("r.csv"), louder.collect::<String>()).unwrap();
    assert!(rest_alarms() > 0, "its own floor would have hidden it");
}

#[test]
fn false_alarms_have_the_cause_that_was_named() {
    let dir = folder("recording,kind,material,onset_s\nb,onset,x,0.5\nr,rest,y,\n");
    fs::write(
        dir.path().join("phases.csv"),
        "recording,begin_s,end_s,cause\nb,0.2,0.3,closing\nr,0.1,0.4,arm\n",
    )
    .unwrap();
    let result = run(dir.path()).unwrap();
    let [alarm] = result.recordings[0].alarms_at.as_slice() else {
        panic!("{:?}", result.recordings[0])
    };
    assert_eq!((alarm.cause.as_str(), alarm.is_false), ("closing", true));
    assert!((0.225..0.24).contains(&alarm.t_s), "{alarm:?}");
    let causes = result.causes();
    let of = |name: &str| causes.iter().find(|c| c.cause == name).unwrap();
    assert_eq!((of("closing").alarms, of("arm").alarms, of(UNKNOWN).alarms), (1, 0, 0));
    assert!((of("closing").seconds - 0.1).abs() < 2e-3 && (of("arm").seconds - 0.3).abs() < 2e-3);
    let [low, high] = of("closing").per_hour_ci.unwrap();
    assert!(low < 36_000.0 && high > 36_000.0, "one in 0.1 s: {low} to {high}");
}

#[test]
fn live_floors_know_nothing_of_other_recordings_and_of_what_comes_later() {
    let dir = folder("recording,kind,material,onset_s\na,onset,x,0.3\nr,rest,y,\n");
    let live = |dir: &Path| {
        let rules = Rules { floors: Floors::Live, ..RULES };
        score(dir, &CsvOptions::default(), &HostConfig::default(), rules).unwrap()
    };
    let before = live(dir.path());
    assert_eq!((before.floor, before.floor_s), (None, 0.0));
    assert!(!before.recordings[0].missed, "{:?}", before.recordings[0]);
    // What comes after the alarm, and the other recording, change nothing.
    let cut: String =
        recording(300, 200.0, 1).lines().take(800).map(|l| format!("{l}\n")).collect();
    fs::write(dir.path().join("a.csv"), cut).unwrap();
    fs::write(dir.path().join("r.csv"), recording(0, 1e4, 9)).unwrap();
    assert_eq!(live(dir.path()).recordings[0].alarm_s, before.recordings[0].alarm_s);
}

#[test]
fn time_without_samples_is_no_time_without_alarms() {
    let dir = folder("recording,kind,material,onset_s\na,onset,x,0.3\nr,rest,y,\n");
    // 100 s are missing in the middle.
    let gap =
        recording(1000, 0.0, 4).lines().enumerate().fold(String::new(), |mut text, (i, line)| {
            match line.split_once(',').filter(|_| i > 600) {
                Some((t, x)) => {
                    let _ = writeln!(text, "{:.6},{x}", t.parse::<f64>().unwrap() + 100.0);
                }
                None => {
                    let _ = writeln!(text, "{line}");
                }
            }
            text
        });
    fs::write(dir.path().join("r.csv"), gap).unwrap();
    let total = run(dir.path()).unwrap().total(60.0);
    assert!((total.rest_s - 0.6).abs() < 0.01, "{}", total.rest_s);
}

#[test]
fn chance_finds_nothing_where_alarms_are_few_and_recordings_long() {
    let dir = folder("recording,kind,material,onset_s\na,onset,x,0.3\nr,rest,y,\n");
    let total = run(dir.path()).unwrap().total(60.0);
    // One alarm in 1.2 s, a window of 0.36 s.
    let by = total.onsets_chance.unwrap();
    assert!((by.found - 0.3).abs() < 0.01 && (by.p - 0.3).abs() < 0.01, "{by:?}");
    assert_eq!(total.steady_chance, None);
}

#[test]
fn a_recording_that_cannot_be_used_is_the_callers_to_correct() {
    for error in [CsvError::BadRate { rate_hz: 0.0 }, CsvError::NoRows { file: "x".into() }] {
        assert_eq!(Exit::of(&ScoreError::Recording(error)), Exit::WrongArguments);
    }
}
