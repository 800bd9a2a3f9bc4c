//! Made-up runs of a gripper, filled into a model by hand.

use grip_link::message::Unit;
use grip_link::message::daemon::{
    Appended, BadFrames, ClockOffset, GripState, Gripper, Health, Latency, LinkState, Method,
    Reading, RealTime, Scene, SensorHealth,
};
use grip_scope::feed::{
    DaemonInfo, DerivedBlock, EventKind, EventMark, Feed, LearningCurve, RowBlock, SpectrumColumn,
    Study, StudyNet, StudyResult, TaxelBlock, Turn,
};
use grip_scope::{Channel, Model, SourceStatus};
use gripmon::num::narrow;
use slip_core::{Phase, PipelineState, SlipReport, units::Micros, velocity::SpeedSource};

/// A spike of one sample stands here (us).
pub(crate) const SPIKE_US: u64 = 1_234_500;
/// Its height (m).
pub(crate) const SPIKE_M: f32 = 2e-3;

/// Rows from `from` to before `to` of a run at `rate_hz`, with a value of every channel of `channels`.
pub(crate) fn rows(channels: &[Channel], rate_hz: u64, from: usize, to: usize) -> RowBlock {
    let t_s = |i: usize| i as f64 / rate_hz as f64;
    let value = |channel: usize, i: usize| {
        let t_s = t_s(i);
        let wave = (t_s * (40.0 + 17.0 * channel as f64) * core::f64::consts::TAU).sin()
            + 0.1 * (t_s * 9973.0).sin();
        narrow(1e-5 * wave)
    };
    RowBlock {
        times_us: (from as u64..to as u64).map(|i| i * 1_000_000 / rate_hz).collect(),
        columns: channels
            .iter()
            .enumerate()
            .map(|(n, c)| (*c, (from..to).map(|i| value(n, i)).collect()))
            .collect(),
        ..RowBlock::default()
    }
}

/// Two seconds of a grasp at 10 kHz with a slip, a fault and everything else that a daemon reports.
pub(crate) fn grasp() -> Model {
    let mut model = Model::new(64 << 20);
    greet(&mut model, true);
    for start in (0..20_000).step_by(500) {
        let mut block = rows(&[Channel::Stylus, Channel::NormalForce], 10_000, start, start + 500);
        block.columns[1].1.iter_mut().for_each(|n| *n = 5.0 + *n * 1e4);
        for (time_us, value) in block.times_us.iter().zip(&mut block.columns[0].1) {
            if *time_us == SPIKE_US {
                *value = SPIKE_M;
            }
        }
        block.taxels =
            Some(TaxelBlock { count: 4, values: (0..2000).map(|i| (i % 7) as f32).collect() });
        model.take(Feed::Rows(block));
        let t_s = (start + 500) as f64 / 10_000.0;
        (0..5).for_each(|i| model.take(Feed::State(state(t_s - 0.04 + 0.01 * f64::from(i)))));
        model.take(Feed::Derived(Box::new(derived(t_s - 0.05))));
    }
    events(&mut model);
    model.take(Feed::Health(Box::new(health())));
    model
}

/// Who is there.
pub(crate) fn greet(model: &mut Model, may_command: bool) {
    model.take(Feed::Status(SourceStatus::Live));
    model.take(Feed::Welcome(DaemonInfo {
        name: "gripd 0.1.0".to_owned(),
        place: "tcp:127.0.0.1:7747".to_owned(),
        may_command,
        dry_run: false,
        real_time: RealTime::Granted,
        every_nth: 1,
    }));
    let gripper = Gripper {
        uid: [7; 16],
        boot_id: 1,
        rate_hz: 10_000,
        force_max_n: Some(40.0),
        link: LinkState::Stream,
        taxels: 4,
        stylus: Unit::Metre,
    };
    model.take(Feed::Gripper(gripper));
    model.take(Feed::Notice("the link streams".to_owned()));
}

/// The pipeline at a time; it slips from 0.9 s to 1.1 s.
pub(crate) fn state(t_s: f64) -> PipelineState {
    let slipping = (0.9..1.1).contains(&t_s);
    let scene = if t_s < 0.3 {
        Scene::Idle
    } else if slipping {
        Scene::Slipping
    } else {
        Scene::Holding
    };
    PipelineState {
        t: Micros::from_seconds(t_s),
        scene,
        grip: GripState::Holding,
        sensors: [SensorHealth::Good, SensorHealth::Good, SensorHealth::Frozen, SensorHealth::Good],
        esc_flags: 4,
        esc_kind: if slipping { Reading::Literal } else { Reading::None },
        statistic: Some(if slipping { 8.0 } else { 0.1 }),
        command_n: Some(if t_s > 1.0 { 12.0 } else { 5.0 }),
        applied_n: Some(5.0),
        esc: slipping.then_some(0.2),
        estimate_n: slipping.then_some(9.5),
        rate_hz: 10_000,
        lost: 3,
        late_ms: Some(1.5),
        need_low_n: (t_s > 0.5).then_some(3.25),
        need_n: (t_s > 0.5).then_some(4.0),
        need_high_n: (t_s > 0.5).then_some(6.75),
        ..PipelineState::UNKNOWN
    }
}

fn derived(from_s: f64) -> DerivedBlock {
    let at = |i: u32| from_s + 0.005 * f64::from(i);
    let turn = |i: u32| Turn { t_s: at(i), height: 1e-5, is_peak: i.is_multiple_of(2) };
    let span = [from_s, from_s + 0.05];
    let mut block = DerivedBlock {
        turns: (0..10).map(turn).collect(),
        spectra: vec![SpectrumColumn { span, top_hz: 5000.0, bins: (0..64).collect() }],
        ..DerivedBlock::default()
    };
    for t_s in (0..10).map(at) {
        bands(&mut block, t_s);
        if (0.9..1.1).contains(&from_s) {
            block.put(t_s, [(Channel::SlipSpeed, 0.05), (Channel::SlipSpeedSigma, 0.01)]);
            let [low, high] = [(Channel::EstimateLow, 8.0), (Channel::EstimateHigh, 11.0)];
            block.put(t_s, [(Channel::OwnEstimate, 9.5), low, high]);
        }
    }
    block
}

/// What the observer derives each few milliseconds.
pub(crate) fn bands(block: &mut DerivedBlock, t_s: f64) {
    block.put(t_s, Channel::BANDS.into_iter().zip([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    block.put(t_s, [(Channel::OwnStatistic, 0.002)]);
}

fn events(model: &mut Model) {
    let slip = SlipReport {
        method: Method::Stylus,
        statistic: Some(8.0),
        confidence: Some(0.9998),
        speed_m_s: Some(0.05),
        speed_sigma_m_s: Some(0.002),
        speed_source: SpeedSource::Travel,
        ruled_out: 0b1_0001,
        possible: 0b0_0010,
        ..SlipReport::UNKNOWN
    };
    for (t_s, phase) in [(0.9, Phase::Incipient), (0.95, Phase::Gross)] {
        let slip = SlipReport { t: Micros::from_seconds(t_s), phase, ..slip };
        model.take(Feed::Event(EventMark::slip(&slip)));
    }
    for (t_s, kind, text) in [
        (0.96, EventKind::Reflex, "12 N"),
        (1.1, EventKind::Ended, "ended"),
        (1.5, EventKind::Fault, "the pressure array is frozen"),
        (1.6, EventKind::Recovered, "the pressure array is good"),
    ] {
        model.take(Feed::Event(EventMark::plain(t_s, kind, text)));
    }
}

pub(crate) fn health() -> Health {
    let mut histogram = [0; Appended::BUCKETS];
    for (bucket, count) in [(7, 500), (8, 3000), (9, 200), (12, 3), (23, 1)] {
        histogram[bucket] = count;
    }
    let clock = Some(ClockOffset { offset_us: 1234, half_us: 40.0 });
    Health {
        host_us: 10_000_000,
        rate_hz: Some(9_999.0),
        samples: 20_000,
        lost: 3,
        bad: BadFrames { crc: 2, ..BadFrames::default() },
        clients: 1,
        link: LinkState::Stream,
        latency: Latency { p50_us: Some(21.0), p99_us: Some(60.0), max_us: Some(2000.0) },
        stages: [20_000, 100, 5_000, 2_000],
        slips: 1,
        commands: 120,
        appended: Some(Appended { p999_us: Some(400.0), clock, histogram }),
        ..Health::default()
    }
}

/// A study of two nets.
pub(crate) fn study() -> Model {
    let epoch: Vec<f64> = (1..50).map(f64::from).collect();
    let errors: Vec<_> = epoch.iter().map(|epoch| Some(1.0 / epoch)).collect();
    let curve = LearningCurve { epoch, train: errors.clone(), test: errors };
    let net = |trainer: &str| StudyNet {
        net: trainer.to_owned(),
        trainer: trainer.to_owned(),
        curve: Some(curve.clone()),
    };
    let title = "Learning of surface2".to_owned();
    let result = StudyResult { title, nets: vec![net("gd"), net("lm")] };
    let (title, summary) = ("Four nets".to_owned(), vec!["twenty starts each".to_owned()]);
    let mut model = Model::new(1 << 20);
    model.take(Feed::Study(Box::new(Study { title, summary, results: vec![result] })));
    model.take(Feed::Status(SourceStatus::Complete { note: String::new() }));
    model
}
