//! Each bad input gets its verdict, its payload error and its NACK.

use crate::table::{rows, unhex};
use grip_link::cobs;
use grip_link::decoder::{Decoder, Fault, Role, Verdict};
use grip_link::device::{DeviceConfig, DeviceLink};
use grip_link::frame::{Direction, Frame, Header, MAX_WIRE, encode};
use grip_link::message::{
    Channel, ChannelKind, ConfigAck, Event, FaultCode, Firmware, Hello, Ident, Kind, Layout,
    Limits, Log, MAX_CHANNELS, Nack, NackReason, PayloadError, Pong, Reaction, ResetReason,
    Samples, Stats, Status, ToDevice, Versions,
};

const SESSION: u16 = 0xBEEF;

fn word(verdict: &Verdict<'_>) -> &'static str {
    match verdict {
        Verdict::Frame(_) => "ok",
        Verdict::Bad(Fault::TooLong) => "too_long",
        Verdict::Bad(Fault::Cobs) => "cobs",
        Verdict::Bad(Fault::Length) => "length",
        Verdict::Bad(Fault::Crc) => "crc",
        Verdict::Bad(Fault::Echo) => "echo",
        Verdict::Bad(Fault::Version(_)) => "version",
        Verdict::Bad(Fault::Stale(_)) => "stale",
        Verdict::Bad(Fault::Duplicate(_)) => "duplicate",
        Verdict::Bad(Fault::UnknownKind(_)) => "unknown",
    }
}

fn to_host(frame: &Frame<'_>) -> Result<(), PayloadError> {
    let payload = frame.payload;
    match frame.header.kind {
        Kind::IDENT => Ident::parse(payload).map(drop),
        Kind::CONFIG_ACK => ConfigAck::parse(payload).map(drop),
        Kind::PONG => Pong::parse(payload).map(drop),
        Kind::SAMPLES => {
            let two = Channel { count: 2, ..Channel::single(ChannelKind::PressureArray, 1.0) };
            Samples::parse(payload, &Layout::new(&[two], 1)).map(drop)
        }
        Kind::STATUS => Status::parse(payload).map(drop),
        Kind::STATS => Stats::parse(payload).map(drop),
        Kind::EVENT => Event::parse(payload).map(drop),
        Kind::LOG => Log::parse(payload).map(drop),
        _ => Ok(()),
    }
}

fn error(role: Role, frame: &Frame<'_>) -> String {
    let parsed = match role {
        Role::Device => ToDevice::parse(frame).map(drop),
        _ => to_host(frame),
    };
    match parsed {
        Ok(()) if frame.header.kind == Kind::HELLO && frame.header.session == 0 => "session".into(),
        Ok(()) => "-".into(),
        Err(PayloadError::Short { .. }) => "short".into(),
        Err(PayloadError::Value { at, .. }) => format!("value@{at}"),
        Err(other) => panic!("{other}"),
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
            words.push(word(&verdict));
            last = match verdict {
                Verdict::Frame(frame) => error(role, &frame),
                Verdict::Bad(_) => "-".to_owned(),
            };
        }
        assert_eq!(words.join(","), verdicts, "{name}");
        assert_eq!(last, expected, "{name}");
    }
}

fn device() -> DeviceLink {
    let mut channels = [Ident::NO_CHANNEL; MAX_CHANNELS];
    channels[0] = Channel::single(ChannelKind::Stylus, 1e-8);
    channels[1] = Channel::single(ChannelKind::NormalForce, 1e-3);
    let ident = Ident {
        versions: Versions::OURS,
        max_rx: 480,
        caps: 0,
        uid: [7; 16],
        boot_id: 1,
        tick_hz: 1_000_000,
        limits: Limits {
            rate_max_hz: 20_000,
            force_max_mn: 20_000,
            slew_max_mn_s: 400_000,
            hold_cap_mn: 15_000,
            travel_min_um: 0,
            travel_max_um: 50_000,
        },
        firmware: Firmware { major: 0, minor: 0, patch: 1 },
        reset: ResetReason::PowerOn,
        state: grip_link::message::DeviceState::Idle,
        fault: FaultCode::NONE,
        channels,
        channel_count: 2,
    };
    let mut device = DeviceLink::new(DeviceConfig { ident, estop: Reaction::Hold }).unwrap();
    device.ready(0);
    device
}

fn greet(device: &mut DeviceLink) {
    let mut payload = [0; Hello::SIZE];
    let hello = Hello { versions: Versions::OURS, max_rx: 480, caps: 0, time_us: 0 };
    hello.write(&mut payload).unwrap();
    let mut out = [0; MAX_WIRE];
    let header = Header::new(Direction::ToDevice, Kind::HELLO, 0, SESSION);
    let len = encode(&header, &payload, &mut out).unwrap();
    assert!(device.receive(1, &mut &out[..len]).is_some());
}

/// Reasons of all NACKs that a device has to send.
fn nacks(device: &mut DeviceLink) -> Vec<NackReason> {
    let mut found = Vec::new();
    let mut out = [0; MAX_WIRE];
    while let Some(len) = device.poll_transmit(2, &mut out) {
        let body = cobs::decode_in_place(&mut out[1..len - 1]).unwrap();
        let frame = Frame::from_body(body).unwrap();
        if frame.header.kind == Kind::NACK {
            found.push(Nack::parse(frame.payload).unwrap().reason);
        }
    }
    found
}

#[test]
fn device_refuses_and_keeps_its_state() {
    for [name, role, session, wire, verdicts, expected, nack] in rows::<7>("invalid.tsv") {
        if role != "device" {
            continue;
        }
        let mut device = device();
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
