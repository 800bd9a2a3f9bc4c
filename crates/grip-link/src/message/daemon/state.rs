//! STATE: what the pipeline thinks after a frame of samples.

use super::{GripState, Reading, Scene, SensorHealth};
use crate::message::wire::{PayloadError, Reader, Writer};
use crate::message::{DeviceState, FaultCode};

/// The last reading of E_sc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EscValue {
    /// Which reading.
    pub kind: Reading,
    /// Its value (W or J).
    pub value: Option<f32>,
    /// What is wrong with it: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
    pub flags: u8,
}

/// STATE (A2), daemon to client. NaN stands for what is not known.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 8 | u64 | device time of the last sample | us |
/// | 8 | 8 | u64 | host time since the daemon's start | us |
/// | 16 | 1 | u8 | [`Scene`] code | |
/// | 17 | 1 | u8 | [`GripState`] code | |
/// | 18 | 4 | u8\[4\] | [`SensorHealth`] codes of stylus, travel, pressure, reference | |
/// | 22 | 1 | u8 | [`DeviceState`] code | |
/// | 23 | 1 | u8 | b0 E_sc depends on the surface, b1 the estimate is extrapolated | |
/// | 24 | 2 | u16 | latched fault | |
/// | 26 | 1 | u8 | E_sc flags, as in SLIP | |
/// | 27 | 1 | u8 | [`Reading`] code | |
/// | 28 | 4 | f32 | statistic over its threshold | |
/// | 32 | 4 | f32 | commanded force | N |
/// | 36 | 4 | f32 | measured normal force | N |
/// | 40 | 4 | f32 | the last E_sc | W or J |
/// | 44 | 4 | f32 | the last estimate of the adequate force | N |
/// | 48 | 4 | u32 | sample rate in force | Hz |
/// | 52 | 8 | u64 | rows lost since the daemon's start | |
/// | 60 | 4 | f32 | age of the newest usable row at the last command; not in payloads of 60 bytes | ms |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Device time of the last sample (us).
    pub device_us: u64,
    /// Host time (us since the daemon's start).
    pub host_us: u64,
    /// What the grasp is doing.
    pub scene: Scene,
    /// What the force controller does.
    pub grip: GripState,
    /// Stylus, travel, pressure, reference.
    pub sensors: [SensorHealth; 4],
    /// State of the gripper.
    pub device: DeviceState,
    /// b0 E_sc depends on the surface, b1 the estimate is extrapolated.
    pub notes: u8,
    /// Its latched fault.
    pub fault: FaultCode,
    /// The last E_sc.
    pub esc: EscValue,
    /// Statistic over its threshold.
    pub statistic: Option<f32>,
    /// Commanded force (N).
    pub command_n: Option<f32>,
    /// Measured normal force (N).
    pub applied_n: Option<f32>,
    /// The last estimate (N).
    pub estimate_n: Option<f32>,
    /// Sample rate in force (Hz).
    pub rate_hz: u32,
    /// Rows lost since the daemon's start.
    pub lost: u64,
    /// Age of the newest usable row at the last command (ms), by the daemon's clock; left out where it is not known.
    pub late_ms: Option<f32>,
}

impl State {
    /// Bytes of the payload without what was appended.
    pub const SIZE: usize = 60;
    /// Bytes of the payload.
    pub const WHOLE: usize = Self::SIZE + 4;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, or an infinite number.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let (device_us, host_us) = (r.u64()?, r.u64()?);
        let [scene, grip] = r.take()?;
        let sensors = r.take::<4>()?.map(SensorHealth::from_code);
        let [device, notes] = r.take()?;
        let fault = FaultCode(r.u16()?);
        let [flags, kind] = r.take()?;
        let (statistic, command_n, applied_n) = (r.maybe()?, r.maybe()?, r.maybe()?);
        let esc = EscValue { kind: Reading::from_code(kind), value: r.maybe()?, flags };
        Ok(Self {
            device_us,
            host_us,
            scene: Scene::from_code(scene),
            grip: GripState::from_code(grip),
            sensors,
            device: DeviceState::from_code(device),
            notes,
            fault,
            esc,
            statistic,
            command_n,
            applied_n,
            estimate_n: r.maybe()?,
            rate_hz: r.u32()?,
            lost: r.u64()?,
            late_ms: if payload.len() < Self::WHOLE { None } else { r.maybe()? },
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u64(self.device_us).u64(self.host_us);
        let w = w.u8(self.scene.code()).u8(self.grip.code());
        let w = w.put(&self.sensors.map(SensorHealth::code));
        let w = w.u8(self.device.code()).u8(self.notes).u16(self.fault.0);
        let w = w.u8(self.esc.flags).u8(self.esc.kind.code());
        let w = w.maybe(self.statistic).maybe(self.command_n).maybe(self.applied_n);
        let w = w.maybe(self.esc.value).maybe(self.estimate_n);
        let w = w.u32(self.rate_hz).u64(self.lost);
        if self.late_ms.is_some() { w.maybe(self.late_ms).finish() } else { w.finish() }
    }
}
