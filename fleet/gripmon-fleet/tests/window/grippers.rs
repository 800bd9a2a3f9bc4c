//! Made-up grippers of a network, filled into a roster by hand.

use grip_fleet::wire;
use grip_link::message::daemon::{GripState, Health, LinkState, PipelineState, Scene};
use grip_link::message::{DeviceState, Kind};
use gripmon_fleet::grippers::{FleetFeed, Member, Message, Received, Roster, Uid};
use slip_core::units::Micros;

/// A gripper of a hall.
pub(crate) fn member(site: &str, number: u16) -> Member {
    let mut uid = [0x5a; 16];
    uid[14..].copy_from_slice(&number.to_be_bytes());
    Member { site: site.parse().unwrap(), uid: Uid(uid) }
}

pub(crate) fn message(kind: Kind, write: impl FnOnce(&mut [u8]) -> usize) -> Received {
    Received::Message(Message::from_wire(&wire(kind, write)).unwrap())
}

/// A gripper that holds an object with this force.
pub(crate) fn state(applied_n: f32) -> PipelineState {
    PipelineState {
        t: Micros(1_000_000),
        scene: Scene::Holding,
        grip: GripState::Holding,
        device: DeviceState::from_code(2),
        statistic: Some(0.25),
        command_n: Some(5.0),
        applied_n: Some(applied_n),
        rate_hz: 1000,
        ..PipelineState::UNKNOWN
    }
}

pub(crate) fn reported(state: &PipelineState) -> Received {
    message(Kind::STATE, |out| state.write(out).unwrap())
}

pub(crate) fn health(slips: u32) -> Received {
    health_of(slips, 0)
}

pub(crate) fn health_of(slips: u32, lost: u64) -> Received {
    let health = Health { link: LinkState::Stream, slips, lost, ..Health::default() };
    message(Kind::HEALTH, |out| health.write(out).unwrap())
}

pub(crate) fn of(member: &Member, at_s: f64, what: Received) -> FleetFeed {
    FleetFeed::Of { member: member.clone(), at_s, what }
}

/// So many grippers with three minutes of curves.
pub(crate) fn many(count: u16) -> Roster {
    let mut roster = Roster::default();
    for number in 0..count {
        let member = member(if number.is_multiple_of(2) { "hall-1" } else { "hall-2" }, number);
        roster.take(of(&member, 0.0, Received::Came));
        for second in 0..200_u16 {
            let wave = (f32::from(second) * 0.1 + f32::from(number)).sin();
            let statistic = Some(10_f32.powf(wave));
            let state = PipelineState { statistic, ..state(10.0 + 5.0 * wave) };
            roster.take(of(&member, f64::from(second), reported(&state)));
        }
        roster.take(of(&member, 200.0, health(u32::from(number))));
    }
    roster
}
