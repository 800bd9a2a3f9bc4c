//! Items of the hot thread in, messages for clients out.

use crate::LinkNote;
use grip_host::report::{EventLine, EvidenceFields};
use grip_host::session::explain;
use grip_link::message::daemon::{Method, Phase, Reading, Sensor, SensorHealth, Slip, SpeedSource};
use grip_link::message::{
    EventKind,
    daemon::{EXTRAPOLATED, INFORMATIVE},
};
use slip_core::esc::Flags;

/// SLIP of an event line, numbered by the caller; `None` for the other lines.
#[must_use]
pub fn slip(host_us: u64, line: &EventLine) -> Option<Slip> {
    match *line {
        EventLine::Slip { t_s, phase, method, statistic, confidence, evidence, .. } => Some(Slip {
            phase: if phase == "gross" { Phase::Gross } else { Phase::Incipient },
            method: Method::from_name(method).unwrap_or(Method::None),
            statistic: Some(statistic),
            confidence: Some(confidence),
            ..known(host_us, t_s, &evidence)
        }),
        EventLine::SlipEnd { t_s, duration_s, evidence, .. } => Some(Slip {
            phase: Phase::Ended,
            duration_s: Some(single(duration_s)),
            ..known(host_us, t_s, &evidence)
        }),
        EventLine::Grip { .. } | EventLine::Health { .. } => None,
    }
}

/// What event lines and messages have in common.
fn known(host_us: u64, t_s: f64, evidence: &EvidenceFields) -> Slip {
    let source = evidence.speed_source.and_then(SpeedSource::from_name);
    let reading = evidence.esc_reading.and_then(Reading::from_name);
    let notes = if evidence.esc_informative == Some(true) { INFORMATIVE } else { 0 }
        | if evidence.extrapolated == Some(true) { EXTRAPOLATED } else { 0 };
    Slip {
        number: 0,
        device_us: micros(t_s),
        host_us,
        phase: Phase::Ended,
        method: Method::None,
        speed_source: source.unwrap_or(SpeedSource::None),
        esc_kind: reading.unwrap_or(Reading::None),
        statistic: None,
        confidence: None,
        speed_m_s: evidence.speed_m_s,
        sigma_m_s: evidence.speed_sigma_m_s,
        moved_m: evidence.moved_m,
        irregularities: evidence.irregularities,
        esc_w: evidence.esc_w.map(single),
        esc_chosen: evidence.esc_value.map(single),
        esc_flags: evidence.esc_flags.map_or(0, Flags::bits),
        notes,
        estimate_n: evidence.estimate_n,
        command_n: evidence.command_n,
        duration_s: None,
    }
}

/// Sensor and its health, by the names of an event line.
pub(super) fn sensor(channel: &str, health: &str) -> Option<(Sensor, SensorHealth)> {
    Some((Sensor::from_name(channel)?, SensorHealth::from_name(health)?))
}

/// What people are told of the link; `None` for what STATE and GRIPPER say.
pub(super) fn link_text(note: &LinkNote) -> Option<String> {
    Some(match note {
        LinkNote::State(_) | LinkNote::Status(_) | LinkNote::Configured(_) => return None,
        LinkNote::Identified { uid, rebooted, .. } => {
            let again = if *rebooted { ", restarted" } else { "" };
            format!("gripper {}{again}", hex(uid))
        }
        LinkNote::OtherGripper { uid } => format!("another gripper answered: {}", hex(uid)),
        LinkNote::Rebooted => "the gripper has restarted".to_owned(),
        LinkNote::Device(event) => {
            let fault = event.fault.0;
            match event.kind {
                EventKind::Fault => format!("the gripper has stopped with fault {fault:04x}"),
                EventKind::FaultCleared => format!("the gripper is free of fault {fault:04x}"),
                EventKind::CommandRejected => {
                    format!("the gripper takes no command because of fault {fault:04x}")
                }
                _ => format!("gripper: {} -> {}", event.before, event.after),
            }
        }
        LinkNote::Refused(nack) => {
            format!("the gripper refused type {:02x}: {}", nack.kind.0, nack.reason)
        }
        LinkNote::Closed(reason) => format!("link closed: {}", explain(reason)),
        LinkNote::Late(late_us) => {
            format!("readings were {} ms late, the force was not raised", late_us / 1000)
        }
        LinkNote::PortOpened => "the port is open".to_owned(),
        LinkNote::PortLost => "the port is gone".to_owned(),
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "told with seven digits")]
fn single(value: f64) -> f32 {
    value as f32
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn micros(t_s: f64) -> u64 {
    (t_s * 1e6).round() as u64
}
