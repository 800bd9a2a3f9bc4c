//! Messages of gripd as objects in JSON. Names and units of the fields are a contract: what has a unit ends in it.
#![expect(missing_docs, reason = "a field is what the message's field of that name is")]

use crate::config::Uid;
use crate::report::slip_text;
use grip_link::message::{
    Unit,
    daemon::{
        ClockOffset, Gripper, Health, Phase, PipelineState, RowOfSample, RowSet, SlipReport,
        ToClient,
    },
};
use serde::Serialize;
use slip_core::{Cause, CauseSet, Sample, health::SensorHealth, units::Micros};

/// An object of JSON, as a table: a row gives a field, its type and where it comes from.
#[macro_export]
macro_rules! json_object {
    (
        $(#[$about:meta])* $vis:vis struct $name:ident $(<$life:lifetime>)? of ($($from:ident: $source:ty),+) {
            $($(#[$meta:meta])* $field:ident: $type:ty = $value:expr;)+
        }
    ) => {
        $(#[$about])*
        $vis struct $name $(<$life>)? {
            $($(#[$meta])* $vis $field: $type,)+
        }

        impl $(<$life>)? $name $(<$life>)? {
            /// What is known.
            #[must_use]
            $vis fn of($($from: $source),+) -> Self {
                Self { $($field: $value,)+ }
            }
        }
    };
}

json_object! {
    /// GRIPPER.
    #[derive(Debug, Serialize)]
    pub struct GripperReport of (gripper: &Gripper) {
        /// `None` where no gripper was seen yet.
        uid: Option<String> = (gripper.uid != [0; 16]).then(|| Uid(gripper.uid).to_string());
        boot_id: u32 = gripper.boot_id;
        rate_hz: u32 = gripper.rate_hz;
        force_max_n: Option<f32> = gripper.force_max_n;
        link: &'static str = gripper.link.name();
        taxels: u8 = gripper.taxels;
        /// `displacement` (m) or `vibration` (own unit); `None` where no samples came yet.
        stylus: Option<&'static str> = (gripper.rate_hz > 0).then_some(match gripper.stylus {
            Unit::Metre => "displacement",
            _ => "vibration",
        });
    }
}

/// State of a sensor while no samples come: what the last one showed is no health.
#[must_use]
pub fn unread(health: &'static str) -> &'static str {
    if health == SensorHealth::Absent.name() { health } else { "unread" }
}

json_object! {
    /// STATE.
    #[derive(Debug, Serialize)]
    pub struct StateReport of (state: &PipelineState) {
        t_s: f64 = state.t.as_seconds();
        scene: &'static str = state.scene.name();
        grip: &'static str = state.grip.name();
        device: String = state.device.name().to_owned();
        fault: u16 = state.fault.0;
        statistic: Option<f32> = state.statistic;
        command_n: Option<f32> = state.command_n;
        applied_n: Option<f32> = state.applied_n;
        estimate_n: Option<f32> = state.estimate_n;
        /// Quantiles of the normal force of one finger that the object needs at full weight (N): 10, 50 and 90 %.
        need_low_n: Option<f32> = state.need_low_n;
        need_n: Option<f32> = state.need_n;
        need_high_n: Option<f32> = state.need_high_n;
        /// Acceleration of the arm at which the object slips with a probability of 10 % (m/s^2).
        admissible_m_s2: Option<f32> = state.admissible_m_s2;
        esc: Option<f32> = state.esc;
        esc_reading: &'static str = state.esc_kind.name();
        stylus: &'static str = state.sensors[0].name();
        travel: &'static str = state.sensors[1].name();
        pressure: &'static str = state.sensors[2].name();
        reference: &'static str = state.sensors[3].name();
        /// Age of the newest usable row at the last command (ms).
        late_ms: Option<f32> = state.late_ms;
    }
}

json_object! {
    /// HEALTH.
    #[derive(Debug, Serialize)]
    pub struct HealthReport of (health: &Health) {
        rate_hz: Option<f32> = health.rate_hz;
        samples: u64 = health.samples;
        lost: u64 = health.lost;
        bad_too_long: u32 = health.bad.too_long;
        bad_cobs: u32 = health.bad.cobs;
        bad_length: u32 = health.bad.length;
        bad_crc: u32 = health.bad.crc;
        bad_useless: u32 = health.bad.useless;
        gap: u32 = health.bad.gap;
        dropped_service: u64 = health.dropped.service;
        dropped_recorder: u64 = health.dropped.recorder;
        dropped_clients: u32 = health.dropped.clients;
        clients: u16 = health.clients;
        recording: &'static str = health.recording.name();
        recorded_bytes: u64 = health.recorded_bytes;
        latency_p50_us: Option<f32> = health.latency.p50_us;
        latency_p99_us: Option<f32> = health.latency.p99_us;
        /// Absent, as the clocks, where the daemon is older than that.
        latency_p99_9_us: Option<f32> = health.appended.and_then(|appended| appended.p999_us);
        latency_max_us: Option<f32> = health.latency.max_us;
        clock_offset_us: Option<i64> = clock(health).map(|clock| clock.offset_us);
        clock_half_us: Option<f32> = clock(health).map(|clock| clock.half_us);
        stage_bands: u64 = health.stages[0];
        stage_gate: u64 = health.stages[1];
        stage_methods: u64 = health.stages[2];
        stage_observation: u64 = health.stages[3];
        slips: u32 = health.slips;
        reconnects: u32 = health.reconnects;
        commands: u64 = health.commands;
    }
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
        /// In words, without the time.
        #[serde(skip)]
        text: String,
    },
    Notice {
        host_s: f64,
        about: &'static str,
        text: String,
        count: u32,
    },
    Gripper(GripperReport),
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
            text: slip_text(slip),
        }
    }
}

fn clock(health: &Health) -> Option<ClockOffset> {
    health.appended.and_then(|appended| appended.clock)
}

/// As it travelled.
#[expect(clippy::cast_possible_truncation, reason = "it came with seven digits")]
const fn single(value: f64) -> f32 {
    value as f32
}

fn names(causes: u8) -> Vec<&'static str> {
    CauseSet::from_bits(causes).iter().map(Cause::name).collect()
}

/// The sample that a row is; NaN is no reading.
#[must_use]
pub fn sample(row: &RowOfSample<'_>) -> Sample {
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
