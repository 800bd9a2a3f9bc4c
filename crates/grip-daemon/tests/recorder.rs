//! The recorder on simulated grasps: replays give the identical events, whatever happens to the files.
#![expect(clippy::unwrap_used, reason = "test code")]

use grip_daemon::{
    Item, LinkNote,
    recorder::{About, Recorder, RecorderUpdate, RecordingOptions},
};
use grip_eval::trial;
use grip_link::message::Firmware;
use grip_record::{CsvOptions, mcap::Attached, read_csv};
use grip_session::{
    HostConfig, Update, model,
    report::Event,
    session::Beginning,
    tape::{Played, Tape, TapeError, TapeOptions},
};
use slip_core::{Sample, units::Micros};
use std::{
    fs,
    path::{Path, PathBuf},
};

enum Kept {
    Began(Box<Beginning>),
    Sample(u32, Sample),
    Event(Event),
}

fn grasp(scene: &str, seed: u64) -> Vec<(u64, Kept)> {
    let scene = grip_sim::scene::load(scene).unwrap().reseeded(seed).unwrap();
    let (mut items, mut now_us) = (Vec::new(), 0);
    let mut report = |updates: Update<'_>| match updates {
        Update::Began(beginning) => items.push((now_us, Kept::Began(Box::new(*beginning)))),
        Update::Step { index, sample, .. } => {
            now_us = sample.t.0;
            items.push((now_us, Kept::Sample(index, *sample)));
        }
        Update::Event(line) => items.push((now_us, Kept::Event(line))),
        Update::Gripper { .. } | Update::Link(_) => {}
    };
    let estimator = model::default_estimator().unwrap();
    trial::grasp(&scene, &HostConfig::default(), estimator, Micros(1_500_000), &mut report)
        .unwrap();
    items
}

fn about() -> About {
    let model = Attached {
        name: grip_session::recording::MODEL_NAME.to_owned(),
        media_type: "application/json".to_owned(),
        data: model::default_text().as_bytes().to_vec(),
    };
    About {
        program: "test 1".to_owned(),
        run: "r1".to_owned(),
        wall_ns: 1_763_766_000_000_000_000,
        attached: vec![model],
        ..About::default()
    }
}

/// Puts everything through the recorder, with a tick every 50 ms.
fn feed(recorder: &mut Recorder, items: &[(u64, Kept)], from_us: u64) -> u64 {
    let mut ticked_us = 0;
    let mut now_us = from_us;
    for (at_us, kept) in items {
        now_us = from_us + at_us;
        let host_us = now_us;
        let item = match kept {
            Kept::Began(beginning) => Item::Began { host_us, beginning },
            Kept::Sample(index, sample) => {
                Item::Sample { host_us, index: *index, sample, taxels: &[] }
            }
            Kept::Event(event) => Item::Event { host_us, event },
        };
        recorder.take(&item, now_us);
        if now_us >= ticked_us + 50_000 {
            ticked_us = now_us;
            recorder.tick(now_us);
        }
    }
    now_us
}

fn live(items: &[(u64, Kept)]) -> Vec<String> {
    let lines = items.iter().filter_map(|(_, kept)| match kept {
        Kept::Event(line) => Some(serde_json::to_string(line).unwrap()),
        _ => None,
    });
    lines.collect()
}

/// Lines replayed, lines recorded and notes.
#[derive(Default)]
struct Received {
    replayed: Vec<String>,
    recorded: Vec<String>,
    notes: Vec<String>,
}

fn replay(files: &[PathBuf]) -> (Tape, Received, Result<(), TapeError>) {
    let (mut tape, mut received) = (Tape::new(TapeOptions::default()), Received::default());
    let mut outcome = Ok(());
    for file in files {
        outcome = outcome.and_then(|()| {
            tape.play(file, &mut |played| match played {
                Played::Line(line) => received.replayed.push(serde_json::to_string(line).unwrap()),
                Played::Recorded(line) => received.recorded.push(line.to_owned()),
                Played::Note(text) => received.notes.push(text),
                _ => {}
            })
        });
    }
    (tape, received, outcome)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    // run.mcap comes before run-0001.mcap.
    files.sort_by_key(|file| (file.file_stem().unwrap().len(), file.clone()));
    files
}

#[test]
fn a_replay_gives_the_identical_events() {
    for (scene, seed) in [("default", 0), ("shaken", 2), ("moving", 1)] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.mcap");
        let items = grasp(scene, seed);
        let mut recorder = Recorder::create(&file, RecordingOptions::default(), about()).unwrap();
        feed(&mut recorder, &items, 1_000_000);
        let counters = recorder.finish().unwrap();
        assert_eq!((counters.stopped, counters.files, counters.failures), (0, 1, 0));
        let (tape, received, outcome) = replay(&[file]);
        outcome.unwrap();
        let lines = live(&items);
        assert!(lines.iter().any(|line| line.contains("\"slip\"")), "{scene}: {lines:?}");
        assert_eq!((&received.replayed, &received.recorded), (&lines, &lines), "{scene}");
        let summary = tape.summary();
        assert_eq!((summary.samples, summary.lost), (counters.samples, 0));
        assert!(!summary.mid_run && summary.pipelines == 1 && received.notes.is_empty());
    }
}

/// Two grippers' lives, or a restart, one after the other in one recording.
#[test]
fn each_pipeline_begins_where_it_began() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let (first, second) = (grasp("default", 3), grasp("light_rough", 5));
    let mut recorder = Recorder::create(&file, RecordingOptions::default(), about()).unwrap();
    let end_us = feed(&mut recorder, &first, 0);
    recorder.attach(&about().attached[0], end_us);
    feed(&mut recorder, &second, end_us + 500_000);
    recorder.finish().unwrap();
    let (tape, received, outcome) = replay(&[file]);
    outcome.unwrap();
    let lines = [live(&first), live(&second)].concat();
    assert_eq!((&received.replayed, &received.recorded), (&lines, &lines));
    assert_eq!(tape.summary().pipelines, 2);
}

#[test]
fn rotated_files_stand_for_themselves_and_follow_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let items = grasp("default", 0);
    let options = RecordingOptions { rotate_us: Some(400_000), ..RecordingOptions::default() };
    let mut recorder = Recorder::create(&file, options, about()).unwrap();
    let firmware = Firmware { major: 1, minor: 2, patch: 3 };
    let note = LinkNote::Identified { uid: [7; 16], boot_id: 2, firmware, rebooted: false };
    recorder.take(&Item::Link { host_us: 0, note: &note }, 0);
    feed(&mut recorder, &items, 0);
    let counters = recorder.finish().unwrap();
    let files = files(folder.path());
    assert!(files.len() >= 3 && files.len() == counters.files as usize, "{files:?}");
    assert!(files[1].ends_with("run-0001.mcap"), "{files:?}");
    let (_, received, outcome) = replay(&files);
    outcome.unwrap();
    assert_eq!((&received.replayed, &received.notes), (&live(&items), &Vec::new()));
    // One alone is readable, and states what it is.
    let (tape, received, outcome) = replay(files.get(1..2).unwrap());
    outcome.unwrap();
    assert!(tape.summary().mid_run && tape.summary().samples > 1000);
    assert!(received.notes[0].contains("middle of a run"), "{:?}", received.notes);
    let (_, _, outcome) = replay(&[files[0].clone(), files[2].clone()]);
    let text = outcome.unwrap_err().to_string();
    assert!(text.contains("run-0002.mcap: does not go on where"), "{text}");
    let large = RecordingOptions { rotate_bytes: Some(50_000), ..RecordingOptions::default() };
    let mut recorder = Recorder::create(&folder.path().join("b.mcap"), large, about()).unwrap();
    feed(&mut recorder, &items, 0);
    assert!(recorder.finish().unwrap().files > 1, "by size");
}

#[test]
fn the_oldest_files_of_the_run_make_room_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other.mcap");
    fs::write(&other, vec![0; 1 << 20]).unwrap();
    let items = grasp("default", 0);
    let options = RecordingOptions {
        rotate_bytes: Some(50_000),
        keep_bytes: Some(150_000),
        ..RecordingOptions::default()
    };
    let mut recorder = Recorder::create(&folder.path().join("run.mcap"), options, about()).unwrap();
    feed(&mut recorder, &items, 0);
    let mut deleted = Vec::new();
    while let Some(updates) = recorder.updates() {
        if let RecorderUpdate::Deleted(file) = updates {
            deleted.push(file);
        }
    }
    let counters = recorder.finish().unwrap();
    assert!(!deleted.is_empty() && deleted[0].ends_with("run.mcap"), "{deleted:?}");
    assert!(deleted.iter().all(|file| !file.exists()) && other.exists());
    let left = files(folder.path());
    assert_eq!(left.len(), counters.files as usize - deleted.len() + 1, "{left:?}");
    let bytes: u64 = left
        .iter()
        .filter(|file| **file != other)
        .map(|file| fs::metadata(file).unwrap().len())
        .sum();
    assert!(bytes < 150_000 + 2 * 100_000, "{bytes}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_stops_the_recording_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    assert!(
        Recorder::create(Path::new("/dev/full"), RecordingOptions::default(), about()).is_ok(),
        "a CSV is written later"
    );
    std::os::unix::fs::symlink("/dev/full", &file).unwrap();
    let error = Recorder::create(&file, RecordingOptions::default(), about()).unwrap_err();
    assert!(
        error.to_string().contains("run.mcap") && error.to_string().contains("No space"),
        "{error}"
    );
    // CSV gets that far, and fails when it is flushed.
    let csv = folder.path().join("run.csv");
    std::os::unix::fs::symlink("/dev/full", &csv).unwrap();
    let items = grasp("default", 0);
    let mut recorder = Recorder::create(&csv, RecordingOptions::default(), about()).unwrap();
    let end_us = feed(&mut recorder, &items, 0);
    let mut stops = 0;
    while let Some(updates) = recorder.updates() {
        if let RecorderUpdate::Stopped(error) = updates {
            stops += 1;
            assert!(error.to_string().contains("No space"), "{error}");
        }
    }
    let counters = recorder.counters();
    assert_eq!((stops, counters.failures), (1, 1), "told once");
    assert_eq!(
        (counters.samples, counters.stopped),
        (0, counters.items),
        "every item is accounted for"
    );
    assert!(recorder.file().is_none());
    recorder.tick(9_000_000);
    assert!(recorder.file().is_none(), "ten seconds after the failure, not before");
    recorder.tick(end_us + 60_000_000);
    assert_eq!(
        recorder.file(),
        Some(folder.path().join("run-0001.csv").as_path()),
        "a new file is tried"
    );
    feed(&mut recorder, &items, end_us + 60_000_000);
    assert!(recorder.finish().unwrap().samples > 10_000);
}

#[test]
fn what_did_not_reach_the_recorder_is_reported_in_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let items = grasp("default", 0);
    let mut recorder = Recorder::create(&file, RecordingOptions::default(), about()).unwrap();
    let (before, after) = items.split_at(items.len() / 2);
    let now_us = feed(&mut recorder, before, 0);
    recorder.dropped(12, now_us);
    feed(&mut recorder, after, 0);
    assert_eq!(recorder.finish().unwrap().dropped, 12);
    let (tape, received, outcome) = replay(&[file]);
    outcome.unwrap();
    assert_eq!(tape.summary().unrecorded, 12);
    assert_eq!(received.notes, ["12 items were not recorded here"]);
}

#[test]
fn a_csv_holds_the_samples_of_one_pipeline() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    fs::write(&file, "something else").unwrap();
    let items = grasp("default", 0);
    let mut recorder = Recorder::create(&file, RecordingOptions::default(), about()).unwrap();
    let end_us = feed(&mut recorder, &items, 500_000);
    feed(&mut recorder, &items, end_us);
    recorder.finish().unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), "something else");
    for name in ["run-0001.csv", "run-0002.csv"] {
        let recording = read_csv(&folder.path().join(name), &CsvOptions::default()).unwrap();
        let samples = items.iter().filter_map(|(_, kept)| match kept {
            Kept::Sample(_, sample) => Some(*sample),
            _ => None,
        });
        assert!(recording.samples.iter().copied().eq(samples), "{name}");
    }
}

/// A daemon that is killed leaves its last flush behind.
#[test]
fn a_killed_recording_replays_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let items = grasp("default", 0);
    let mut recorder = Recorder::create(&file, RecordingOptions::default(), about()).unwrap();
    let end_us = feed(&mut recorder, &items, 0);
    let cut = folder.path().join("cut.mcap");
    fs::copy(&file, &cut).unwrap();
    recorder.finish().unwrap();
    let (tape, received, outcome) = replay(&[cut]);
    let Err(TapeError::Mcap(error)) = outcome else { panic!("a file without its end") };
    assert!(error.to_string().contains("gripctl recover"), "{error}");
    let lines = live(&items);
    assert_eq!(Some(received.replayed.as_slice()), lines.get(..received.replayed.len()));
    let lost = items.len() as u64 - tape.summary().samples;
    assert!(
        lost < 10 * 310 + lines.len() as u64 + 2,
        "{lost} of 10 a millisecond up to {end_us} us"
    );
}
