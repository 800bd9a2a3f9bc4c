//! MCAP recordings through `gripctl replay`, `recover` and `csv`.

use crate::run::{gripctl, number};
use grip_eval::trial;
use grip_record::mcap::{Attached, McapWriter, Record, SampleRecord};
use grip_session::{
    HostConfig, Update, model,
    recording::{MODEL_NAME, event_record, pipeline_record},
};
use grip_sim::scene;
use serde_json::Value;
use slip_core::units::Micros;
use std::{
    fs::{self, File},
    path::Path,
};

/// Grasps and records as the daemon does; gives the lines of the session.
fn record(file: &Path) -> Vec<String> {
    record_events(file, "default", 0, Micros(1_500_000), None)
}

/// The same in a scene of a seed until a time, with another text in place of that of each event.
fn record_events(
    file: &Path,
    scene: &str,
    seed: u64,
    until: Micros,
    tampered: Option<&'static str>,
) -> Vec<String> {
    let scene = scene::load(scene).unwrap().reseeded(seed).unwrap();
    let out = File::create(file).unwrap();
    let mut writer = McapWriter::new(out, "gripd test", 1_763_766_000_000_000_000).unwrap();
    let data = model::default_text().as_bytes().to_vec();
    let media_type = "application/json".to_owned();
    writer.attach(0, &Attached { name: MODEL_NAME.to_owned(), media_type, data }).unwrap();
    let (mut lines, mut json, mut now_us) = (Vec::new(), Vec::new(), 0);
    let mut report = |updates: Update<'_>| match updates {
        Update::Began(beginning) => {
            let record = pipeline_record(beginning, &mut json).unwrap();
            writer.write(now_us, &Record::Pipeline(record)).unwrap();
        }
        Update::Step { index, sample, taxels, .. } => {
            now_us = sample.t.0;
            let record = SampleRecord { index, sample: *sample, taxels };
            writer.write(now_us, &Record::Sample(record)).unwrap();
            if index % 2500 == 0 {
                writer.flush().unwrap();
            }
        }
        Update::Event(line) => {
            let mut record = event_record(&line, &mut json).unwrap();
            lines.push(record.json.to_owned());
            record.json = tampered.unwrap_or(record.json);
            writer.write(now_us, &Record::Event(record)).unwrap();
        }
        Update::Gripper { .. } | Update::Link(_) => {}
    };
    let estimator = model::default_estimator().unwrap();
    trial::grasp(&scene, &HostConfig::default(), estimator, until, &mut report).unwrap();
    writer.finish().unwrap();
    lines
}

#[test]
fn recordings_replay_to_the_recorded_lines_and_so_does_their_csv() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, seed) in [("default", 0), ("light_rough", 5), ("shaken", 2), ("moving", 1)] {
        let lines =
            record_events(&folder.path().join("run.mcap"), scene, seed, Micros(1_500_000), None);
        assert!(lines.iter().any(|line| line.contains("\"slip\"")), "{scene}: {lines:?}");
        let ran = gripctl(&folder, "replay run.mcap --check").done();
        assert!(ran.out.starts_with(&format!("{} events, byte by byte", lines.len())), "{ran:?}");
        for file in ["run.mcap", "run.csv", "run.npz"] {
            if file != "run.mcap" {
                gripctl(&folder, format!("csv run.mcap -o {file} --force")).done();
            }
            for more in ["", "--no-skip"] {
                let args = &format!("replay {file} --json {more}");
                let ran = gripctl(&folder, args).done();
                let mut printed: Vec<&str> = ran.out.lines().collect();
                let summary: Value = serde_json::from_str(printed.pop().unwrap()).unwrap();
                assert_eq!(printed, lines, "{scene} {args:?}");
                assert_eq!((&summary["type"], &summary["lost"]), (&"summary".into(), &0.into()));
                assert!((number(&summary, "duration_s") - 1.49).abs() < 0.05, "{summary}");
            }
        }
    }
    let ran = gripctl(&folder, "replay run.csv --json --observe").done();
    let slip = ran.json().into_iter().find(|line| line["type"] == "slip").unwrap();
    assert!(slip["command_n"].is_null(), "only observed: {slip}");
    let text = gripctl(&folder, "replay run.csv").done().out;
    assert!(text.contains("slip (") && text.contains("0 gaps"), "{text}");
}

#[test]
fn a_recording_that_ends_before_its_floor_is_known_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (until_us, learning) in [(100_000, true), (1_500_000, false)] {
        record_events(&folder.path().join("run.mcap"), "default", 0, Micros(until_us), None);
        let ran = gripctl(&folder, "replay run.mcap --json").done();
        let summary = ran.json().pop().unwrap();
        assert_eq!(summary["learning"], learning, "{summary}");
        let said = ran.err.contains("run.mcap: ends before its noise floor is learned");
        assert_eq!(said, learning, "{}", ran.err);
    }
}

#[test]
fn a_difference_is_shown_and_fails() {
    let folder = tempfile::tempdir().unwrap();
    // Its events were tampered with: the chunks are written anew, so nothing is damaged.
    record_events(
        &folder.path().join("other.mcap"),
        "default",
        0,
        Micros(1_500_000),
        Some("{\"type\":\"slip\"}"),
    );
    let ran = gripctl(&folder, "replay other.mcap --check");
    assert_eq!(ran.code, 1, "{ran:?}");
    assert!(
        ran.err.contains("event 1 differs") && ran.err.contains("recorded: {\"type\":\"slip\"}"),
        "{}",
        ran.err
    );
}

#[test]
fn a_cut_recording_is_recovered_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let lines = record(&file);
    let whole = fs::read(&file).unwrap();
    let ran = gripctl(&folder, "recover run.mcap").done();
    assert!(
        ran.out.contains("run.mcap is whole") && fs::read(&file).unwrap() == whole,
        "{}",
        ran.out
    );
    fs::write(&file, whole.get(..whole.len() / 2).unwrap()).unwrap();
    let ran = gripctl(&folder, "replay run.mcap --check");
    assert_eq!(ran.code, 3, "{ran:?}");
    assert!(ran.err.contains("`gripctl recover`"), "{}", ran.err);
    let ran = gripctl(&folder, "recover run.mcap --json");
    assert_eq!(ran.code, 3, "{ran:?}");
    let report = ran.json().pop().unwrap();
    assert_eq!((&report["whole"], &report["output"]), (&false.into(), &"run.mcap".into()));
    assert!(
        report["messages"].as_u64().unwrap() > 2500 && report["lost_bytes"].as_u64().unwrap() > 0
    );
    let ran = gripctl(&folder, "replay run.mcap --json").done();
    let count = ran.out.lines().count() - 1;
    assert!(ran.out.lines().take(count).eq(lines.iter().take(count).map(String::as_str)));
    gripctl(&folder, "recover run.mcap").done();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
}

/// What another program wrote, or holds no message, is never replaced.
#[test]
fn a_foreign_recording_that_is_cut_off_stays() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let mut bytes = fs::read(&file).unwrap();
    let library = bytes.windows(6).position(|text| text == b"gripd ").unwrap();
    bytes[library..library + 5].copy_from_slice(b"other");
    for (len, code) in [(bytes.len() / 2, 3), (library + 40, 1)] {
        let cut = &bytes[..len];
        fs::write(&file, cut).unwrap();
        let ran = gripctl(&folder, "recover run.mcap");
        assert_eq!(ran.code, code, "{ran:?}");
        assert_eq!(fs::read(&file).unwrap(), cut);
        let beside = folder.path().join("run.recovered.mcap");
        assert_eq!(beside.exists(), code == 3, "{ran:?}");
        if code == 3 {
            assert!(ran.out.contains("run.recovered.mcap: saved"), "{ran:?}");
            gripctl(&folder, "replay run.recovered.mcap --json").done();
            let again = gripctl(&folder, "recover run.mcap");
            assert!(again.code == 2 && again.err.contains("add --force"), "{again:?}");
            fs::remove_file(beside).unwrap();
        } else {
            assert!(ran.out.contains("no message can be saved"), "{ran:?}");
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
}

/// Where the records of that kind begin, and how long they are with their heads.
fn records(bytes: &[u8], kind: u8) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (8, Vec::new());
    while let Some([opcode, len @ ..]) = bytes.get(at..).and_then(|rest| rest.first_chunk::<9>()) {
        let whole = 9 + usize::try_from(u64::from_le_bytes(*len)).unwrap();
        if *opcode == kind {
            found.push((at, whole));
        }
        at += whole;
    }
    found
}

/// Kinds of records in the format.
const CHUNK: u8 = 0x06;
const MESSAGE_INDEX: u8 = 0x07;

#[test]
fn a_damaged_index_is_made_anew_and_no_message_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let whole = fs::read(&file).unwrap();
    let &(at, len) = records(&whole, MESSAGE_INDEX).iter().max_by_key(|(_, len)| *len).unwrap();
    let mut bytes = whole.clone();
    bytes[at + len / 2..at + len / 2 + 40].fill(0);
    fs::write(&file, &bytes).unwrap();
    gripctl(&folder, "replay run.mcap --check").done();
    let ran = gripctl(&folder, "recover run.mcap").done();
    assert!(ran.out.contains("only its index was missing or damaged"), "{}", ran.out);
    let again = gripctl(&folder, "recover run.mcap").done();
    assert!(again.out.contains("is whole"), "{}", again.out);
    gripctl(&folder, "replay run.mcap --check").done();
}

#[test]
fn a_damaged_recording_is_recovered_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let mut bytes = fs::read(&file).unwrap();
    let chunks = records(&bytes, CHUNK);
    let &(at, len) = chunks.get(chunks.len() / 2).unwrap();
    bytes[at + len / 2..at + len / 2 + 40].fill(0);
    fs::write(&file, &bytes).unwrap();
    let ran = gripctl(&folder, "recover run.mcap");
    assert_eq!(ran.code, 3, "{ran:?}");
    assert!(
        ran.out.contains("damaged at byte") && ran.out.contains("run.recovered.mcap: saved"),
        "{}",
        ran.out
    );
    assert_eq!(fs::read(&file).unwrap(), bytes, "the damaged one stays");
    let ran = gripctl(&folder, "recover run.recovered.mcap").done();
    assert!(ran.out.contains("is whole"), "{}", ran.out);
}
