//! Every vector of every peer: its fields by the tables of the messages, and its bytes again from the message that was read.

use crate::table::rows;
use crate::targets::messages;
use crate::targets::words::{fault_word, hex, unhex};
use grip_link::cobs;
use grip_link::crc::crc32c;
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Frame, Header, MAX_PAYLOAD, MAX_WIRE, encode};
use grip_link::message::daemon::{ToClient, ToDaemon};
use grip_link::message::{
    Channel, ChannelKind, Config, Kind, Layout, PayloadError, SAMPLES_HEADER, SampleFormat,
    Samples, ToDevice,
};
use slip_msg::{Field, Wire as _};
use std::collections::{BTreeMap, HashSet};

/// The payload that the message of a frame writes again, by one who listens.
fn again(role: Role, frame: &Frame<'_>) -> Result<Vec<u8>, PayloadError> {
    match role {
        Role::Device => ToDevice::parse(frame).map(drop)?,
        Role::Daemon => ToDaemon::parse(frame).map(drop)?,
        Role::Client => ToClient::parse(frame).map(drop)?,
        _ => {}
    }
    let mut out = [0xAA; MAX_PAYLOAD];
    let len = messages::again(frame.header.kind, frame.payload, &mut out)?;
    let mut payload = out[..len].to_vec();
    if frame.header.kind == Kind::SAMPLES {
        let two = Channel { count: 2, ..Channel::single(ChannelKind::PressureArray, 1.0) };
        Samples::parse(frame.payload, &Layout::new(&[two], 1))?;
        payload.extend(&frame.payload[len..]);
    }
    Ok(payload)
}

/// A field as the vectors write it.
fn read(kind: &str, bytes: &[u8]) -> String {
    let each = |bytes: &[u8]| {
        let mut wide = [0; 8];
        wide[..bytes.len()].copy_from_slice(bytes);
        match kind {
            "f32" => hex(&bytes.iter().rev().copied().collect::<Vec<_>>()),
            "i32" => i32::from_le_bytes(bytes.try_into().unwrap()).to_string(),
            "i64" => i64::from_le_bytes(wide).to_string(),
            _ => u64::from_le_bytes(wide).to_string(),
        }
    };
    let all: Vec<String> = bytes.chunks(Field::bytes(kind)).map(each).collect();
    all.join(",")
}

/// Compares what a vector names with the payload by the table of a message, and takes it out of `left`.
fn compare(table: &[Field], payload: &[u8], left: &mut BTreeMap<String, String>) {
    Field::each(table, &mut |Field { at, size, kind, name, appended, .. }| {
        let bytes = payload.get(at..at + size).unwrap_or_default();
        let found = match kind {
            _ if bytes.is_empty() => return,
            // More than any program writes: no field yet.
            _ if appended && !left.contains_key(name) => return,
            "" => return,
            "text" => {
                let end = at + 1 + usize::from(bytes[0]);
                hex(&payload[at + 1..end])
            }
            "u8" if size > 1 => hex(bytes),
            _ => read(kind, bytes),
        };
        let own = match name {
            "entry_size" | "table_at" => return,
            "channel_count" => Some(left["channels"].split(',').count().to_string()),
            "crc" if left.contains_key("config_seq") => {
                Some(crc32c(&payload[8..8 + Config::SIZE]).to_string())
            }
            _ => left.remove(name),
        };
        assert_eq!(Some(found), own, "{name} at {at} of {left:?}");
    });
}

/// Entries of the channel table, from where and at what distance the payload states.
fn channels(payload: &[u8]) -> String {
    let (count, size) = (usize::from(payload[64]), usize::from(payload[65]));
    let begin = usize::from(u16::from_le_bytes([payload[66], payload[67]]));
    let entry = |n: usize| {
        let entry = &payload[begin + n * size..];
        let mut parts = Vec::new();
        Field::each(Channel::FIELDS, &mut |Field { at, size, kind, .. }| {
            parts.push(read(kind, &entry[at..at + size]));
        });
        parts.join(":")
    };
    (0..count).map(entry).collect::<Vec<_>>().join(",")
}

/// Rows of SAMPLES or ROWS as a vector writes them, as bytes.
fn row_bytes(kind: Kind, is_f32: bool, text: &str) -> Vec<u8> {
    let element = |(n, word): (usize, &str)| match kind {
        Kind::ROWS if n == 0 => word.parse::<u32>().unwrap().to_le_bytes().to_vec(),
        Kind::SAMPLES if !is_f32 => word.parse::<i16>().unwrap().to_le_bytes().to_vec(),
        _ => u32::from_str_radix(word, 16).unwrap().to_le_bytes().to_vec(),
    };
    text.split(';').flat_map(|row| row.split(',').enumerate().flat_map(element)).collect()
}

fn pairs(text: &str) -> BTreeMap<String, String> {
    let words = text.split(' ').filter(|word| *word != "-");
    let pairs = words.map(|word| word.split_once('=').unwrap());
    pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
}

#[test]
fn cobs_blocks_are_byte_exact() {
    let mut seen = 0;
    for [name, usage, direction, _, _, fields, wire] in rows::<7>("valid.tsv") {
        if direction != "cobs" {
            continue;
        }
        let data = unhex(&pairs(&fields)["data"]);
        let mut block = unhex(&wire);
        if usage == "both" {
            let mut out = [0; 600];
            let len = cobs::encode(&data, &mut out).unwrap();
            assert_eq!(hex(&out[..len]), wire, "{name}");
        }
        assert_eq!(cobs::decode_in_place(&mut block).unwrap(), data, "{name}");
        seen += 1;
    }
    assert!(seen >= 8, "{seen}");
}

#[test]
fn frames_are_byte_exact_and_hold_their_fields() {
    let mut kinds = HashSet::new();
    for row in [rows::<7>("valid.tsv"), rows::<7>("clients.tsv")].concat() {
        let [name, usage, direction, message, head, fields, wire] = row;
        let (way, role) = match direction.as_str() {
            "cobs" => continue,
            "to_device" => (Direction::ToDevice, Role::Device),
            "to_daemon" => (Direction::ToDevice, Role::Daemon),
            "to_client" => (Direction::ToHost, Role::Client),
            _ => (Direction::ToHost, Role::Host),
        };
        let head = pairs(&head);
        let (_, kind) = *Kind::ALL.iter().find(|(known, _)| *known == message).unwrap();
        let number = |name: &str| head[name].parse::<u16>().unwrap();
        let header = Header {
            version: u8::try_from(number("version")).unwrap(),
            ack_req: head["ack_req"] == "1",
            ..Header::new(way, kind, number("seq"), number("session"))
        };
        let bytes = unhex(&wire);
        let mut decoder = Decoder::new(role);
        decoder.open_session(header.session, None);
        let Some(Verdict::Frame(frame)) = decoder.next(&mut &bytes[..]) else { panic!("{name}") };
        assert_eq!(frame.header, header, "{name}");
        let payload = again(role, &frame).unwrap();
        if role != Role::Client && role != Role::Daemon && kind != Kind::SAMPLES {
            // What a later version appends is ignored.
            let longer = [frame.payload, &[0xEE; 9]].concat();
            let longer = again(role, &Frame { payload: &longer, ..frame });
            assert_eq!(longer.as_ref(), Ok(&payload), "{name}");
        }
        let mut out = [0; MAX_WIRE];
        let len = encode(&header, &payload, &mut out).unwrap();
        assert_eq!(hex(&out[..len]) == wire, usage == "both", "{name}");
        hold_their_fields(kind, frame.payload, pairs(&fields), &name);
        kinds.insert(kind);
    }
    assert_eq!(kinds.len(), Kind::ALL.len(), "every message at least once");
}

fn hold_their_fields(kind: Kind, payload: &[u8], mut left: BTreeMap<String, String>, name: &str) {
    let is_f32 =
        left.get("format").is_some_and(|code| *code == SampleFormat::F32.code().to_string());
    compare(kind.fields(), payload, &mut left);
    if kind == Kind::CONFIG_ACK {
        compare(Config::FIELDS, &payload[8..], &mut left);
    }
    if let Some(text) = left.remove("channels").filter(|_| kind == Kind::IDENT) {
        assert_eq!(channels(payload), text, "{name}");
    }
    if let Some(text) = left.remove("rows") {
        let bytes = row_bytes(kind, is_f32, &text);
        assert!(payload[SAMPLES_HEADER..].starts_with(&bytes), "{name}");
    }
    assert!(left.is_empty(), "{name}: no field {left:?}");
}

#[test]
fn bad_frames_of_clients_get_their_verdict() {
    for [name, role, session, bytes, verdicts, error, _] in rows::<7>("clients-invalid.tsv") {
        let role = if role == "daemon" { Role::Daemon } else { Role::Client };
        let mut decoder = Decoder::new(role);
        if session == "beef" {
            decoder.open_session(crate::targets::gripper::SESSION, Some(0));
        }
        let bytes = unhex(&bytes);
        let mut input = &bytes[..];
        let (mut words, mut last) = (Vec::new(), "-".to_owned());
        while let Some(verdict) = decoder.next(&mut input) {
            last = error_of(role, &verdict);
            words.push(match verdict {
                Verdict::Frame(_) => "ok",
                Verdict::Bad(fault) => fault_word(fault),
            });
        }
        assert_eq!((words.join(","), last), (verdicts, error), "{name}");
    }
}

/// What is wrong with the payload of a good frame, in the words of the vectors.
pub(crate) fn error_of(role: Role, verdict: &Verdict<'_>) -> String {
    match verdict {
        Verdict::Frame(frame) => match again(role, frame) {
            Ok(_) => "-".to_owned(),
            Err(PayloadError::Short { .. }) => "short".to_owned(),
            Err(PayloadError::Value { at, .. }) => format!("value@{at}"),
            Err(other) => panic!("{other}"),
        },
        Verdict::Bad(_) => "-".to_owned(),
    }
}
