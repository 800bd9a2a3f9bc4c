//! The page in the browser: what it is made of, who gets it, and viewers that do not keep up.

use crate::{
    made,
    server::{Rig, get},
};
use grip_daemon::{
    Board, Item, LinkNote,
    board::About,
    live::{EVERY_US, Feed},
};
use grip_link::message::{FaultCode, Status};
use serde_json::{Value, json};
use slip_core::{Phase, PipelineState, alarm::Method, sample::Scene, units::Micros};
use std::{
    io::{Read as _, Write as _},
    net::Shutdown,
};

/// Takes states from `from_us` on, one each 20 ms.
fn take(board: &mut Board, from_us: u64, states: &[PipelineState]) {
    for (state, t) in states.iter().zip((from_us..).step_by(20_000).map(Micros)) {
        board.take(&Item::State(&PipelineState { t, ..*state }));
    }
}

/// The next message.
fn next(feed: &mut Feed, board: &Board, now_us: u64) -> Value {
    let message = feed.next(board, now_us, 1).unwrap();
    let data = message.strip_prefix("retry: 2000\ndata: ").unwrap().strip_suffix("\n\n").unwrap();
    assert_eq!(data.lines().count(), 1, "one event");
    serde_json::from_str(data).unwrap()
}

#[test]
fn the_page_is_for_this_computer_and_runs_nothing_but_its_files() {
    let mut rig = Rig::new();
    let page = rig.ask(&get("/"));
    let (head, body) = page.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\n"));
    assert!(head.contains("\r\nContent-Security-Policy: default-src 'none'; script-src 'self'; "));
    // What it loads is there; nothing stands in it that the policy would refuse.
    let files: Vec<_> = body.split('"').filter(|text| text.starts_with('/')).collect();
    assert!(files.len() >= 4, "{files:?}");
    for file in files {
        assert!(rig.ask(&get(file)).starts_with("HTTP/1.1 200 "), "{file}");
    }
    assert!(!["<style", " style=", " on", "://"].iter().any(|text| body.contains(text)));
    for foreign in ["/ HTTP/1.1\r\nHost", "/events HTTP/1.1\r\nHost", "/events HTTP/1.1\r\nOrigin"]
    {
        let answer = rig.ask(&format!("GET {foreign}: http://evil.example\r\n\r\n"));
        assert!(answer.starts_with("HTTP/1.1 421 "), "{foreign}");
    }
}

#[test]
fn a_message_has_the_points_since_the_last_one_and_numbers_or_null() {
    let (mut board, mut feed) = (Board::new(About::default()), Feed::default());
    let new = next(&mut feed, &board, 0);
    assert_eq!((&new["pipeline"], &new["points"]), (&Value::Null, &json!([])));
    assert!(feed.next(&board, EVERY_US - 1, 1).is_none(), "not due");
    // A short slip, a statistic that is no number, a slip that is only an event.
    let [mut slip, mut odd] = [made::STATE; 2];
    (slip.scene, slip.statistic, odd.statistic) = (Scene::Slipping, Some(7.0), Some(f32::NAN));
    take(&mut board, 1_000_000, &[made::STATE, slip, odd, made::STATE]);
    board.take(&Item::Event { host_us: 9, event: &made::slip(Phase::Gross, Method::Travel) });
    take(&mut board, 1_120_000, &[made::STATE]);
    let points = next(&mut feed, &board, EVERY_US)["points"].clone();
    let point = |t_s: f64, slip: bool, statistic: f64| {
        let forces_n = json!([2.5, null, 1.75, 2.0, 2.25]);
        json!({ "t_s": t_s, "scene": "holding", "slip": slip, "statistic": statistic, "forces_n": forces_n })
    };
    assert_eq!(
        points,
        json!([point(1.0, false, 0.75), point(1.06, true, 7.0), point(1.12, true, 0.75)])
    );
    assert_eq!(next(&mut feed, &board, 2 * EVERY_US)["points"], json!([]));
    take(&mut board, 2_000_000, &[made::STATE; 5000]);
    assert_eq!(next(&mut feed, &board, 3 * EVERY_US)["points"].as_array().unwrap().len(), 600);
    let dropped = Status { fault: FaultCode::OBJECT_LOST, ..made::STATUS };
    board.take(&Item::Link { host_us: 9, note: &LinkNote::Status(dropped) });
    let before = next(&mut Feed::default(), &board, 0)["run"].clone();
    take(&mut board, 1, &[made::STATE]);
    let restarted = next(&mut Feed::default(), &board, 0);
    assert_ne!(before, restarted["run"], "the times of another run");
    let another = Board::new(About { run_id: 7, ..About::default() });
    assert_ne!(new["run"], next(&mut Feed::default(), &another, 0)["run"], "of another gripd");
    assert_eq!(restarted["points"].as_array().unwrap().len(), 1);
    assert_eq!(
        (&restarted["points"][0]["scene"], &restarted["fault"]),
        (&json!("fault"), &json!("the object is gone."))
    );
}

#[test]
fn a_viewer_that_closes_its_sending_side_gets_events_until_it_hangs_up() {
    let mut rig = Rig::new();
    let mut viewer = rig.connect();
    viewer.write_all(get("/events").as_bytes()).unwrap();
    viewer.shutdown(Shutdown::Write).unwrap();
    while rig.server.streams() < 1 {
        rig.turn();
    }
    for count in 1..4 {
        rig.server.publish(rig.now_us, "data: more\n\n");
        rig.turn();
        assert_eq!(rig.server.streams(), 1, "after {count}");
    }
    assert!(rig.server.interests().skip(1).all(|interest| !interest.read), "it wakes nobody");
    drop(viewer);
    while rig.server.counts().0 > 0 {
        rig.server.publish(rig.now_us, "data: more\n\n");
        rig.turn();
    }
}

#[test]
fn viewers_that_never_read_make_room_for_one_that_does() {
    let mut rig = Rig::new();
    let mut silent = [(); 4].map(|()| rig.connect());
    for viewer in &mut silent {
        viewer.write_all(get("/events").as_bytes()).unwrap();
    }
    while rig.server.streams() < 4 {
        rig.turn();
    }
    let (mut feed, mut board, mut answer) = (Feed::default(), made::board(), String::new());
    // As often as a page asks.
    while !answer.starts_with("HTTP/1.1 200 ") {
        for _ in 0..40 {
            rig.now_us += EVERY_US;
            take(&mut board, rig.now_us, &[made::STATE; 3]);
            rig.server.publish(rig.now_us, &feed.next(&board, rig.now_us, 4).unwrap());
            rig.turn();
        }
        assert!(rig.now_us <= 12_000_000, "locked out");
        let mut viewer = rig.connect();
        viewer.write_all(get("/events").as_bytes()).unwrap();
        let mut bytes = vec![0; 1 << 20];
        for _ in 0..100 {
            rig.turn();
            if let Ok(count) = viewer.read(&mut bytes) {
                answer = String::from_utf8_lossy(&bytes[..count]).into_owned();
                break;
            }
        }
    }
    assert_eq!(rig.server.streams(), 4, "one of them was closed, no more");
}

#[test]
fn a_viewer_gets_events_and_one_that_does_not_read_is_dropped() {
    let mut rig = Rig::new();
    let mut viewers = [(); 4].map(|()| rig.connect());
    for viewer in &mut viewers {
        viewer.write_all(get("/events").as_bytes()).unwrap();
    }
    while rig.server.streams() < 4 {
        rig.turn();
    }
    assert!(rig.ask(&get("/events")).starts_with("HTTP/1.1 503 "), "four at a time");
    assert!(rig.ask(&get("/metrics")).starts_with("HTTP/1.1 200 "), "others are served");
    let (mut read, mut sent, mut feed, mut board) =
        (String::new(), 2, Feed::default(), made::board());
    // Beyond the limits of a request and of an answer: who reads stays.
    while rig.server.counts().0 > 1 || rig.now_us < 20_000_000 {
        rig.now_us += EVERY_US;
        take(&mut board, sent * 6_000_000, &[made::STATE; 300]);
        rig.server.publish(rig.now_us, &feed.next(&board, rig.now_us, 1).unwrap());
        rig.turn();
        sent += 1;
        assert!(sent < 10_000, "{} viewers are still there", rig.server.counts().0);
        let mut bytes = vec![0; 1 << 20];
        if let Ok(count) = viewers[0].read(&mut bytes) {
            read.push_str(str::from_utf8(&bytes[..count]).unwrap());
        }
    }
    assert_eq!(rig.server.streams(), 1);
    let (head, events) = read.split_once("\r\n\r\n").unwrap();
    assert!(head.contains("\r\nContent-Type: text/event-stream\r\n"), "{head}");
    assert!(events.matches("\n\n").count() > 100);
    for event in events.split_inclusive("\n\n").filter(|event| event.ends_with("\n\n")) {
        let data = event.strip_prefix("retry: 2000\ndata: ").unwrap();
        assert!(serde_json::from_str::<Value>(data).unwrap()["points"].is_array());
    }
}
