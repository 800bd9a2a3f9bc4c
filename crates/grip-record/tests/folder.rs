//! Labels and travel of a labelled folder.
#![expect(clippy::unwrap_used, reason = "helpers of the tests stand outside the test functions")]

use std::fs;
use std::path::PathBuf;

use grip_record::{CsvError, LabelKind, Travel, read_labels};
use grip_table::TableError;
use proptest::prelude::*;
use slip_core::units::Micros;
use tempfile::TempDir;

fn file(name: &str, content: impl AsRef<[u8]>) -> (TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    fs::write(&path, content).unwrap();
    (dir, path)
}

fn refused(rows: &str) -> String {
    let (dir, path) = file("labels.csv", format!("recording,kind,material,onset_s\n{rows}"));
    let message = read_labels(&path).unwrap_err().to_string();
    message.replace(&dir.path().join("").display().to_string(), "")
}

#[test]
fn labels_are_read() {
    let text =
        "recording,kind,material,onset_s\na,onset,wood,0.1234567\nb,steady,glass,\nc,rest,,\n";
    let (dir, path) = file("labels.csv", text);
    let labels = read_labels(&path).unwrap();
    let kinds: Vec<_> = labels.iter().map(|label| label.kind).collect();
    assert_eq!(
        kinds,
        [LabelKind::Onset { at: Micros(123_457) }, LabelKind::Steady, LabelKind::Rest]
    );
    assert_eq!(labels[0].onset(), Some(Micros(123_457)));
    assert_eq!((labels[1].material.as_str(), labels[1].onset()), ("glass", None));
    assert_eq!(labels[0].file(dir.path()), dir.path().join("a.csv"));
}

#[test]
fn columns_may_be_swapped_and_the_last_two_absent() {
    let (_dir, path) = file("labels.csv", "kind,note,recording\r\nrest,x,a\r\n");
    let labels = read_labels(&path).unwrap();
    assert_eq!((labels[0].recording.as_str(), labels[0].material.as_str()), ("a", ""));
}

#[test]
fn label_faults_name_line_and_column() {
    let cases = [
        ("", "labels.csv: has a header but no rows; record at least one row"),
        (
            "a,slip,m,\n",
            "labels.csv: line 2, column kind: \"slip\" is unknown; write onset, steady or rest",
        ),
        (
            "a,rest,m,\nb,onset,m,\n",
            "labels.csv: line 3, column onset_s: is empty; kind onset needs the time of the onset in seconds",
        ),
        (
            "a,steady,m,0.5\n",
            "labels.csv: line 2, column onset_s: \"0.5\" stands at kind steady; only kind onset has a time, clear the cell",
        ),
        (
            "a,onset,m,soon\n",
            "labels.csv: line 2, column onset_s: \"soon\" is not a number; write digits with a decimal point",
        ),
        (
            "a,rest,m,\nb,rest,m,\na,rest,m,\n",
            "labels.csv: line 4, column recording: \"a\" has a label already; remove one of the rows, or give further onsets in rising order",
        ),
        (
            "../a,rest,m,\n",
            "labels.csv: line 2, column recording: \"../a\" is no file name; write the name of a file in this folder without .csv",
        ),
        (
            "a,rest,m\n",
            "labels.csv: line 2: 3 fields where the header names 4; add the missing fields (an empty one is a comma)",
        ),
    ];
    for (rows, message) in cases {
        assert_eq!(refused(rows), message, "{rows:?}");
    }
    let (_dir, path) = file("labels.csv", "name,kind\na,rest\n");
    let message = read_labels(&path).unwrap_err().to_string();
    assert!(message.ends_with("no column recording; the file has: name, kind"));
}

#[test]
fn travel_is_linear_between_poses() {
    let (dir, _path) = file("a_pose.csv", "t_s,travel_mm\n0.010,-0\n0.020,1\n0.020,2\n0.060,4\n");
    let travel = Travel::read_beside(&dir.path().join("a.csv")).unwrap().unwrap();
    let cases = [
        (9_999, None),
        (10_000, Some(0.0)),
        (15_000, Some(0.5)),
        (20_000, Some(2.0)),
        (40_000, Some(3.0)),
    ];
    for (micros, mm) in cases {
        assert_eq!(travel.travel_at(Micros(micros)), mm, "{micros}");
    }
    assert_eq!(
        (travel.travel_at(Micros(60_000)), travel.travel_at(Micros(60_001))),
        (Some(4.0), None)
    );
    assert_eq!(Travel::read_beside(&dir.path().join("b.csv")).unwrap(), None);
}

#[test]
fn a_pose_must_be_known() {
    let refused = |text: &str| {
        let (_dir, path) = file("a_pose.csv", text);
        Travel::read(&path).unwrap_err()
    };
    assert!(matches!(
        refused("t_s,travel_mm\n0,nan\n"),
        CsvError::Table(TableError::NotFinite { line: 2, .. })
    ));
    assert!(matches!(
        refused("t_s,travel_mm\n0,\n"),
        CsvError::Table(TableError::NotANumber { line: 2, .. })
    ));
    assert!(matches!(
        refused("t_s,travel_mm\n1,0\n0,0\n"),
        CsvError::TimeBackwards { line: 3, .. }
    ));
    assert!(matches!(refused("t_s,x\n"), CsvError::Table(TableError::Missing { .. })));
    assert!(matches!(refused("t_s,travel_mm\n"), CsvError::NoRows { .. }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_bytes_make_it_panic(bytes: Vec<u8>, at: u64) {
        let labels = [b"recording,kind,onset_s\n".as_slice(), &bytes].concat();
        let poses = [b"t_s,travel_mm\n0,0\n".as_slice(), &bytes].concat();
        let (_dir, path) = file("labels.csv", labels);
        let _ = read_labels(&path);
        let (_dir, path) = file("a_pose.csv", poses);
        if let Ok(travel) = Travel::read(&path) {
            prop_assert!(travel.travel_at(Micros(at)).is_none_or(f64::is_finite));
        }
    }
}
