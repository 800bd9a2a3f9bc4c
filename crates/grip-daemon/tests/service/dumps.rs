//! Files that a fault leaves behind.

use crate::made;
use grip_daemon::{
    Item, LinkNote,
    dump::{Cause, Dumped, FlightRecorder, folder},
    log::Clocks,
};
use grip_link::{
    host::CloseReason,
    message::{EventKind, FaultCode},
};
use slip_core::PipelineState;
use slip_core::grip::GripState;
use std::{ffi::OsStr, fs, path::Path};

const WALL_US: u64 = 1_795_301_948_125_000;

fn at(host_us: u64) -> Clocks {
    Clocks { host_us, wall_us: WALL_US + host_us }
}

#[test]
fn causes_are_seen_once() {
    let mut recorder = FlightRecorder::new(None);
    let mut link = |note: LinkNote| recorder.take(&Item::Link { host_us: 1, note: &note });
    assert_eq!(link(LinkNote::Closed(CloseReason::Requested)), None);
    assert_eq!(link(LinkNote::PortLost), None);
    let lost = CloseReason::Lost { silent_us: 5 };
    assert_eq!(link(LinkNote::Closed(lost)), Some(Cause::LinkClosed(lost)));
    let fault = made::device_event(EventKind::Fault, FaultCode::DRIVE);
    assert_eq!(link(fault), Some(Cause::GripperFault(FaultCode::DRIVE)));
    assert_eq!(link(made::device_event(EventKind::FaultCleared, FaultCode::DRIVE)), None);
    let mut state = |grip| {
        let state = PipelineState { grip, ..made::STATE };
        recorder.take(&Item::State(&state))
    };
    assert_eq!(state(GripState::Holding), None);
    assert_eq!(state(GripState::Fault), Some(Cause::ControllerFault));
    assert_eq!(state(GripState::Fault), None, "still the same one");
    assert_eq!(state(GripState::Holding), None);
    assert_eq!(state(GripState::Fault), Some(Cause::ControllerFault));
}

#[test]
fn a_file_reports_cause_state_and_frames_in_the_order_of_time() {
    let home = tempfile::tempdir().unwrap();
    let dumps = home.path().join("state/gripd");
    let mut recorder = FlightRecorder::new(Some(dumps.clone()));
    for n in 0..150_u64 {
        let bytes = [0, 2, 9, 0];
        recorder.take(&Item::Wire { host_us: 10 * n, to_device: n % 3 == 0, bytes: &bytes });
    }
    let cause = Cause::LinkClosed(CloseReason::Lost { silent_us: 500_000 });
    let written = recorder.write(&cause, &made::board(), at(2_000_000)).unwrap();
    let file = dumps.join("gripd-20261121T225910Z-link_closed-1.txt");
    assert_eq!(written, Dumped::File(file.clone()));
    let text = fs::read_to_string(&file).unwrap();
    let head = "gripd 1.2.3: dump of 2026-11-21T22:59:10.125Z, 2.000000 s after the start\n\
                cause: the link closed: the gripper fell silent (500 ms without a frame)\n";
    assert!(text.starts_with(head), "{text}");
    assert!(text.contains("\"uid\": \"abababab"), "{text}");
    let frames: Vec<&str> = text.lines().filter(|line| line.contains("no frame")).collect();
    assert_eq!(frames.len(), 150, "100 from the gripper, 50 to it");
    assert!(frames.is_sorted_by_key(|line| line[..14].trim().parse::<f64>().unwrap().to_bits()));
    assert!(frames[0].contains("0.000000 -> no frame: body of 1 bytes"), "{}", frames[0]);
}

#[test]
fn files_are_rare_and_what_was_left_out_is_counted() {
    let home = tempfile::tempdir().unwrap();
    let mut recorder = FlightRecorder::new(Some(home.path().to_owned()));
    let board = made::board();
    let mut write = |host_us| recorder.write(&Cause::ControllerFault, &board, at(host_us)).unwrap();
    assert!(matches!(write(0), Dumped::File(_)));
    assert_eq!(write(1), Dumped::TooMany);
    assert_eq!(write(9_999_999), Dumped::TooMany);
    let Dumped::File(second) = write(10_000_000) else { panic!() };
    let text = fs::read_to_string(second).unwrap();
    assert!(text.contains("2 causes since the last dump were not written down"), "{text}");
    let files = (2..200).filter(|n| matches!(write(n * 10_000_000), Dumped::File(_))).count();
    assert_eq!(files, 48, "50 in a run");
}

#[test]
fn a_folder_that_cannot_be_is_reported_and_none_is_reported_too() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("file");
    fs::write(&file, "").unwrap();
    let mut recorder = FlightRecorder::new(Some(file.clone()));
    let reported = recorder.write(&Cause::Asked, &made::board(), at(0)).unwrap_err().to_string();
    assert!(
        reported.starts_with(&format!("the dump cannot be written into {}: ", file.display())),
        "{reported}"
    );
    let mut none = FlightRecorder::new(None);
    assert_eq!(none.write(&Cause::Asked, &made::board(), at(0)).unwrap(), Dumped::NoFolder);
    let (set, states) = (Some(Path::new("/a")), Some(OsStr::new("/b:/c")));
    assert_eq!(folder(set, states).as_deref(), set);
    assert_eq!(folder(None, states).as_deref(), Some(Path::new("/b")));
    assert_eq!(folder(None, Some(OsStr::new(""))), None);
}
