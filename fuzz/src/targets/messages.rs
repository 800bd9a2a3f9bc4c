//! Payload bytes of every type: what can be read is written back, reads the same again, and writes the same bytes again.
//!
//! Input: the type, then the payload.

use super::gripper::ident;
use core::fmt::Debug;
use grip_link::frame::{Direction, Frame, Header, MAX_PAYLOAD};
use grip_link::message::daemon::{
    Appended, Command, Gripper, Health, Load, Notice, PipelineState, RowSet, Rows, Setup,
    SlipReport, Subscribe, ToClient, ToDaemon, Welcome,
};
use grip_link::message::{
    Ack, ClearFault, Config, ConfigAck, Event, Grip, Heartbeat, Hello, Ident, Kind, Layout, Log,
    Nack, PayloadError, Ping, Pong, Samples, SamplesHeader, Stats, Status, ToDevice,
};

type Written = Result<usize, PayloadError>;

/// decode(encode(x)) = x for every x that can be read, and encode(decode(b)) is stable.
fn round<'a, T: PartialEq + Debug>(
    payload: &'a [u8],
    out: &'a mut [u8; MAX_PAYLOAD],
    parse: impl Fn(&'a [u8]) -> Result<T, PayloadError>,
    write: impl Fn(&T, &mut [u8]) -> Written,
) {
    let Ok(message) = parse(payload) else { return };
    let len = write(&message, &mut out[..]).unwrap();
    let mut second = [0; MAX_PAYLOAD];
    assert_eq!(write(&message, &mut second), Ok(len));
    for short in 0..len {
        assert_eq!(write(&message, &mut second[..short]), Err(PayloadError::Full { have: short }));
    }
    let out: &'a [u8; MAX_PAYLOAD] = out;
    assert_eq!(parse(&out[..len]).as_ref(), Ok(&message), "decode(encode(x)) = x");
    assert!(len == 0 || parse(&out[..len - 1]).is_err(), "a byte short is refused");
    assert_eq!(parse(&out[..]).as_ref(), Ok(&message), "what is appended is ignored");
    let again = parse(&out[..len]).unwrap();
    let mut third = [0; MAX_PAYLOAD];
    assert_eq!(write(&again, &mut third), Ok(len));
    assert_eq!(third[..len], out[..len], "encode(decode(b)) is stable");
}

macro_rules! rounds {
    ($kind:expr, $payload:expr, $($code:ident => $message:ty),+ $(,)?) => {
        match $kind {
            $(Kind::$code => round($payload, &mut [0; MAX_PAYLOAD], <$message>::parse, <$message>::write),)+
            Kind::LOG => {
                let mut out = [0; MAX_PAYLOAD];
                round($payload, &mut out, Log::parse, |log, out| log.write(out));
            }
            Kind::SAMPLES => {
                round($payload, &mut [0; MAX_PAYLOAD], SamplesHeader::parse, SamplesHeader::write);
                samples($payload);
            }
            Kind::WELCOME => {
                let mut out = [0; MAX_PAYLOAD];
                round($payload, &mut out, Welcome::parse, |welcome, out| welcome.write(out));
            }
            Kind::NOTICE => {
                let mut out = [0; MAX_PAYLOAD];
                round($payload, &mut out, Notice::parse, |notice, out| notice.write(out));
            }
            Kind::SETUP => {
                let mut out = [0; MAX_PAYLOAD];
                round($payload, &mut out, Setup::parse, |setup, out| setup.write(out));
            }
            Kind::LOAD => {
                let mut out = [0; MAX_PAYLOAD];
                round($payload, &mut out, Load::parse, |load, out| load.write(out));
            }
            Kind::HEALTH => health($payload),
            Kind::SLIP => {
                let (size, whole) = (SlipReport::SIZE, SlipReport::WHOLE);
                let older = |slip: &SlipReport| SlipReport { certified_s: None, ..*slip };
                grown($payload, size, whole, SlipReport::parse, SlipReport::write, older)
            }
            Kind::STATE => {
                let (size, whole) = (PipelineState::SIZE, PipelineState::WHOLE);
                let older = |state: &PipelineState| PipelineState { late_ms: None, ..*state };
                grown($payload, size, whole, PipelineState::parse, PipelineState::write, older)
            }
            Kind::ROWS => {
                let mut out = [0; MAX_PAYLOAD];
                round($payload, &mut out, Rows::parse, |rows, out| rows.write(out));
                rows($payload);
            }
            _ => {}
        }
    };
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

/// What was appended is all there or not at all, and is written only where it was.
fn health(payload: &[u8]) {
    let Ok(message) = Health::parse(payload) else { return };
    let (mut out, mut second) = ([0; MAX_PAYLOAD], [0; MAX_PAYLOAD]);
    let len = message.write(&mut out).unwrap();
    let whole = Health::SIZE + Appended::SIZE;
    assert_eq!(message.appended.is_some(), payload.len() >= whole);
    assert_eq!(len, if message.appended.is_some() { whole } else { Health::SIZE });
    for short in 0..len {
        assert_eq!(message.write(&mut second[..short]), Err(PayloadError::Full { have: short }));
    }
    let again = Health::parse(&out[..len]);
    assert_eq!(again.as_ref(), Ok(&message), "decode(encode(x)) = x");
    assert!(Health::parse(&out[..Health::SIZE - 1]).is_err(), "a byte short is refused");
    assert_eq!(again.unwrap().write(&mut second), Ok(len));
    assert_eq!(second[..len], out[..len], "encode(decode(b)) is stable");
    let first = Health { appended: None, ..message };
    assert_eq!(Health::parse(&out[..whole.min(len) - usize::from(len == whole)]), Ok(first));
}

/// A message of `size` without and of `whole` with a last field, which is written where it is known. `older` is the message without it.
fn grown<T: PartialEq + Debug>(
    payload: &[u8],
    size: usize,
    whole: usize,
    parse: impl Fn(&[u8]) -> Result<T, PayloadError>,
    write: impl Fn(&T, &mut [u8]) -> Written,
    older: impl Fn(&T) -> T,
) {
    let Ok(message) = parse(payload) else { return };
    let (mut out, mut second) = ([0; MAX_PAYLOAD], [0; MAX_PAYLOAD]);
    let len = write(&message, &mut out).unwrap();
    let without = older(&message);
    assert_eq!(len, if message == without { size } else { whole });
    assert!(message == without || payload.len() >= whole);
    for short in 0..len {
        assert_eq!(write(&message, &mut second[..short]), Err(PayloadError::Full { have: short }));
    }
    assert_eq!(parse(&out[..len]).as_ref(), Ok(&message), "decode(encode(x)) = x");
    assert!(parse(&out[..size - 1]).is_err(), "a byte short is refused");
    for short in size..len {
        assert_eq!(parse(&out[..short]).as_ref(), Ok(&without));
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
    rounds!(
        kind, payload,
        HELLO => Hello, CONFIG => Config, PING => Ping, GRIP => Grip, HEARTBEAT => Heartbeat,
        CLEAR_FAULT => ClearFault, IDENT => Ident, CONFIG_ACK => ConfigAck, PONG => Pong, ACK => Ack,
        NACK => Nack, STATUS => Status, STATS => Stats, EVENT => Event,
        GRIPPER => Gripper, SUBSCRIBE => Subscribe, COMMAND => Command,
    );
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
