//! A board as a busy hour leaves it.

use grip_daemon::{
    Board, HotCounters, Item, LinkNote,
    board::{About, ClientCounts, Grant, RecordingState},
};
use grip_link::{
    host::LinkState,
    message::{
        DeviceState, Event, EventKind, FaultCode, Firmware, ForceClamp, Status, StatusFlags,
    },
};
use grip_session::report::Event as Happened;
use slip_core::{
    Phase, PipelineState, SlipReport, alarm::Method, grip::GripState, health::SensorHealth,
    sample::Scene, units::Micros,
};

const FIRMWARE: Firmware = Firmware { major: 1, minor: 2, patch: 3 };

pub(crate) const STATE: PipelineState = PipelineState {
    t: Micros(1_500_000),
    host: Micros(1_900_000),
    scene: Scene::Holding,
    grip: GripState::Holding,
    sensors: [SensorHealth::Good, SensorHealth::Good, SensorHealth::Absent, SensorHealth::Lost],
    statistic: Some(0.75),
    command_n: Some(2.5),
    applied_n: Some(f32::NAN),
    estimate_n: Some(9.4),
    rate_hz: 10_000,
    lost: 3,
    late_ms: Some(1.5),
    need_low_n: Some(1.75),
    need_n: Some(2.0),
    need_high_n: Some(2.25),
    admissible_m_s2: Some(1.0),
    ..PipelineState::UNKNOWN
};

pub(crate) const STATUS: Status = Status {
    last_cmd_id: 1,
    state: DeviceState::Active,
    clamp: ForceClamp(0),
    fault: FaultCode::NONE,
    applied_mn: 2500,
    target_mn: 2500,
    age_us: 5,
    flags: StatusFlags(0),
    rejected: 0,
};

pub(crate) const fn slip(phase: Phase, method: Method) -> Happened {
    Happened::Slip(SlipReport {
        t: Micros(500_000),
        phase,
        method,
        statistic: Some(3.0),
        confidence: Some(0.9),
        ..SlipReport::UNKNOWN
    })
}

pub(crate) fn device_event(kind: EventKind, fault: FaultCode) -> LinkNote {
    let (before, after) = (DeviceState::Active, DeviceState::Fault);
    LinkNote::Device(Event { tick: 7, kind, before, after, fault, dropped: 0, value: 0 })
}

fn counters(host_us: u64, samples: u64) -> HotCounters {
    let mut hot =
        HotCounters { host_us, samples, slips: 2, commands: 99, ..HotCounters::default() };
    hot.loss.lost = 5;
    hot.loss.dropped_by_mcu = 2;
    hot.frames.ok = 1000;
    hot.frames.crc = 4;
    hot.frames.garbage_bytes = 123;
    hot.health.glitches = 6;
    hot.stages.bands = 777;
    hot.rx_bytes = 1_000_000;
    (1..=1000).for_each(|us| hot.latency.record(1000 * us));
    hot
}

/// Two seconds at 10 kHz, two slips, a stranger and a fault.
pub(crate) fn board() -> Board {
    let grants = vec![
        Grant { what: "mlockall".to_owned(), refused: None },
        Grant { what: "SCHED_FIFO 50".to_owned(), refused: Some("not permitted".to_owned()) },
    ];
    let mut board = Board::new(About {
        version: "1.2.3".to_owned(),
        port: "/dev/tty\"ACM0\"".to_owned(),
        config_files: vec!["gripd.toml".into()],
        reloads: (1, 2),
        grants,
        dry_run: false,
        run_id: 5,
    });
    board.clients =
        ClientCounts { connected: 2, accepted: 7, refused: 1, dropped: 55, bad_commands: 3 };
    board.recording = RecordingState {
        file: Some("x.mcap".into()),
        bytes: 4096,
        files: 1,
        ..RecordingState::default()
    };
    let notes = [
        LinkNote::PortOpened,
        LinkNote::Identified { uid: [0xAB; 16], boot_id: 3, firmware: FIRMWARE, rebooted: false },
        LinkNote::State(LinkState::Stream),
        device_event(EventKind::Fault, FaultCode::DRIVE),
    ];
    for note in &notes {
        board.take(&Item::Link { host_us: 10, note });
    }
    for (phase, method) in [
        (Phase::Incipient, Method::Stylus),
        (Phase::Gross, Method::Stylus),
        (Phase::Gross, Method::Travel),
    ] {
        board.take(&Item::Event { host_us: 20, event: &slip(phase, method) });
    }
    board.take(&Item::State(&STATE));
    board.count(&counters(1_000_000, 10_000));
    board.count(&counters(2_000_000, 20_000));
    board
}
