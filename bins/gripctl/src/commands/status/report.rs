//! Messages of gripd in, what is known of it with the names of the JSON fields out.

use grip_link::message::Versions;
use grip_link::message::daemon::{
    Gripper, Health, NoticeKind, Phase, PipelineState, SlipReport, ToClient, Welcome, WelcomeFlags,
};
use serde::Serialize;
use slip_core::{Cause, CauseSet};

/// Everything that QUERY tells.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Report {
    #[serde(skip)]
    pub(crate) welcomed: bool,
    #[serde(skip)]
    pub(crate) answered: bool,
    #[serde(skip)]
    pub(crate) goodbye: Option<String>,
    #[serde(skip)]
    versions: Option<Versions>,
    #[serde(flatten)]
    pub(crate) daemon: Option<DaemonReport>,
    pub(crate) gripper: Option<GripperReport>,
    pub(crate) state: Option<StateReport>,
    pub(crate) health: Option<HealthReport>,
    /// What is known of the object in hand or next; absent where gripd remembers none.
    pub(crate) object: Option<String>,
    pub(crate) events: Vec<EventReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct DaemonReport {
    pub(crate) daemon: String,
    pub(crate) run_id: u32,
    pub(crate) uptime_s: f64,
    pub(crate) commands_allowed: bool,
    pub(crate) dry_run: bool,
    pub(crate) records: bool,
    pub(crate) real_time: &'static str,
}

#[derive(Debug, Serialize)]
pub(crate) struct GripperReport {
    /// `None` where no gripper was seen yet.
    pub(crate) uid: Option<String>,
    pub(crate) boot_id: u32,
    pub(crate) rate_hz: u32,
    pub(crate) force_max_n: Option<f32>,
    pub(crate) link: &'static str,
    pub(crate) taxels: u8,
}

#[derive(Debug, Serialize)]
pub(crate) struct StateReport {
    pub(crate) t_s: f64,
    pub(crate) scene: &'static str,
    pub(crate) grip: &'static str,
    pub(crate) device: String,
    pub(crate) fault: u16,
    pub(crate) statistic: Option<f32>,
    pub(crate) command_n: Option<f32>,
    pub(crate) applied_n: Option<f32>,
    pub(crate) estimate_n: Option<f32>,
    pub(crate) esc: Option<f32>,
    pub(crate) esc_reading: &'static str,
    pub(crate) stylus: &'static str,
    pub(crate) travel: &'static str,
    pub(crate) pressure: &'static str,
    pub(crate) reference: &'static str,
    /// Age of the newest usable row at the last command (ms).
    pub(crate) late_ms: Option<f32>,
}

#[derive(Debug, Serialize)]
pub(crate) struct HealthReport {
    pub(crate) rate_hz: Option<f32>,
    pub(crate) samples: u64,
    pub(crate) lost: u64,
    pub(crate) bad_too_long: u32,
    pub(crate) bad_cobs: u32,
    pub(crate) bad_length: u32,
    pub(crate) bad_crc: u32,
    pub(crate) bad_useless: u32,
    pub(crate) gap: u32,
    pub(crate) dropped_service: u64,
    pub(crate) dropped_recorder: u64,
    pub(crate) dropped_clients: u32,
    pub(crate) clients: u16,
    pub(crate) recording: &'static str,
    pub(crate) recorded_bytes: u64,
    pub(crate) latency_p50_us: Option<f32>,
    pub(crate) latency_p99_us: Option<f32>,
    /// Absent, as the clocks, where the daemon is older than that.
    pub(crate) latency_p99_9_us: Option<f32>,
    pub(crate) latency_max_us: Option<f32>,
    pub(crate) clock_offset_us: Option<i64>,
    pub(crate) clock_half_us: Option<f32>,
    pub(crate) stage_bands: u64,
    pub(crate) stage_gate: u64,
    pub(crate) stage_methods: u64,
    pub(crate) stage_observation: u64,
    pub(crate) slips: u32,
    pub(crate) reconnects: u32,
    pub(crate) commands: u64,
}

/// One line of `--events` and of the last events.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum EventReport {
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

impl Report {
    pub(crate) fn take(&mut self, message: &ToClient<'_>) {
        self.answered |= super::is_answer(message);
        match message {
            ToClient::Welcome(welcome) => {
                self.welcomed = true;
                self.versions = Some(welcome.versions);
                self.daemon = Some(DaemonReport::of(welcome));
            }
            ToClient::Gripper(gripper) => self.gripper = Some(GripperReport::of(gripper)),
            ToClient::State(state) => self.state = Some(StateReport::of(state)),
            ToClient::Health(health) => self.health = Some(HealthReport::of(health)),
            ToClient::Slip(_) => self.events.extend(EventReport::of(message)),
            ToClient::Notice(notice) if notice.kind == NoticeKind::Object => {
                self.object = Some(notice.as_str().to_owned());
            }
            ToClient::Notice(notice) if notice.kind == NoticeKind::Goodbye => {
                self.goodbye = Some(notice.as_str().to_owned());
            }
            _ => {}
        }
    }

    /// Whether the daemon speaks a protocol version of this program.
    pub(crate) fn check_versions(&self) -> anyhow::Result<()> {
        match self.versions {
            Some(theirs) if Versions::OURS.common(theirs).is_none() => anyhow::bail!(
                "gripd speaks versions {} to {} of the protocol, this gripctl {} to {}: use programs of one release",
                theirs.min,
                theirs.max,
                Versions::OURS.min,
                Versions::OURS.max
            ),
            _ => Ok(()),
        }
    }
}

impl DaemonReport {
    fn of(welcome: &Welcome<'_>) -> Self {
        Self {
            daemon: welcome.daemon().to_owned(),
            run_id: welcome.run_id,
            uptime_s: seconds(welcome.host_us),
            commands_allowed: welcome.flags.has(WelcomeFlags::COMMANDS),
            dry_run: welcome.flags.has(WelcomeFlags::DRY_RUN),
            records: welcome.flags.has(WelcomeFlags::RECORDS),
            real_time: welcome.real_time.name(),
        }
    }
}

impl GripperReport {
    fn of(gripper: &Gripper) -> Self {
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
    fn of(state: &PipelineState) -> Self {
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
    fn of(health: &Health) -> Self {
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
    pub(crate) fn of(message: &ToClient<'_>) -> Option<Self> {
        Some(match message {
            ToClient::Slip(slip) => Self::slip(slip),
            ToClient::Notice(notice) => Self::Notice {
                host_s: seconds(notice.host_us),
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

#[expect(clippy::cast_precision_loss, reason = "exact for 285 years of microseconds")]
fn seconds(us: u64) -> f64 {
    us as f64 / 1e6
}
