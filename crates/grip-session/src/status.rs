//! Messages of gripd in, the objects that stand for them in JSON out. Names and units of the fields are a contract: what has a unit ends in it.
#![expect(missing_docs, reason = "a field is what the message's field of that name is")]

use grip_link::message::daemon::{Gripper, Health, Phase, PipelineState, SlipReport, ToClient};
use serde::Serialize;
use slip_core::{Cause, CauseSet, units::Micros};

/// GRIPPER.
#[derive(Debug, Serialize)]
pub struct GripperReport {
    /// `None` where no gripper was seen yet.
    pub uid: Option<String>,
    pub boot_id: u32,
    pub rate_hz: u32,
    pub force_max_n: Option<f32>,
    pub link: &'static str,
    pub taxels: u8,
}

/// STATE.
#[derive(Debug, Serialize)]
pub struct StateReport {
    pub t_s: f64,
    pub scene: &'static str,
    pub grip: &'static str,
    pub device: String,
    pub fault: u16,
    pub statistic: Option<f32>,
    pub command_n: Option<f32>,
    pub applied_n: Option<f32>,
    pub estimate_n: Option<f32>,
    pub esc: Option<f32>,
    pub esc_reading: &'static str,
    pub stylus: &'static str,
    pub travel: &'static str,
    pub pressure: &'static str,
    pub reference: &'static str,
    /// Age of the newest usable row at the last command (ms).
    pub late_ms: Option<f32>,
}

/// HEALTH.
#[derive(Debug, Serialize)]
pub struct HealthReport {
    pub rate_hz: Option<f32>,
    pub samples: u64,
    pub lost: u64,
    pub bad_too_long: u32,
    pub bad_cobs: u32,
    pub bad_length: u32,
    pub bad_crc: u32,
    pub bad_useless: u32,
    pub gap: u32,
    pub dropped_service: u64,
    pub dropped_recorder: u64,
    pub dropped_clients: u32,
    pub clients: u16,
    pub recording: &'static str,
    pub recorded_bytes: u64,
    pub latency_p50_us: Option<f32>,
    pub latency_p99_us: Option<f32>,
    /// Absent, as the clocks, where the daemon is older than that.
    pub latency_p99_9_us: Option<f32>,
    pub latency_max_us: Option<f32>,
    pub clock_offset_us: Option<i64>,
    pub clock_half_us: Option<f32>,
    pub stage_bands: u64,
    pub stage_gate: u64,
    pub stage_methods: u64,
    pub stage_observation: u64,
    pub slips: u32,
    pub reconnects: u32,
    pub commands: u64,
}

/// SLIP, NOTICE or GRIPPER.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum EventReport {
    Slip {
        number: u32,
        t_s: f64,
        host_s: f64,
        phase: &'static str,
        method: &'static str,
        statistic: Option<f32>,
        confidence: Option<f32>,
        certified_interval_s: Option<f32>,
        ruled_out: Vec<&'static str>,
        possible: Vec<&'static str>,
        speed_m_s: Option<f32>,
        speed_sigma_m_s: Option<f32>,
        moved_m: Option<f32>,
        irregularities: Option<u32>,
        esc_w: Option<f32>,
        estimate_n: Option<f32>,
        extrapolated: bool,
        command_n: Option<f32>,
        duration_s: Option<f32>,
    },
    Notice {
        host_s: f64,
        about: &'static str,
        text: String,
        count: u32,
    },
    Gripper(GripperReport),
}

impl GripperReport {
    #[must_use]
    pub fn of(gripper: &Gripper) -> Self {
        let uid: String = gripper.uid.iter().map(|byte| format!("{byte:02x}")).collect();
        Self {
            uid: (gripper.uid != [0; 16]).then_some(uid),
            boot_id: gripper.boot_id,
            rate_hz: gripper.rate_hz,
            force_max_n: gripper.force_max_n,
            link: gripper.link.name(),
            taxels: gripper.taxels,
        }
    }
}

impl StateReport {
    #[must_use]
    pub fn of(state: &PipelineState) -> Self {
        let [stylus, travel, pressure, reference] = state.sensors.map(|sensor| sensor.name());
        Self {
            t_s: state.t.as_seconds(),
            scene: state.scene.name(),
            grip: state.grip.name(),
            device: state.device.name().to_owned(),
            fault: state.fault.0,
            statistic: state.statistic,
            command_n: state.command_n,
            applied_n: state.applied_n,
            estimate_n: state.estimate_n,
            esc: state.esc,
            esc_reading: state.esc_kind.name(),
            stylus,
            travel,
            pressure,
            reference,
            late_ms: state.late_ms,
        }
    }
}

impl HealthReport {
    #[must_use]
    pub fn of(health: &Health) -> Self {
        let [stage_bands, stage_gate, stage_methods, stage_observation] = health.stages;
        let clock = health.appended.and_then(|appended| appended.clock);
        Self {
            rate_hz: health.rate_hz,
            samples: health.samples,
            lost: health.lost,
            bad_too_long: health.bad.too_long,
            bad_cobs: health.bad.cobs,
            bad_length: health.bad.length,
            bad_crc: health.bad.crc,
            bad_useless: health.bad.useless,
            gap: health.bad.gap,
            dropped_service: health.dropped.service,
            dropped_recorder: health.dropped.recorder,
            dropped_clients: health.dropped.clients,
            clients: health.clients,
            recording: health.recording.name(),
            recorded_bytes: health.recorded_bytes,
            latency_p50_us: health.latency.p50_us,
            latency_p99_us: health.latency.p99_us,
            latency_p99_9_us: health.appended.and_then(|appended| appended.p999_us),
            latency_max_us: health.latency.max_us,
            clock_offset_us: clock.map(|clock| clock.offset_us),
            clock_half_us: clock.map(|clock| clock.half_us),
            stage_bands,
            stage_gate,
            stage_methods,
            stage_observation,
            slips: health.slips,
            reconnects: health.reconnects,
            commands: health.commands,
        }
    }
}

impl EventReport {
    /// `None` for what is no event.
    #[must_use]
    pub fn of(message: &ToClient<'_>) -> Option<Self> {
        Some(match message {
            ToClient::Slip(slip) => Self::slip(slip),
            ToClient::Notice(notice) => Self::Notice {
                host_s: Micros(notice.host_us).as_seconds(),
                about: notice.kind.name(),
                text: notice.as_str().to_owned(),
                count: notice.count,
            },
            ToClient::Gripper(gripper) => Self::Gripper(GripperReport::of(gripper)),
            _ => return None,
        })
    }

    fn slip(slip: &SlipReport) -> Self {
        let method = if slip.phase == Phase::Ended { "none" } else { slip.method.name() };
        Self::Slip {
            number: slip.number,
            t_s: slip.t.as_seconds(),
            host_s: slip.host.as_seconds(),
            phase: slip.phase.name(),
            method,
            statistic: slip.statistic,
            confidence: slip.confidence,
            certified_interval_s: slip.certified_s,
            ruled_out: names(slip.ruled_out),
            possible: names(slip.possible),
            speed_m_s: slip.speed_m_s,
            speed_sigma_m_s: slip.speed_sigma_m_s,
            moved_m: slip.moved_m,
            irregularities: slip.irregularities,
            esc_w: slip.esc_w.map(single),
            estimate_n: slip.estimate_n,
            extrapolated: slip.is_extrapolated(),
            command_n: slip.command_n,
            duration_s: slip.duration_s.map(single),
        }
    }
}

/// As it travelled.
#[expect(clippy::cast_possible_truncation, reason = "it came with seven digits")]
const fn single(value: f64) -> f32 {
    value as f32
}

fn names(causes: u8) -> Vec<&'static str> {
    CauseSet::from_bits(causes).iter().map(Cause::name).collect()
}
