//! Tests with rows of another program: slips, commands and a summary, on standard output and back to the program.

use crate::{
    recording::replays,
    running::{command, gripd},
};
use core::{fmt::Write as _, time::Duration};
use serde_json::Value;
use std::{
    io::{BufRead as _, BufReader, Read, Write},
    net::{Shutdown, TcpStream, UdpSocket},
    os::unix::net::UnixStream,
    path::Path,
    thread,
    time::Instant,
};
use stories::{Ended, Program, until};

const RATE: u32 = 1600;

/// A number from -1 to 1.
fn noise(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f32::from(u16::try_from(*state >> 16).unwrap()) / 32_768.0 - 1.0
}

/// Two seconds of an accelerometer (g), ten times as loud from 1.5 s to 1.6 s.
fn vibration() -> Vec<f32> {
    let mut seed = 1;
    (0..2 * RATE)
        .map(|row| noise(&mut seed) * if (2400..2560).contains(&row) { 0.1 } else { 0.01 })
        .collect()
}

fn csv() -> String {
    let mut text = format!("t_s,vibration,rate={RATE}\n");
    for (row, value) in (0_u32..).zip(vibration()) {
        writeln!(text, "{:.6},{value}", f64::from(row) / f64::from(RATE)).unwrap();
    }
    text
}

/// gripd with `input` on standard input, run to its end.
fn piped(folder: &Path, args: &[&str], input: impl Into<Vec<u8>>) -> Ended {
    let args = [&["--listen", "off"], args].concat();
    Program::fed(command(folder, &args), input.into()).ended()
}

/// A slip in the loud part, and all rows counted.
#[track_caller]
fn slipped(lines: &[Value]) {
    let slip = lines.iter().find(|line| line["type"] == "slip");
    let t_s = slip.and_then(|slip| slip["t_s"].as_f64()).unwrap();
    assert!((1.5..1.6).contains(&t_s), "{t_s}");
    let summary = lines.last().unwrap();
    assert_eq!(summary["type"], "summary", "{summary}");
    assert_eq!(summary["rows"]["taken"], 2 * RATE, "{summary}");
}

#[test]
fn standard_input_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["--sensor", "rows:-", "--json", "--record", "run.mcap"];
    let ran = piped(folder.path(), &args, csv()).done();
    replays(folder.path(), &ran);
    slipped(&ran.lines());
    let summary = ran.lines().pop().unwrap();
    assert_eq!(
        (summary["commands"].clone(), summary["samples"].clone()),
        (0.into(), (2 * RATE).into())
    );
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(ran.err.contains("only observing") && ran.err.contains("run in real time"), "{ran:?}");
    assert!(!ran.err.contains("late or missing"), "{}", ran.err);
}

/// A loop that sends what it has each 15 ms is later than a board may be, and loses nothing; rows that are left out are named.
#[test]
fn what_a_sender_loses_is_named_and_its_jitter_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let whole = csv();
    let kept = whole.split_inclusive('\n').enumerate();
    let kept = kept.filter(|(line, _)| !(1601..1761).contains(line)).map(|(_, line)| line);
    for (rows, missing) in [(whole.clone(), 0), (kept.collect(), 160)] {
        let address = format!("127.0.0.1:{}", free_port());
        let served = served(folder.path(), &["--sensor", &format!("rows:tcp:{address}")]);
        let mut stream = connected(|| TcpStream::connect(&address));
        in_real_time(&mut stream, &rows, 24);
        stream.shutdown(Shutdown::Write).unwrap();
        json_lines(stream);
        let ran = served.ended();
        assert_eq!(ran.lines().pop().unwrap()["rows"]["missing"], missing, "{ran:?}");
        let named = ran.err.contains("160 rows are missing before row");
        assert_eq!(
            (named, ran.err.contains("late or missing")),
            (missing > 0, false),
            "{}",
            ran.err
        );
    }
}

/// Without a stylus: held with 5 N, and moved or pressed otherwise from 2 s on. What such a session cannot do is stated at its start, and
/// its recording replays to the same lines.
#[test]
fn a_travel_or_taxels_alone_show_a_slip_and_move_nothing() {
    const ROWS: u32 = 500;
    let mut seed = 1;
    let mut travel = format!("t_s,force_n,travel_mm,rate={ROWS}\n");
    let mut taxels =
        format!("t_s,force_n,pressure_0,pressure_1,pressure_2,pressure_3,rate={ROWS}\n");
    for row in 0..3 * ROWS {
        let t_s = f64::from(row) / f64::from(ROWS);
        let (force_n, slid_s) = ((20.0 * t_s).min(5.0), (t_s - 2.0).clamp(0.0, 0.2));
        let moved_mm = 20.0 * slid_s + 0.002 * f64::from(noise(&mut seed));
        writeln!(travel, "{t_s:.6},{force_n:.3},{moved_mm:.5}").unwrap();
        write!(taxels, "{t_s:.6},{force_n:.3}").unwrap();
        for side in [1.0, -1.0, 0.5, -0.5] {
            let share = 100.0 * force_n + 1500.0 * side * slid_s + f64::from(noise(&mut seed));
            write!(taxels, ",{share:.3}").unwrap();
        }
        taxels.push('\n');
    }
    for (text, port) in [(travel, "--port"), (taxels, "--sensor")] {
        let folder = tempfile::tempdir().unwrap();
        let ran = piped(folder.path(), &[port, "rows:-", "--json", "--record", "run.mcap"], text);
        replays(folder.path(), &ran);
        let lines = ran.lines();
        let slips = lines.iter().filter(|line| line["type"] == "slip");
        let times: Vec<f64> = slips.filter_map(|slip| slip["t_s"].as_f64()).collect();
        let expected = times.first().is_some_and(|t_s| (2.0..2.2).contains(t_s));
        assert!(expected, "{times:?} {}", ran.err);
        assert!(
            ran.err.contains("no stylus") && ran.err.contains("nothing is commanded"),
            "{ran:?}"
        );
        let summary = lines.last().unwrap();
        assert_eq!((&summary["commands"], &summary["rows"]["bad"]), (&0.into(), &0.into()));
    }
}

/// A machine that starts after the floor was learned is no slip that a gripper could stop.
#[test]
fn an_alarm_with_the_level_of_a_machine_is_named_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = format!("t_s,vibration,rate={RATE}\n");
    let mut seed = 1;
    for row in 0..5 * RATE {
        let level = if row < 3 * RATE / 2 { 0.01 } else { 0.1 };
        writeln!(text, "{:.6},{}", f64::from(row) / f64::from(RATE), level * noise(&mut seed))
            .unwrap();
    }
    let args = ["--sensor", "rows:-", "--json", "--record", "run.mcap"];
    let ran = piped(folder.path(), &args, text).done();
    replays(folder.path(), &ran);
    assert_eq!(ran.err.matches("steady for 2 s: is this the machine?").count(), 1, "{}", ran.err);
    let ran = piped(folder.path(), &["--sensor", "rows:-", "--json"], csv()).done();
    assert!(!ran.err.contains("steady for"), "{}", ran.err);
}

#[test]
fn a_csv_of_a_vibration_has_its_column() {
    let folder = tempfile::tempdir().unwrap();
    let ran = piped(folder.path(), &["--sensor", "rows:-", "--json", "--record", "run.csv"], csv());
    slipped(&ran.done().lines());
    let recorded = std::fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let columns: Vec<&str> = recorded.lines().next().unwrap().split(',').collect();
    assert!(columns.contains(&"vibration") && !columns.contains(&"stylus"), "{columns:?}");
}

#[test]
fn what_is_wrong_with_rows_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |input: &str, words: &[&str]| {
        piped(folder.path(), &["--sensor", "rows:-"], input).refused(1, words)
    };
    refused("", &["rows from standard input: the input ended before its first row"]);
    refused("vibration\n1\n", &["the rate is missing", "vibration,rate=1600"]);
    refused("0.1,0.2\n", &["`0.1` is no column", "vibration"]);
    refused("vibration,rate=1600\n1;2\n", &["row 1: `1;2` is no number (vibration)"]);
    refused("vibration,rate=1600\n1,2\n", &["row 1: 2 values, the header names 1 column"]);
    let bad = csv().replace("\n0.500000,", "\n0.500000,x");
    let ran = piped(folder.path(), &["--sensor", "rows:-", "--json"], bad);
    let summary = ran.lines().pop().unwrap();
    assert!(ran.err.contains("row 801: `x"), "{}", ran.err);
    assert_eq!((ran.code, summary["rows"]["bad"].clone()), (3, 1.into()), "data is lost: {ran:?}");
}

#[test]
fn ends_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |args: &[&str], words: &[&str]| gripd(folder.path(), args).refused(2, words);
    refused(&["--sensor", "rows:7750"], &["`rows:7750` is no source of rows", "rows:tcp:IP:PORT"]);
    refused(&["--sensor", "sim", "--port", "sim"], &["--sensor", "--port"]);
    refused(
        &["--sensor", "sim", "--gripper", "/dev/x"],
        &["simulated sensor", "leave --gripper out"],
    );
    refused(&["--sensor", "sim", "--gripper", "rows"], &["only rows have a way back"]);
    refused(&["--port", "rows:-"], &["--json", "--gripper none"]);
    refused(&["--sensor", "rows:udp:0.0.0.0:7750"], &["allow_remote"]);
}

/// With `--gripper none` the simulated gripper is never commanded, and no command is computed.
#[test]
fn an_observer_commands_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for ends in [&["--port", "sim", "--gripper", "none"][..], &["--sensor", "sim"]] {
        let ran = gripd(folder.path(), &[ends, &["--duration", "1.2", "--json"]].concat()).done();
        let summary = ran.lines().pop().unwrap();
        assert_eq!(summary["commands"], 0, "{summary}");
        assert_eq!(summary["command_n"], Value::Null, "{summary}");
    }
}

/// gripd at `ends`, until it is over.
fn served(folder: &Path, ends: &[&str]) -> Program {
    Program::of(command(folder, &[ends, &["--listen", "off", "--json"]].concat()))
}

/// Tries until somebody listens.
fn connected<S>(connect: impl Fn() -> std::io::Result<S>) -> S {
    let mut stream = None;
    let listens = until(|| {
        stream = connect().ok();
        stream.is_some()
    });
    assert!(listens, "nobody listens");
    stream.unwrap()
}

fn free_port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

fn json_lines(from: impl Read) -> Vec<Value> {
    BufReader::new(from).lines().map(|line| serde_json::from_str(&line.unwrap()).unwrap()).collect()
}

/// So many rows at once.
#[expect(clippy::disallowed_methods, reason = "a test may send at times of its own")]
fn in_real_time(stream: &mut TcpStream, rows: &str, at_once: u32) {
    let (start, period) = (Instant::now(), at_once * Duration::from_secs(1) / RATE);
    let lines: Vec<&str> = rows.split_inclusive('\n').collect();
    for (sent, lines) in (0_u32..).zip(lines.chunks(at_once as usize)) {
        thread::sleep((start + sent * period).duration_since(Instant::now()));
        stream.write_all(lines.concat().as_bytes()).unwrap();
    }
}

#[test]
fn a_program_that_connects_gets_events_and_commands_back() {
    let folder = tempfile::tempdir().unwrap();
    let address = format!("127.0.0.1:{}", free_port());
    let served = served(folder.path(), &["--port", &format!("rows:tcp:{address}")]);
    let mut stream = connected(|| TcpStream::connect(&address));
    // With a gripper no row waits.
    in_real_time(&mut stream, &csv(), 8);
    stream.shutdown(Shutdown::Write).unwrap();
    let back = json_lines(stream);
    let ran = served.ended();
    slipped(&back);
    let forces: Vec<f64> = back
        .iter()
        .filter(|line| line["type"] == "command" && line["mode"] == "force")
        .map(|line| line["force_n"].as_f64().unwrap())
        .collect();
    assert!(forces.iter().any(|force_n| *force_n > 1.0), "{forces:?}");
    assert!(!ran.out.contains("\"command\","), "standard output has the events: {}", ran.out);
    slipped(&ran.lines());
}

#[test]
fn a_connection_that_breaks_is_reported_and_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let address = format!("127.0.0.1:{}", free_port());
    let served = served(folder.path(), &["--port", &format!("rows:tcp:{address}")]);
    let mut stream = connected(|| TcpStream::connect(&address));
    stream.write_all(b"vibration,rate=1600\n0.5\n").unwrap();
    // A command comes back once the row is there; then the connection is reset.
    stream.read_exact(&mut [0; 8]).unwrap();
    rustix::net::sockopt::set_socket_linger(&stream, Some(Duration::ZERO)).unwrap();
    drop(stream);
    let ran = served.ended().done();
    assert!(ran.err.contains("the connection broke, and its last rows may be missing"), "{ran:?}");
    assert_eq!(ran.lines().pop().unwrap()["rows"]["taken"], 1, "{ran:?}");
}

#[test]
fn a_socket_file_is_an_address_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rows.sock");
    let served = served(folder.path(), &["--sensor", &format!("rows:unix:{}", path.display())]);
    let mut stream = connected(|| UnixStream::connect(&path));
    let mut bytes = format!("vibration,rate={RATE},format=f32\n").into_bytes();
    bytes.extend(vibration().into_iter().flat_map(f32::to_le_bytes));
    stream.write_all(&bytes).unwrap();
    stream.shutdown(Shutdown::Write).unwrap();
    slipped(&json_lines(stream));
    let ran = served.ended();
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(!path.exists());
}

/// A second gripd, a scan and a browser connect before the program does; a gripper may hold meanwhile.
#[test]
fn what_sends_no_header_is_no_source() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rows.sock");
    let sensor = format!("rows:unix:{}", path.display());
    let served = served(folder.path(), &["--sensor", &sensor]);
    drop(connected(|| UnixStream::connect(&path)));
    let second = gripd(folder.path(), &["--sensor", &sensor, "--listen", "off"]);
    second.refused(1, &["another program listens there"]);
    for probe in
        ["GET / HTTP/1.1\r\nHost: x\r\n\r\n", "\x16\x03\x01\0", "\x1b[2J\n", &"x".repeat(5000)]
    {
        let mut stream = connected(|| UnixStream::connect(&path));
        // It may be gone already.
        let _refused = stream.write_all(probe.as_bytes());
    }
    let mut stream = connected(|| UnixStream::connect(&path));
    stream.write_all(csv().as_bytes()).unwrap();
    stream.shutdown(Shutdown::Write).unwrap();
    let ran = served.ended();
    slipped(&ran.lines());
    assert!(ran.err.contains("no header of rows, waiting for the next: nothing came"), "{ran:?}");
    assert!(ran.err.contains("`GET / HTTP/1.1` is no column"), "{ran:?}");
    assert!(ran.err.contains("\\u001b[2J") && !ran.err.contains('\x1b'), "{ran:?}");
    assert_eq!(ran.code, 0, "{ran:?}");
}

#[test]
fn datagrams_of_any_size_come_whole_and_foreign_ones_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let address = format!("127.0.0.1:{}", free_port());
    let served = served(folder.path(), &["--sensor", &format!("rows:udp:{address}")]);
    let [foreign, socket] = [0, 1].map(|_| {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(&address).unwrap();
        socket
    });
    connected(|| foreign.send(b"hello\n").and_then(|_| foreign.send(b"hello\n")));
    foreign.send(&[]).unwrap();
    let text = csv();
    let (header, rows) = text.split_once('\n').unwrap();
    socket.send(header.as_bytes()).unwrap();
    // With the header the system refuses what others send, which would take the place of rows.
    assert!(until(|| foreign.send(&[]).is_err()), "another program fills the queue");
    let half = rows[..rows.len() / 2].rfind('\n').unwrap();
    for part in [&rows[..half], &rows[half..]] {
        assert!(part.len() > 32_000 && part.len() < 65_000, "{}", part.len());
        socket.send(part.as_bytes()).unwrap();
    }
    socket.send(&[]).unwrap();
    let ran = served.ended();
    slipped(&ran.lines());
    assert!(ran.err.contains("`hello` is no column"), "{ran:?}");
}

#[test]
fn a_lost_datagram_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let address = format!("127.0.0.1:{}", free_port());
    let served = served(folder.path(), &["--sensor", &format!("rows:udp:{address}")]);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(&address).unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    let header = format!("vibration,rate={RATE},format=f32");
    // Until gripd is there, a datagram finds nobody; the header may come again.
    connected(|| socket.send(header.as_bytes()).and_then(|_| socket.send(header.as_bytes())));
    let (mut back, mut line) = (String::new(), [0; 4096]);
    let mut listen = |back: &mut String| {
        if let Ok(count) = socket.recv(&mut line) {
            back.push_str(str::from_utf8(&line[..count]).unwrap());
        }
    };
    for (number, rows) in (0_u32..).step_by(16).zip(vibration().chunks(16)) {
        if number == 1600 {
            continue;
        }
        let mut bytes = number.to_le_bytes().to_vec();
        bytes.extend(rows.iter().copied().flat_map(f32::to_le_bytes));
        while socket.send(&bytes).is_err() {}
        listen(&mut back);
    }
    socket.send(&[]).unwrap();
    let ran = served.ended();
    (0..50).for_each(|_| listen(&mut back));
    let summary = ran.lines().pop().unwrap();
    assert_eq!((ran.code, summary["rows"]["missing"].clone()), (3, 16.into()), "{ran:?}");
    assert!(back.contains("\"type\":\"slip\""), "{back}");
}
