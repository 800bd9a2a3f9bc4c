//! Each bad input gets its verdict, its payload error and its NACK.

use crate::table::rows;
use crate::targets::gripper::{SESSION, hello, idle, sent, wire};
use crate::targets::words::{fault_word, unhex};
use crate::valid::error_of;
use grip_link::cobs::decode_in_place;
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::device::DeviceLink;
use grip_link::frame::{Direction, Frame, Header};
use grip_link::message::{Kind, Nack, NackReason, Versions};

fn error(role: Role, frame: &Frame<'_>) -> String {
    match error_of(role, &Verdict::Frame(*frame)) {
        fine if fine == "-" && frame.header.kind == Kind::HELLO && frame.header.session == 0 => {
            "session".to_owned()
        }
        other => other,
    }
}

/// What is appended is ignored, but a byte less is none of the message.
#[test]
fn a_payload_cut_anywhere_is_refused_and_a_longer_one_is_not() {
    for [name, usage, direction, kind, _, _, bytes] in rows::<7>("valid.tsv") {
        // How much SAMPLES have to hold depends on the channels.
        if usage != "both" || direction == "cobs" || kind == "SAMPLES" {
            continue;
        }
        let role = if direction == "to_device" { Role::Device } else { Role::Host };
        let mut block = unhex(bytes.strip_prefix("00").unwrap().strip_suffix("00").unwrap());
        let frame = Frame::from_body(decode_in_place(&mut block).unwrap()).unwrap();
        let longer = [frame.payload, &[0xEE; 9]].concat();
        for len in 0..=longer.len() {
            let (payload, whole) = (&longer[..len], frame.payload.len());
            let reported = error(role, &Frame { payload, ..frame });
            assert_eq!(reported != "short", len >= whole, "{name} of {len} bytes: {reported}");
        }
    }
}

#[test]
fn decoder_gives_each_block_its_verdict() {
    for [name, role, session, wire, verdicts, expected, _] in rows::<7>("invalid.tsv") {
        let role = if role == "device" { Role::Device } else { Role::Host };
        let mut decoder = Decoder::new(role);
        if session == "beef" {
            decoder.open_session(SESSION, Some(0));
        }
        let bytes = unhex(&wire);
        let mut input = &bytes[..];
        let mut words = Vec::new();
        let mut last = "-".to_owned();
        while let Some(verdict) = decoder.next(&mut input) {
            words.push(match &verdict {
                Verdict::Frame(_) => "ok",
                Verdict::Bad(fault) => fault_word(*fault),
            });
            last = match verdict {
                Verdict::Frame(frame) => error(role, &frame),
                Verdict::Bad(_) => "-".to_owned(),
            };
        }
        assert_eq!(words.join(","), verdicts, "{name}");
        assert_eq!(last, expected, "{name}");
    }
}

fn greet(device: &mut DeviceLink) {
    let header = Header::new(Direction::ToDevice, Kind::HELLO, 0, SESSION);
    let bytes = wire(&header, &hello(Versions::OURS, 0));
    assert!(device.receive(1, &mut &bytes[..]).is_some());
}

/// Reasons of all NACKs that a device has to send.
fn nacks(device: &mut DeviceLink) -> Vec<NackReason> {
    let frames = sent(device, 2).into_iter().filter(|(kind, _)| *kind == Kind::NACK);
    frames.map(|(_, payload)| Nack::parse(&payload).unwrap().reason).collect()
}

#[test]
fn device_refuses_and_keeps_its_state() {
    for [name, role, session, wire, verdicts, expected, nack] in rows::<7>("invalid.tsv") {
        if role != "device" {
            continue;
        }
        let mut device = idle(1);
        if session == "beef" {
            greet(&mut device);
            let _ident = nacks(&mut device);
        }
        let state = device.state();
        let bytes = unhex(&wire);
        let mut input = &bytes[..];
        let event = device.receive(2, &mut input);
        assert!(event.is_none(), "{name}: {event:?}");
        assert_eq!(device.state(), state, "{name}");
        assert_eq!(
            device.counters().ok,
            u32::from(session == "beef")
                + u32::try_from(verdicts.split(',').filter(|v| *v == "ok").count()).unwrap(),
            "{name}"
        );
        let reasons = match nack.as_str() {
            "-" => vec![],
            "unknown_type" => vec![NackReason::UnknownType],
            "malformed" => vec![NackReason::Malformed],
            "wrong_state" => vec![NackReason::WrongState],
            "other_fault" => vec![NackReason::OtherFault],
            other => panic!("{name}: {other}"),
        };
        assert_eq!(nacks(&mut device), reasons, "{name}");
        let refused = expected != "-";
        assert!(!refused || nack == "malformed" || nack == "-", "{name}");
    }
}
