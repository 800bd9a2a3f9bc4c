//! Payload bytes of every type: what can be read is written back, reads the same again, and writes the same bytes again.
//!
//! Input: the type, then the payload.

use super::gripper::ident;
use grip_link::frame::{Direction, Frame, Header, MAX_PAYLOAD};
use grip_link::message::daemon::{
    Command, Estimates, Gripper, Health, Load, Notice, Object, PipelineState, RowSet, Rows, Setup,
    SlipReport, Subscribe, ToClient, ToDaemon, Welcome,
};
use grip_link::message::{
    Ack, ClearFault, Config, ConfigAck, Event, Grip, Heartbeat, Hello, Ident, Kind, Layout, Log,
    Nack, PayloadError, Ping, Pong, Samples, SamplesHeader, Stats, Status, ToDevice,
};

macro_rules! messages {
    ($kind:ident, $payload:ident, $out:ident; $($code:ident => $message:ident),+ $(,)?) => {
        match $kind {
            $(Kind::$code => $message::parse($payload)?.write($out),)+
            Kind::START | Kind::STOP | Kind::ESTOP | Kind::QUERY => Ok(0),
            Kind(kind) => Err(PayloadError::Kind { kind }),
        }
    };
}

/// Reads a payload and writes it again, of SAMPLES the header: its length.
pub fn again(kind: Kind, payload: &[u8], out: &mut [u8]) -> Result<usize, PayloadError> {
    messages! {
        kind, payload, out;
        HELLO => Hello, CONFIG => Config, PING => Ping, GRIP => Grip, HEARTBEAT => Heartbeat,
        CLEAR_FAULT => ClearFault, IDENT => Ident, CONFIG_ACK => ConfigAck, PONG => Pong, ACK => Ack,
        NACK => Nack, SAMPLES => SamplesHeader, STATUS => Status, STATS => Stats, EVENT => Event,
        LOG => Log, WELCOME => Welcome, SLIP => SlipReport, STATE => PipelineState, HEALTH => Health,
        GRIPPER => Gripper, ROWS => Rows, NOTICE => Notice, SETUP => Setup, SUBSCRIBE => Subscribe,
        COMMAND => Command, LOAD => Load, OBJECT => Object, SHADOW => Load, ESTIMATES => Estimates,
    }
}

/// What can be read is written, and reads and writes the same again; of what was appended as much is there as was known.
fn round(kind: Kind, payload: &[u8]) {
    let (mut out, mut second) = ([0; MAX_PAYLOAD], [0; MAX_PAYLOAD]);
    let Ok(len) = again(kind, payload, &mut out) else { return };
    for short in 0..len {
        let full = again(kind, payload, &mut second[..short]);
        assert_eq!(full, Err(PayloadError::Full { have: short }));
    }
    assert_eq!(again(kind, &out[..len], &mut second), Ok(len));
    assert_eq!(second[..len], out[..len], "encode(decode(b)) is stable");
    let (first, whole) = kind.sizes();
    if first == whole {
        assert!(len == 0 || again(kind, &out[..len - 1], &mut second).is_err(), "a byte short");
        assert_eq!(again(kind, &out, &mut second), Ok(len), "what is appended is ignored");
        return;
    }
    assert!((first..=whole).contains(&len) && len <= payload.len());
    assert!(again(kind, &out[..first - 1], &mut second).is_err(), "a byte short is refused");
    for short in first..len {
        let kept = again(kind, &out[..short], &mut second).unwrap_or_default();
        assert!((first..=short).contains(&kept), "{kept} of {short} bytes");
        assert_eq!(second[..kept], out[..kept], "without what was appended later");
    }
}

/// Every row of a batch can be read, and there are as many as its header states.
fn samples(payload: &[u8]) {
    let described = ident(1);
    for mask in 0..8 {
        let layout = Layout::new(described.channels(), mask);
        let Ok(samples) = Samples::parse(payload, &layout) else { continue };
        assert_eq!(samples.rows().count(), samples.len());
        let first = samples.header.first_index;
        for (k, row) in (0..).zip(samples.rows()) {
            assert_eq!(row.index, first.wrapping_add(k));
            for column in layout.columns() {
                for element in 0..column.count {
                    assert!(row.value(column, element).is_some());
                }
                assert_eq!(row.value(column, column.count), None);
            }
        }
    }
}

/// As many rows as the header states, each with a value for each of its channels and taxels and for no other.
fn rows(payload: &[u8]) {
    let Ok(rows) = Rows::parse(payload) else { return };
    assert_eq!(rows.iter().len(), usize::from(rows.header.rows));
    for row in rows.iter() {
        for bit in 0..16 {
            let channel = RowSet(1 << bit);
            let there = rows.header.channels.0 & channel.0 != 0;
            assert_eq!(row.value(channel).is_some(), there);
        }
        let taxels = usize::from(rows.header.taxels);
        assert!(taxels == 0 || row.taxel(taxels - 1).is_some());
        assert_eq!(row.taxel(taxels), None);
    }
}

/// The target.
pub fn check(data: &[u8]) {
    let Some((&kind, payload)) = data.split_first() else { return };
    let payload = &payload[..payload.len().min(MAX_PAYLOAD)];
    let kind = Kind(kind);
    round(kind, payload);
    match kind {
        Kind::SAMPLES => samples(payload),
        Kind::ROWS => rows(payload),
        _ => {}
    }
    let header = Header::new(Direction::ToDevice, kind, 0, 1);
    let parsed = ToDevice::parse(&Frame { header, payload });
    let known = kind.is_to_device();
    assert_eq!(matches!(parsed, Err(PayloadError::Kind { .. })), !known);
    let frame = Frame { header, payload };
    let parsed = ToDaemon::parse(&frame);
    assert_eq!(matches!(parsed, Err(PayloadError::Kind { .. })), !kind.is_to_daemon());
    if let Ok(ToDaemon::Command(command)) = parsed {
        assert!(command.force_mn >= 0, "a negative force is refused");
    }
    let parsed = ToClient::parse(&frame);
    assert_eq!(matches!(parsed, Err(PayloadError::Kind { .. })), !kind.is_to_client());
}
