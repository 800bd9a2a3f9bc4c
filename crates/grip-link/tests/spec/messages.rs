//! The screen of messages against the types of the crate.

use crate::fields::frames;
use crate::markdown::{Row, headings, table};
use grip_link::message::daemon::{
    Command, Estimates, Gripper, Health, Load, Notice, Object, PipelineState, ROWS_HEADER, Setup,
    SlipReport, Subscribe, Welcome,
};
use grip_link::message::{
    Ack, ClearFault, Config, ConfigAck, Event, Grip, Heartbeat, Hello, Ident, Kind, Nack, Ping,
    Pong, SAMPLES_HEADER, Stats, Status,
};
use std::collections::BTreeMap;

const SCREEN: &str = "## 4 Messages on one screen";
const DAEMON: &str = "### Messages of the daemon on one screen";

/// Both screens: that of the serial line and that of the daemon's socket.
pub(crate) fn screens() -> Vec<Row> {
    [table(SCREEN), table(DAEMON)].concat()
}

/// Bytes of the smallest payload of a type.
fn size(kind: Kind) -> usize {
    match kind {
        Kind::HELLO => Hello::SIZE,
        Kind::IDENT => Ident::TABLE,
        Kind::CONFIG => Config::SIZE,
        Kind::CONFIG_ACK => ConfigAck::SIZE,
        Kind::START | Kind::STOP | Kind::ESTOP => 0,
        Kind::PING => Ping::SIZE,
        Kind::PONG => Pong::SIZE,
        Kind::GRIP => Grip::SIZE,
        Kind::HEARTBEAT => Heartbeat::SIZE,
        Kind::CLEAR_FAULT => ClearFault::SIZE,
        Kind::ACK => Ack::SIZE,
        Kind::NACK => Nack::SIZE,
        Kind::SAMPLES => SAMPLES_HEADER,
        Kind::STATUS => Status::SIZE,
        Kind::STATS => Stats::SIZE,
        Kind::EVENT => Event::SIZE,
        Kind::LOG => 10,
        Kind::WELCOME => Welcome::SIZE,
        Kind::SLIP => SlipReport::SIZE,
        Kind::STATE => PipelineState::SIZE,
        Kind::HEALTH => Health::SIZE,
        Kind::GRIPPER => Gripper::SIZE,
        Kind::ROWS => ROWS_HEADER,
        Kind::NOTICE => Notice::SIZE,
        Kind::SETUP => Setup::SIZE,
        Kind::SUBSCRIBE => Subscribe::SIZE,
        Kind::COMMAND => Command::SIZE,
        Kind::QUERY => 0,
        Kind::LOAD => Load::SIZE,
        Kind::OBJECT => Object::SIZE,
        Kind::SHADOW => Load::SIZE,
        Kind::ESTIMATES => Estimates::SIZE,
        Kind(other) => panic!("type {other:02x} has no size here"),
    }
}

#[test]
fn each_type_of_the_crate_has_its_row_and_section() {
    let rows = table(SCREEN);
    let code = |row: &[String]| u8::from_str_radix(&row[0], 16).unwrap();
    let known = (0..=255).map(Kind).filter(|kind| kind.is_to_device() || kind.is_to_host());
    let known: Vec<u8> = known.map(|kind| kind.0).collect();
    assert_eq!(rows.iter().map(|row| code(row)).collect::<Vec<_>>(), known);
    let of_clients =
        |kind: &Kind| kind.is_to_daemon() || (kind.is_to_client() && !kind.is_to_host());
    let known: Vec<u8> = (0..=255).map(Kind).filter(of_clients).map(|kind| kind.0).collect();
    let screen = table(DAEMON);
    assert_eq!(screen.iter().map(|row| code(row)).collect::<Vec<_>>(), known);
    let rows = screens();
    let named: BTreeMap<&str, u8> = Kind::ALL.iter().map(|(name, kind)| (*name, kind.0)).collect();
    let written: BTreeMap<&str, u8> = rows.iter().map(|row| (row[1].as_str(), code(row))).collect();
    assert_eq!(written, named);
    for row in &rows {
        let heading = format!("### {} {}", row[0], row[1]);
        assert_eq!(headings(&heading), [heading.as_str()]);
    }
}

#[test]
fn directions_and_sizes() {
    for row in screens() {
        let kind = Kind(u8::from_str_radix(&row[0], 16).unwrap());
        let way = match kind {
            _ if kind.is_to_device() => "to device",
            _ if kind.is_to_host() => "to host",
            _ if kind.is_to_daemon() => "to daemon",
            _ => "to client",
        };
        assert_eq!(row[2], way, "{}", row[1]);
        let stated: usize = row[3].split(' ').next().unwrap().parse().unwrap();
        assert_eq!(stated, size(kind), "{}", row[1]);
    }
}

#[test]
fn requests_for_an_answer() {
    let mut asks = BTreeMap::new();
    for frame in frames() {
        asks.entry(frame.name).or_insert(frame.ack_req);
    }
    for row in screens() {
        assert_eq!(row[4] == "yes", asks[&row[1]], "{}", row[1]);
    }
}
