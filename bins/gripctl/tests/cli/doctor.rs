//! `gripctl doctor`: what it finds on this machine, at a simulated gripper, and at ports that are none.

use crate::run::{Ran, gripctl, noise, normal, put, read, wav};
use core::sync::atomic::{AtomicBool, Ordering};
use grip_sim::Pty;
use serde_json::Value;
use std::{fs, os::unix::fs::symlink, thread};
use tempfile::TempDir;

/// The findings of a run, by the name of what was looked at.
fn finding<'a>(lines: &'a [Value], check: &str) -> &'a Value {
    let found = lines.iter().find(|line| line["check"] == check);
    found.unwrap_or_else(|| panic!("no {check} in {lines:?}"))
}

/// Every finding is whole, and the last line counts them.
fn checked(ran: &Ran) -> Vec<Value> {
    let mut lines = ran.json();
    let total = lines.pop().unwrap();
    assert_eq!(total["type"], "doctor");
    for (verdict, count) in [("ok", "ok"), ("warning", "warnings"), ("fault", "faults")] {
        let found = lines.iter().filter(|line| line["verdict"] == verdict).count();
        assert_eq!(total[count].as_u64().unwrap(), found as u64, "{verdict} in {lines:?}");
    }
    for line in &lines {
        let good = line["verdict"] == "ok";
        assert_eq!(line["remedy"].is_null(), good, "a remedy exactly where it is needed: {line}");
    }
    assert_eq!(ran.code == 0, total["faults"] == 0, "{ran:?}");
    lines
}

fn doctor(folder: &TempDir, args: &str) -> Ran {
    gripctl(folder, format!("doctor --json --folder . {args}"))
}

#[test]
fn a_simulated_gripper_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "c.toml", "[link]\nsample_rate_hz = 2000\n");
    let ran = doctor(&folder, "sim --seconds 1 --config c.toml");
    let lines = checked(&ran);
    for check in ["configuration", "real time", "kernel", "processors", "disk", "daemon"] {
        finding(&lines, check);
    }
    let text = |check: &str| finding(&lines, check)["text"].as_str().unwrap().to_owned();
    assert!(text("gripper").contains("firmware"), "{}", text("gripper"));
    assert!(text("sample rate").contains("2000 Hz in force, 2000 Hz configured"));
    assert!(text("gaps").contains("longest pause"));
    assert!(text("frames").contains(" 0 damaged"), "{}", text("frames"));
    assert!(text("clock").contains("round trip"), "{}", text("clock"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
}

#[test]
fn ports_that_are_no_gripper_are_faults_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let lines = checked(&doctor(&folder, "./none"));
    assert_eq!(finding(&lines, "port")["verdict"], "fault");
    put(&folder, "file", "kept");
    let lines = checked(&doctor(&folder, "./file"));
    assert!(finding(&lines, "port")["text"].as_str().unwrap().contains("no serial port"));
    assert_eq!(read(&folder, "file"), "kept");
    let lines = checked(&doctor(&folder, "/dev/null"));
    assert!(finding(&lines, "port")["text"].as_str().unwrap().contains("no serial port"));
    // Nobody answers on this one; then another program takes it.
    let pty = Pty::open(None).unwrap();
    symlink(pty.port(), folder.path().join("silent")).unwrap();
    let lines = checked(&doctor(&folder, "./silent"));
    let gripper = finding(&lines, "gripper");
    assert!(gripper["text"].as_str().unwrap().contains("no gripper answered"), "{gripper}");
    let held = serialport::new(pty.port().to_str().unwrap(), 115_200).open().unwrap();
    let lines = checked(&doctor(&folder, "./silent"));
    assert!(finding(&lines, "gripper")["text"].as_str().unwrap().contains("busy"));
    let own = format!("process {}", std::process::id());
    let holder = finding(&lines, "held by");
    assert!(holder["text"].as_str().unwrap().contains(&own), "{holder}");
    drop(held);
}

#[test]
fn a_configuration_that_is_wrong_is_a_fault() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "bad.toml", "[grip]\nf_max_n = -3\n");
    let lines = checked(&doctor(&folder, "./none --config bad.toml"));
    let found = finding(&lines, "configuration");
    assert_eq!(found["verdict"], "fault");
    assert!(found["text"].as_str().unwrap().contains("bad.toml:2:1"), "{found}");
}

/// A recording of a vibration at `rate_hz`: rounded noise of the deviation `level(t_s)` (counts).
fn sensor(rate_hz: u32, seconds: u32, level: impl Fn(f64) -> f64) -> String {
    let mut rows = "t_s,vibration\n".to_owned();
    let mut noise = normal(5);
    for i in 0..rate_hz * seconds {
        let t_s = f64::from(i) / f64::from(rate_hz);
        rows += &format!("{t_s:.6},{}\n", (level(t_s) * noise()).round());
    }
    rows
}

#[test]
fn a_sensor_is_judged_by_a_recording_at_rest() {
    let folder = tempfile::tempdir().unwrap();
    let judge = |rows: &str| {
        put(&folder, "s.csv", rows);
        checked(&gripctl(&folder, "doctor --json --sensor s.csv"))
    };
    let verdicts = |lines: &[Value]| -> Vec<String> {
        let bad = lines.iter().filter(|line| line["verdict"] != "ok");
        bad.map(|line| format!("{} {}", line["verdict"], line["check"])).collect()
    };
    let good = judge(&sensor(10_000, 3, |_| 6.0));
    assert!(verdicts(&good).is_empty(), "{good:?}");
    // White noise of 6 counts over 5 kHz: 300 Hz of it have 1.5.
    let text = finding(&good, "sensor floor")["text"].as_str().unwrap();
    let number = |after: &str| -> f64 {
        let rest = text.split_once(after).unwrap().1;
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let smallest = number("found from ");
    assert!((1.0..10.0).contains(&smallest), "{text}");

    // One wrong reading every 0.1 s, 30 deviations away.
    let spoil = |(i, line): (usize, &str)| match line.split_once(',') {
        Some((t, _)) if i % 1000 == 999 => format!("{t},180\n"),
        _ => format!("{line}\n"),
    };
    let outliers =
        judge(&sensor(10_000, 3, |_| 6.0).lines().enumerate().map(spoil).collect::<String>());
    assert_eq!(verdicts(&outliers), ["\"warning\" \"sensor outliers\""], "{outliers:?}");
    let text = finding(&outliers, "sensor outliers")["text"].as_str().unwrap();
    assert!(text.starts_with("30 isolated readings (0.1000 %)"), "{text}");
    let clean = finding(&good, "sensor outliers")["text"].as_str().unwrap();
    assert!(clean.starts_with("0 isolated readings"), "{clean}");

    let coarse = judge(&sensor(10_000, 3, |_| 0.2));
    assert_eq!(verdicts(&coarse), ["\"warning\" \"sensor steps\""], "{coarse:?}");
    let slow = judge(&sensor(40, 60, |_| 6.0));
    assert_eq!(verdicts(&slow), ["\"warning\" \"sensor rate\""], "{slow:?}");
    let rate = |lines: &[Value]| finding(lines, "sensor rate")["text"].as_str().unwrap().to_owned();
    assert!(rate(&slow).contains("none lies above the motion"), "{slow:?}");
    // At 200 Hz the shear band is whole, and octaves are missing.
    let slower = judge(&sensor(200, 20, |_| 6.0));
    assert!(rate(&slower).contains("20-80 Hz") && !rate(&slower).contains("motion"), "{slower:?}");
    let moved = judge(&sensor(10_000, 4, |t_s| if t_s > 2.0 { 60.0 } else { 6.0 }));
    assert_eq!(verdicts(&moved), ["\"warning\" \"sensor rest\""], "{moved:?}");
    let dead = judge(&sensor(10_000, 3, |_| 0.0));
    assert_eq!(verdicts(&dead), ["\"fault\" \"sensor noise\""], "{dead:?}");
    let whole = sensor(1000, 4, |_| 6.0);
    let kept: Vec<&str> =
        whole.lines().enumerate().filter(|(i, _)| i % 500 != 100).map(|(_, line)| line).collect();
    let gaps = judge(&kept.join("\n"));
    assert!(verdicts(&gaps).contains(&"\"warning\" \"sensor data\"".to_owned()), "{gaps:?}");
    put(&folder, "t.csv", "t_s,travel_m\n0,0\n0.001,0\n0.002,0\n");
    let none = checked(&gripctl(&folder, "doctor --json --sensor t.csv"));
    assert_eq!(finding(&none, "sensor")["verdict"], "fault");
    let absent = gripctl(&folder, "doctor --sensor no.csv");
    assert!(absent.code != 0 && absent.err.contains("no.csv"), "{absent:?}");
}

/// Quiet noise of a microphone.
fn microphone(samples: usize) -> Vec<u8> {
    let mut noise = noise(7);
    wav(10_000, core::iter::repeat_with(|| 256.0 * noise()).take(samples))
}

#[test]
fn a_wav_is_judged_and_calibrated_as_it_is_replayed() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "rest.wav", microphone(60_000));
    let judged = checked(&gripctl(&folder, "doctor --json --sensor rest.wav"));
    assert!(judged.iter().all(|line| line["verdict"] == "ok"), "{judged:?}");
    let replayed = gripctl(&folder, "replay rest.wav");
    assert!(replayed.code == 0 && replayed.out.contains("60000 samples"), "{replayed:?}");
    let made = gripctl(&folder, "calibrate rest.wav -o CAL.toml");
    assert!(made.code == 0 && folder.path().join("CAL.toml").exists(), "{made:?}");
}

#[test]
fn a_recording_where_a_port_should_be_is_named_as_one() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "rest.wav", microphone(10));
    let lost = gripctl(&folder, "doctor rest.wav");
    assert!(lost.code == 1 && lost.out.contains("doctor --sensor rest.wav"), "{lost:?}");
    // A sound under another name.
    fs::copy(folder.path().join("rest.wav"), folder.path().join("rest.m4a")).unwrap();
    let sound = gripctl(&folder, "replay rest.m4a");
    assert!(sound.code == 2 && sound.err.contains("name it .wav"), "{sound:?}");
}

/// Status of Robotiq's manual: activated, open fingers at 13. What unit 9 answers when it is asked for one, two or all three of its
/// registers.
const OPEN: [&[u8]; 3] = [
    &[9, 4, 2, 0xF9, 0, 0x1A, 0xA1],
    &[9, 4, 4, 0xF9, 0, 0, 0, 0x42, 0xD8],
    &[9, 4, 6, 0xF9, 0, 0, 0, 0x0D, 0, 0x17, 0xAA],
];

#[test]
fn a_robotiq_gripper_is_asked_for_its_status_alone() {
    let folder = tempfile::tempdir().unwrap();
    let pty = Pty::open(None).unwrap();
    let name = format!("robotiq:2f-85:{}", pty.port().display());
    let place = format!("2F-85 at {}, unit 9, 115200 baud", pty.port().display());
    let text = |lines: &[Value]| finding(lines, "gripper")["text"].as_str().unwrap().to_owned();
    let silent = checked(&doctor(&folder, &name));
    assert!(text(&silent).starts_with(&place) && text(&silent).contains("no status"), "{silent:?}");
    assert!(!text(&silent).contains(" 0 requests"), "it was asked: {silent:?}");
    let mut left = [0; 4096];
    while pty.read(&mut left).unwrap() > 0 {}
    let over = AtomicBool::new(false);
    let (lines, asked) = thread::scope(|scope| {
        let device = scope.spawn(|| {
            let mut asked = Vec::new();
            while !over.load(Ordering::Relaxed) {
                pty.wait(20_000, false).unwrap();
                let mut request = [0; 64];
                let count = pty.read(&mut request).unwrap();
                if count > 0 {
                    asked.extend_from_slice(&request[..count]);
                    pty.write(OPEN[usize::from(request[5]) - 1]).unwrap();
                }
            }
            asked
        });
        let lines = checked(&doctor(&folder, &name));
        over.store(true, Ordering::Relaxed);
        (lines, device.join().unwrap())
    });
    let found = format!("{place}: activated, holds nothing, position 13 of 255");
    assert!(text(&lines).starts_with(&found), "{lines:?}");
    assert!(asked.chunks(8).all(|request| request.starts_with(&[9, 4, 0x07, 0xD0])), "{asked:?}");
    let wrong = gripctl(&folder, "doctor robotiq:3f:/dev/ttyUSB0");
    assert!(wrong.code == 2 && wrong.err.contains("3f"), "{wrong:?}");
}
