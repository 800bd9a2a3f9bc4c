//! Every code, and no other, has its row.

use crate::markdown::{pairs, table};
use crate::source;
use core::fmt::Debug;
use grip_link::clock::PongVerdict;
use grip_link::host::LinkState;
use grip_link::message::daemon;
use grip_link::message::{
    ChannelKind, Clamped, Config, DeviceState, EventKind, FaultCode, ForceClamp, GripMode,
    LogLevel, LossAction, NackReason, Reaction, ResetReason, SampleFormat, StatusFlags, Unit,
};
use std::collections::BTreeMap;

/// `PowerOn` to `POWER_ON`.
pub(crate) fn upper(value: &impl Debug) -> String {
    let mut name = String::new();
    let mut after_small = false;
    for letter in format!("{value:?}").chars() {
        if letter.is_uppercase() && after_small {
            name.push('_');
        }
        after_small = !letter.is_uppercase();
        name.extend(letter.to_uppercase());
    }
    name
}

/// The rows of a table are exactly the codes that have a meaning.
fn check<T: Debug>(heading: &str, from_code: impl Fn(u8) -> Option<T>) {
    let meant = |code| from_code(code).map(|value| (code, upper(&value)));
    let expected: BTreeMap<u8, String> =
        (0..=255).filter_map(meant).filter(|(_, name)| !name.starts_with("OTHER(")).collect();
    let written: Vec<_> = pairs(heading, 0, 1);
    let rows: BTreeMap<u8, String> =
        written.iter().map(|(code, name)| (code.parse().unwrap(), name.clone())).collect();
    assert_eq!(rows, expected, "{heading}");
    assert_eq!(written.len(), expected.len(), "{heading}");
}

#[test]
fn enumerations() {
    check("### Device states", |code| Some(DeviceState::from_code(code)));
    check("### Reset reasons", |code| Some(ResetReason::from_code(code)));
    check("### Channel kinds", |code| Some(ChannelKind::from_code(code)));
    check("### Units", |code| Some(Unit::from_code(code)));
    check("### NACK reasons", |code| Some(NackReason::from_code(code)));
    check("### Event kinds", |code| Some(EventKind::from_code(code)));
    check("### Log levels", |code| Some(LogLevel::from_code(code)));
    check("### Sample formats", SampleFormat::from_code);
    check("### Grip modes", GripMode::from_code);
    check("### Loss actions", LossAction::from_code);
}

#[test]
fn enumerations_of_the_daemon() {
    check("### Slip phases", |code| Some(daemon::Phase::from_code(code)));
    check("### Slip methods", |code| Some(daemon::Method::from_code(code)));
    check("### Speed sources", |code| Some(daemon::SpeedSource::from_code(code)));
    check("### Readings of E_sc", |code| Some(daemon::Reading::from_code(code)));
    check("### Scenes", |code| Some(daemon::Scene::from_code(code)));
    check("### Grip stages", |code| Some(daemon::GripState::from_code(code)));
    check("### Sensors", |code| Some(daemon::Sensor::from_code(code)));
    check("### Sensor healths", |code| Some(daemon::SensorHealth::from_code(code)));
    check("### Link states", |code| Some(LinkState::from_code(code)));
    check("### Recording states", |code| Some(daemon::Recording::from_code(code)));
    check("### Real-time grants", |code| Some(daemon::RealTime::from_code(code)));
    check("### Notice kinds", |code| Some(daemon::NoticeKind::from_code(code)));
    check("### Dropped classes", |code| Some(daemon::DroppedClass::from_code(code)));
    check("### Reasons of a goodbye", |code| Some(daemon::Goodbye::from_code(code)));
    check("### Client operations", daemon::Operation::from_code);
}

#[test]
fn units_of_channels_and_sizes_of_formats() {
    for row in table("### Channel kinds") {
        let kind = ChannelKind::from_code(row[0].parse().unwrap());
        assert_eq!(row[2], upper(&kind.unit()), "{}", row[1]);
    }
    for row in table("### Sample formats") {
        let format = SampleFormat::from_code(row[0].parse().unwrap()).unwrap();
        assert_eq!(row[2], format.size().to_string(), "{}", row[1]);
    }
}

#[test]
fn faults_and_their_reactions() {
    let rows = table("### Fault codes");
    let code = |row: &[String]| u16::from_str_radix(&row[0], 16).unwrap();
    let written: BTreeMap<String, u64> =
        rows.iter().map(|row| (row[1].clone(), u64::from(code(row)))).collect();
    assert_eq!(written, source::codes("../../slip-msg/src/fault.rs", "FaultCode"));
    assert_eq!(rows.len(), written.len());
    let mut holds = vec![FaultCode::ESTOP.0];
    for row in rows.iter().filter(|row| code(row) > 1) {
        let reaction = if row[2] == "hold" { Reaction::Hold } else { Reaction::Passive };
        assert_eq!(FaultCode(code(row)).reaction(), reaction, "{}", row[1]);
        holds.extend((reaction == Reaction::Hold).then(|| code(row)));
    }
    for other in (0..=u16::MAX).filter(|code| !holds.contains(code)) {
        assert_eq!(FaultCode(other).reaction(), Reaction::Passive, "{other:04x}");
    }
}

/// Bit numbers of a table against those of a type.
fn check_bits(heading: &str, bits: &[(u8, &str)]) {
    let written = pairs(heading, 0, 1).into_iter();
    let written: Vec<_> = written.map(|(bit, name)| (bit.parse().unwrap(), name)).collect();
    let bits: Vec<_> = bits.iter().map(|(bit, name)| (*bit, (*name).to_owned())).collect();
    assert_eq!(written, bits, "{heading}");
}

#[test]
fn bit_sets() {
    check_bits("### Clamp bits", ForceClamp::BITS);
    check_bits("### Status flags", StatusFlags::BITS);
    check_bits("### Topics", daemon::Topics::BITS);
    check_bits("### Welcome flags", daemon::WelcomeFlags::BITS);
    check_bits("### Row channels", daemon::RowSet::BITS);
}

#[test]
fn clamped_fields() {
    let old = crate::targets::gripper::CONFIG;
    let rows = table("### Clamped fields");
    assert_eq!(rows.len(), 8);
    for row in rows {
        let new = match row[2].split(';').next().unwrap() {
            "sample_rate_hz" => Config { sample_rate_hz: 1, ..old },
            "batch" => Config { batch: 1, ..old },
            "channel_mask" => Config { channel_mask: 9, ..old },
            "force_max_mn" => Config { force_max_mn: 1, ..old },
            "slew_mn_s" => Config { slew_mn_s: 1, ..old },
            "ttl_ms" => Config { ttl_ms: 1, ..old },
            "hold_cap_mn" => Config { hold_cap_mn: 1, ..old },
            "loss_after_ms" => Config { loss_after_ms: 1, ..old },
            other => panic!("no field {other}"),
        };
        let bit: u32 = row[0].parse().unwrap();
        assert_eq!(Clamped::between(&old, &new), Clamped(1 << bit), "{}", row[1]);
    }
}

#[test]
fn states_and_verdicts_of_the_host() {
    use LinkState as S;
    use PongVerdict as P;
    let states = [S::Closed, S::Open, S::Hello, S::Config, S::Stream, S::Degraded];
    let names: Vec<String> = states.iter().map(upper).collect();
    assert_eq!(
        table("### Host states").iter().map(|row| row[0].clone()).collect::<Vec<_>>(),
        names
    );
    let verdicts = [P::Kept, P::Slow, P::Outlier, P::Impossible, P::Restarted];
    let names: Vec<String> = verdicts.iter().map(upper).collect();
    assert_eq!(
        table("### PONG verdicts").iter().map(|row| row[0].clone()).collect::<Vec<_>>(),
        names
    );
}
