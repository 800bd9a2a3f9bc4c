//! A service manager that waits for signs of life, also while there is no gripper.

use crate::running::command;
use core::time::Duration;
use rustix::process::{Pid, Signal, kill_process};
use std::{os::unix::net::UnixDatagram, process::Stdio};

#[test]
fn signs_of_life_come_without_a_port_too() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("notify");
    let socket = UnixDatagram::bind(&place).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let mut child = command(folder.path(), &["--port", "./none", "--listen", "off"])
        .env("NOTIFY_SOCKET", &place)
        .env("WATCHDOG_USEC", "500000")
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let next = || {
        let mut text = [0; 256];
        let count = socket.recv(&mut text).unwrap();
        String::from_utf8_lossy(&text[..count]).into_owned()
    };
    assert!(next().starts_with("READY=1"));
    for _ in 0..4 {
        assert!(next().starts_with("WATCHDOG=1"));
    }
    let pid = Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
    kill_process(pid, Signal::TERM).unwrap();
    while !next().starts_with("STOPPING=1") {}
    assert!(child.wait().unwrap().code().is_some());
}
