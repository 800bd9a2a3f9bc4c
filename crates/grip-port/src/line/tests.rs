use super::{Kept, Line, LineCounters, Written, least_interval_us, nonce};
use crate::PortError;
use core::time::Duration;
use std::{
    io::{Read as _, Write as _},
    os::{fd::OwnedFd, unix::net::UnixStream},
};

const AT_ONCE: Duration = Duration::ZERO;
const PATIENCE: Duration = Duration::from_secs(20);

fn pair() -> (Line, UnixStream) {
    let (ours, theirs) = UnixStream::pair().unwrap();
    (Line::from_fd(OwnedFd::from(ours)).unwrap(), theirs)
}

/// A frame of one byte value, distinguished from others by it.
fn frame(value: u8) -> [u8; 200] {
    [value; 200]
}

/// Fills the line until it takes no more; gives the number of whole frames, and whether one was begun.
fn fill(line: &mut Line, value: u8) -> (usize, bool) {
    let mut whole = 0;
    loop {
        match line.write_frame(&frame(value)).unwrap() {
            Written::Whole => whole += 1,
            Written::Begun => return (whole, true),
            Written::Refused => return (whole, false),
            Written::Waiting => panic!("no command"),
        }
    }
}

/// Reads `count` bytes at the other end while the line goes on with what it keeps.
fn drain(line: &mut Line, theirs: &mut UnixStream, count: usize) -> Vec<u8> {
    let mut got = vec![0; count];
    theirs.set_nonblocking(true).unwrap();
    let mut have = 0;
    while have < count {
        match theirs.read(&mut got[have..]) {
            Ok(0) => panic!("closed after {have} bytes"),
            Ok(more) => have += more,
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {
                assert_eq!(line.read(&mut [0; 16], PATIENCE).unwrap(), 0);
            }
            Err(error) => panic!("{error}"),
        }
    }
    got
}

#[test]
fn bytes_pass_both_ways_and_an_empty_line_waits_no_longer_than_reported() {
    let (mut line, mut theirs) = pair();
    let mut input = [0; 16];
    assert_eq!(line.read(&mut input, AT_ONCE).unwrap(), 0);
    assert_eq!(line.read(&mut input, Duration::from_micros(1500)).unwrap(), 0);
    theirs.write_all(b"abc").unwrap();
    assert_eq!(line.read(&mut input, PATIENCE).unwrap(), 3);
    assert_eq!(&input[..3], b"abc");
    assert_eq!(line.write_frame(b"xyz").unwrap(), Written::Whole);
    assert_eq!(drain(&mut line, &mut theirs, 3), b"xyz");
    assert_eq!(line.read(&mut [], AT_ONCE).unwrap(), 0, "no room is not the end of the line");
    assert_eq!(line.counters(), LineCounters::default());
}

#[test]
fn a_full_line_refuses_frames_and_keeps_the_newest_command() {
    let (mut line, mut theirs) = pair();
    let (whole, begun) = fill(&mut line, 1);
    let before = line.counters();
    assert_eq!(line.write_frame(&frame(2)).unwrap(), Written::Refused);
    assert_eq!(line.counters().refused, before.refused + 1);
    for value in 3..=5 {
        assert_eq!(line.write_command(&frame(value)).unwrap(), Written::Waiting);
    }
    assert_eq!(line.counters().replaced, 2);
    // What waits goes first, so a frame is still refused.
    assert_eq!(line.write_frame(&frame(6)).unwrap(), Written::Refused);
    let frames = whole + usize::from(begun) + 1;
    let got = drain(&mut line, &mut theirs, 200 * frames);
    assert!(line.is_clear());
    for (at, taken) in got.chunks(200).enumerate() {
        let expected = if at + 1 == frames { 5 } else { 1 };
        assert!(taken.iter().all(|byte| *byte == expected), "frame {at}: {taken:?}");
    }
    assert_eq!(theirs.read(&mut [0; 8]).unwrap_err().kind(), std::io::ErrorKind::WouldBlock);
}

#[test]
fn a_frame_that_was_begun_is_finished_before_anything_else() {
    let (mut line, mut theirs) = pair();
    line.rest.keep(&frame(7));
    assert!(!line.is_clear());
    assert_eq!(line.write_command(&frame(8)).unwrap(), Written::Whole);
    line.rest.keep(&frame(9));
    line.waiting.keep(&frame(10));
    assert_eq!(line.read(&mut [0; 4], PATIENCE).unwrap(), 0);
    let got = drain(&mut line, &mut theirs, 800);
    let order: Vec<u8> = got.chunks(200).map(|frame| frame[199]).collect();
    assert_eq!(order, [7, 8, 9, 10]);
}

#[test]
fn no_frame_of_the_protocol_is_longer_than_what_can_be_kept() {
    let (mut line, _theirs) = pair();
    let long = [1; 4096];
    assert_eq!(line.write_frame(&long).unwrap(), Written::Refused);
    assert_eq!(line.write_command(&long).unwrap(), Written::Refused);
    assert_eq!(line.counters().refused, 2);
    let mut kept = Kept::EMPTY;
    kept.keep(&long);
    assert!(kept.bytes().len() < long.len());
}

#[test]
fn the_other_end_is_gone() {
    let (mut line, mut theirs) = pair();
    theirs.write_all(b"last").unwrap();
    drop(theirs);
    let mut input = [0; 16];
    assert_eq!(line.read(&mut input, PATIENCE).unwrap(), 4, "what came before is not lost");
    assert!(matches!(line.read(&mut input, PATIENCE), Err(PortError::Closed)));
    assert!(matches!(line.write_frame(b"x"), Err(PortError::Closed)));
    assert!(matches!(line.write_command(b"x"), Err(PortError::Closed)));
}

#[test]
fn reading_and_writing_allocate_nothing() {
    let (mut line, mut theirs) = pair();
    theirs.write_all(&[1; 64]).unwrap();
    let counted = allocation_counter::measure(|| {
        for value in 0..20 {
            line.write_frame(&frame(value)).unwrap();
            line.write_command(&frame(value)).unwrap();
        }
        fill(&mut line, 3);
        line.write_command(&frame(4)).unwrap();
        line.read(&mut [0; 64], AT_ONCE).unwrap();
        line.read(&mut [0; 64], AT_ONCE).unwrap();
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn commands_leave_half_of_a_slow_line_free() {
    // 30 bytes of ten bits at 115,200 bit/s take 2.6 ms.
    assert_eq!(least_interval_us(115_200, 30), 5209);
    assert_eq!(least_interval_us(2_000_000, 30), 300);
    assert_eq!(least_interval_us(0, 30), 600_000_000);
    let (line, _theirs) = pair();
    assert_eq!(line.least_interval_us(30), 0, "a socket has no baud rate");
}

#[test]
fn a_nonce_is_never_zero() {
    assert!((0..2000).all(|_| nonce() != 0));
}
