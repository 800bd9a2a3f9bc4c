//! One pinned frame of each message, and the offsets of its fields.

use crate::targets::gripper::{CONFIG, ident, wire};
use crate::targets::words::{hex, unhex};
use grip_link::frame::{Direction, Header, MAX_PAYLOAD};
use grip_link::message::{
    Ack, Channel, ChannelKind, Clamped, ClearFault, Config, ConfigAck, DeviceState, Event,
    EventKind, FaultCode, ForceClamp, Grip, Heartbeat, Ident, Kind, Layout, Log, LogLevel, Nack,
    NackReason, PayloadError, Ping, Pong, SampleFormat, Samples, SamplesHeader, Stats, Status,
    StatusFlags, Unit, Versions,
};

/// Frames of session BEEF, seq 600, that other implementations must write too.
pub(crate) const PINNED: [(&str, &str); 15] = [
    (
        "CONFIG",
        "000812035802efbe1c0388130102050232020301010310270104400d0303401f0103e8030105e33e4b5b00",
    ),
    ("START", "000712045802efbe01054348acd300"),
    ("STOP", "000712055802efbe01058b64afbb00"),
    ("HEARTBEAT", "000810115802efbe0c020501010384030102020201054866f75800"),
    ("CLEAR_FAULT", "000812135802efbe020701025419a60e00"),
    (
        "IDENT",
        "000811815802efbe60050101e00101010113677269702d6c696e6b2d746573742d3107b0010440420f03204e0103204e0104801a0603983a01010101010350c30104010203030101010403084801010101150101030177cc2b32020203016f12833a0905030401072041c3e2492000",
    ),
    (
        "CONFIG_ACK",
        "000811835802efbe2408f8102a5a3412290388130102050232020301010310270104400d0303401f0103e80301051bfe8b3b00",
    ),
    ("PONG", "000811865802efbe180104ca9a3b010101024d0101010101010263010101010101056e4a7c9c00"),
    ("ACK", "0008118e5802efbe040204020205ea3aee3400"),
    ("NACK", "0008118f5802efbe0404030401056279a61000"),
    (
        "SAMPLES",
        "000811905802efbe2003e803010105f2052a01010102c802030209010102640438ff65010380660101051032b93900",
    ),
    ("STATUS", "000811915802efbe180f0403020105100101feffffff8813010470110102010203053da82d7c00"),
    (
        "STATS",
        "000811925802efbe4c020101010202010102030101020401010205010102060101020701010208010102090101020a0101020b0101020c0101020d0101020e0101020f01010210010102110101021201010213010105c4761b5100",
    ),
    ("EVENT", "000811935802efbe1406141a99be1c0101040104050101020109f9ffffff4d2470c100"),
    ("LOG", "000811945802efbe14022a01010101010111010a6c6f7720737570706c79bbd7aaa300"),
];

type Written = Result<usize, PayloadError>;

fn payload(write: impl FnOnce(&mut [u8]) -> Written) -> Vec<u8> {
    let mut bytes = [0xAA; MAX_PAYLOAD];
    let len = write(&mut bytes).unwrap();
    bytes[..len].to_vec()
}

fn status() -> Status {
    Status {
        last_cmd_id: 0x0102_0304,
        state: DeviceState::Hold,
        clamp: ForceClamp::HOLD_CAP,
        fault: FaultCode::SENSOR_DEAD,
        applied_mn: -2,
        target_mn: 5000,
        age_us: 70_000,
        flags: StatusFlags::SAMPLING,
        rejected: 3,
    }
}

fn event() -> Event {
    Event {
        tick: 123_456_789_012,
        kind: EventKind::State,
        before: DeviceState::Active,
        after: DeviceState::Hold,
        fault: FaultCode::NONE,
        dropped: 1,
        value: -7,
    }
}

fn stats() -> Stats {
    let mut bytes = [0; Stats::SIZE];
    for (i, field) in bytes.chunks_mut(4).enumerate() {
        field.copy_from_slice(&(u32::try_from(i).unwrap() + 1).to_le_bytes());
    }
    Stats::parse(&bytes).unwrap()
}

fn samples() -> Vec<u8> {
    let header = SamplesHeader {
        first_index: 1000,
        t0_tick: 5_000_000_000,
        dt_ticks: 200,
        rows: 3,
        format: SampleFormat::I16,
        dropped_total: 9,
    };
    let mut bytes = payload(|p| header.write(p));
    for value in [100_i16, -200, 101, i16::MIN, 102, 0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

fn all() -> Vec<(&'static str, Kind, bool, Vec<u8>)> {
    let ack = ConfigAck { seq: 0x1234, clamped: Clamped(0x29), config: CONFIG };
    let beat = Heartbeat { turns: 5, longest_us: 900, late: 2, flags: 1 };
    let pong = Pong { t1_us: 1_000_000_000, rx_tick: 77, tx_tick: 99 };
    let log = Log { tick: 42, level: LogLevel::Warn, text: b"low supply" };
    vec![
        ("CONFIG", Kind::CONFIG, true, payload(|p| CONFIG.write(p))),
        ("START", Kind::START, true, vec![]),
        ("STOP", Kind::STOP, true, vec![]),
        ("HEARTBEAT", Kind::HEARTBEAT, false, payload(|p| beat.write(p))),
        (
            "CLEAR_FAULT",
            Kind::CLEAR_FAULT,
            true,
            payload(|p| ClearFault { fault: FaultCode::OBJECT_LOST }.write(p)),
        ),
        ("IDENT", Kind::IDENT, false, payload(|p| ident(0xB007).write(p))),
        ("CONFIG_ACK", Kind::CONFIG_ACK, false, payload(|p| ack.write(p))),
        ("PONG", Kind::PONG, false, payload(|p| pong.write(p))),
        ("ACK", Kind::ACK, false, payload(|p| Ack { kind: Kind::START, seq: 2 }.write(p))),
        (
            "NACK",
            Kind::NACK,
            false,
            payload(|p| Nack { kind: Kind::CONFIG, reason: NackReason::Latched, seq: 1 }.write(p)),
        ),
        ("SAMPLES", Kind::SAMPLES, false, samples()),
        ("STATUS", Kind::STATUS, false, payload(|p| status().write(p))),
        ("STATS", Kind::STATS, false, payload(|p| stats().write(p))),
        ("EVENT", Kind::EVENT, false, payload(|p| event().write(p))),
        ("LOG", Kind::LOG, false, payload(|p| log.write(p))),
    ]
}

#[test]
fn every_message_has_its_pinned_frame() {
    for (i, (name, kind, ack_req, payload)) in all().into_iter().enumerate() {
        let direction = if kind.is_to_host() { Direction::ToHost } else { Direction::ToDevice };
        let header = Header { ack_req, ..Header::new(direction, kind, 600, 0xBEEF) };
        assert_eq!((name, hex(&wire(&header, &payload)).as_str()), PINNED[i]);
    }
}

#[test]
fn sizes_are_those_of_the_table() {
    let sizes: Vec<(&str, usize)> =
        all().iter().map(|(name, _, _, payload)| (*name, payload.len())).collect();
    let expected = [
        ("CONFIG", 28),
        ("START", 0),
        ("STOP", 0),
        ("HEARTBEAT", 12),
        ("CLEAR_FAULT", 2),
        ("IDENT", 72 + 3 * 8),
        ("CONFIG_ACK", 36),
        ("PONG", 24),
        ("ACK", 4),
        ("NACK", 4),
        ("SAMPLES", 20 + 12),
        ("STATUS", 24),
        ("STATS", 76),
        ("EVENT", 20),
        ("LOG", 20),
    ];
    assert_eq!(sizes, expected);
}

/// Writes what was parsed from a payload; `None` when it was refused.
fn again(kind: Kind, bytes: &[u8]) -> Option<Vec<u8>> {
    Some(match kind {
        Kind::CONFIG => Config::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::HEARTBEAT => Heartbeat::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::CLEAR_FAULT => ClearFault::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::IDENT => Ident::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::CONFIG_ACK => ConfigAck::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::PONG => Pong::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::ACK => Ack::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::NACK => Nack::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::STATUS => Status::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::STATS => Stats::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::EVENT => Event::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::LOG => Log::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::PING => Ping::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        Kind::GRIP => Grip::parse(bytes).ok().map(|m| payload(|p| m.write(p)))?,
        _ => return None,
    })
}

#[test]
fn reading_undoes_writing_ignores_more_and_refuses_less() {
    for (name, kind, _, bytes) in all() {
        if matches!(kind, Kind::START | Kind::STOP | Kind::SAMPLES) {
            continue;
        }
        assert_eq!(again(kind, &bytes).unwrap(), bytes, "{name}");
        let longer = [&bytes[..], &[0xEE; 9]].concat();
        assert_eq!(again(kind, &longer).unwrap(), bytes, "{name}");
        for len in 0..bytes.len() {
            assert_eq!(again(kind, &bytes[..len]), None, "{name} of {len} bytes");
        }
    }
}

#[test]
fn samples_give_rows_in_units() {
    let layout = Layout::new(ident(1).channels(), 0b011);
    let bytes = [&samples()[..], &[1, 2, 3]].concat();
    let batch = Samples::parse(&bytes, &layout).unwrap();
    let force = layout.column(ChannelKind::NormalForce).unwrap();
    let rows: Vec<_> = batch
        .rows()
        .map(|row| (row.index, row.tick, row.raw(0), row.value(&force, 0).unwrap()))
        .collect();
    assert_eq!(rows[0], (1000, 5_000_000_000, Some(100), -0.2));
    assert_eq!((rows[1].0, rows[1].1, rows[1].2), (1001, 5_000_000_200, Some(101)));
    assert!(rows[1].3.is_nan(), "-32768 is no reading");
    assert_eq!(rows.len(), 3);
    let first = batch.rows().next().unwrap();
    assert_eq!(first.read(ChannelKind::Stylus), Some(100.0 * 1e-8));
    assert_eq!((first.read(ChannelKind::Velocity), first.value(&force, 1)), (None, None));
    assert!(Samples::parse(&bytes[..31], &layout).is_err());
    assert!(Samples::parse(&bytes, &Layout::EMPTY).is_err());
}

#[test]
fn array_and_float_rows() {
    let layout = Layout::new(ident(1).channels(), 0b101);
    assert_eq!((layout.elements(), layout.row_bytes(SampleFormat::F32)), (5, 20));
    let header = SamplesHeader {
        first_index: u32::MAX,
        t0_tick: 0,
        dt_ticks: 1000,
        rows: 2,
        format: SampleFormat::F32,
        dropped_total: 0,
    };
    let mut bytes = payload(|p| header.write(p));
    for i in 0..10_u8 {
        bytes.extend(f32::from(i).to_le_bytes());
    }
    let batch = Samples::parse(&bytes, &layout).unwrap();
    let array = layout.column(ChannelKind::PressureArray).unwrap();
    let second = batch.rows().nth(1).unwrap();
    assert_eq!((second.index, second.raw(0)), (0, None));
    let values: Vec<f32> = (0..4).map(|k| second.value(&array, k).unwrap()).collect();
    assert_eq!(values, [6.0, 7.0, 8.0, 9.0]);
    assert_eq!(second.value(&array, 4), None);
}

#[test]
fn ident_tables_may_grow_and_must_make_sense() {
    let bytes = payload(|p| ident(1).write(p));
    let mut grown = bytes[..68].to_vec();
    grown[65] = 10;
    grown[66] = 76;
    grown.extend([9; 8]);
    for entry in bytes[72..].chunks(8) {
        grown.extend(entry);
        grown.extend([7, 7]);
    }
    assert_eq!(Ident::parse(&grown).unwrap(), ident(1));
    let broken = |at: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = value;
        Ident::parse(&bytes)
    };
    assert_eq!(broken(64, 17), Err(PayloadError::Value { at: 64, value: 17 }));
    assert_eq!(broken(65, 7), Err(PayloadError::Value { at: 65, value: 7 }));
    assert_eq!(broken(75, 0), Err(PayloadError::Value { at: 75, value: 0 }));
    assert!(broken(79, 0xFF).is_err(), "a negative scale");
    assert!(broken(66, 90).is_err(), "a table past the end");
}

#[test]
fn codes_go_both_ways() {
    for code in 0..=255 {
        assert_eq!(ChannelKind::from_code(code).code(), code);
        assert_eq!(Unit::from_code(code).code(), code);
        assert_eq!(DeviceState::from_code(code).code(), code);
        assert_eq!(NackReason::from_code(code).code(), code);
        assert_eq!(EventKind::from_code(code).code(), code);
        assert_eq!(LogLevel::from_code(code).code(), code);
    }
    assert_eq!(Channel::single(ChannelKind::Velocity, 1.0).unit, Unit::MetrePerSecond);
}

#[test]
fn versions_meet_at_the_highest() {
    let range = |min, max| Versions { min, max };
    assert_eq!(range(1, 3).common(range(2, 5)), Some(3));
    assert_eq!(range(1, 1).common(range(2, 5)), None);
    assert_eq!(range(4, 6).common(range(1, 3)), None);
}

#[test]
fn a_text_that_is_not_utf8_is_cut() {
    let log = Log { tick: 0, level: LogLevel::Info, text: b"ok \xFF no" };
    assert_eq!(log.as_str(), "ok ");
    assert!(Log { text: &[b'x'; 256], ..log }.write(&mut [0; MAX_PAYLOAD]).is_err());
    assert_eq!(unhex("00ff"), [0, 255]);
}
