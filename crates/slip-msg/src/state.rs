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
        0 t: Micros, "us", "Device time of the last sample.";
        8 host: Micros, "us", "Host time since the daemon's start.";
        16 scene: Scene, "", "What the grasp is doing.";
        17 grip: GripState, "", "What the force controller does.";
        18 sensors: [SensorHealth; 4], "", "Stylus, travel, pressure, reference.";
        22 device: DeviceState, "", "State of the gripper.";
        23 notes: u8, "", "b0 E_sc depends on the surface, b1 the estimate is extrapolated and not used.";
        24 fault: FaultCode, "", "Latched fault of the gripper.";
        26 esc_flags: u8, "", "What is wrong with E_sc: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.";
        27 esc_kind: Reading, "", "Which reading `esc` is.";
        28 statistic: Option<f32>, "", "Slip statistic over its threshold.";
        32 command_n: Option<f32>, "N", "Commanded force.";
        36 applied_n: Option<f32>, "N", "Measured normal force.";
        40 esc: Option<f32>, "W or J", "The last E_sc.";
        44 estimate_n: Option<f32>, "N", "The last estimate of the adequate force.";
        48 rate_hz: u32, "Hz", "Sample rate in force.";
        52 lost: u64, "rows", "Lost since the daemon's start.";
    }
    appended {
        60 late_ms: Option<f32>, "ms", "Age of the newest usable row at the last command, by the daemon's clock.";
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
