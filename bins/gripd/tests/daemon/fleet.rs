//! gripd beside a router in the test: whoever watches the fleet gets each slip once, whatever becomes of router and daemon.

use crate::running::{Running, until};
use core::time::Duration;
use grip_fleet::{
    EventId, Selector, Since,
    net::{self, Network, Told, Watch},
};
use grip_link::message::daemon::ToClient;
use std::{collections::HashSet, fs, net::TcpListener, path::Path};

/// Looks of 20 ms.
const LOOK: Duration = Duration::from_millis(20);

/// A router's address, and a folder with a configuration that names it.
fn place(folder: &Path) -> (String, Network) {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let router = format!("tcp/127.0.0.1:{port}");
    let retry = "{ connect: { retry: { period_init_ms: 200, period_max_ms: 200 } } }";
    let file = folder.join("zenoh.json5");
    fs::write(&file, retry).unwrap();
    let text = format!(
        "[fleet]\nsite = \"hall\"\nrouter = \"{router}\"\nnetwork = \"zenoh.json5\"\nspool = \"spool\"\n"
    );
    fs::write(folder.join("gripd.toml"), text).unwrap();
    (router.clone(), Network { router: Some(router), file: Some(file) })
}

/// Slips as they came: the number of each event and that of the slip in it.
fn slips(watch: &mut Watch, into: &mut Vec<(EventId, u32)>) {
    while let Some(told) = watch.next(LOOK).unwrap() {
        let Told::Event { id, message, missing, .. } = told else { continue };
        assert_eq!(missing, 0, "{id}");
        if let Ok(ToClient::Slip(slip)) = message.read() {
            into.push((id, slip.number));
        }
    }
}

/// Lines about slips that were printed.
fn printed(running: &Running) -> usize {
    running.printed().lines().filter(|line| line.contains("\"type\":\"slip")).count()
}

#[test]
fn every_slip_is_told_once_though_router_and_daemon_end() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, network) = place(folder.path());
    let router = net::router(&endpoint).unwrap();
    let first = Running::holding(folder.path(), &[]);
    first.wait_for("this gripper is there as hall/");
    let session = network.open().unwrap();
    let mut watch = Watch::new(session, &Selector::default(), Since::Start, &[]).unwrap();
    let mut got = Vec::new();
    assert!(until(|| {
        slips(&mut watch, &mut got);
        got.len() >= printed(&first)
    }));
    drop(router);
    let before = printed(&first);
    // Killed without a goodbye.
    drop(first);
    let _router = net::router(&endpoint).unwrap();
    let second = Running::holding(folder.path(), &[]);
    let told = || second.told();
    assert!(
        until(|| {
            slips(&mut watch, &mut got);
            got.len() >= before + printed(&second)
        }),
        "{}",
        told()
    );
    second.stop();
    let ids: HashSet<EventId> = got.iter().map(|(id, _)| *id).collect();
    assert_eq!(ids.len(), got.len(), "one came twice");
    for numbers in got.chunk_by(|a, b| a.0.run == b.0.run) {
        let numbers: Vec<u32> = numbers.iter().map(|(_, number)| *number).collect();
        let wanted: Vec<u32> = (1..).take(numbers.len()).collect();
        assert_eq!(numbers, wanted);
    }
}
