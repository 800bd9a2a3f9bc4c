//! A session and a virtual gripper that exchange bytes in simulated time.

use grip_eval::trial;
use grip_link::{frame::MAX_WIRE, message::FaultCode};
use grip_record::{Channel, ChannelSet, CsvOptions, CsvWriter, StylusKind, parse_csv};
use grip_session::{
    HostConfig, Session, SessionOptions, Update, model, replay,
    report::{Event, EventLog},
};
use grip_sim::{Scene, VirtualMcu};
use slip_core::ClientCommand;
use slip_core::{Sample, grip::GripState, units::Micros};
use std::{collections::VecDeque, path::Path};

fn scene(force_max_n: f64) -> Scene {
    let text = format!(
        "name = \"x\"\nmass_kg = 0.5\nfriction = 0.4\n[drive]\nforce_max_n = {force_max_n:.1}\n"
    );
    Scene::from_toml(&text).unwrap()
}

/// What a grasp with `config` printed, and its samples as a recording.
fn grasp(scene: &Scene, config: &HostConfig) -> (Vec<String>, Vec<u8>) {
    let (mut lines, mut samples) = (Vec::new(), Vec::<Sample>::new());
    let mut report = |updates: Update<'_>| match updates {
        Update::Step { sample, .. } => samples.push(*sample),
        Update::Event(line) => lines.push(serde_json::to_string(&line).unwrap()),
        _ => {}
    };
    let estimator = model::default_estimator().unwrap();
    let outcome = trial::grasp(scene, config, estimator, Micros(2_000_000), &mut report).unwrap();
    let limit = scene.config().drive.force_max_n;
    assert!(f64::from(outcome.peak_command_n) <= limit, "{outcome:?} above {limit} N");
    let channels =
        Channel::ALL.into_iter().fold(ChannelSet::new(StylusKind::Displacement), ChannelSet::with);
    let mut writer = CsvWriter::new(Vec::new(), &channels).unwrap();
    samples.iter().for_each(|sample| writer.write(sample).unwrap());
    (lines, writer.finish().unwrap())
}

/// What a replay of the recording with `config` prints.
fn replayed(recording: &[u8], config: &HostConfig) -> Vec<String> {
    let recording = parse_csv(Path::new("x.csv"), recording, &CsvOptions::default()).unwrap();
    let pipeline = replay::pipeline_config(&recording, config, false);
    let estimator = model::default_estimator().unwrap();
    let steps = replay::Replay::new(&recording, pipeline, Some(estimator)).unwrap();
    let mut log = EventLog::default();
    let lines = steps.flat_map(|step| log.events(&step).into_iter().flatten());
    lines.map(|line| serde_json::to_string(&line).unwrap()).collect()
}

/// Also where a period is no whole number of microseconds, as at 3 and 7 kHz.
#[test]
fn a_recording_replays_identically_at_every_rate() {
    let scene = scene(60.0);
    for rate_hz in [1000, 2200, 3000, 7000, 10_000, 19_000, 20_000] {
        let mut config = HostConfig::default();
        config.link.sample_rate_hz = rate_hz;
        let (lines, recording) = grasp(&scene, &config);
        assert!(lines.iter().any(|line| line.contains("\"slip\"")), "{rate_hz} Hz: {lines:?}");
        assert_eq!(replayed(&recording, &config), lines, "{rate_hz} Hz");
    }
}

/// The virtual gripper reports truthfully when its fingers travel, and the answer to a slip is no motion.
#[test]
fn motion_comes_from_the_gripper_and_is_recorded() {
    let (lines, recording) = grasp(&scene(60.0), &HostConfig::default());
    let recording = parse_csv(Path::new("x.csv"), &recording, &CsvOptions::default()).unwrap();
    let with =
        |motion: f32| recording.samples.iter().filter(move |sample| sample.motion == Some(motion));
    // Still while the floor is learned (200 ms), 100 ms of travel up to the contact, 50 ms of more force up to the trial force, still again.
    let moving: Vec<f64> = with(1.0).map(|sample| sample.t.as_seconds()).collect();
    let (first, last) = (moving[0], moving[moving.len() - 1]);
    assert!((0.15..0.3).contains(&first), "{first} s");
    assert!((0.14..0.17).contains(&(last - first)), "{first} to {last} s");
    assert!((moving.len() as f64 * 1e-4 - (last - first)).abs() < 0.01, "in one piece");
    let slip: serde_json::Value = lines
        .iter()
        .map(|line| serde_json::from_str(line).unwrap())
        .find(|line: &serde_json::Value| line["type"] == "slip")
        .unwrap();
    let slip_s = slip["t_s"].as_f64().unwrap();
    assert!(
        with(0.0).filter(|s| s.t.as_seconds() > slip_s).count() > 1000,
        "the answer is no motion"
    );
    assert!(slip_s > last);
}

/// Pads that give way by 30 um/N under forces of 2 to 30 N, for some seconds of holding; and a gripper whose stylus does not drift.
#[test]
fn holding_is_no_drift() {
    let text = "name = \"soft\"\nmass_kg = 1.0\nfriction = 0.25\n[pad]\nsink_um_n = 30.0\n";
    let scene = Scene::from_toml(text).unwrap();
    let config = HostConfig::default();
    let estimator = model::default_estimator().unwrap();
    let mut reported = Vec::new();
    let mut report = |updates: Update<'_>| {
        if let Update::Event(line @ Event::Health { .. }) = updates {
            reported.push(line);
        }
    };
    let outcome = trial::grasp(&scene, &config, estimator, Micros(6_000_000), &mut report).unwrap();
    assert!(outcome.held() && outcome.slips > 0, "{outcome:?}");
    assert_eq!(reported, []);
}

/// A gripper that is weaker than the configuration asks for; its limit in the configuration of the replay gives the same.
#[test]
fn the_limit_of_the_gripper_stands() {
    let (lines, recording) = grasp(&scene(7.0), &HostConfig::default());
    let mut config = HostConfig::default();
    config.grip.f_max_n = 7.0;
    assert_eq!(replayed(&recording, &config), lines);
}

/// A gripper and a session that has just opened the line to it.
fn facing() -> (VirtualMcu, Session) {
    let mcu = VirtualMcu::new(&scene(60.0), 1).unwrap();
    let estimator = model::default_estimator().unwrap();
    let mut session =
        Session::new(HostConfig::default(), estimator, SessionOptions::default()).unwrap();
    session.open(0, 1).unwrap();
    (mcu, session)
}

/// From 0.5 s on the line holds every byte back for 80 ms, longer than a command lives: the slip is felt late, and the force is not raised
/// on what is past by then.
#[test]
fn late_samples_do_not_raise_the_force() {
    let (mut mcu, mut session) = facing();
    let (mut held_back, mut out) = (VecDeque::new(), [0; MAX_WIRE]);
    let (mut before_mn, mut wanted_n) = (0, 0.0_f32);
    while mcu.next_due() < Micros(1_000_000) {
        let now = mcu.next_due();
        mcu.advance(now);
        let mut bytes = Vec::new();
        mcu.transmit(now, &mut bytes);
        let late = now >= Micros(500_000);
        held_back.push_back((if late { now.plus(Micros(80_000)) } else { now }, bytes));
        while held_back.front().is_some_and(|(due, _)| *due <= now) {
            let (_, bytes) = held_back.pop_front().unwrap();
            if let Some(len) = session.answer(now.0, &bytes, &mut out).unwrap() {
                mcu.receive(now, &out[..len]);
                let sent_mn = session.link().last_grip().unwrap().force_mn;
                assert!(!late || sent_mn <= before_mn, "{sent_mn} mN at {now:?}");
                before_mn = sent_mn;
                wanted_n = session.latest().and_then(|step| step.command).unwrap().0;
            }
        }
        while let Some(len) = session.poll_transmit(now.0, &mut out) {
            mcu.receive(now, &out[..len]);
        }
    }
    // Nor does the controller itself ask for more.
    assert!(before_mn >= 500 && wanted_n < 1.3, "{before_mn} mN, {wanted_n} N");
}

/// Other settings wait for the end of a slip, but not for ever; where they come in the middle of one, the force goes on from where it was.
#[test]
fn settings_wait_for_the_end_of_a_slip_but_not_for_ever() {
    let (mut mcu, mut session) = facing();
    let mut out = [0; MAX_WIRE];
    let mut swapped_mn = None;
    while mcu.next_due() < Micros(2_000_000) {
        let now = mcu.next_due();
        mcu.advance(now);
        let mut bytes = Vec::new();
        mcu.transmit(now, &mut bytes);
        let slipping = session.grip_state() == Some(GripState::Slipping);
        assert_eq!(session.can_swap(1_999_999), !slipping);
        assert!(session.can_swap(2_000_000));
        if let Some(len) = session.answer(now.0, &bytes, &mut out).unwrap() {
            mcu.receive(now, &out[..len]);
            let force_mn = session.link().last_grip().unwrap().force_mn;
            assert!(swapped_mn.is_none_or(|before| force_mn >= before), "{force_mn} mN at {now:?}");
            if slipping && swapped_mn.is_none() {
                let mut config = HostConfig::default();
                let mut estimator = model::default_estimator().unwrap();
                session.swap(&mut config, &mut estimator).unwrap();
                swapped_mn = Some(force_mn);
            }
        }
        while let Some(len) = session.poll_transmit(now.0, &mut out) {
            mcu.receive(now, &out[..len]);
        }
    }
    let truth = mcu.truth();
    assert!(swapped_mn.is_some_and(|before| before > 0) && !truth.slipping, "{truth:?}");
}

/// A stop silences the commands and takes back what was asked for; what comes after its end begins with the force that the gripper was left with.
#[test]
fn a_stop_leaves_nothing_that_leaps_when_it_is_cleared() {
    let (mut mcu, mut session) = facing();
    let mut out = [0; MAX_WIRE];
    let (mut stopped, mut sent_mn, mut fastest_mn) = (0, 0, 0);
    while mcu.next_due() < Micros(3_000_000) {
        let now = mcu.next_due();
        mcu.advance(now);
        let mut bytes = Vec::new();
        mcu.transmit(now, &mut bytes);
        let latched = (1_550_000..2_000_000).contains(&now.0);
        if let Some(len) = session.answer(now.0, &bytes, &mut out).unwrap() {
            assert!(!latched, "a command in a stop, at {now:?}");
            mcu.receive(now, &out[..len]);
            let force_mn = session.link().last_grip().unwrap().force_mn;
            if now.0 > 2_000_000 {
                fastest_mn = fastest_mn.max(force_mn - sent_mn);
            }
            sent_mn = force_mn;
        }
        stopped += u64::from(latched);
        match now.0 / 1000 {
            1500 => assert!(session.obey(now.0, ClientCommand::Stop)),
            1700 => assert!(!session.obey(now.0, ClientCommand::AtLeast(20.0))),
            1701 => assert!(!session.obey(now.0, ClientCommand::Grasp)),
            2000 => assert!(session.obey(now.0, ClientCommand::ClearFault(FaultCode::ESTOP))),
            _ => {}
        }
        while let Some(len) = session.poll_transmit(now.0, &mut out) {
            mcu.receive(now, &out[..len]);
        }
    }
    assert!(stopped > 100 && sent_mn >= 2000, "{stopped}, {sent_mn} mN");
    assert!(fastest_mn <= 100, "a leap of {fastest_mn} mN");
}
