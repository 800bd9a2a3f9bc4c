//! The pipeline after a frame of samples.

use crate::{
    DeviceState, FaultCode, GripState, Reading, Scene, SensorHealth, message, units::Micros,
};

/// E_sc depends on the surface: bit of `notes`.
pub const INFORMATIVE: u8 = 1;
/// The estimate is extrapolated and not used: bit of `notes`.
pub const EXTRAPOLATED: u8 = 2;

message! {
    /// The pipeline after a frame of samples; STATE (A2), daemon to client.
    PipelineState {
        0 t as "device_us": Micros, "us, device time of the last sample", "Device time of the last sample.";
        8 host as "host_us": Micros, "us since the daemon's start", "Host time since the daemon's start.";
        16 scene: Scene, "scene", "What the grasp is doing.";
        17 grip: GripState, "grip stage", "What the force controller does.";
        18 sensors as "stylus travel pressure reference": [SensorHealth; 4], "sensor health", "Stylus, travel, pressure, reference.";
        22 device: DeviceState, "device state", "State of the gripper.";
        23 notes: u8, "as in SLIP", "b0 E_sc depends on the surface, b1 the estimate is extrapolated and not used.";
        24 fault: FaultCode, "latched fault", "Latched fault of the gripper.";
        26 esc_flags: u8, "as in SLIP", "What is wrong with E_sc: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.";
        27 esc_kind: Reading, "which E_sc `esc` is", "Which reading `esc` is.";
        28 statistic: Option<f32>, "over the interval", "Evidence of a slip over the wanted interval.";
        32 command_n as "command": Option<f32>, "N, commanded force", "Commanded force.";
        36 applied_n as "applied": Option<f32>, "N, measured normal force", "Measured normal force.";
        40 esc: Option<f32>, "W or J, the last E_sc", "The last E_sc.";
        44 estimate_n as "estimate": Option<f32>, "N, the last estimate of the adequate force", "The last estimate of the adequate force.";
        48 rate_hz: u32, "Hz, sample rate in force", "Sample rate in force.";
        52 lost: u64, "rows lost since the daemon's start", "Lost since the daemon's start.";
    }
    appended {
        60 late_ms as "late": Option<f32>, "ms, age of the newest usable row at the last command, by the daemon's clock; left out where it is not known", "Age of the newest usable row at the last command, by the daemon's clock.";
        64 need_low_n as "need_low": Option<f32>, "N, normal force of one finger that the object needs at full weight: its 10 % quantile", "Normal force of one finger that the object needs at full weight: its 10 % quantile.";
        68 need_n as "need": Option<f32>, "N, its median", "Its median.";
        72 need_high_n as "need_high": Option<f32>, "N, its 90 % quantile", "Its 90 % quantile.";
        76 admissible_m_s2 as "admissible": Option<f32>, "m/s^2, acceleration of the arm beside gravity, in any direction, at which the object slips at the commanded force with a probability of 10 %", "Acceleration of the arm beside gravity, in any direction, at which the object slips at the commanded force with a probability of 10 %.";
    }
}

impl PipelineState {
    /// Whether E_sc depends on the surface at the assumed noise.
    #[must_use]
    pub const fn is_informative(&self) -> bool {
        self.notes & INFORMATIVE != 0
    }

    /// Whether the estimate lies outside what the network was trained on.
    #[must_use]
    pub const fn is_extrapolated(&self) -> bool {
        self.notes & EXTRAPOLATED != 0
    }
}

#[cfg(test)]
mod tests {
    use super::PipelineState;
    use crate::PayloadError;

    const STATE: PipelineState = PipelineState {
        estimate_n: Some(9.5),
        late_ms: Some(1.5),
        need_low_n: Some(3.0),
        need_n: Some(4.0),
        need_high_n: Some(5.5),
        admissible_m_s2: Some(2.25),
        ..PipelineState::UNKNOWN
    };

    #[test]
    fn a_payload_holds_what_its_writer_knew_of() {
        let mut bytes = [0xEE; 100];
        assert_eq!(STATE.write(&mut bytes), Ok(80));
        assert_eq!((PipelineState::SIZE, PipelineState::WHOLE), (60, 80));
        for more in [80, 81, 100] {
            assert_eq!(PipelineState::parse(&bytes[..more]), Ok(STATE), "{more} bytes");
        }
        // Writers of before the needed force end after `late`, those before them in front of it.
        let late = PipelineState {
            need_low_n: None,
            need_n: None,
            need_high_n: None,
            admissible_m_s2: None,
            ..STATE
        };
        assert_eq!(PipelineState::parse(&bytes[..64]), Ok(late));
        for short in 60..64 {
            let first = PipelineState { late_ms: None, ..late };
            assert_eq!(PipelineState::parse(&bytes[..short]), Ok(first), "{short} bytes");
        }
        let short = PayloadError::Short { need: 60, have: 59 };
        assert_eq!(PipelineState::parse(&bytes[..59]), Err(short));
    }

    #[test]
    fn what_is_not_known_is_left_out_where_nothing_known_follows() {
        let mut bytes = [0xEE; 80];
        assert_eq!(PipelineState::UNKNOWN.write(&mut bytes), Ok(60));
        let late = PipelineState { late_ms: Some(1.5), ..PipelineState::UNKNOWN };
        assert_eq!(late.write(&mut bytes), Ok(64));
        let needed = PipelineState { late_ms: None, ..STATE };
        assert_eq!(needed.write(&mut bytes), Ok(80));
        assert_eq!(PipelineState::parse(&bytes), Ok(needed));
        assert_eq!(bytes[60..64], f32::NAN.to_le_bytes());
    }
}
