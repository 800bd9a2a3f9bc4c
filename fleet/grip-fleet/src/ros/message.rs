//! Encoder of STATE and SLIP of a daemon as the bytes of ROS 2 messages.

use super::topic::RosTopic;
use crate::{id::EventId, message::Message};
use grip_link::message::daemon::{PipelineState, SlipReport, ToClient};
use grip_record::mcap::CdrWriter;

/// The one joint of a gripper: what its fingers press with.
const JOINT: &str = "fingers";

/// When something was (ns since 1970).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp(pub u64);

/// The messages of ROS 2 for one of a daemon: two for STATE, one for SLIP, none for the others. `start_ns` is what the clock showed at the
/// daemon's start (ns since 1970), from which the daemon counts; `id` the number of the event.
#[must_use]
pub fn messages(message: &Message, id: EventId, start_ns: u64) -> Vec<(RosTopic, Vec<u8>)> {
    let stamp = |host_us: u64| Stamp(start_ns.saturating_add(host_us.saturating_mul(1000)));
    match message.read() {
        Ok(ToClient::State(state)) => {
            let stamp = stamp(state.host.0);
            vec![
                (RosTopic::JointStates, joint_state(&state, stamp)),
                (RosTopic::State, grip_state(&state, stamp)),
            ]
        }
        Ok(ToClient::Slip(slip)) => {
            vec![(RosTopic::Slip, slip_event(&slip, id, stamp(slip.host.0)))]
        }
        // Of what cannot be read nothing can be said.
        Ok(_) | Err(_) => Vec::new(),
    }
}

/// `sensor_msgs/msg/JointState`: the measured normal force (N) as the effort of the joint `fingers`, empty where it is not known. Position and
/// velocity are empty: no daemon knows where the fingers are, and what the travel channel measures is the object.
#[must_use]
pub fn joint_state(state: &PipelineState, stamp: Stamp) -> Vec<u8> {
    let mut out = Vec::with_capacity(64);
    let mut w = header(&mut out, stamp);
    w.u32(1).text(JOINT).u32(0).u32(0);
    match state.applied_n {
        Some(force) => w.u32(1).f64(force.into()),
        None => w.u32(0),
    };
    out
}

/// `grip_msgs/msg/GripState`.
#[must_use]
pub fn grip_state(state: &PipelineState, stamp: Stamp) -> Vec<u8> {
    let mut out = Vec::with_capacity(104);
    let mut w = header(&mut out, stamp);
    w.u64(state.t.0).u8(state.scene.code()).u8(state.grip.code());
    let [stylus, travel, pressure, reference] = state.sensors.map(|health| health.code());
    w.u8(stylus).u8(travel).u8(pressure).u8(reference);
    w.u8(state.device.code()).u16(state.fault.0);
    maybe(&mut w, &[state.statistic, state.command_n, state.applied_n, state.estimate_n]);
    w.bool(state.is_extrapolated()).u8(state.esc_kind.code());
    maybe(&mut w, &[state.esc]);
    w.bool(state.is_informative()).u8(state.esc_flags);
    w.u32(state.rate_hz).u64(state.lost);
    maybe(&mut w, &[state.need_low_n, state.need_n, state.need_high_n, state.admissible_m_s2]);
    out
}

/// `grip_msgs/msg/SlipEvent`; `id` is its number among the events of the fleet.
#[must_use]
pub fn slip_event(slip: &SlipReport, id: EventId, stamp: Stamp) -> Vec<u8> {
    let mut out = Vec::with_capacity(128);
    let mut w = header(&mut out, stamp);
    w.u32(id.run).u64(id.seq).u32(slip.number).u64(slip.t.0);
    w.u8(slip.phase.code()).u8(slip.method.code()).u8(slip.speed_source.code());
    maybe(&mut w, &[slip.statistic, slip.confidence]);
    maybe(&mut w, &[slip.speed_m_s, slip.speed_sigma_m_s, slip.moved_m]);
    w.u32(slip.irregularities.unwrap_or(u32::MAX));
    maybe(&mut w, &[slip.esc_w.map(single)]);
    w.u8(slip.esc_kind.code());
    maybe(&mut w, &[slip.esc.map(single)]);
    w.bool(slip.is_informative()).u8(slip.esc_flags);
    maybe(&mut w, &[slip.estimate_n]);
    w.bool(slip.is_extrapolated());
    maybe(&mut w, &[slip.command_n, slip.duration_s.map(single)]);
    w.u8(slip.ruled_out).u8(slip.possible);
    maybe(&mut w, &[slip.certified_s]);
    out
}

/// Begins a message with a `std_msgs/Header` of no frame.
fn header(out: &mut Vec<u8>, stamp: Stamp) -> CdrWriter<'_> {
    let mut w = CdrWriter::new(out);
    w.time(stamp.0).text("");
    w
}

/// As it travelled.
#[expect(clippy::cast_possible_truncation, reason = "it came with seven digits")]
const fn single(value: f64) -> f32 {
    value as f32
}

/// Values that may not be known.
fn maybe(w: &mut CdrWriter<'_>, values: &[Option<f32>]) {
    for value in values {
        w.f32(value.unwrap_or(f32::NAN));
    }
}

#[cfg(test)]
mod tests {
    use super::{EventId, Message, PipelineState, RosTopic, SlipReport, Stamp, messages};
    use crate::message::wire;
    use grip_link::message::daemon::EXTRAPOLATED;
    use grip_link::message::{
        DeviceState, FaultCode, Kind,
        daemon::{GripState, Health, Method, Phase, Reading, Scene, SensorHealth, SpeedSource},
    };
    use slip_core::units::Micros;

    const START_NS: u64 = 1_763_766_000_000_000_000;
    const ID: EventId = EventId { run: 0x0102_0304, seq: 9 };

    fn frame(kind: Kind, write: impl FnOnce(&mut [u8]) -> usize) -> Message {
        Message::from_wire(&wire(kind, write)).unwrap()
    }

    fn state(applied_n: Option<f32>) -> PipelineState {
        PipelineState {
            t: Micros(7),
            host: Micros(1_500_000),
            scene: Scene::Holding,
            grip: GripState::Slipping,
            sensors: [
                SensorHealth::Good,
                SensorHealth::Jumped,
                SensorHealth::Failed,
                SensorHealth::Lost,
            ],
            device: DeviceState::Active,
            notes: EXTRAPOLATED,
            fault: FaultCode(0x0202),
            esc_kind: Reading::LiftWork,
            esc: None,
            esc_flags: 4,
            statistic: Some(0.5),
            command_n: Some(2.0),
            applied_n,
            estimate_n: None,
            rate_hz: 1000,
            lost: 3,
            late_ms: None,
            need_low_n: Some(3.0),
            need_n: Some(4.0),
            need_high_n: None,
            admissible_m_s2: Some(2.25),
        }
    }

    #[test]
    fn a_state_becomes_a_joint_and_a_state() {
        let reported = frame(Kind::STATE, |out| state(Some(1.5)).write(out).unwrap());
        let reported = messages(&reported, ID, START_NS);
        let topics: Vec<RosTopic> = reported.iter().map(|(topic, _)| *topic).collect();
        assert_eq!(topics, [RosTopic::JointStates, RosTopic::State]);
        // Written by hand: time; no frame, to the next multiple of four; one name; no position, no velocity; one effort at a multiple of eight.
        let mut joint = vec![0, 1, 0, 0];
        joint.extend_from_slice(&1_763_766_001_u32.to_le_bytes());
        joint.extend_from_slice(&500_000_000_u32.to_le_bytes());
        joint.extend_from_slice(b"\x01\0\0\0\0\0\0\0");
        joint.extend_from_slice(b"\x01\0\0\0\x08\0\0\0fingers\0");
        joint.extend_from_slice(&[0; 8]);
        joint.extend_from_slice(b"\x01\0\0\0\0\0\0\0");
        joint.extend_from_slice(&1.5_f64.to_le_bytes());
        assert_eq!(reported[0].1, joint);
        let need = [3.0, 4.0, f32::NAN, 2.25].map(f32::to_le_bytes);
        assert!(reported[1].1.ends_with(&need.concat()), "{:?}", reported[1].1);
    }

    #[test]
    fn a_force_that_is_not_known_is_no_effort() {
        let stamp = Stamp(START_NS);
        let (known, unknown) = (state(Some(0.0)), state(None));
        let known = super::joint_state(&known, stamp);
        let unknown = super::joint_state(&unknown, stamp);
        assert!(known.len() > unknown.len());
        assert!(unknown.ends_with(&[0; 12]), "position, velocity and effort are empty");
    }

    #[test]
    fn a_slip_bears_its_number_and_other_updates_are_nothing_to_ros() {
        let slip = SlipReport {
            number: 4,
            t: Micros(5),
            host: Micros(u64::MAX),
            phase: Phase::Ended,
            method: Method::None,
            speed_source: SpeedSource::TwoStyli,
            esc_kind: Reading::Literal,
            ..SlipReport::UNKNOWN
        };
        let reported = messages(&frame(Kind::SLIP, |out| slip.write(out).unwrap()), ID, START_NS);
        let [(RosTopic::Slip, bytes)] = reported.as_slice() else { panic!("{reported:?}") };
        assert_eq!(bytes[20..24], ID.run.to_le_bytes());
        let health = frame(Kind::HEALTH, |out| Health::default().write(out).unwrap());
        assert_eq!(messages(&health, ID, START_NS), []);
    }
}
