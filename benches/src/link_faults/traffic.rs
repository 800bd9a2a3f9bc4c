//! A seed in, streams of the frames that host and gripper really exchange out.

use anyhow::Result;
use core::ops::Range;
use grip_link::frame::{self, Direction, Frame, Header, MAX_PAYLOAD, MAX_WIRE};
use grip_link::message::{
    Config, DeviceState, Event, EventKind, FaultCode, ForceClamp, Grip, Heartbeat, Kind, Log,
    LogLevel, LossAction, PayloadError, Ping, Pong, SAMPLES_HEADER, SampleFormat, SamplesHeader,
    Stats, Status, StatusFlags,
};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// One frame of a stream.
#[derive(Clone, Debug)]
pub struct Sent {
    /// Where its wire bytes lie in the stream, delimiters included.
    pub span: Range<usize>,
    /// Its header.
    pub header: Header,
    /// Its payload.
    pub payload: Vec<u8>,
}

/// Frames of one direction and session, one behind the other.
#[derive(Clone, Debug)]
pub struct Stream {
    /// The wire bytes of all of them.
    pub bytes: Vec<u8>,
    /// The frames, numbered on from `first_seq`.
    pub frames: Vec<Sent>,
    /// Direction of all of them.
    pub direction: Direction,
    /// Session of all of them.
    pub session: u16,
    /// Sequence number of the first.
    pub first_seq: u16,
}

impl Stream {
    /// Which of the sent frames this is, word for word.
    #[must_use]
    pub fn find(&self, frame: &Frame<'_>) -> Option<usize> {
        let index = usize::from(frame.header.seq.wrapping_sub(self.first_seq));
        let sent = self.frames.get(index)?;
        (sent.header == frame.header && sent.payload == frame.payload).then_some(index)
    }
}

/// Makes streams.
#[derive(Clone, Debug)]
pub struct Traffic {
    rng: ChaCha8Rng,
    index: u32,
    tick: u64,
}

impl Traffic {
    /// The same seed makes the same streams.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (index, tick) = (rng.next_u32(), rng.next_u64() >> 20);
        Self { rng, index, tick }
    }

    /// `count` frames: to the host SAMPLES (1 to 57 rows), STATUS, PONG, STATS, EVENT and LOG, to the device GRIP, PING,
    /// HEARTBEAT and CONFIG.
    ///
    /// # Errors
    /// Never: every frame fits.
    pub fn stream(&mut self, direction: Direction, count: usize) -> Result<Stream> {
        let [s0, s1, q0, q1, ..] = self.rng.next_u64().to_le_bytes();
        let session = u16::from_le_bytes([s0, s1]).max(1);
        let first_seq = u16::from_le_bytes([q0, q1]);
        let mut stream =
            Stream { bytes: Vec::new(), frames: Vec::new(), direction, session, first_seq };
        let mut seq = first_seq;
        for _ in 0..count {
            let mut payload = [0; MAX_PAYLOAD];
            let (kind, len) = match direction {
                Direction::ToHost => self.host_frame(&mut payload)?,
                Direction::ToDevice => self.device_frame(&mut payload)?,
            };
            let payload = payload.get(..len).unwrap_or(&payload);
            let ack_req = kind == Kind::CONFIG;
            let header = Header { ack_req, ..Header::new(direction, kind, seq, session) };
            let mut wire = [0; MAX_WIRE];
            let used = frame::encode(&header, payload, &mut wire)?;
            let start = stream.bytes.len();
            stream.bytes.extend_from_slice(wire.get(..used).unwrap_or(&wire));
            let span = start..start + used;
            stream.frames.push(Sent { span, header, payload: payload.to_vec() });
            seq = seq.wrapping_add(1);
        }
        Ok(stream)
    }

    fn below(&mut self, end: u32) -> u32 {
        self.rng.next_u32() % end.max(1)
    }

    fn byte(&mut self) -> u8 {
        self.rng.next_u32().to_le_bytes()[0]
    }

    /// A number of either sign, mostly small.
    fn milli(&mut self) -> i32 {
        let bits = self.below(24);
        self.below(1 << bits).cast_signed()
    }

    fn host_frame(&mut self, out: &mut [u8; MAX_PAYLOAD]) -> Result<(Kind, usize), PayloadError> {
        self.tick += u64::from(self.below(2000));
        let (tick, applied_mn, value) = (self.tick, self.milli(), self.milli());
        Ok(match self.below(12) {
            0 => {
                let flags = StatusFlags::SAMPLING;
                let status = Status {
                    last_cmd_id: self.index / 10,
                    state: DeviceState::Active,
                    clamp: ForceClamp(0),
                    fault: FaultCode::NONE,
                    applied_mn,
                    target_mn: value,
                    age_us: self.below(2000),
                    flags,
                    rejected: 0,
                };
                (Kind::STATUS, status.write(out)?)
            }
            1 => {
                let pong = Pong { t1_us: tick + 7, rx_tick: tick, tx_tick: tick + 12 };
                (Kind::PONG, pong.write(out)?)
            }
            2 => {
                let stats = Stats { sent: self.index, malformed: 1, ..Stats::default() };
                (Kind::STATS, stats.write(out)?)
            }
            3 => {
                let event = Event {
                    tick,
                    kind: EventKind::State,
                    before: DeviceState::Active,
                    after: DeviceState::Hold,
                    fault: FaultCode::NONE,
                    dropped: 0,
                    value,
                };
                (Kind::EVENT, event.write(out)?)
            }
            4 => {
                let text: Vec<u8> = (0..self.below(256)).map(|_| b' ' + self.byte() % 95).collect();
                let log = Log { tick, level: LogLevel::Info, text: &text };
                (Kind::LOG, log.write(out)?)
            }
            _ => (Kind::SAMPLES, self.samples(out)?),
        })
    }

    /// Rows of stylus and force as i16 or f32; every fourth sensor is at rest and reads mostly zero.
    fn samples(&mut self, out: &mut [u8; MAX_PAYLOAD]) -> Result<usize, PayloadError> {
        let format = if self.below(2) == 0 { SampleFormat::I16 } else { SampleFormat::F32 };
        let most = if self.below(4) == 0 { 57 } else { 12 };
        let rows = u8::try_from(1 + self.below(most)).unwrap_or(1);
        let header = SamplesHeader {
            first_index: self.index,
            t0_tick: self.tick,
            dt_ticks: 100,
            rows,
            format,
            dropped_total: 0,
        };
        self.index = self.index.wrapping_add(u32::from(rows));
        header.write(out)?;
        let end = SAMPLES_HEADER + usize::from(rows) * 2 * format.size();
        let at_rest = self.below(4) == 0;
        let room = out.get_mut(SAMPLES_HEADER..end).ok_or(PayloadError::Full { have: end })?;
        self.rng.fill_bytes(room);
        if at_rest {
            room.iter_mut().for_each(|byte| *byte = if *byte < 240 { 0 } else { *byte });
        }
        Ok(end)
    }

    fn device_frame(&mut self, out: &mut [u8; MAX_PAYLOAD]) -> Result<(Kind, usize), PayloadError> {
        self.index = self.index.wrapping_add(1);
        let (cmd_id, force_mn) = (self.index, self.milli());
        Ok(match self.below(8) {
            0 => (Kind::PING, Ping { t1_us: self.tick }.write(out)?),
            1 => {
                let beat = Heartbeat { turns: cmd_id, longest_us: 900, late: 0, flags: 0 };
                (Kind::HEARTBEAT, beat.write(out)?)
            }
            2 => {
                let config = Config {
                    sample_rate_hz: 10_000,
                    batch: 10,
                    format: SampleFormat::F32,
                    ttl_ms: 50,
                    channel_mask: 7,
                    force_max_mn: 60_000,
                    slew_mn_s: 2_000_000,
                    hold_cap_mn: force_mn,
                    loss_after_ms: 1000,
                    loss_action: LossAction::Hold,
                };
                (Kind::CONFIG, config.write(out)?)
            }
            _ => {
                let grip = Grip {
                    cmd_id,
                    mode: 1,
                    flags: 0,
                    ttl_ms: 0,
                    force_mn,
                    slew_mn_s: 0,
                    cause_sample: cmd_id.wrapping_mul(10),
                };
                (Kind::GRIP, grip.write(out)?)
            }
        })
    }
}
