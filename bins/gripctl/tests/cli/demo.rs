//! `gripctl demo`: one grasp as curves, the same every time, and a recording to go on with.

use crate::run::gripctl;
use std::fs;

#[test]
fn curves_slips_the_end_and_what_to_type_next_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let ran = gripctl(&folder, "demo").done();
    assert_eq!(ran.out, gripctl(&folder, "demo").done().out);
    let lines: Vec<&str> = ran.out.lines().collect();
    let curves =
        lines.iter().filter(|line| line.contains(|c| ('\u{2801}'..'\u{28ff}').contains(&c)));
    assert!(curves.count() >= 12, "{}", ran.out);
    assert!(lines.iter().all(|line| line.chars().count() <= 110), "{}", ran.out);
    for words in [
        "gross slip, seen by the travel",
        "The object was held",
        "Next:",
        "gripctl demo -o demo.csv",
    ] {
        assert!(ran.out.contains(words), "no {words:?} in {}", ran.out);
    }
    assert!(fs::read_dir(folder.path()).unwrap().next().is_none(), "nothing is written unasked");
}

#[test]
fn its_recording_is_replayed_with_the_same_slips() {
    let folder = tempfile::tempdir().unwrap();
    let ran = gripctl(&folder, "demo -o demo.csv").done();
    assert!(ran.out.contains("gripctl replay demo.csv") && ran.out.contains("gripmon demo.csv"));
    let lines = gripctl(&folder, "replay demo.csv --json").done().json();
    let begun = |line: &&serde_json::Value| line["type"] == "slip";
    let replayed = lines.iter().filter(begun).count();
    assert_eq!(replayed, ran.out.matches(" slip, seen by").count(), "{lines:?}");
    assert!(replayed >= 2);
}
