//! Each worked example is what the encoder writes, and its annotation covers each byte once.

use crate::markdown::{fence, headings, table};
use crate::rig::{hello, ident};
use crate::targets::gripper::{CONFIG, SESSION, press, wire, written};
use crate::targets::words::unhex;
use grip_link::cobs;
use grip_link::frame::{Direction, Frame, Header};
use grip_link::message::{
    Ack, Clamped, ConfigAck, DeviceState, FaultCode, ForceClamp, Grip, Kind, Nack, NackReason,
    Ping, Pong, SampleFormat, SamplesHeader, Status, StatusFlags,
};

fn bytes(text: &str) -> Vec<u8> {
    unhex(&text.replace(' ', ""))
}

fn samples(header: SamplesHeader, elements: &[&[u8]]) -> Vec<u8> {
    let mut payload = written(|p| header.write(p));
    payload.extend(elements.concat());
    payload
}

fn rows_i16() -> Vec<u8> {
    let header = SamplesHeader {
        first_index: 1000,
        t0_tick: 5_000_000_000,
        dt_ticks: 200,
        rows: 3,
        format: SampleFormat::I16,
        dropped_total: 9,
    };
    let rows = [100_i16, -200, 101, i16::MIN, 102, 0].map(i16::to_le_bytes);
    samples(header, &rows.iter().map(|row| &row[..]).collect::<Vec<_>>())
}

fn rows_f32() -> Vec<u8> {
    let header = SamplesHeader {
        first_index: 1003,
        t0_tick: 5_000_000_600,
        dt_ticks: 200,
        rows: 2,
        format: SampleFormat::F32,
        dropped_total: 9,
    };
    let rows = [1.5e-6, f32::NAN, -0.0, 2.25].map(f32::to_le_bytes);
    samples(header, &rows.iter().map(|row| &row[..]).collect::<Vec<_>>())
}

fn grip() -> Grip {
    Grip { ttl_ms: 50, slew_mn_s: 200_000, cause_sample: 123_456, ..press(42, 5_000) }
}

fn status() -> Status {
    Status {
        last_cmd_id: 42,
        state: DeviceState::Active,
        clamp: ForceClamp(0),
        fault: FaultCode::NONE,
        applied_mn: 2_000,
        target_mn: 5_000,
        age_us: 350,
        flags: StatusFlags::SAMPLING,
        rejected: 0,
    }
}

/// Headings of the examples.
fn examples() -> Vec<&'static str> {
    let mut found = headings("### W");
    found.retain(|heading| heading[5..].starts_with(|c: char| c.is_ascii_digit()));
    assert_eq!(found.len(), 14);
    found
}

/// Type, seq and payload of an example.
fn message(heading: &str) -> (Kind, u16, Vec<u8>) {
    let t1_us = 1_000_000_000;
    match heading {
        "### W1 HELLO" => (Kind::HELLO, 0, hello()),
        "### W2 IDENT" => (Kind::IDENT, 0, written(|p| ident().write(p))),
        "### W3 CONFIG" => (Kind::CONFIG, 1, CONFIG.to_bytes().to_vec()),
        "### W4 CONFIG_ACK" => {
            let ack = ConfigAck { seq: 1, clamped: Clamped(0), config: CONFIG };
            (Kind::CONFIG_ACK, 3, written(|p| ack.write(p)))
        }
        "### W5 START" => (Kind::START, 2, vec![]),
        "### W6 ACK" => (Kind::ACK, 4, written(|p| Ack { kind: Kind::START, seq: 2 }.write(p))),
        "### W7 SAMPLES i16" => (Kind::SAMPLES, 5, rows_i16()),
        "### W8 SAMPLES f32" => (Kind::SAMPLES, 6, rows_f32()),
        "### W9 GRIP" => (Kind::GRIP, 7, written(|p| grip().write(p))),
        "### W10 STATUS" => (Kind::STATUS, 8, written(|p| status().write(p))),
        "### W11 PING" => (Kind::PING, 9, written(|p| Ping { t1_us }.write(p))),
        "### W12 PONG" => {
            let pong = Pong { t1_us, rx_tick: 5_000_040_000, tx_tick: 5_000_040_120 };
            (Kind::PONG, 9, written(|p| pong.write(p)))
        }
        "### W13 ESTOP" => (Kind::ESTOP, 8, vec![]),
        "### W14 NACK" => {
            let nack = Nack { kind: Kind::CONFIG, reason: NackReason::Latched, seq: 1 };
            (Kind::NACK, 600, written(|p| nack.write(p)))
        }
        other => panic!("no message for {other:?}"),
    }
}

fn expected(heading: &str) -> Vec<u8> {
    let (kind, seq, payload) = message(heading);
    let way = if kind.is_to_device() { Direction::ToDevice } else { Direction::ToHost };
    let asks = [Kind::HELLO, Kind::CONFIG, Kind::START, Kind::ESTOP].contains(&kind);
    let session = if kind == Kind::ESTOP { 0 } else { SESSION };
    wire(&Header { ack_req: asks, ..Header::new(way, kind, seq, session) }, &payload)
}

#[test]
fn examples_are_what_the_encoder_writes() {
    for heading in examples() {
        let hex = bytes(&fence(heading, "hex").join(""));
        assert_eq!(hex, expected(heading), "{heading}");
    }
}

#[test]
fn annotations_cover_each_byte_once() {
    for heading in examples() {
        let rows = table(heading);
        let column = |n: usize| rows.iter().flat_map(|row| bytes(&row[n])).collect::<Vec<u8>>();
        let (wire, body) = (column(0), column(1));
        assert_eq!(wire, expected(heading), "{heading}");
        let mut block = wire[1..wire.len() - 1].to_vec();
        assert_eq!(cobs::decode_in_place(&mut block).unwrap(), body, "{heading}");
        let frame = Frame::from_body(&body).unwrap();
        let meanings: Vec<&str> = rows.iter().map(|row| row[2].as_str()).collect();
        assert!(meanings.contains(&format!("len {}", frame.payload.len()).as_str()), "{heading}");
        assert!(meanings.contains(&format!("seq {}", frame.header.seq).as_str()), "{heading}");
        for row in rows.iter().filter(|row| !row[1].is_empty()) {
            let same =
                bytes(&row[0]).into_iter().zip(bytes(&row[1])).all(|(w, b)| w == b || b == 0);
            assert!(same, "{heading}: {row:?}");
        }
    }
}
