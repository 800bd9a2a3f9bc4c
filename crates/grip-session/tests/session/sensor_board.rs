//! A board of one accelerometer: it has no actuator, and its channel is in any unit. Slips are found, nothing is commanded.

use grip_link::{
    device::{DeviceConfig, DeviceEvent, DeviceLink},
    frame::MAX_WIRE,
    message::{Channel, ChannelKind, Ident, Limits, Reaction, Unit},
};
use grip_session::{HostConfig, Session, SessionOptions, Update, model, report::Event};
use slip_core::{ClientCommand, Signal};

const RATE_HZ: u32 = 1600;

fn board(unit: Unit, force_max_mn: i32) -> DeviceLink {
    let channel = Channel { unit, ..Channel::single(ChannelKind::Stylus, 1e-3) };
    let limits = Limits {
        rate_max_hz: RATE_HZ,
        force_max_mn,
        slew_max_mn_s: 1_000_000,
        hold_cap_mn: force_max_mn,
        travel_min_um: 0,
        travel_max_um: 0,
    };
    let ident = Ident::new(*b"a sensor board 1", 1, limits, &[channel]);
    let mut link = DeviceLink::new(DeviceConfig { ident, estop: Reaction::Hold }).unwrap();
    link.ready(0);
    link
}

/// A number from -1 to 1.
fn noise(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 16) as f32 / 32_768.0 - 1.0
}

/// What two seconds led to: noise of `size`, which is ten times as loud from 1.5 s to 1.6 s.
#[derive(Debug, Default)]
struct Ran {
    slips: usize,
    grips: usize,
    obeyed: bool,
    commands: usize,
    signal: Option<Signal>,
    refusal: Option<String>,
}

fn run(mut board: DeviceLink, mut session: Session, size: f32) -> Ran {
    let (mut ran, mut seed, mut to_host, mut frame) =
        (Ran::default(), 1, Vec::new(), [0; MAX_WIRE]);
    session.open(0, 7).unwrap();
    for row in 0..2 * u64::from(RATE_HZ) {
        let now_us = 625 * row;
        let loud = (2400..2560).contains(&row);
        let value = size * noise(&mut seed) * if loud { 10.0 } else { 1.0 };
        // Rows before START are refused, which is right.
        let _ = board.push_f32(now_us, &[value]);
        while let Some(len) = board.poll_transmit(now_us, &mut frame) {
            to_host.extend_from_slice(&frame[..len]);
        }
        let bytes = core::mem::take(&mut to_host);
        let mut left = &bytes[..];
        while let Some(update) = session.receive(now_us, &mut left).unwrap() {
            match update {
                Update::Event(Event::Slip(_)) => ran.slips += 1,
                Update::Began(begun) => ran.signal = Some(begun.config.signal),
                Update::Step { step, .. } => ran.commands += usize::from(step.command.is_some()),
                _ => {}
            }
        }
        ran.refusal = session.refusal().map(|error| error.to_string()).or(ran.refusal);
        ran.obeyed |= session.obey(now_us, ClientCommand::AtLeast(5.0));
        let mut to_board = Vec::new();
        while let Some(len) = session.poll_transmit(now_us, &mut frame) {
            to_board.extend_from_slice(&frame[..len]);
        }
        if let Some(len) = session.command(now_us, &mut frame) {
            to_board.extend_from_slice(&frame[..len]);
        }
        let mut bytes = &to_board[..];
        while let Some(event) = board.receive(now_us, &mut bytes) {
            ran.grips += usize::from(matches!(event, DeviceEvent::Command(_)));
        }
        board.drive(now_us);
    }
    ran
}

fn session(config: HostConfig, observe: bool) -> Session {
    let options = SessionOptions { observe, ..SessionOptions::default() };
    Session::new(config, model::default_estimator().unwrap(), options).unwrap()
}

#[test]
fn a_board_without_an_actuator_finds_slips_in_any_unit_and_gets_no_command() {
    for (unit, size) in [(Unit::MetrePerSecond2, 0.01), (Unit::None, 300.0), (Unit::None, 1e-4)] {
        let ran = run(board(unit, 0), session(HostConfig::default(), false), size);
        assert_eq!(ran.signal, Some(Signal::Vibration), "{ran:?}");
        assert!(ran.slips >= 1, "{unit:?} {size}: {ran:?}");
        assert_eq!((ran.grips, ran.commands, ran.obeyed), (0, 0, false), "{ran:?}");
    }
}

#[test]
fn who_only_observes_computes_no_command_although_there_is_an_actuator() {
    let ran = run(board(Unit::None, 20_000), session(HostConfig::default(), true), 1.0);
    assert!(ran.slips >= 1, "{ran:?}");
    assert_eq!((ran.grips, ran.commands, ran.obeyed), (0, 0, false), "{ran:?}");
    let ran = run(board(Unit::None, 20_000), session(HostConfig::default(), false), 1.0);
    assert!(ran.grips > 0 && ran.commands > 0, "the same board is commanded otherwise: {ran:?}");
}

/// A calibration of a vibration, at 1600 Hz: floors of noise of 1.
fn calibrated(vibration: bool) -> HostConfig {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cal.toml");
    let text = format!(
        "sample_rate_hz = 1600.0\nvibration = {vibration}\n\
         floor = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]\nslack_still = [3.0, 3.0, 8.0, 8.0, 3.0, 3.0, 1.0]\n\
         slack_moving = [8.0, 3.0, 8.0, 8.0, 3.0, 3.0, 1.0]\n[evidence]\nwanted_interval_s = 600.0\nrest_s = 300.0\nmotion_s = 0.0\n\
         unsteady = 1.2\nseen = 0\njudged_s = 150.0\nalarms = 0\ninterval_low_s = 50.1\n"
    );
    std::fs::write(&file, text).unwrap();
    HostConfig::default().with_calibration(&file).unwrap()
}

#[test]
fn a_calibration_of_a_vibration_is_taken_where_the_channel_is_one() {
    let ran = run(board(Unit::None, 0), session(calibrated(true), false), 1.0);
    assert!(ran.slips >= 1 && ran.refusal.is_none(), "{ran:?}");
    let ran = run(board(Unit::Metre, 0), session(calibrated(true), false), 1e-6);
    assert!(ran.refusal.is_some_and(|text| text.contains("vibration")), "heights are none");
}
