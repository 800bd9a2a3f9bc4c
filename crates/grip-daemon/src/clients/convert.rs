//! Items of the hot thread in, messages for clients out.

use crate::{LinkNote, State as PipelineState};
use grip_host::report::{EventLine, EvidenceFields};
use grip_link::host::{CloseReason, HostState};
use grip_link::message::daemon::{
    EscKind, EscValue, GripStage, LinkState, Method, Phase, SceneCode, Sensor, SensorHealth, Slip,
    SpeedSource, State,
};
use grip_link::message::{DeviceState, EventKind, FaultCode};
use slip_core::{
    detector::ReferenceHealth,
    distance::TravelHealth,
    esc::{Esc, Flags, Reading},
    grip::GripState,
    health::Health,
    pressure::PressureHealth,
    scene::Scene,
};

/// SLIP of an event line, numbered by the caller; `None` for the other lines.
#[must_use]
pub fn slip(host_us: u64, line: &EventLine) -> Option<Slip> {
    match *line {
        EventLine::Slip {
            t_s,
            phase,
            method,
            statistic,
            confidence,
            certified_interval_s,
            ruled_out,
            possible,
            evidence,
            ..
        } => Some(Slip {
            phase: if phase == "gross" { Phase::Gross } else { Phase::Incipient },
            method: named(method, Method::from_code, Method::name).unwrap_or(Method::None),
            statistic: Some(statistic),
            confidence: Some(confidence),
            certified_s: certified_interval_s,
            ruled_out: ruled_out.bits(),
            possible: possible.bits(),
            ..known(host_us, t_s, &evidence)
        }),
        EventLine::SlipEnd { t_s, duration_s, certified_interval_s, evidence, .. } => Some(Slip {
            phase: Phase::Ended,
            certified_s: certified_interval_s,
            duration_s: Some(single(duration_s)),
            ..known(host_us, t_s, &evidence)
        }),
        EventLine::Grip { .. } | EventLine::Health { .. } => None,
    }
}

/// What event lines and messages have in common.
fn known(host_us: u64, t_s: f64, evidence: &EvidenceFields) -> Slip {
    let source = evidence
        .speed_source
        .and_then(|text| named(text, SpeedSource::from_code, SpeedSource::name));
    let reading =
        evidence.esc_reading.and_then(|text| named(text, EscKind::from_code, EscKind::name));
    let notes = if evidence.esc_informative == Some(true) { Slip::INFORMATIVE } else { 0 }
        | if evidence.extrapolated == Some(true) { Slip::EXTRAPOLATED } else { 0 };
    Slip {
        number: 0,
        device_us: micros(t_s),
        host_us,
        phase: Phase::Ended,
        method: Method::None,
        speed_source: source.unwrap_or(SpeedSource::None),
        esc_kind: reading.unwrap_or(EscKind::None),
        statistic: None,
        confidence: None,
        speed_m_s: evidence.speed_m_s,
        sigma_m_s: evidence.speed_sigma_m_s,
        moved_m: evidence.moved_m,
        irregularities: evidence.irregularities,
        esc_w: evidence.esc_w.map(single),
        esc_chosen: evidence.esc_value.map(single),
        esc_flags: evidence.esc_flags.map_or(0, flag_bits),
        notes,
        ruled_out: 0,
        possible: 0,
        estimate_n: evidence.estimate_n,
        command_n: evidence.command_n,
        duration_s: None,
        certified_s: None,
    }
}

/// STATE; what the gripper told of itself comes from its last STATUS.
#[must_use]
pub fn state(host_us: u64, state: &PipelineState, device: DeviceState, fault: FaultCode) -> State {
    let extrapolated = state.estimate.is_some_and(|estimate| estimate.extrapolated);
    let informative = state.esc.is_some_and(|esc| esc.informative());
    State {
        device_us: state.t.0,
        host_us,
        scene: scene(state.scene),
        grip: state.grip.map_or(GripStage::Observing, grip),
        sensors: [
            stylus(state.health),
            travel(state.travel_health),
            pressure(state.pressure_health),
            reference(state.reference_health),
        ],
        device,
        notes: if informative { Slip::INFORMATIVE } else { 0 }
            | if extrapolated { Slip::EXTRAPOLATED } else { 0 },
        fault,
        esc: state.esc.map_or(EscValue { kind: EscKind::None, value: None, flags: 0 }, esc),
        statistic: Some(state.statistic),
        command_n: state.command.map(|command| command.0),
        applied_n: state.applied_n,
        estimate_n: state.estimate.map(|estimate| estimate.force_n),
        rate_hz: state.rate_hz,
        lost: state.lost,
        late_ms: state.late_ms,
    }
}

/// E_sc as STATE tells it.
#[must_use]
pub fn esc(esc: Esc) -> EscValue {
    let kind = match esc.reading {
        Reading::Literal => EscKind::Literal,
        Reading::ArcCot => EscKind::ArcCot,
        Reading::SlopePower => EscKind::SlopePower,
        Reading::LiftWork => EscKind::LiftWork,
        Reading::ViscousWork => EscKind::ViscousWork,
    };
    EscValue { kind, value: Some(single(esc.value)), flags: flag_bits(esc.flags) }
}

fn flag_bits(flags: Flags) -> u8 {
    flags.iter().fold(0, |bits, flag| bits | 1 << flag as u8)
}

fn scene(scene: Scene) -> SceneCode {
    match scene {
        Scene::Idle => SceneCode::Idle,
        Scene::Moving => SceneCode::Moving,
        Scene::Holding => SceneCode::Holding,
        Scene::Slipping => SceneCode::Slipping,
    }
}

fn grip(grip: GripState) -> GripStage {
    match grip {
        GripState::Open => GripStage::Open,
        GripState::Closing => GripStage::Closing,
        GripState::Settling => GripStage::Settling,
        GripState::Holding => GripStage::Holding,
        GripState::Slipping => GripStage::Slipping,
        GripState::Fault => GripStage::Fault,
        GripState::Released => GripStage::Released,
    }
}

fn stylus(health: Health) -> SensorHealth {
    match health {
        Health::Good => SensorHealth::Good,
        Health::Frozen => SensorHealth::Frozen,
        Health::Saturated => SensorHealth::Saturated,
        Health::Failed => SensorHealth::Failed,
        Health::Drifting => SensorHealth::Drifting,
        Health::Doubted => SensorHealth::Doubted,
    }
}

fn travel(health: TravelHealth) -> SensorHealth {
    match health {
        TravelHealth::Good => SensorHealth::Good,
        TravelHealth::Jumped => SensorHealth::Jumped,
        TravelHealth::Frozen => SensorHealth::Frozen,
        TravelHealth::Backwards => SensorHealth::Backwards,
        TravelHealth::Doubted => SensorHealth::Doubted,
        TravelHealth::Coarse => SensorHealth::Coarse,
    }
}

fn pressure(health: PressureHealth) -> SensorHealth {
    match health {
        PressureHealth::Good => SensorHealth::Good,
        PressureHealth::Frozen => SensorHealth::Frozen,
        PressureHealth::Failed => SensorHealth::Failed,
    }
}

fn reference(health: ReferenceHealth) -> SensorHealth {
    match health {
        ReferenceHealth::Good => SensorHealth::Good,
        ReferenceHealth::Frozen => SensorHealth::Frozen,
        ReferenceHealth::Lost => SensorHealth::Lost,
        ReferenceHealth::Late => SensorHealth::Late,
        ReferenceHealth::Uncoupled => SensorHealth::Uncoupled,
    }
}

/// Sensor and its health, by the names of an event line.
pub(super) fn sensor(channel: &str, health: &str) -> Option<(Sensor, SensorHealth)> {
    Some((
        named(channel, Sensor::from_code, Sensor::name)?,
        named(health, SensorHealth::from_code, SensorHealth::name)?,
    ))
}

/// State of the link, as clients hear it.
#[must_use]
pub fn link(state: HostState) -> LinkState {
    match state {
        HostState::Closed => LinkState::Closed,
        HostState::Open => LinkState::Open,
        HostState::Hello => LinkState::Hello,
        HostState::Config => LinkState::Config,
        HostState::Stream => LinkState::Stream,
        HostState::Degraded => LinkState::Degraded,
    }
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
                _ => format!("gripper: {:?} -> {:?}", event.before, event.after),
            }
        }
        LinkNote::Refused(nack) => {
            format!("the gripper refused type {:02x}: {:?}", nack.kind.0, nack.reason)
        }
        LinkNote::Closed(reason) => format!("link closed: {}", closed(*reason)),
        LinkNote::Late(late_us) => {
            format!("readings were {} ms late, the force was not raised", late_us / 1000)
        }
        LinkNote::PortOpened => "the port is open".to_owned(),
        LinkNote::PortLost => "the port is gone".to_owned(),
    })
}

fn closed(reason: CloseReason) -> String {
    match reason {
        CloseReason::NoAnswer { bytes: 0, .. } => "nobody answered".to_owned(),
        CloseReason::NoAnswer { bytes, .. } => format!("nobody answered, {bytes} bytes came"),
        CloseReason::VersionMismatch { min, max } => format!("it speaks versions {min} to {max}"),
        other => format!("{other:?}"),
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The known code whose name is `text`.
fn named<T: Copy>(text: &str, from: fn(u8) -> T, name: fn(T) -> &'static str) -> Option<T> {
    (0..16).map(from).find(|code| name(*code) == text)
}

#[expect(clippy::cast_possible_truncation, reason = "told with seven digits")]
fn single(value: f64) -> f32 {
    value as f32
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn micros(t_s: f64) -> u64 {
    (t_s * 1e6).round() as u64
}
