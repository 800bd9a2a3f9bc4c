//! Conversion of messages of a daemon to records of a live view.

use grip_link::message::daemon::{Gripper, Health, Notice, Sensor, SensorHealth, Welcome};
use grip_record::mcap::{EventRecord, HealthRecord};
use serde_json::{Value, json};

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
