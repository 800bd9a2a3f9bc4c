//! What a recording holds, one kind for each topic, as the bytes of its message and back.

use slip_core::{Arrival, PipelineState, Sample, pressure::MAX_TAXELS, units::Micros};
use slip_msg::{
    ClientCommand, EXTRAPOLATED, FaultCode, GripState, INFORMATIVE, Method, Operation, Phase,
    Reading, Scene, SlipReport,
};

use super::cdr::{CdrError, CdrReader, CdrWriter};
use super::codes::{self, PRESSURE, REFERENCE, STYLUS, TRAVEL};
use super::schema::Topic;
use crate::channels::Channel;

/// Bit of `esc_flags`: E_sc shows nothing at this noise.
const NO_INFORMATION: u8 = 1 << 2;

/// One message of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Record<'a> {
    /// Sensor readings.
    Sample(SampleRecord<'a>),
    /// What the pipeline thinks.
    State(PipelineState),
    /// A line worth reading.
    Event(EventRecord<'a>),
    /// A force command.
    Command(CommandRecord),
    /// A client's command.
    Client(ClientCommand),
    /// Updates of the link.
    Link(LinkRecord<'a>),
    /// Bytes of the line.
    Wire(WireRecord<'a>),
    /// A pipeline begins.
    Pipeline(PipelineRecord<'a>),
}

/// A row of sensor readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRecord<'a> {
    /// Number of the row on the device; wraps.
    pub index: u32,
    /// The sample.
    pub sample: Sample,
    /// The frame of the taxel array that came with it, empty where none did.
    pub taxels: &'a [f32],
}

/// A line worth reading; NaN or an empty string where a field has no meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "as in the Event message and in the JSON line")]
pub struct EventRecord<'a> {
    pub t_s: f64,
    pub kind: &'a str,
    pub phase: &'a str,
    pub method: &'a str,
    pub channel: &'a str,
    pub health: &'a str,
    pub duration_s: f64,
    pub esc_w: f64,
    pub esc_value: f64,
    pub statistic: f32,
    pub confidence: f32,
    pub speed_m_s: f32,
    pub speed_sigma_m_s: f32,
    pub moved_m: f32,
    pub irregularities: f32,
    pub estimate_n: f32,
    pub command_n: f32,
    /// The line itself, which is what counts.
    pub json: &'a str,
}

impl Default for EventRecord<'_> {
    /// Nothing is known.
    fn default() -> Self {
        let (text, long, short) = ("", f64::NAN, f32::NAN);
        Self {
            t_s: long,
            kind: text,
            phase: text,
            method: text,
            channel: text,
            health: text,
            duration_s: long,
            esc_w: long,
            esc_value: long,
            statistic: short,
            confidence: short,
            speed_m_s: short,
            speed_sigma_m_s: short,
            moved_m: short,
            irregularities: short,
            estimate_n: short,
            command_n: short,
            json: text,
        }
    }
}

/// A force command as it was written to the gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandRecord {
    /// Command number.
    pub cmd_id: u32,
    /// Mode code of the link.
    pub mode: u8,
    /// b0: answers a slip.
    pub flags: u8,
    /// Life (ms); 0 for that of the configuration.
    pub ttl_ms: u16,
    /// Force (mN).
    pub force_mn: i32,
    /// Change of force (mN/s); 0 for that of the configuration.
    pub slew_mn_s: u32,
    /// Index of the sample that caused it.
    pub cause_sample: u32,
}

/// Updates of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkRecord<'a> {
    /// What happened, as in the Link message.
    pub kind: &'a str,
    /// The rest as a JSON object.
    pub detail: &'a str,
}

/// Bytes of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireRecord<'a> {
    /// Whether they went to the gripper.
    pub to_device: bool,
    /// The bytes.
    pub bytes: &'a [u8],
}

/// A pipeline begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PipelineRecord<'a> {
    /// Whether it began in an earlier file.
    pub continued: bool,
    /// Force (N) at which the controller takes over a grip.
    pub carried_n: Option<f32>,
    /// Force (N) that a client asked for; 0 where none did.
    pub least_n: f32,
    /// Whether a client had let go of the object.
    pub released: bool,
    /// Taxels of the gripper's array.
    pub taxels: u32,
    /// Samples per second.
    pub rate_hz: f32,
    /// Whether the force controller runs.
    pub grips: bool,
    /// Every setting, as JSON.
    pub config: &'a str,
}

impl Record<'_> {
    /// The topic it belongs to.
    #[must_use]
    pub const fn topic(&self) -> Topic {
        match self {
            Self::Sample(_) => Topic::Sample,
            Self::State(_) => Topic::State,
            Self::Event(_) => Topic::Event,
            Self::Command(_) => Topic::Command,
            Self::Client(_) => Topic::Client,
            Self::Link(_) => Topic::Link,
            Self::Wire(_) => Topic::Wire,
            Self::Pipeline(_) => Topic::Pipeline,
        }
    }

    /// Appends its message, stamped `stamp_ns` (since 1970), to `out`.
    pub fn encode(&self, stamp_ns: u64, out: &mut Vec<u8>) {
        let mut w = CdrWriter::new(out);
        w.time(stamp_ns);
        match self {
            Self::Sample(record) => record.encode(&mut w),
            Self::State(state) => encode_state(state, &mut w),
            Self::Event(record) => record.encode(&mut w),
            Self::Command(record) => record.encode(&mut w),
            Self::Client(command) => encode_command(*command, &mut w),
            Self::Link(record) => {
                w.text(record.kind).text(record.detail);
            }
            Self::Wire(record) => {
                w.bool(record.to_device).bytes(record.bytes);
            }
            Self::Pipeline(record) => record.encode(&mut w),
        }
    }
}

impl<'a> Record<'a> {
    /// Reads a message of `topic`; `taxels` is written over with its frame.
    ///
    /// # Errors
    /// Where the bytes are no such message.
    pub fn decode(
        topic: Topic,
        bytes: &'a [u8],
        taxels: &'a mut Vec<f32>,
    ) -> Result<Self, CdrError> {
        let mut r = CdrReader::new(bytes)?;
        r.time()?;
        Ok(match topic {
            Topic::Sample => Self::Sample(SampleRecord::decode(&mut r, taxels)?),
            Topic::State => Self::State(decode_state(&mut r)?),
            Topic::Event => Self::Event(EventRecord::decode(&mut r)?),
            Topic::Command => Self::Command(CommandRecord::decode(&mut r)?),
            Topic::Client => Self::Client(decode_command(&mut r)?),
            Topic::Link => Self::Link(LinkRecord { kind: r.text()?, detail: r.text()? }),
            Topic::Wire => Self::Wire(WireRecord { to_device: r.bool()?, bytes: r.bytes()? }),
            Topic::Pipeline => Self::Pipeline(PipelineRecord::decode(&mut r)?),
        })
    }
}

impl SampleRecord<'_> {
    #[inline]
    fn encode(&self, w: &mut CdrWriter<'_>) {
        let sample = &self.sample;
        let mut present = 0;
        let mut readings = [f32::NAN; Channel::ALL.len()];
        for (bit, (channel, place)) in Channel::ALL.into_iter().zip(&mut readings).enumerate() {
            if let Some(value) = channel.reading(sample) {
                present |= 1 << bit;
                *place = value;
            }
        }
        w.u64(sample.t.0).u32(self.index).u16(present).f32(sample.stylus);
        for value in readings {
            w.f32(value);
        }
        w.floats(self.taxels);
        let Arrival { at, age } = sample.arrival.unwrap_or_default();
        w.u64(at.0).u32(u32::try_from(age.0).unwrap_or(u32::MAX));
    }
}

impl<'a> SampleRecord<'a> {
    fn decode(r: &mut CdrReader<'_>, taxels: &'a mut Vec<f32>) -> Result<Self, CdrError> {
        let t = Micros(r.u64()?);
        let (index, present) = (r.u32()?, r.u16()?);
        let mut sample = Sample::stylus(t, r.f32()?);
        let readings = r.f32s::<{ Channel::ALL.len() }>()?;
        for (bit, (channel, value)) in Channel::ALL.into_iter().zip(readings).enumerate() {
            channel.set(&mut sample, (present >> bit & 1 == 1).then_some(value));
        }
        taxels.clear();
        r.floats(taxels)?;
        check_count(taxels.len())?;
        // Recordings of before 2026-11-23 end here.
        if !r.is_at_end() {
            let arrival = Arrival { at: Micros(r.u64()?), age: Micros(r.u32()?.into()) };
            sample.arrival = Some(arrival).filter(|arrival| arrival.at.0 > 0);
        }
        Ok(Self { index, sample, taxels })
    }
}

fn encode_state(state: &PipelineState, w: &mut CdrWriter<'_>) {
    let [stylus, travel, pressure, reference] = state.sensors;
    w.u64(state.t.0).u8(state.scene.code()).u8(state.grip.code());
    w.u8(codes::code(&STYLUS, stylus)).u8(codes::code(&REFERENCE, reference));
    w.u8(codes::code(&TRAVEL, travel)).u8(codes::code(&PRESSURE, pressure));
    w.f32(short(state.statistic)).f32(short(state.command_n)).f32(short(state.applied_n));
    w.f64(short(state.esc).into()).bool(state.is_informative());
    w.f32(short(state.estimate_n)).bool(state.is_extrapolated());
    w.u64(state.lost).u32(state.rate_hz).f32(short(state.late_ms));
    w.f32(short(state.need_low_n)).f32(short(state.need_n)).f32(short(state.need_high_n));
    w.f32(short(state.admissible_m_s2));
}

/// What the gripper said of itself is not in the message; an E_sc is that as printed.
fn decode_state(r: &mut CdrReader<'_>) -> Result<PipelineState, CdrError> {
    let (t, scene, grip) = (Micros(r.u64()?), r.u8()?, r.u8()?);
    let stylus = codes::health(&STYLUS, r.u8()?);
    let reference = codes::health(&REFERENCE, r.u8()?);
    let travel = codes::health(&TRAVEL, r.u8()?);
    let pressure = codes::health(&PRESSURE, r.u8()?);
    let (statistic, command_n, applied_n) = (known(r.f32()?), known(r.f32()?), known(r.f32()?));
    #[expect(
        clippy::cast_possible_truncation,
        reason = "files of before 2026-11-25 have more digits"
    )]
    let esc = known(r.f64()? as f32);
    let informative = if r.bool()? { INFORMATIVE } else { 0 };
    let estimate_n = known(r.f32()?);
    let extrapolated = if r.bool()? { EXTRAPOLATED } else { 0 };
    Ok(PipelineState {
        t,
        scene: Scene::from_code(scene),
        grip: GripState::from_code(grip),
        sensors: [stylus, travel, pressure, reference],
        notes: informative | extrapolated,
        esc_kind: if esc.is_some() { Reading::Literal } else { Reading::None },
        esc_flags: if esc.is_some() && informative == 0 { NO_INFORMATION } else { 0 },
        statistic,
        command_n,
        applied_n,
        esc,
        estimate_n,
        lost: r.u64()?,
        rate_hz: r.u32()?,
        // Recordings of before 2026-11-23 end here.
        late_ms: appended(r)?,
        // Those of before 2026-11-28 end here.
        need_low_n: appended(r)?,
        need_n: appended(r)?,
        need_high_n: appended(r)?,
        admissible_m_s2: appended(r)?,
        ..PipelineState::UNKNOWN
    })
}

impl EventRecord<'static> {
    /// The record of a slip, without its line.
    #[must_use]
    pub fn of_slip(slip: &SlipReport) -> Self {
        let ended = slip.phase == Phase::Ended;
        let irregularities = slip.irregularities.map(|count| count as f32);
        let long = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Self {
            t_s: slip.t.as_seconds(),
            kind: if ended { "slip_end" } else { "slip" },
            phase: if ended { "" } else { slip.phase.name() },
            method: if slip.method == Method::None { "" } else { slip.method.name() },
            duration_s: long(slip.duration_s),
            esc_w: long(slip.esc_w),
            esc_value: long(slip.esc),
            statistic: short(slip.statistic),
            confidence: short(slip.confidence),
            speed_m_s: short(slip.speed_m_s),
            speed_sigma_m_s: short(slip.speed_sigma_m_s),
            moved_m: short(slip.moved_m),
            irregularities: short(irregularities),
            estimate_n: short(slip.estimate_n),
            command_n: short(slip.command_n),
            ..Self::default()
        }
    }
}

impl<'a> EventRecord<'a> {
    /// The slip that it reports; `None` where it is another event.
    #[must_use]
    pub fn slip(&self) -> Option<SlipReport> {
        let phase = match self.kind {
            "slip" => Phase::from_name(self.phase)?,
            "slip_end" => Phase::Ended,
            _ => return None,
        };
        let long = |value: f64| Some(value).filter(|value| !value.is_nan());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let irregularities = known(self.irregularities).map(|count| count as u32);
        Some(SlipReport {
            t: Micros::from_seconds(self.t_s),
            phase,
            method: Method::from_name(self.method).unwrap_or(Method::None),
            statistic: known(self.statistic),
            confidence: known(self.confidence),
            speed_m_s: known(self.speed_m_s),
            speed_sigma_m_s: known(self.speed_sigma_m_s),
            moved_m: known(self.moved_m),
            irregularities,
            esc_w: long(self.esc_w),
            esc: long(self.esc_value),
            estimate_n: known(self.estimate_n),
            command_n: known(self.command_n),
            duration_s: long(self.duration_s),
            ..SlipReport::UNKNOWN
        })
    }

    fn encode(&self, w: &mut CdrWriter<'_>) {
        w.f64(self.t_s).text(self.kind).text(self.phase).text(self.method);
        w.text(self.channel).text(self.health);
        w.f64(self.duration_s).f64(self.esc_w).f64(self.esc_value);
        w.f32(self.statistic).f32(self.confidence).f32(self.speed_m_s).f32(self.speed_sigma_m_s);
        w.f32(self.moved_m).f32(self.irregularities).f32(self.estimate_n).f32(self.command_n);
        w.text(self.json);
    }

    fn decode(r: &mut CdrReader<'a>) -> Result<Self, CdrError> {
        Ok(Self {
            t_s: r.f64()?,
            kind: r.text()?,
            phase: r.text()?,
            method: r.text()?,
            channel: r.text()?,
            health: r.text()?,
            duration_s: r.f64()?,
            esc_w: r.f64()?,
            esc_value: r.f64()?,
            statistic: r.f32()?,
            confidence: r.f32()?,
            speed_m_s: r.f32()?,
            speed_sigma_m_s: r.f32()?,
            moved_m: r.f32()?,
            irregularities: r.f32()?,
            estimate_n: r.f32()?,
            command_n: r.f32()?,
            json: r.text()?,
        })
    }
}

impl CommandRecord {
    fn encode(&self, w: &mut CdrWriter<'_>) {
        let force_n = self.force_mn as f32 / 1000.0;
        w.u32(self.cmd_id).u8(self.mode).bool(self.flags & 1 == 1).u8(self.flags);
        w.u16(self.ttl_ms).i32(self.force_mn).f32(force_n);
        w.u32(self.slew_mn_s).u32(self.cause_sample);
    }

    fn decode(r: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let (cmd_id, mode) = (r.u32()?, r.u8()?);
        r.bool()?;
        let (flags, ttl_ms, force_mn) = (r.u8()?, r.u16()?, r.i32()?);
        r.f32()?;
        let (slew_mn_s, cause_sample) = (r.u32()?, r.u32()?);
        Ok(Self { cmd_id, mode, flags, ttl_ms, force_mn, slew_mn_s, cause_sample })
    }
}

/// The code of a command in a file is one less than that of its operation.
fn encode_command(command: ClientCommand, w: &mut CdrWriter<'_>) {
    let force_n = match command {
        ClientCommand::AtLeast(force_n) | ClientCommand::Expect(force_n) => force_n,
        _ => f32::NAN,
    };
    w.u8(command.operation().code() - 1).f32(force_n).u16(command.fault().0);
}

fn decode_command(r: &mut CdrReader<'_>) -> Result<ClientCommand, CdrError> {
    let (code, force_n, fault) = (r.u8()?, r.f32()?, r.u16()?);
    match code.checked_add(1).and_then(Operation::from_code) {
        Some(Operation::AtLeast) => Ok(ClientCommand::AtLeast(force_n)),
        Some(Operation::Expect) => Ok(ClientCommand::Expect(force_n)),
        Some(Operation::Release) => Ok(ClientCommand::Release),
        Some(Operation::Grasp) => Ok(ClientCommand::Grasp),
        Some(Operation::Stop) => Ok(ClientCommand::Stop),
        Some(Operation::ClearFault) => Ok(ClientCommand::ClearFault(FaultCode(fault))),
        None => Err(CdrError::Code { code, at: r.position() }),
    }
}

impl<'a> PipelineRecord<'a> {
    fn encode(&self, w: &mut CdrWriter<'_>) {
        w.bool(self.continued).bool(self.carried_n.is_some()).f32(short(self.carried_n));
        w.f32(self.least_n).bool(self.released);
        w.u32(self.taxels).f32(self.rate_hz).bool(self.grips).text(self.config);
    }

    fn decode(r: &mut CdrReader<'a>) -> Result<Self, CdrError> {
        let (continued, carries, carried_n) = (r.bool()?, r.bool()?, r.f32()?);
        let (least_n, released, taxels) = (r.f32()?, r.bool()?, r.u32()?);
        check_count(usize::try_from(taxels).unwrap_or(usize::MAX))?;
        Ok(Self {
            continued,
            carried_n: carries.then_some(carried_n),
            least_n,
            released,
            taxels,
            rate_hz: r.f32()?,
            grips: r.bool()?,
            config: r.text()?,
        })
    }
}

/// # Errors
/// Where an array has more taxels than any that is read.
fn check_count(count: usize) -> Result<(), CdrError> {
    if count > MAX_TAXELS { Err(CdrError::Taxels { count }) } else { Ok(()) }
}

fn short(value: Option<f32>) -> f32 {
    value.unwrap_or(f32::NAN)
}

fn known(value: f32) -> Option<f32> {
    Some(value).filter(|value| !value.is_nan())
}

/// A value that older recordings end before.
fn appended(r: &mut CdrReader<'_>) -> Result<Option<f32>, CdrError> {
    if r.is_at_end() { Ok(None) } else { r.f32().map(known) }
}
