//! Archives that are killed at every point, days that change, and what stands in the files.

use super::{Archive, EVENT, HEALTH, STATE, StoreError};
use crate::wire;
use crate::{EventId, Member, Message, Stamp, Uid, WallTime, json};
use core::mem;
use grip_link::message::{
    Kind,
    daemon::{Gripper, Health, Notice, NoticeKind, SlipReport},
};
use grip_record::mcap::{Foreign, ForeignReader, no_unpack};
use serde_json::Value;
use std::{collections::BTreeSet, fs, path::Path};

/// 2026-11-26T00:00:00Z, in ns.
const MORNING: u64 = 1_795_651_200_000_000_000;
const DAY: u64 = 86_400_000_000_000;

fn message(kind: Kind, write: impl FnOnce(&mut [u8]) -> usize) -> Message {
    Message::from_wire(&wire(kind, write)).unwrap()
}

fn notice() -> Message {
    let kind = NoticeKind::Link;
    let notice = Notice { kind, code: 0, value: 0, count: 0, host_us: 0, text: b"open" };
    message(Kind::NOTICE, |out| notice.write(out).unwrap())
}

fn health() -> Message {
    message(Kind::HEALTH, |out| Health::default().write(out).unwrap())
}

fn member() -> Member {
    Member { site: "hall".parse().unwrap(), uid: Uid([7; 16]) }
}

fn stamp(seq: u64) -> Stamp {
    let at = WallTime { ns: MORNING - DAY + seq, error_us: 50 };
    Stamp { id: EventId { run: 1, seq }, at }
}

fn event(archive: &mut Archive, now_ns: u64, seq: u64) {
    archive.event(now_ns, &member(), stamp(seq), 0, &notice()).unwrap();
}

/// Topic, log time and object of a message.
type Logged = (String, u64, Value);

/// Finished files by name, and the messages in each.
fn files(folder: &Path) -> Vec<(String, Vec<Logged>)> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let names: BTreeSet<String> = names.map(|name| name.into_string().unwrap()).collect();
    // The first of a day has no number.
    let mut finished: Vec<&str> =
        names.iter().filter_map(|name| name.strip_suffix(".mcap")).collect();
    finished.sort_unstable();
    let file = |stem: &str| folder.join(format!("{stem}.mcap"));
    finished.into_iter().map(|stem| (stem.to_owned(), messages(&file(stem)))).collect()
}

fn messages(file: &Path) -> Vec<Logged> {
    let mut reader = ForeignReader::open(file, no_unpack).unwrap();
    let (mut topics, mut found) = (Vec::new(), Vec::new());
    while let Some(item) = reader.next_item().unwrap() {
        match item {
            Foreign::Channel { id, channel } => topics.push((id, channel.topic)),
            Foreign::Message { channel, log_ns, data, .. } => {
                let (_, topic) = topics.iter().find(|(id, _)| *id == channel).unwrap();
                found.push((topic.clone(), log_ns, serde_json::from_slice(data).unwrap()));
            }
        }
    }
    found
}

/// Numbers of the events in all files.
fn seqs(folder: &Path) -> Vec<u64> {
    let all = files(folder).into_iter().flat_map(|(_, messages)| messages);
    all.filter(|(topic, ..)| topic.ends_with("/events"))
        .map(|(.., value)| value["seq"].as_u64().unwrap())
        .collect()
}

#[test]
fn messages_are_in_files_of_their_day_with_topics_times_and_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let mut archive = Archive::open(folder.path(), "test").unwrap();
    let evening = MORNING + DAY - 1;
    event(&mut archive, MORNING, 1);
    archive.health(evening, &member(), stamp(1), &health()).unwrap();
    archive.event(evening + 1, &member(), stamp(4), 2, &notice()).unwrap();
    archive.close().unwrap();
    event(&mut archive, evening + 2, 4);
    event(&mut archive, evening + 2, 5);
    archive.close().unwrap();
    let files = files(folder.path());
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["2026-11-26", "2026-11-27", "2026-11-27-0001"]);
    let place = format!("/hall/{}", "07".repeat(16));
    let [(_, first), (_, second), (_, third)] = &files[..] else { panic!("{files:?}") };
    let (topic, log_ns, value) = &first[0];
    assert_eq!((topic, *log_ns), (&format!("{place}/events"), MORNING));
    assert_eq!((&value["id"], &value["text"]), (&"00000001.1".into(), &"open".into()));
    assert_eq!(value["unix_ns"], MORNING - DAY + 1);
    assert_eq!((&first[1].0, &first[1].2["type"]), (&format!("{place}/health"), &"health".into()));
    let kinds: Vec<&str> = second.iter().filter_map(|(.., value)| value["type"].as_str()).collect();
    assert_eq!((kinds, &second[0].2["events"]), (vec!["missing", "notice"], &2.into()));
    assert_eq!(third.len(), 1, "number 4 is there already");
}

/// What is killed asks for everything behind what it knows, as `Watch` does.
#[test]
fn a_kill_at_any_point_costs_no_event_and_doubles_none() {
    let folder = tempfile::tempdir().unwrap();
    let mut next = 1;
    for kill in 0..12 {
        let mut archive = Archive::open(folder.path(), "test").unwrap();
        let known = archive.received().flat_map(|(_, ids)| ids).map(|id| id.seq).max().unwrap_or(0);
        assert!(known <= next);
        for seq in known + 1..=next + 3 {
            event(&mut archive, MORNING, seq);
            if kill % 3 == 1 && seq == next {
                archive.commit().unwrap();
            }
        }
        next += 3;
        if kill % 4 == 3 {
            archive.close().unwrap();
        }
        let part = archive.open.as_ref().map(|open| super::part(folder.path(), &open.name));
        // Without its drop, as a kill.
        mem::forget(mem::take(&mut archive.open));
        drop(archive);
        if let Some(part) = part {
            // What it had written, not yet counted, is there too.
            let rubbish = [fs::read(&part).unwrap(), vec![3; 100]].concat();
            fs::write(&part, rubbish).unwrap();
        }
    }
    let mut last = Archive::open(folder.path(), "test").unwrap();
    let known = last.received().flat_map(|(_, ids)| ids).map(|id| id.seq).max().unwrap_or(0);
    (known + 1..=next).for_each(|seq| event(&mut last, MORNING, seq));
    last.close().unwrap();
    assert_eq!(seqs(folder.path()), (1..=next).collect::<Vec<_>>());
    let left = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let left: Vec<_> = left.filter(|name| name.to_string_lossy().contains(".mcap.")).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// Killed while the file that an earlier kill has left was being finished: before and after it got its name, and before the state was written.
#[test]
fn a_kill_while_what_is_left_is_finished_costs_nothing() {
    for step in 0..3 {
        let folder = tempfile::tempdir().unwrap();
        let mut archive = Archive::open(folder.path(), "test").unwrap();
        (1..4).for_each(|seq| event(&mut archive, MORNING, seq));
        archive.commit().unwrap();
        let state = fs::read(folder.path().join(STATE)).unwrap();
        let part = folder.path().join("2026-11-26.mcap.part");
        let left = fs::read(&part).unwrap();
        mem::forget(mem::take(&mut archive.open));
        drop(archive);
        if step > 0 {
            drop(Archive::open(folder.path(), "test").unwrap());
            fs::write(folder.path().join(STATE), &state).unwrap();
        }
        if step == 1 {
            fs::write(&part, &left).unwrap();
        }
        let mut archive = Archive::open(folder.path(), "test").unwrap();
        assert_eq!(archive.recovered().map(|(_, saved)| saved.messages), (step < 2).then_some(3));
        event(&mut archive, MORNING, 4);
        archive.close().unwrap();
        assert_eq!(seqs(folder.path()), [1, 2, 3, 4], "{step}");
    }
}

#[test]
fn one_archive_at_a_time_and_a_state_that_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let first = Archive::open(folder.path(), "test").unwrap();
    let second = Archive::open(folder.path(), "test").unwrap_err();
    assert!(matches!(second, StoreError::Locked { .. }), "{second}");
    drop(first);
    for text in ["rubbish", r#"{"bytes":0,"received":{"hall":[]}}"#] {
        fs::write(folder.path().join(STATE), text).unwrap();
        let wrong = Archive::open(folder.path(), "test").unwrap_err();
        assert!(matches!(wrong, StoreError::Content { .. }), "{wrong}");
    }
}

#[test]
fn every_field_is_in_the_schema_with_its_type() {
    let some = Some(0.5);
    let slip = SlipReport {
        statistic: some,
        confidence: some,
        speed_m_s: some,
        speed_sigma_m_s: some,
        moved_m: some,
        irregularities: Some(3),
        esc_w: Some(0.5),
        ruled_out: 1,
        estimate_n: some,
        command_n: some,
        duration_s: Some(0.5),
        certified_s: some,
        ..SlipReport::UNKNOWN
    };
    let gripper = Gripper { uid: [7; 16], force_max_n: some, ..Gripper::NONE };
    let messages = [
        (EVENT, message(Kind::SLIP, |out| slip.write(out).unwrap())),
        (EVENT, message(Kind::GRIPPER, |out| gripper.write(out).unwrap())),
        (EVENT, notice()),
        (HEALTH, health()),
    ];
    for (kind, message) in messages {
        let schema: Value = serde_json::from_str(kind.schema).unwrap();
        let object = json::of_message(&member(), stamp(1), &message).unwrap();
        let object: Value = serde_json::from_str(&object).unwrap();
        for (name, value) in object.as_object().unwrap() {
            let fits = match schema["properties"][name]["type"].as_str() {
                Some("string") => value.is_string(),
                Some("integer") => value.is_u64() || value.is_i64(),
                Some("number") => value.is_number(),
                Some("boolean") => value.is_boolean(),
                Some("array") => value.is_array(),
                _ => false,
            };
            assert!(fits, "{name}: {value}");
        }
        for name in schema["required"].as_array().unwrap() {
            assert!(object.get(name.as_str().unwrap()).is_some(), "{name}");
        }
    }
}
