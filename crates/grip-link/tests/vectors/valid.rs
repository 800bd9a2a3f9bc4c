//! Fields give the wire bytes, and wire bytes the fields.

use crate::fields::{Given, channels, row_bytes, row_text};
use crate::table::rows;
use crate::targets::gripper::written;
use crate::targets::words::{hex, unhex};
use grip_link::cobs;
use grip_link::decoder::{Counters, Decoder, Role, Verdict};
use grip_link::frame::{Direction, Frame, Header, MAX_WIRE, encode};
use grip_link::message::{
    Ack, Channel, ChannelKind, ClearFault, Config, ConfigAck, Event, Firmware, Grip, Heartbeat,
    Hello, Ident, Kind, Layout, Limits, Log, Nack, Ping, Pong, SampleFormat, Samples,
    SamplesHeader, Stats, Status, Versions,
};

fn kind(name: &str) -> Kind {
    let found = Kind::ALL.iter().find(|(known, _)| *known == name);
    found.unwrap_or_else(|| panic!("no message {name}")).1
}

/// A value with the fields of a list: some made by hand, the others read by their names.
macro_rules! given {
    ($g:ident, $type:ident { $($own:ident: $value:expr),*; $($field:ident),* }) => {
        $type { $($own: $value,)* $($field: $g.num(stringify!($field)),)* }
    };
}

/// The payload that a message with these fields writes; that of the frame reads back as the message.
macro_rules! message {
    ($g:ident, $frame:ident, $type:ident { $($fields:tt)* }) => {{
        let value = given! { $g, $type { $($fields)* } };
        assert_eq!($type::parse($frame.payload), Ok(value));
        written(|p| value.write(p))
    }};
}

fn config(g: &mut Given) -> Config {
    given! { g, Config {
        ; sample_rate_hz, batch, format, ttl_ms, channel_mask, force_max_mn, slew_mn_s, hold_cap_mn,
        loss_after_ms, loss_action
    } }
}

fn versions(g: &mut Given) -> Versions {
    given! { g, Versions { ; min, max } }
}

fn limits(g: &mut Given) -> Limits {
    given! { g, Limits {
        ; rate_max_hz, force_max_mn, slew_max_mn_s, hold_cap_mn, travel_min_um, travel_max_um
    } }
}

fn firmware(g: &mut Given) -> Firmware {
    Firmware { major: g.num("fw_major"), minor: g.num("fw_minor"), patch: g.num("fw_patch") }
}

fn received(g: &mut Given) -> Counters {
    given! { g, Counters {
        ; ok, too_long, cobs, length, crc, echo, version, stale, duplicate, unknown, gap, garbage_bytes
    } }
}

fn to_device(kind: Kind, g: &mut Given, frame: &Frame<'_>) -> Vec<u8> {
    match kind {
        Kind::HELLO => {
            message! { g, frame, Hello { versions: versions(g); max_rx, caps, time_us } }
        }
        Kind::CONFIG => {
            let config = config(g);
            assert_eq!(Config::parse(frame.payload), Ok(config));
            written(|p| config.write(p))
        }
        Kind::PING => message! { g, frame, Ping { ; t1_us } },
        Kind::GRIP => message! {
            g, frame, Grip { ; cmd_id, mode, flags, ttl_ms, force_mn, slew_mn_s, cause_sample }
        },
        Kind::HEARTBEAT => message! { g, frame, Heartbeat { ; turns, longest_us, late, flags } },
        Kind::CLEAR_FAULT => message! { g, frame, ClearFault { ; fault } },
        _ => Vec::new(),
    }
}

fn answers(kind: Kind, g: &mut Given, frame: &Frame<'_>) -> Vec<u8> {
    match kind {
        Kind::IDENT => {
            let (channels, channel_count) = channels(&g.text("channels"));
            let uid = g.bytes("uid").try_into().unwrap();
            message! { g, frame, Ident {
                versions: versions(g), uid: uid, limits: limits(g), firmware: firmware(g),
                channels: channels, channel_count: channel_count;
                max_rx, caps, boot_id, tick_hz, reset, state, fault
            } }
        }
        Kind::CONFIG_ACK => message! {
            g, frame, ConfigAck { seq: g.num("config_seq"), config: config(g); clamped }
        },
        Kind::PONG => message! { g, frame, Pong { ; t1_us, rx_tick, tx_tick } },
        Kind::ACK => message! { g, frame, Ack { seq: g.num("request_seq"); kind } },
        Kind::NACK => message! { g, frame, Nack { seq: g.num("request_seq"); kind, reason } },
        Kind::SAMPLES => samples(g, frame),
        Kind::STATUS => message! { g, frame, Status {
            ; last_cmd_id, state, clamp, fault, applied_mn, target_mn, age_us, flags, rejected
        } },
        Kind::STATS => message! { g, frame, Stats {
            received: received(g);
            sent, dropped_batches, dropped_rows, malformed, old, refused, unanswered
        } },
        Kind::EVENT => message! {
            g, frame, Event { ; tick, kind, before, after, fault, dropped, value }
        },
        Kind::LOG => {
            let text = g.bytes("text");
            message! { g, frame, Log { text: &text; tick, level } }
        }
        other => panic!("{other:?} is not a message to the host"),
    }
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
