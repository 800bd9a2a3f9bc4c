//! Clients and a scraper at a real gripd: every sample arrives once, the pages answer, a fault leaves a dump.

use crate::running::{UPDATES, client, holding, receive, serving};
use grip_link::message::daemon::{NoticeKind, Subscribe, ToClient};
use rustix::process::Signal;
use serde_json::Value;
use std::{
    fs,
    io::{Read as _, Write as _},
    net::{TcpListener, TcpStream},
};
use stories::until;

/// Numbers from the first row on without a gap, unless gripd reports that it dropped frames or lost samples.
#[test]
fn a_client_that_wants_every_sample_gets_each_once() {
    let folder = tempfile::tempdir().unwrap();
    let running = serving(folder.path(), &[]);
    let mut client = client(folder.path(), 3, Subscribe { every_nth: 1, ..UPDATES });
    let (mut next, mut rows, mut gaps, mut dropped) = (None, 0_u32, 0_u32, false);
    receive(&mut client, |message| {
        match message {
            ToClient::Rows(batch) => {
                for row in batch.iter() {
                    gaps += u32::from(next.is_some_and(|next| next != row.index));
                    next = Some(row.index.wrapping_add(1));
                    rows += 1;
                }
            }
            ToClient::Notice(notice) => dropped |= notice.kind == NoticeKind::Dropped,
            _ => {}
        }
        rows >= 20_000
    });
    let ran = running.interrupted();
    let summary: Value = serde_json::from_str(ran.out.lines().last().unwrap()).unwrap();
    let whole = summary["lost"] == 0 && summary["untold_notes"] == 0 && !dropped;
    assert!(gaps == 0 || !whole, "{gaps} gaps: {summary}");
}

/// A port that was free a moment ago.
fn free_address() -> String {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string()
}

/// The answer to GET, and its status line.
fn get(address: &str, path: &str) -> (String, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.lines().next().unwrap().to_owned(), body.to_owned())
}

/// The value of a metric without labels.
fn metric(page: &str, name: &str) -> f64 {
    let line = page.lines().find(|line| line.split(' ').next() == Some(name));
    line.and_then(|line| line.split(' ').nth(1)).unwrap().parse().unwrap()
}

#[test]
fn the_pages_report_what_runs() {
    let folder = tempfile::tempdir().unwrap();
    let address = free_address();
    let args = ["--metrics", &address, "--record", "run.mcap"];
    let running = holding(folder.path(), &args);
    let mut page = String::new();
    // Each counter reaches the page in its own time.
    let counted = until(|| {
        page = get(&address, "/metrics").1;
        metric(&page, "gripd_recording_bytes_total") > 10_000.0
            && metric(&page, "gripd_samples_total") > 1000.0
            && metric(&page, "gripd_slips_total") >= 1.0
    });
    assert!(counted, "{page}");
    assert!(page.contains("gripd_link_state{state=\"stream\"} 1"), "{page}");
    let (status, body) = get(&address, "/status");
    let body: Value = serde_json::from_str(&body).unwrap();
    assert!(status.contains("200") && body["recording"]["file"] == "run.mcap", "{body}");
    assert!(get(&address, "/healthz").0.contains("200"));
    assert!(get(&address, "/etc/passwd").0.contains("404"));
    running.interrupted().done();
}

#[test]
fn a_fault_leaves_the_last_frames_behind() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gripd.toml");
    fs::write(&file, "dump_dir = \"dumps\"\n").unwrap();
    let running = holding(folder.path(), &[]);
    // Less than the object needs: it falls, and the gripper notices that it holds nothing.
    fs::write(&file, "dump_dir = \"dumps\"\n[grip]\nf_max_n = 5.0\n").unwrap();
    running.signal(Signal::HUP);
    running.until_reported("the last frames and the state were written to dumps/gripd-");
    running.interrupted().done();
    let dump = fs::read_dir(folder.path().join("dumps")).unwrap().next().unwrap().unwrap();
    let name = dump.file_name().into_string().unwrap();
    assert!(name.contains("gripper_fault"), "{name}");
    let text = fs::read_to_string(dump.path()).unwrap();
    assert!(text.contains("cause: the gripper reported fault"), "{text}");
    assert!(text.contains("== state") && text.contains("SAMPLES"), "{text}");
}
