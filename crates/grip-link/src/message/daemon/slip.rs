//! SLIP: a slip was noticed, became gross, or ended.

use super::{EscKind, Method, Phase, SpeedSource};
use crate::message::wire::{PayloadError, Reader, Writer};

/// SLIP (A1), daemon to client. NaN, and 4294967295 irregularities, stand for what is not known.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 4 | u32 | number: +1 for every SLIP since the daemon started, from 1 | |
/// | 4 | 8 | u64 | device time | us |
/// | 12 | 8 | u64 | host time since the daemon's start | us |
/// | 20 | 1 | u8 | [`Phase`] code | |
/// | 21 | 1 | u8 | [`Method`] code | |
/// | 22 | 1 | u8 | [`SpeedSource`] code | |
/// | 23 | 1 | u8 | [`EscKind`] code of the chosen reading | |
/// | 24 | 4 | f32 | statistic over its threshold | |
/// | 28 | 4 | f32 | confidence | 0..=1 |
/// | 32 | 4 | f32 | slip speed | m/s |
/// | 36 | 4 | f32 | its standard deviation | m/s |
/// | 40 | 4 | f32 | moved distance | m |
/// | 44 | 4 | u32 | irregularities passed | |
/// | 48 | 4 | f32 | E_sc as printed | W |
/// | 52 | 4 | f32 | the chosen reading of E_sc | W or J |
/// | 56 | 1 | u8 | E_sc flags: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate | |
/// | 57 | 1 | u8 | b0 E_sc depends on the surface, b1 the estimate is extrapolated | |
/// | 58 | 1 | u8 | causes that were ruled out, a bit for each: b0 knock, b1 motion, b2 grip change, b3 closing, b4 arm stop | |
/// | 59 | 1 | u8 | causes that were not; one in neither could not be judged | |
/// | 60 | 4 | f32 | estimate of the adequate force | N |
/// | 64 | 4 | f32 | commanded force | N |
/// | 68 | 4 | f32 | from the first notice to the end | s |
/// | 72 | 4 | f32 | interval that the slip is certified with; not in payloads of 72 bytes | s |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slip {
    /// Counts from 1 since the daemon's start.
    pub number: u32,
    /// Device time (us).
    pub device_us: u64,
    /// Host time (us since the daemon's start).
    pub host_us: u64,
    /// How far it has come.
    pub phase: Phase,
    /// Which method noticed it.
    pub method: Method,
    /// Where the speed comes from.
    pub speed_source: SpeedSource,
    /// Which reading of E_sc was chosen.
    pub esc_kind: EscKind,
    /// Statistic over its threshold.
    pub statistic: Option<f32>,
    /// Probability that noise alone would not reach the statistic.
    pub confidence: Option<f32>,
    /// Slip speed (m/s).
    pub speed_m_s: Option<f32>,
    /// Its standard deviation (m/s).
    pub sigma_m_s: Option<f32>,
    /// Distance moved (m).
    pub moved_m: Option<f32>,
    /// Irregularities passed.
    pub irregularities: Option<u32>,
    /// E_sc as printed (W).
    pub esc_w: Option<f32>,
    /// The chosen reading (W or J).
    pub esc_chosen: Option<f32>,
    /// What is wrong with E_sc.
    pub esc_flags: u8,
    /// b0 E_sc depends on the surface, b1 the estimate is extrapolated.
    pub notes: u8,
    /// Causes other than a slip that were ruled out: b0 knock, b1 motion, b2 grip change, b3 closing, b4 arm stop.
    pub ruled_out: u8,
    /// Those that were not; one in neither could not be judged.
    pub possible: u8,
    /// Estimate of the adequate force (N).
    pub estimate_n: Option<f32>,
    /// Commanded force (N).
    pub command_n: Option<f32>,
    /// From the first notice to the end (s).
    pub duration_s: Option<f32>,
    /// The interval that the slip is certified with (s); left out where it is not.
    pub certified_s: Option<f32>,
}

impl Slip {
    /// Bytes of the payload without what was appended.
    pub const SIZE: usize = 72;
    /// Bytes of the payload.
    pub const WHOLE: usize = Self::SIZE + 4;
    /// Bit of `notes`: E_sc depends on the surface.
    pub const INFORMATIVE: u8 = 1;
    /// Bit of `notes`: the estimate is extrapolated and not used.
    pub const EXTRAPOLATED: u8 = 2;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, or an infinite number.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let (number, device_us, host_us) = (r.u32()?, r.u64()?, r.u64()?);
        let [phase, method, source, reading] = r.take()?;
        let (statistic, confidence) = (r.maybe()?, r.maybe()?);
        let (speed_m_s, sigma_m_s, moved_m) = (r.maybe()?, r.maybe()?, r.maybe()?);
        let irregularities = Some(r.u32()?).filter(|n| *n != u32::MAX);
        let (esc_w, esc_chosen) = (r.maybe()?, r.maybe()?);
        let [esc_flags, notes, ruled_out, possible] = r.take()?;
        Ok(Self {
            number,
            device_us,
            host_us,
            phase: Phase::from_code(phase),
            method: Method::from_code(method),
            speed_source: SpeedSource::from_code(source),
            esc_kind: EscKind::from_code(reading),
            statistic,
            confidence,
            speed_m_s,
            sigma_m_s,
            moved_m,
            irregularities,
            esc_w,
            esc_chosen,
            esc_flags,
            notes,
            ruled_out,
            possible,
            estimate_n: r.maybe()?,
            command_n: r.maybe()?,
            duration_s: r.maybe()?,
            certified_s: if payload.len() < Self::WHOLE { None } else { r.maybe()? },
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u32(self.number).u64(self.device_us).u64(self.host_us);
        let w = w.u8(self.phase.code()).u8(self.method.code());
        let w = w.u8(self.speed_source.code()).u8(self.esc_kind.code());
        let w = w.maybe(self.statistic).maybe(self.confidence);
        let w = w.maybe(self.speed_m_s).maybe(self.sigma_m_s).maybe(self.moved_m);
        let w = w.u32(self.irregularities.unwrap_or(u32::MAX));
        let w = w.maybe(self.esc_w).maybe(self.esc_chosen);
        let w = w.u8(self.esc_flags).u8(self.notes).u8(self.ruled_out).u8(self.possible);
        let w = w.maybe(self.estimate_n).maybe(self.command_n).maybe(self.duration_s);
        if self.certified_s.is_some() { w.maybe(self.certified_s).finish() } else { w.finish() }
    }
}
