//! Fields give the wire bytes, and wire bytes the fields.

use crate::fields::{Given, channels, row_bytes, row_text};
use crate::table::rows;
use crate::targets::gripper::written;
use crate::targets::words::{hex, unhex};
use grip_link::cobs;
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Frame, Header, MAX_WIRE, encode};
use grip_link::message::{
    Ack, Channel, ChannelKind, Clamped, ClearFault, Config, ConfigAck, DeviceState, Event,
    EventKind, FaultCode, Firmware, ForceClamp, Grip, Heartbeat, Hello, Ident, Kind, Layout,
    Limits, Log, LogLevel, LossAction, Nack, NackReason, Ping, Pong, ResetReason, SampleFormat,
    Samples, SamplesHeader, Stats, Status, StatusFlags, Versions,
};

fn kind(name: &str) -> Kind {
    let found = Kind::ALL.iter().find(|(known, _)| *known == name);
    found.unwrap_or_else(|| panic!("no message {name}")).1
}

/// A message, the payload it writes, and whether a payload reads back as it.
macro_rules! message {
    ($frame:expr, $parse:path, $value:expr) => {{
        let value = $value;
        assert_eq!($parse($frame.payload), Ok(value));
        written(|p| value.write(p))
    }};
}

fn config(g: &mut Given) -> Config {
    Config {
        sample_rate_hz: g.num("sample_rate_hz"),
        batch: g.num("batch"),
        format: SampleFormat::from_code(g.num("format")).unwrap(),
        ttl_ms: g.num("ttl_ms"),
        channel_mask: g.num("channel_mask"),
        force_max_mn: g.num("force_max_mn"),
        slew_mn_s: g.num("slew_mn_s"),
        hold_cap_mn: g.num("hold_cap_mn"),
        loss_after_ms: g.num("loss_after_ms"),
        loss_action: LossAction::from_code(g.num("loss_action")).unwrap(),
    }
}

fn ident(g: &mut Given) -> Ident {
    let (channels, channel_count) = channels(&g.text("channels"));
    Ident {
        versions: Versions { min: g.num("min"), max: g.num("max") },
        max_rx: g.num("max_rx"),
        caps: g.num("caps"),
        uid: g.bytes("uid").try_into().unwrap(),
        boot_id: g.num("boot_id"),
        tick_hz: g.num("tick_hz"),
        limits: Limits {
            rate_max_hz: g.num("rate_max_hz"),
            force_max_mn: g.num("force_max_mn"),
            slew_max_mn_s: g.num("slew_max_mn_s"),
            hold_cap_mn: g.num("hold_cap_mn"),
            travel_min_um: g.num("travel_min_um"),
            travel_max_um: g.num("travel_max_um"),
        },
        firmware: Firmware {
            major: g.num("fw_major"),
            minor: g.num("fw_minor"),
            patch: g.num("fw_patch"),
        },
        reset: ResetReason::from_code(g.num("reset")),
        state: DeviceState::from_code(g.num("state")),
        fault: FaultCode(g.num("fault")),
        channels,
        channel_count,
    }
}

fn to_device(kind: Kind, g: &mut Given, frame: &Frame<'_>) -> Vec<u8> {
    match kind {
        Kind::HELLO => message!(
            frame,
            Hello::parse,
            Hello {
                versions: Versions { min: g.num("min"), max: g.num("max") },
                max_rx: g.num("max_rx"),
                caps: g.num("caps"),
                time_us: g.num("time_us"),
            }
        ),
        Kind::CONFIG => message!(frame, Config::parse, config(g)),
        Kind::PING => message!(frame, Ping::parse, Ping { t1_us: g.num("t1_us") }),
        Kind::GRIP => message!(
            frame,
            Grip::parse,
            Grip {
                cmd_id: g.num("cmd_id"),
                mode: g.num("mode"),
                flags: g.num("flags"),
                ttl_ms: g.num("ttl_ms"),
                force_mn: g.num("force_mn"),
                slew_mn_s: g.num("slew_mn_s"),
                cause_sample: g.num("cause_sample"),
            }
        ),
        Kind::HEARTBEAT => message!(
            frame,
            Heartbeat::parse,
            Heartbeat {
                turns: g.num("turns"),
                longest_us: g.num("longest_us"),
                late: g.num("late"),
                flags: g.num("flags"),
            }
        ),
        Kind::CLEAR_FAULT => {
            message!(frame, ClearFault::parse, ClearFault { fault: FaultCode(g.num("fault")) })
        }
        _ => Vec::new(),
    }
}

fn answers(kind: Kind, g: &mut Given, frame: &Frame<'_>) -> Vec<u8> {
    match kind {
        Kind::IDENT => message!(frame, Ident::parse, ident(g)),
        Kind::CONFIG_ACK => message!(
            frame,
            ConfigAck::parse,
            ConfigAck {
                seq: g.num("config_seq"),
                clamped: Clamped(g.num("clamped")),
                config: config(g),
            }
        ),
        Kind::PONG => message!(
            frame,
            Pong::parse,
            Pong { t1_us: g.num("t1_us"), rx_tick: g.num("rx_tick"), tx_tick: g.num("tx_tick") }
        ),
        Kind::ACK => message!(
            frame,
            Ack::parse,
            Ack { kind: Kind(g.num("kind")), seq: g.num("request_seq") }
        ),
        Kind::NACK => message!(
            frame,
            Nack::parse,
            Nack {
                kind: Kind(g.num("kind")),
                reason: NackReason::from_code(g.num("reason")),
                seq: g.num("request_seq"),
            }
        ),
        _ => reports(kind, g, frame),
    }
}

fn reports(kind: Kind, g: &mut Given, frame: &Frame<'_>) -> Vec<u8> {
    match kind {
        Kind::SAMPLES => samples(g, frame),
        Kind::STATUS => message!(
            frame,
            Status::parse,
            Status {
                last_cmd_id: g.num("last_cmd_id"),
                state: DeviceState::from_code(g.num("state")),
                clamp: ForceClamp(g.num("clamp")),
                fault: FaultCode(g.num("fault")),
                applied_mn: g.num("applied_mn"),
                target_mn: g.num("target_mn"),
                age_us: g.num("age_us"),
                flags: StatusFlags(g.num("flags")),
                rejected: g.num("rejected"),
            }
        ),
        Kind::STATS => message!(frame, Stats::parse, stats(g)),
        Kind::EVENT => message!(
            frame,
            Event::parse,
            Event {
                tick: g.num("tick"),
                kind: EventKind::from_code(g.num("kind")),
                before: DeviceState::from_code(g.num("before")),
                after: DeviceState::from_code(g.num("after")),
                fault: FaultCode(g.num("fault")),
                dropped: g.num("dropped"),
                value: g.num("value"),
            }
        ),
        Kind::LOG => {
            let text = g.bytes("text");
            let level = LogLevel::from_code(g.num("level"));
            message!(frame, Log::parse, Log { tick: g.num("tick"), level, text: &text })
        }
        other => panic!("{other:?} is not a message to the host"),
    }
}

fn stats(g: &mut Given) -> Stats {
    let mut stats = Stats {
        sent: g.num("sent"),
        dropped_batches: g.num("dropped_batches"),
        dropped_rows: g.num("dropped_rows"),
        malformed: g.num("malformed"),
        old: g.num("old"),
        refused: g.num("refused"),
        unanswered: g.num("unanswered"),
        ..Stats::default()
    };
    let c = &mut stats.received;
    c.ok = g.num("ok");
    c.too_long = g.num("too_long");
    c.cobs = g.num("cobs");
    c.length = g.num("length");
    c.crc = g.num("crc");
    c.echo = g.num("echo");
    c.version = g.num("version");
    c.stale = g.num("stale");
    c.duplicate = g.num("duplicate");
    c.unknown = g.num("unknown");
    c.gap = g.num("gap");
    c.garbage_bytes = g.num("garbage_bytes");
    stats
}

fn samples(g: &mut Given, frame: &Frame<'_>) -> Vec<u8> {
    let format: u8 = g.num("format");
    let text = g.text("rows");
    let (bytes, elements) = row_bytes(&text, format);
    let header = SamplesHeader {
        first_index: g.num("first_index"),
        t0_tick: g.num("t0_tick"),
        dt_ticks: g.num("dt_ticks"),
        rows: g.num("n"),
        format: SampleFormat::from_code(format).unwrap(),
        dropped_total: g.num("dropped_total"),
    };
    let channel = Channel {
        count: u8::try_from(elements).unwrap(),
        ..Channel::single(ChannelKind::PressureArray, 1.0)
    };
    let layout = Layout::new(&[channel], 1);
    let samples = Samples::parse(frame.payload, &layout).unwrap();
    assert_eq!(samples.header, header);
    assert_eq!(samples.rows().count(), usize::from(header.rows));
    let elements_of_all = &frame.payload[20..20 + bytes.len()];
    assert_eq!(row_text(elements_of_all, format, elements), text);
    let mut payload = written(|p| header.write(p));
    payload.extend(bytes);
    payload
}

#[test]
fn cobs_blocks_are_byte_exact() {
    let mut seen = 0;
    for [name, usage, direction, _, _, fields, wire] in rows::<7>("valid.tsv") {
        if direction != "cobs" {
            continue;
        }
        let data = Given::new(&fields).bytes("data");
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
fn frames_are_byte_exact() {
    let mut kinds = std::collections::HashSet::new();
    for [name, usage, direction, message, head, fields, wire] in rows::<7>("valid.tsv") {
        if direction == "cobs" {
            continue;
        }
        let (way, role) = match direction.as_str() {
            "to_device" => (Direction::ToDevice, Role::Device),
            _ => (Direction::ToHost, Role::Host),
        };
        let mut head = Given::new(&head);
        let header = Header {
            version: head.num("version"),
            ack_req: head.num::<u8>("ack_req") == 1,
            ..Header::new(way, kind(&message), head.num("seq"), head.num("session"))
        };
        head.finish();
        let bytes = unhex(&wire);
        let mut decoder = Decoder::new(role);
        decoder.open_session(header.session, None);
        let mut input = &bytes[..];
        let Some(Verdict::Frame(frame)) = decoder.next(&mut input) else { panic!("{name}") };
        assert_eq!(frame.header, header, "{name}");
        let read = |frame: &Frame<'_>| {
            let mut given = Given::new(&fields);
            let payload = match way {
                Direction::ToDevice => to_device(header.kind, &mut given, frame),
                Direction::ToHost => answers(header.kind, &mut given, frame),
            };
            given.finish();
            payload
        };
        let payload = read(&frame);
        // What a later version appends is ignored.
        let longer = [frame.payload, &[0xEE; 9]].concat();
        assert_eq!(read(&Frame { payload: &longer, ..frame }), payload, "{name}");
        if usage == "both" {
            let mut out = [0; MAX_WIRE];
            let len = encode(&header, &payload, &mut out).unwrap();
            assert_eq!(hex(&out[..len]), wire, "{name}");
        }
        kinds.insert(header.kind.0);
    }
    assert_eq!(kinds.len(), 19, "every message at least once");
}
