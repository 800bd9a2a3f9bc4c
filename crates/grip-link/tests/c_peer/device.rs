//! A script of ticks and bytes in, all that the device of this crate does out, in the words of the C program.

use crate::peer::{assert_same, hex, run, unhex};
use crate::script;
use grip_link::device::{DeviceConfig, DeviceEvent, DeviceLink, Drive, RowError};
use grip_link::frame::MAX_WIRE;
use grip_link::message::{
    Channel, ChannelKind, DeviceState, FaultCode, Firmware, Ident, Limits, LogLevel, MAX_CHANNELS,
    Reaction, ResetReason, Versions,
};

/// The gripper of the peers; `Reaction` is what an ESTOP does.
pub(crate) fn gripper(estop: Reaction) -> DeviceLink {
    let mut channels = [Ident::NO_CHANNEL; MAX_CHANNELS];
    channels[0] = Channel::single(ChannelKind::Stylus, 1e-8);
    channels[1] = Channel::single(ChannelKind::NormalForce, 1e-3);
    channels[2] = Channel { count: 4, ..Channel::single(ChannelKind::PressureArray, 10.0) };
    let ident = Ident {
        versions: Versions::OURS,
        max_rx: 480,
        caps: 0,
        uid: *b"grip-link-test-1",
        boot_id: 0xB007,
        tick_hz: 1_000_000,
        limits: Limits {
            rate_max_hz: 20_000,
            force_max_mn: 20_000,
            slew_max_mn_s: 400_000,
            hold_cap_mn: 15_000,
            travel_min_um: 0,
            travel_max_um: 50_000,
        },
        firmware: Firmware { major: 1, minor: 2, patch: 3 },
        reset: ResetReason::PowerOn,
        state: DeviceState::Idle,
        fault: FaultCode::NONE,
        channels,
        channel_count: 3,
    };
    DeviceLink::new(DeviceConfig { ident, estop }).unwrap()
}

fn event_line(event: &DeviceEvent) -> String {
    match event {
        DeviceEvent::Linked { session } => format!("linked {session:04x}"),
        DeviceEvent::Configured(c) => format!(
            "configured {} {} {} {} {} {} {} {} {} {}",
            c.sample_rate_hz,
            c.batch,
            c.format.code(),
            c.ttl_ms,
            c.channel_mask,
            c.force_max_mn,
            c.slew_mn_s,
            c.hold_cap_mn,
            c.loss_after_ms,
            c.loss_action.code()
        ),
        DeviceEvent::Started => "started".into(),
        DeviceEvent::Stopped => "stopped".into(),
        DeviceEvent::Command(g) | DeviceEvent::Rejected(g) => {
            let word =
                if matches!(event, DeviceEvent::Command(_)) { "command" } else { "rejected" };
            format!(
                "{word} {} {} {} {} {} {} {}",
                g.cmd_id, g.mode, g.flags, g.ttl_ms, g.force_mn, g.slew_mn_s, g.cause_sample
            )
        }
        DeviceEvent::Heartbeat(h) => {
            format!("heartbeat {} {} {} {}", h.turns, h.longest_us, h.late, h.flags)
        }
        DeviceEvent::Estop => "estop".into(),
        DeviceEvent::Cleared(fault) => format!("cleared {:04x}", fault.0),
    }
}

fn drive_line(device: &mut DeviceLink, tick: u64) -> String {
    let drive = device.drive(tick);
    let kind = match drive {
        Drive::Passive => "passive",
        Drive::Force(_) => "force",
        Drive::Open => "open",
    };
    let (state, fault) = (device.state().code(), device.fault().0);
    format!("drive {kind} {} state {state} fault {fault:04x}", drive.force_mn())
}

fn row_line(result: Result<(), RowError>) -> String {
    let word = match result {
        Ok(()) => "taken",
        Err(RowError::NotSampling) => "not sampling",
        Err(RowError::Format { .. }) => "format",
        Err(RowError::Elements { .. }) => "elements",
    };
    format!("row {word}")
}

/// Does one command; the lines that come of it.
pub(crate) fn step(device: &mut DeviceLink, line: &str) -> Vec<String> {
    let word: Vec<&str> = line.split(' ').collect();
    let tick = word[1].parse().unwrap();
    let mut out = [0; MAX_WIRE];
    match word[0] {
        "new" => {
            let passive = word.get(2) == Some(&"passive");
            *device = gripper(if passive { Reaction::Passive } else { Reaction::Hold });
        }
        "ready" => device.ready(tick),
        "rx" => {
            let bytes = unhex(word[2]);
            let mut input = &bytes[..];
            let events = core::iter::from_fn(|| device.receive(tick, &mut input));
            return events.map(|event| event_line(&event)).collect();
        }
        "tx" => {
            let frames = core::iter::from_fn(|| {
                device
                    .poll_transmit(tick, &mut out)
                    .map(|len| format!("frame {}", hex(&out[..len])))
            });
            return frames.take(word[2].parse().unwrap()).collect();
        }
        "drive" => return vec![drive_line(device, tick)],
        "i16" => {
            let row: Vec<i16> = word[2..].iter().map(|text| text.parse().unwrap()).collect();
            return vec![row_line(device.push_i16(tick, &row))];
        }
        "f32" => {
            let bits = |text: &&str| f32::from_bits(u32::from_str_radix(text, 16).unwrap());
            let row: Vec<f32> = word[2..].iter().map(bits).collect();
            return vec![row_line(device.push_f32(tick, &row))];
        }
        "fault" => {
            device.raise_fault(tick, FaultCode(u16::from_str_radix(word[2], 16).unwrap()));
        }
        "estop" => device.estop(tick),
        "travel" => device.report_travel(word[2].parse().unwrap()),
        "force" => device.report_force(word[2].parse().unwrap()),
        "motion" => device.report_motion(tick, word[2] == "1"),
        "alive" => return vec![format!("alive {}", u8::from(device.take_alive()))],
        "log" => {
            let text = String::from_utf8(unhex(word[3])).unwrap();
            let level = LogLevel::from_code(word[2].parse().unwrap());
            let len = device.log(tick, level, &text, &mut out).unwrap_or(0);
            return vec![format!("log {}", hex(&out[..len]))];
        }
        other => panic!("{other}"),
    }
    vec![]
}

#[test]
fn same_behaviour_on_random_scripts() {
    let mut seen = std::collections::HashSet::new();
    for seed in 0..40 {
        let (script, expected) = script::play(seed, 3000);
        for line in &expected {
            seen.insert(line.split(' ').next().unwrap().to_owned());
            if let Some((_, state)) = line.split_once("state ") {
                seen.insert(format!("state {}", state.split(' ').next().unwrap()));
            }
        }
        assert_same(&format!("seed {seed}"), &expected, &run("device", &script));
    }
    for event in [
        "linked",
        "configured",
        "started",
        "stopped",
        "command",
        "rejected",
        "heartbeat",
        "estop",
        "cleared",
        "log",
    ] {
        assert!(seen.contains(event), "no {event} in any script");
    }
    for state in 0..=8 {
        assert!(seen.contains(&format!("state {state}")), "state {state} was never reached");
    }
}
