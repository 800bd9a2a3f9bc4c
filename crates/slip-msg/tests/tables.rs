//! The constants of Python, C and the message definitions are those of the tables: each of them, and no other.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test")]

#[expect(dead_code, reason = "its `main` prints")]
#[path = "../examples/tables.rs"]
mod printed;

use printed::tables;
use slip_msg::Row;
use std::{collections::BTreeMap, fs, path::Path};

fn read(file: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

fn table(name: &str) -> &'static [Row] {
    tables().into_iter().find(|(own, _)| *own == name).unwrap().1
}

/// The codes of a table by the names of their constants behind `prefix`.
fn constants(prefix: &str, rows: &[Row]) -> BTreeMap<String, u8> {
    rows.iter().map(|row| (prefix.chars().chain(row.constant()).collect(), row.code)).collect()
}

/// Lines `NAME = code` or `uint8 NAME=code` whose name begins with `prefix`.
fn written<'a>(lines: impl Iterator<Item = &'a str>, prefix: &str) -> BTreeMap<String, u8> {
    lines
        .filter_map(|line| {
            let (name, code) = line.trim().trim_start_matches("uint8 ").split_once('=')?;
            Some((name.trim().to_owned(), code.trim().parse().ok()?))
        })
        .filter(|(name, _)| name.starts_with(prefix))
        .collect()
}

#[test]
fn python_has_the_codes_of_the_tables() {
    let package = "protocol/python/src/grip_link/messages";
    let text = ["codes.py", "daemon/codes.py"].map(|file| read(&format!("{package}/{file}")));
    let text = text.concat();
    for (name, rows) in tables() {
        let name = match name {
            "Reading" => "EscKind",
            "GripState" => "GripStage",
            name => name,
        };
        let begin = format!("class {name}(");
        let body = text.lines().skip_while(|line| !line.starts_with(&begin)).skip(1);
        let body = body.take_while(|line| !line.starts_with("class "));
        assert_eq!(written(body, ""), constants("", rows), "{name}");
    }
}

#[test]
fn message_definitions_have_the_codes_of_the_tables() {
    let state = read("fleet/ros/grip_msgs/msg/GripState.msg");
    let slip = read("fleet/ros/grip_msgs/msg/SlipEvent.msg");
    let recorded = read("crates/grip-record/src/mcap/msg/State.msg");
    let command = read("crates/grip-record/src/mcap/msg/Command.msg");
    for (text, prefix, name) in [
        (&state, "SCENE_", "Scene"),
        (&state, "GRIP_", "GripState"),
        (&state, "SENSOR_", "SensorHealth"),
        (&state, "DEVICE_", "DeviceState"),
        (&state, "ESC_", "Reading"),
        (&slip, "PHASE_", "Phase"),
        (&slip, "METHOD_", "Method"),
        (&slip, "SPEED_", "SpeedSource"),
        (&slip, "ESC_", "Reading"),
        (&recorded, "SCENE_", "Scene"),
        (&recorded, "GRIP_", "GripState"),
        (&command, "MODE_", "GripMode"),
    ] {
        assert_eq!(written(text.lines(), prefix), constants(prefix, table(name)), "{prefix}");
    }
}

#[test]
fn the_c_header_counts_as_the_tables_do() {
    let header = read("protocol/c/grip_link.h");
    for (first, name) in [
        ("GL_BOOT = 0", "DeviceState"),
        ("GL_STYLUS = 1", "ChannelKind"),
        ("GL_UNIT_NONE = 0", "Unit"),
        ("GL_I16 = 0", "SampleFormat"),
        ("GL_RESET_UNKNOWN = 0", "ResetReason"),
        ("GL_MODE_FORCE = 1", "GripMode"),
        ("GL_LOSS_HOLD = 0", "LossAction"),
        ("GL_UNKNOWN_TYPE = 1", "NackReason"),
        ("GL_ERROR = 0", "LogLevel"),
    ] {
        let begin = header.find(first).unwrap_or_else(|| panic!("{first}"));
        let names = header[begin..].split('}').next().unwrap().split(',');
        let mut rows = table(name).iter();
        for written in names {
            let written = written.split('=').next().unwrap().trim();
            let constant: String = rows.next().unwrap().constant().collect();
            assert!(written.contains(&constant), "{name}: {written} stands for {constant}");
        }
        // The last reasons are those of the daemon, which C does not speak with.
        assert!(rows.next().is_none() || name == "NackReason", "{name} has more");
    }
}
