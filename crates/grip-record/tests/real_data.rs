//! Real recordings, kept outside the repository: the folder in `GRIP_DATA`, else `shared/data` beside the
//! workspace.
#![expect(clippy::unwrap_used, reason = "helpers of the tests stand outside the test functions")]

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use grip_record::{CsvOptions, StylusKind, Travel, read_csv, read_labels};

/// The folder `name` of the data.
fn folder(name: &str) -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = env::var_os("GRIP_DATA").map_or_else(beside, PathBuf::from).join(name);
    assert!(folder.is_dir(), "no folder {}: set GRIP_DATA", folder.display());
    folder
}

fn renamed(ours: &str, theirs: &str, rate_hz: Option<f32>) -> CsvOptions {
    let map = vec![(ours.to_owned(), theirs.to_owned())];
    CsvOptions { rate_hz, map, ..CsvOptions::default() }
}

fn csv_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "csv")).collect();
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    files
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn a_labelled_folder_is_complete() {
    let folder = folder("biotac_slide");
    let labels = read_labels(&folder.join("labels.csv")).unwrap();
    assert!(!labels.is_empty());
    for label in labels {
        let file = label.file(&folder);
        let recording = read_csv(&file, &CsvOptions::default()).unwrap();
        assert_eq!(
            (recording.name, recording.channels.stylus),
            (label.recording.clone(), StylusKind::Vibration)
        );
        assert!(
            (recording.rate_hz - 2200.0).abs() < 0.5,
            "{} Hz in {}",
            recording.rate_hz,
            file.display()
        );
        assert_eq!(recording.notes.to_string(), "", "{}", file.display());
        let travel = Travel::read_beside(&file).unwrap().unwrap();
        let last = recording.samples.last().unwrap().t;
        assert!(
            label.onset().is_none_or(|at| at < last),
            "onset after the end of {}",
            file.display()
        );
        if let Some(at) = label.onset() {
            let mm = travel.travel_at(at).unwrap();
            assert!((0.05..0.4).contains(&mm), "{mm} mm at the onset of {}", file.display());
        }
    }
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn a_dirty_accelerometer_reads_under_its_own_name() {
    let folder = folder("stylus_accel_1k");
    for file in csv_files(&folder) {
        let recording = read_csv(&file, &CsvOptions::default()).unwrap();
        let named = read_csv(&file, &renamed("vibration", "acceleration", None)).unwrap();
        assert!(named.samples.len() == recording.samples.len(), "an acceleration is a vibration");
        assert!(
            (recording.rate_hz - 1000.0).abs() < 0.5,
            "{} Hz in {}",
            recording.rate_hz,
            file.display()
        );
        assert!(recording.samples.iter().all(|sample| sample.normal_force_n.is_some()));
        assert_eq!(recording.notes.ignored_columns, ["speed_mm_s"]);
        println!("{}: {} rows; {}", recording.name, recording.samples.len(), recording.notes);
    }
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn tables_without_times_in_seconds_read_at_a_rate() {
    for (name, column, rate) in
        [("surfcom_profiles", "height_um", 842.7), ("fabricslide", "channel1", 35.6)]
    {
        let folder = folder(name);
        for file in csv_files(&folder) {
            let recording = read_csv(&file, &renamed("stylus", column, Some(rate))).unwrap();
            assert_eq!(recording.channels.time_source, None);
            let rows = fs::read_to_string(&file).unwrap().lines().count() - 1;
            assert_eq!(recording.samples.len(), rows, "{}", file.display());
        }
    }
}
