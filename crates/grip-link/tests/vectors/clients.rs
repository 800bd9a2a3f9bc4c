//! Every frame between daemon and clients reads and writes back to the same bytes; every bad one gets its verdict.

use crate::table::rows;
use crate::targets::gripper::{SESSION, wire};
use crate::targets::words::{fault_word, hex, unhex};
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Frame, MAX_PAYLOAD};
use grip_link::message::daemon::{ToClient, ToDaemon};
use grip_link::message::{Kind, PayloadError};
use std::collections::HashSet;

/// The payload that the message of a frame writes.
fn again(role: Role, frame: &Frame<'_>) -> Result<Vec<u8>, PayloadError> {
    let mut out = [0xAA; MAX_PAYLOAD];
    let out = &mut out[..];
    let len = if role == Role::Daemon {
        match ToDaemon::parse(frame)? {
            ToDaemon::Subscribe(message) => message.write(out)?,
            ToDaemon::Command(message) => message.write(out)?,
            ToDaemon::Query => 0,
            ToDaemon::Load(message) => message.write(out)?,
            ToDaemon::Object(message) => message.write(out)?,
            ToDaemon::Shadow(message) => message.write(out)?,
        }
    } else {
        match ToClient::parse(frame)? {
            ToClient::Welcome(message) => message.write(out)?,
            ToClient::Slip(message) => message.write(out)?,
            ToClient::State(message) => message.write(out)?,
            ToClient::Health(message) => message.write(out)?,
            ToClient::Gripper(message) => message.write(out)?,
            ToClient::Rows(message) => message.write(out)?,
            ToClient::Notice(message) => message.write(out)?,
            ToClient::Setup(message) => message.write(out)?,
            ToClient::Estimates(message) => message.write(out)?,
            ToClient::Ack(message) => message.write(out)?,
            ToClient::Nack(message) => message.write(out)?,
        }
    };
    Ok(out[..len].to_vec())
}

#[test]
fn frames_are_byte_exact() {
    let mut kinds = HashSet::new();
    for [name, usage, way, _, head, _, bytes] in rows::<7>("clients.tsv") {
        let role = if way == "to_daemon" { Role::Daemon } else { Role::Client };
        let session = head.split("session=").nth(1).unwrap().parse().unwrap();
        let mut decoder = Decoder::new(role);
        decoder.open_session(session, None);
        let sent = unhex(&bytes);
        let Some(Verdict::Frame(frame)) = decoder.next(&mut &sent[..]) else { panic!("{name}") };
        let payload = again(role, &frame).unwrap();
        let same = hex(&wire(&frame.header, &payload)) == bytes;
        assert_eq!(same, usage == "both", "{name}");
        kinds.insert(frame.header.kind);
    }
    let known = (0..=255).map(Kind).filter(|kind| kind.is_to_daemon() || kind.is_to_client());
    assert_eq!(kinds, known.filter(|kind| kind.0 >= 0xA0).collect());
}

#[test]
fn bad_frames_get_their_verdict() {
    for [name, role, session, bytes, verdicts, error, _] in rows::<7>("clients-invalid.tsv") {
        let role = if role == "daemon" { Role::Daemon } else { Role::Client };
        let mut decoder = Decoder::new(role);
        if session == "beef" {
            decoder.open_session(SESSION, Some(0));
        }
        let bytes = unhex(&bytes);
        let mut input = &bytes[..];
        let (mut words, mut last) = (Vec::new(), "-".to_owned());
        while let Some(verdict) = decoder.next(&mut input) {
            last = match verdict {
                Verdict::Frame(frame) => match again(role, &frame) {
                    Ok(_) => "-".to_owned(),
                    Err(PayloadError::Short { .. }) => "short".to_owned(),
                    Err(PayloadError::Value { at, .. }) => format!("value@{at}"),
                    Err(other) => panic!("{name}: {other}"),
                },
                Verdict::Bad(_) => "-".to_owned(),
            };
            words.push(match verdict {
                Verdict::Frame(_) => "ok",
                Verdict::Bad(fault) => fault_word(fault),
            });
        }
        assert_eq!((words.join(","), last), (verdicts, error), "{name}");
    }
}
