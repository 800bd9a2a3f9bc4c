//! A gripper with a taxel array over a pseudo-terminal: its frames are recorded beside the samples, and a replay states the same.

use crate::{live::replays_identically, run::gripd};
use core::sync::atomic::{AtomicBool, Ordering};
use grip_link::{
    device::{DeviceConfig, DeviceLink},
    frame::MAX_WIRE,
    message::{
        Channel, ChannelKind, DeviceState, FaultCode, Firmware, Ident, Limits, Reaction,
        ResetReason, Versions,
    },
};
use grip_record::{CsvOptions, read_csv};
use grip_sim::Pty;
use std::{fs, thread};

const TAXELS: u8 = 6;

fn device() -> DeviceLink {
    let mut ident = Ident {
        versions: Versions::OURS,
        max_rx: 480,
        caps: 0,
        uid: *b"taxels taxels 01",
        boot_id: 1,
        tick_hz: 1_000_000,
        limits: Limits {
            rate_max_hz: 10_000,
            force_max_mn: 60_000,
            slew_max_mn_s: 2_000_000,
            hold_cap_mn: 60_000,
            travel_min_um: 0,
            travel_max_um: 50_000,
        },
        firmware: Firmware { major: 1, minor: 0, patch: 0 },
        reset: ResetReason::PowerOn,
        state: DeviceState::Boot,
        fault: FaultCode::NONE,
        channels: [Ident::NO_CHANNEL; 16],
        channel_count: 3,
    };
    ident.channels[0] = Channel::single(ChannelKind::Stylus, 1e-8);
    ident.channels[1] = Channel::single(ChannelKind::NormalForce, 1e-3);
    let array = Channel::single(ChannelKind::PressureArray, 1.0);
    ident.channels[2] = Channel { count: TAXELS, ..array };
    let mut device = DeviceLink::new(DeviceConfig { ident, estop: Reaction::Hold }).unwrap();
    device.ready(0);
    device
}

/// A number from -1 to 1.
fn noise(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f32::from(u16::try_from(*state >> 16).unwrap()) / 32_768.0 - 1.0
}

/// The row of millisecond `t`: something held at rest, of which the pattern wanders at constant sum for 200 ms of each second. The
/// array is half as fast as the stylus, and now and then a taxel has no reading.
fn row(t: u32, state: &mut u32) -> Vec<f32> {
    let mut row = vec![1e-4 + 1e-7 * noise(state), 5.0];
    let wander = if t % 1000 < 200 { 1.5 * (t % 1000) as f32 } else { 0.0 };
    for k in 0..TAXELS {
        let side = if k % 2 == 0 { wander } else { -wander };
        let value = 500.0 + 40.0 * f32::from(k) + side + noise(state);
        let absent = t % 2 == 1 || (t % 50 == 10 && k == 3);
        row.push(if absent { f32::NAN } else { value });
    }
    row
}

/// Serves the line, a millisecond of device time a turn, until `over`.
fn serve(pty: &Pty, over: &AtomicBool) {
    let (mut device, mut state, mut frame, mut input) = (device(), 1, [0; MAX_WIRE], [0; 4096]);
    for t in 0_u32.. {
        if over.load(Ordering::Relaxed) {
            return;
        }
        let tick = 1000 * u64::from(t);
        if pty.wait(1000, false).is_ok_and(|ready| ready.read) {
            let count = pty.read(&mut input).unwrap_or(0);
            let mut bytes = &input[..count];
            while device.receive(tick, &mut bytes).is_some() {}
        }
        // Rows before START are refused, which is right.
        let _ = device.push_f32(tick, &row(t, &mut state));
        device.drive(tick);
        while let Some(len) = device.poll_transmit(tick, &mut frame) {
            let _ = pty.write(&frame[..len]);
        }
    }
}

#[test]
fn frames_are_recorded_and_replayed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("gripd.toml"), "[link]\nsample_rate_hz = 1000\nbatch = 4\n")
        .unwrap();
    let pty = Pty::open(None).unwrap();
    let port = pty.port().display().to_string();
    let over = AtomicBool::new(false);
    let ran = thread::scope(|threads| {
        threads.spawn(|| serve(&pty, &over));
        let args = ["--port", &port, "--duration", "4", "--json", "--record", "run.csv"];
        let ran = gripd(folder.path(), &args);
        over.store(true, Ordering::Relaxed);
        ran.done()
    });
    let events = ran.json();
    assert!(
        events.iter().any(|line| line["type"] == "slip" && line["method"] == "pressure"),
        "the frames are heard: {events:?}"
    );
    let file = folder.path().join("run.csv");
    let recording = read_csv(&file, &CsvOptions::default()).unwrap();
    let taxels = recording.taxels.as_ref().unwrap();
    assert_eq!(taxels.count(), usize::from(TAXELS));
    let frames: Vec<&[f32]> =
        (0..recording.samples.len()).map(|i| taxels.frame(i)).filter(|f| !f.is_empty()).collect();
    assert!(2 * frames.len() + 4 > recording.samples.len(), "every second sample has a frame");
    assert!(frames.iter().any(|frame| frame[3].is_nan() && frame[2] > 500.0));
    let config = grip_session::HostConfig::read(&folder.path().join("gripd.toml")).unwrap();
    replays_identically(&file, &ran, &config);
}
