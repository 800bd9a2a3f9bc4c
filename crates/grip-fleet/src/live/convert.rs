//! Messages of a daemon in, records of a live view out.

use grip_link::message::daemon::{
    GripStage, Gripper, Health, Method, Notice, Phase, RowOfSample, RowSet, SceneCode, Sensor,
    SensorHealth, Slip, State, Welcome,
};
use grip_record::mcap::{EventRecord, HealthRecord, StateRecord};
use serde_json::{Value, json};
use slip_core::{
    Sample, detector::ReferenceHealth, distance::TravelHealth, grip::GripState, health,
    pressure::PressureHealth, scene::Scene, units::Micros,
};

/// The sample of a row; NaN is no reading.
pub(super) fn sample(row: &RowOfSample<'_>) -> Sample {
    let value = |set| row.value(set).filter(|value: &f32| !value.is_nan());
    Sample {
        t: Micros(row.t_us),
        stylus: row.value(RowSet::STYLUS).unwrap_or(f32::NAN),
        normal_force_n: value(RowSet::NORMAL_FORCE),
        tangential_n: value(RowSet::TANGENTIAL_FORCE),
        travel_m: value(RowSet::TRAVEL),
        velocity_m_s: value(RowSet::VELOCITY),
        second_stylus: value(RowSet::SECOND_STYLUS),
        reference: value(RowSet::REFERENCE),
        pressure: value(RowSet::PRESSURE),
        motion: value(RowSet::MOTION),
        ..Sample::default()
    }
}

/// The state; `None` where it has a code of a later protocol.
pub(super) fn state(state: &State) -> Option<StateRecord> {
    let [stylus, travel, pressure, reference] = state.sensors;
    Some(StateRecord {
        t: Micros(state.device_us),
        scene: scene(state.scene)?,
        grip: grip(state.grip)?,
        health: stylus_health(stylus)?,
        reference_health: reference_health(reference)?,
        travel_health: travel_health(travel)?,
        pressure_health: pressure_health(pressure)?,
        statistic: short(state.statistic),
        command_n: state.command_n,
        applied_n: state.applied_n,
        esc_w: state.esc.value.map(f64::from),
        esc_informative: state.notes & Slip::INFORMATIVE != 0,
        estimate_n: state.estimate_n,
        extrapolated: state.notes & Slip::EXTRAPOLATED != 0,
        lost: state.lost,
        late_ms: state.late_ms,
        rate_hz: state.rate_hz,
    })
}

const fn scene(code: SceneCode) -> Option<Scene> {
    Some(match code {
        SceneCode::Idle => Scene::Idle,
        SceneCode::Moving => Scene::Moving,
        SceneCode::Holding => Scene::Holding,
        SceneCode::Slipping => Scene::Slipping,
        _ => return None,
    })
}

/// What the controller does, where there is one.
const fn grip(code: GripStage) -> Option<Option<GripState>> {
    Some(Some(match code {
        GripStage::Observing => return Some(None),
        GripStage::Open => GripState::Open,
        GripStage::Closing => GripState::Closing,
        GripStage::Settling => GripState::Settling,
        GripStage::Holding => GripState::Holding,
        GripStage::Slipping => GripState::Slipping,
        GripStage::Fault => GripState::Fault,
        GripStage::Released => GripState::Released,
        _ => return None,
    }))
}

const fn stylus_health(code: SensorHealth) -> Option<health::Health> {
    Some(match code {
        SensorHealth::Good => health::Health::Good,
        SensorHealth::Frozen => health::Health::Frozen,
        SensorHealth::Saturated => health::Health::Saturated,
        SensorHealth::Failed => health::Health::Failed,
        SensorHealth::Drifting => health::Health::Drifting,
        SensorHealth::Doubted => health::Health::Doubted,
        _ => return None,
    })
}

const fn reference_health(code: SensorHealth) -> Option<ReferenceHealth> {
    Some(match code {
        SensorHealth::Good => ReferenceHealth::Good,
        SensorHealth::Frozen => ReferenceHealth::Frozen,
        SensorHealth::Lost => ReferenceHealth::Lost,
        SensorHealth::Late => ReferenceHealth::Late,
        SensorHealth::Uncoupled => ReferenceHealth::Uncoupled,
        _ => return None,
    })
}

const fn travel_health(code: SensorHealth) -> Option<TravelHealth> {
    Some(match code {
        SensorHealth::Good => TravelHealth::Good,
        SensorHealth::Jumped => TravelHealth::Jumped,
        SensorHealth::Frozen => TravelHealth::Frozen,
        SensorHealth::Backwards => TravelHealth::Backwards,
        SensorHealth::Doubted => TravelHealth::Doubted,
        SensorHealth::Coarse => TravelHealth::Coarse,
        _ => return None,
    })
}

const fn pressure_health(code: SensorHealth) -> Option<PressureHealth> {
    Some(match code {
        SensorHealth::Good => PressureHealth::Good,
        SensorHealth::Frozen => PressureHealth::Frozen,
        SensorHealth::Failed => PressureHealth::Failed,
        _ => return None,
    })
}

/// The event; the line that gripd prints does not travel.
pub(super) fn slip(slip: &Slip) -> EventRecord<'static> {
    let (kind, phase) = match slip.phase {
        Phase::Ended => ("slip_end", ""),
        phase => ("slip", phase.name()),
    };
    let method = if slip.method == Method::None { "" } else { slip.method.name() };
    #[expect(clippy::cast_precision_loss, reason = "a count for plots")]
    let irregularities = slip.irregularities.map(|count| count as f32);
    EventRecord {
        t_s: seconds(slip.device_us),
        kind,
        phase,
        method,
        duration_s: long(slip.duration_s),
        esc_w: long(slip.esc_w),
        esc_value: long(slip.esc_chosen),
        statistic: short(slip.statistic),
        confidence: short(slip.confidence),
        speed_m_s: short(slip.speed_m_s),
        speed_sigma_m_s: short(slip.sigma_m_s),
        moved_m: short(slip.moved_m),
        irregularities: short(irregularities),
        estimate_n: short(slip.estimate_n),
        command_n: short(slip.command_n),
        ..EventRecord::default()
    }
}

/// The event of a sensor whose health changed.
pub(super) fn sensor(notice: &Notice<'_>) -> EventRecord<'static> {
    let health =
        u8::try_from(notice.value).map_or(SensorHealth::Other(255), SensorHealth::from_code);
    EventRecord {
        kind: "health",
        channel: Sensor::from_code(notice.code).name(),
        health: health.name(),
        ..EventRecord::default()
    }
}

/// The figures.
pub(super) fn health(health: &Health) -> HealthRecord<'static> {
    let (bad, dropped, latency) = (health.bad, health.dropped, health.latency);
    let clock = health.appended.and_then(|appended| appended.clock);
    let p999_us = health.appended.and_then(|appended| appended.p999_us);
    #[expect(clippy::cast_precision_loss, reason = "exact for 285 years of microseconds")]
    let clock_offset_us = clock.map_or(f64::NAN, |clock| clock.offset_us as f64);
    HealthRecord {
        rate_hz: short(health.rate_hz),
        samples: health.samples,
        lost: health.lost,
        bad: [bad.too_long, bad.cobs, bad.length, bad.crc, bad.useless, bad.gap],
        dropped_service: dropped.service,
        dropped_recorder: dropped.recorder,
        dropped_clients: dropped.clients,
        clients: health.clients,
        link: health.link.name(),
        recording: health.recording.name(),
        recorded_bytes: health.recorded_bytes,
        latency_us: [latency.p50_us, latency.p99_us, p999_us, latency.max_us].map(short),
        clock_offset_us,
        clock_half_us: short(clock.map(|clock| clock.half_us)),
        stages: health.stages,
        slips: health.slips,
        reconnects: health.reconnects,
        commands: health.commands,
    }
}

pub(super) fn notice(notice: &Notice<'_>) -> Value {
    let Notice { code, value, count, .. } = *notice;
    json!({ "text": notice.as_str(), "code": code, "value": value, "count": count })
}

pub(super) fn gripper(gripper: &Gripper) -> Value {
    let uid: String = gripper.uid.iter().map(|byte| format!("{byte:02x}")).collect();
    json!({
        "uid": uid,
        "boot_id": gripper.boot_id,
        "rate_hz": gripper.rate_hz,
        "force_max_n": gripper.force_max_n,
        "link": gripper.link.name(),
        "taxels": gripper.taxels,
    })
}

pub(super) fn daemon(welcome: &Welcome<'_>) -> Value {
    json!({ "daemon": welcome.daemon(), "run_id": welcome.run_id })
}

const fn short(value: Option<f32>) -> f32 {
    match value {
        Some(value) => value,
        None => f32::NAN,
    }
}

fn long(value: Option<f32>) -> f64 {
    value.map_or(f64::NAN, f64::from)
}

#[expect(clippy::cast_precision_loss, reason = "exact for 285 years of microseconds")]
fn seconds(us: u64) -> f64 {
    us as f64 / 1e6
}
