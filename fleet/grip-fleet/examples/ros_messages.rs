//! Prints messages of a gripper's ROS 2 node and what is in them, one as JSON a line, for a check by other implementations
//! (`scripts/ros-check.sh`). Every number is one that its field's bytes hold exactly and that no other field has.

#![expect(clippy::print_stdout, reason = "this is what it is for")]

use grip_fleet::{
    EventId, Member, Uid,
    ros::{Attachment, Gid, RosNode, RosTopic, Stamp, grip_state, joint_state, slip_event},
};
use grip_link::message::{
    DeviceState, FaultCode,
    daemon::{
        EXTRAPOLATED, GripState, INFORMATIVE, Method, Phase, PipelineState, Reading, Scene,
        SensorHealth, SlipReport, SpeedSource,
    },
};
use serde_json::{Value, json};
use slip_core::units::Micros;

const STAMP: Stamp = Stamp(1_763_766_123_456_789_012);
const ID: EventId = EventId { run: 0x8102_0304, seq: 0x0506_0708_090A_0B0C };
const SESSION: &str = "8b20917502ee955ac4476e0266340d5c";

fn header() -> Value {
    json!({ "stamp": { "sec": 1_763_766_123, "nanosec": 456_789_012 }, "frame_id": "" })
}

/// A state in which everything is known, or nothing.
fn state(known: bool) -> PipelineState {
    let maybe = |value: f32| known.then_some(value);
    PipelineState {
        t: Micros(0x1112_1314_1516_1718),
        host: Micros(0),
        scene: Scene::Holding,
        grip: GripState::Released,
        sensors: [
            SensorHealth::Frozen,
            SensorHealth::Jumped,
            SensorHealth::Failed,
            SensorHealth::Drifting,
        ],
        device: DeviceState::LossAction,
        notes: if known { INFORMATIVE } else { EXTRAPOLATED },
        fault: FaultCode(0x2122),
        esc_kind: Reading::SlopePower,
        esc: maybe(-0.5),
        esc_flags: 9,
        statistic: maybe(1.25),
        command_n: maybe(2.5),
        applied_n: maybe(2.375),
        estimate_n: maybe(3.75),
        rate_hz: 0x3132_3334,
        lost: 0x4142_4344_4546_4748,
        late_ms: None,
        need_low_n: maybe(3.25),
        need_n: maybe(4.5),
        need_high_n: maybe(6.75),
        admissible_m_s2: maybe(1.125),
    }
}

fn shown_state(known: bool) -> Value {
    let maybe = |value: f64| known.then_some(value);
    json!({
        "header": header(), "device_time_us": 0x1112_1314_1516_1718_u64, "scene": 2, "grip": 7,
        "stylus_health": 1, "travel_health": 5, "pressure_health": 3, "reference_health": 4,
        "device": 6, "fault": 0x2122, "statistic": maybe(1.25), "command_n": maybe(2.5),
        "applied_n": maybe(2.375), "estimate_n": maybe(3.75), "extrapolated": !known,
        "esc_kind": 3, "esc": maybe(-0.5), "esc_informative": known, "esc_flags": 9,
        "sample_rate_hz": 0x3132_3334, "lost": 0x4142_4344_4546_4748_u64,
        "need_low_n": maybe(3.25), "need_n": maybe(4.5), "need_high_n": maybe(6.75),
        "admissible_m_s2": maybe(1.125),
    })
}

fn shown_joint(known: bool) -> Value {
    let effort: &[f64] = if known { &[2.375] } else { &[] };
    json!({
        "header": header(), "name": ["fingers"], "position": [], "velocity": [], "effort": effort,
    })
}

/// A slip of which everything is known, or nothing.
fn slip(known: bool) -> SlipReport {
    let maybe = |value: f32| known.then_some(value);
    SlipReport {
        number: 0x5152_5354,
        t: Micros(0x6162_6364_6566_6768),
        host: Micros(0),
        phase: Phase::Ended,
        method: Method::Travel,
        speed_source: SpeedSource::Gravity,
        esc_kind: Reading::LiftWork,
        statistic: maybe(8.5),
        confidence: maybe(0.75),
        speed_m_s: maybe(0.0625),
        speed_sigma_m_s: maybe(0.125),
        moved_m: maybe(0.015_625),
        irregularities: known.then_some(0x7172_7374),
        esc_w: known.then_some(-16.5),
        esc: known.then_some(17.5),
        esc_flags: 6,
        notes: if known { EXTRAPOLATED } else { INFORMATIVE },
        estimate_n: maybe(18.5),
        command_n: maybe(19.5),
        duration_s: known.then_some(20.5),
        ruled_out: 0b1_0001,
        possible: 0b0_0110,
        certified_s: maybe(600.0),
        ..SlipReport::UNKNOWN
    }
}

fn shown_slip(known: bool) -> Value {
    let maybe = |value: f64| known.then_some(value);
    json!({
        "header": header(), "run": 0x8102_0304_u32, "event": 0x0506_0708_090A_0B0C_u64,
        "number": 0x5152_5354, "device_time_us": 0x6162_6364_6566_6768_u64, "phase": 3, "method": 2,
        "speed_source": 5, "statistic": maybe(8.5), "confidence": maybe(0.75),
        "speed_m_s": maybe(0.0625), "speed_sigma_m_s": maybe(0.125), "moved_m": maybe(0.015_625),
        "irregularities": if known { 0x7172_7374 } else { u32::MAX }, "esc_w": maybe(-16.5),
        "esc_kind": 4, "esc": maybe(17.5), "esc_informative": !known, "esc_flags": 6,
        "estimate_n": maybe(18.5), "extrapolated": known, "command_n": maybe(19.5),
        "duration_s": maybe(20.5), "ruled_out": 17, "possible": 6, "certified_s": maybe(600.0),
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn print(node: &RosNode, topic: RosTopic, bytes: &[u8], fields: &Value) {
    let token = node.publisher_token(SESSION, topic);
    let gid = Gid::of(&token);
    let attachment = Attachment { sequence: 0x0102, source_ns: 1_763_766_124_000_000_001, gid };
    let line = json!({
        "topic": node.topic(topic), "type": topic.ros_type(), "hash": topic.hash(),
        "domain": 42, "node": node.name(), "key": node.key(topic), "token": token,
        "bytes": hex(bytes), "fields": fields, "attachment": hex(&attachment.to_bytes()),
        "sequence": attachment.sequence, "source_ns": attachment.source_ns,
    });
    println!("{line}");
}

fn main() -> anyhow::Result<()> {
    let member = Member { site: "hall-2.east".parse()?, uid: Uid([0xA5; 16]) };
    let node = RosNode::new(&member, 42);
    for known in [true, false] {
        let (state, slip) = (state(known), slip(known));
        let joint = (joint_state(&state, STAMP), shown_joint(known));
        print(&node, RosTopic::JointStates, &joint.0, &joint.1);
        let state = (grip_state(&state, STAMP), shown_state(known));
        print(&node, RosTopic::State, &state.0, &state.1);
        let slip = (slip_event(&slip, ID, STAMP), shown_slip(known));
        print(&node, RosTopic::Slip, &slip.0, &slip.1);
    }
    Ok(())
}
