//! Events and HEALTH as JSON, over a router.

use super::{
    Daemon,
    rig::{endpoint, patient, router},
    wire,
};
use grip_fleet::{EventId, Part, WallTime, net::Session};
use grip_link::message::Kind;
use serde_json::Value;
use std::collections::BTreeMap;
use zenoh::Wait as _;

/// What was published as JSON, by the last part of its name.
fn json(sample: &zenoh::sample::Sample) -> (String, Value) {
    assert_eq!(sample.encoding().to_string(), "application/json");
    let name = sample.key_expr().as_str().split_once("/json/").unwrap().1.to_owned();
    (name, serde_json::from_slice(&sample.payload().to_bytes()).unwrap())
}

/// All answers to `question`, by the last part of their names.
fn answers_in_json(
    daemon: &mut Daemon,
    session: &Session,
    question: &str,
) -> BTreeMap<String, Value> {
    let answers = session.get(question).wait().unwrap();
    let mut came = BTreeMap::new();
    daemon.turn_until(|_, _| match answers.try_recv() {
        Ok(reply) => {
            came.extend(reply.map(|reply| json(reply.result().unwrap())));
            false
        }
        Err(_) => true,
    });
    came
}

#[test]
fn a_client_that_reads_json_only_gets_what_the_others_get() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let _router = router(&endpoint);
    let network = patient(folder.path(), &endpoint);
    let mut daemon = Daemon::start(folder.path(), &network, 1, 0x2a);
    let session = network.open().unwrap();
    daemon.report();
    let live = session.declare_subscriber("grip/v1/*/*/json/**").wait().unwrap();
    let mut published = BTreeMap::new();
    daemon.turn_until(|daemon, at| {
        // Again and again: the router learns of the subscriber in its own time.
        if at.is_multiple_of(50) {
            daemon.report();
        }
        published.extend(live.try_recv().unwrap().map(|sample| json(&sample)));
        published.len() == 2
    });
    let event = &published["events"];
    assert_eq!((&event["type"], &event["about"]), (&"notice".into(), &"link".into()), "{event}");
    assert_eq!((&event["site"], &event["run"]), (&"hall".into(), &"0000002a".into()), "{event}");
    assert_eq!(event["uid"], "01".repeat(16));
    assert_eq!(event["id"], format!("0000002a.{}", event["text"].as_str().unwrap()), "{event}");
    assert_eq!(event["seq"].to_string(), event["text"].as_str().unwrap(), "{event}");
    assert_eq!(published["health"]["type"], "health");
    assert!(published["health"]["samples"].is_u64(), "{published:?}");
    assert!(published["health"].get("latency_p50_us").is_none(), "absent, not null");

    let at = WallTime { ns: 1_700_000_000_123_456_789, error_us: 50_000 };
    daemon.spool.append_at(wire(Kind(0xBF), |_| 0), at);
    let head = daemon.spool.log().head();
    let key = daemon.member.key(Part::EventsJson);
    let after = format!("{key}/**?after={}", EventId { seq: head.seq - 2, ..head });
    for (question, count) in [(after, 2), (daemon.member.key(Part::HealthJson), 1)] {
        let came = answers_in_json(&mut daemon, &session, &question);
        assert_eq!(came.len(), count, "{question}: {came:?}");
        if let Some(last) = came.get(&format!("events/0000002a/{}", head.seq)) {
            // One of a kind that is not known has its place too.
            assert_eq!(last["type"], "unknown", "{last}");
            assert_eq!((&last["unix_ns"], &last["error_us"]), (&at.ns.into(), &50_000.into()));
        }
    }
}
