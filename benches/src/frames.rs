//! Wire bytes of a given count of SAMPLES frames, and of one GRIP.

use crate::signals::Signals;
use anyhow::Result;
use grip_link::{
    frame::{self, Direction, Header, MAX_PAYLOAD, MAX_WIRE},
    message::{Grip, GripMode, Kind, PayloadError, SAMPLES_HEADER, SampleFormat, SamplesHeader},
};

/// Session of all frames here.
pub const SESSION: u16 = 7;
/// Rows of three f32 channels that make a frame of 251 bytes on the wire, the largest up to 256.
pub const ROWS: u8 = 18;

const CHANNELS: usize = 3;

/// `count` SAMPLES frames with `rows` rows of stylus, force and travel each, numbered from 0.
///
/// # Errors
/// Where the rows do not fit a frame.
pub fn samples(count: u16, rows: u8) -> Result<Vec<Vec<u8>>> {
    let mut signals = Signals::new(4);
    (0..count).map(|seq| samples_frame(&mut signals, seq, rows)).collect()
}

fn samples_frame(signals: &mut Signals, seq: u16, rows: u8) -> Result<Vec<u8>> {
    let batch = signals.stretch(usize::from(rows), 3.0, 0.05);
    let first = u32::from(seq) * u32::from(rows);
    let mut payload = [0; MAX_PAYLOAD];
    let header = SamplesHeader {
        first_index: first,
        t0_tick: u64::from(first) * 100,
        dt_ticks: 100,
        rows,
        format: SampleFormat::F32,
        dropped_total: 0,
    };
    header.write(&mut payload)?;
    let values = batch.iter().flat_map(|sample| {
        [Some(sample.stylus), sample.normal_force_n, sample.travel_m]
            .map(|value| value.unwrap_or(f32::NAN).to_le_bytes())
    });
    let len = SAMPLES_HEADER + CHANNELS * 4 * usize::from(rows);
    let room =
        payload.get_mut(SAMPLES_HEADER..len).ok_or(PayloadError::Full { have: MAX_PAYLOAD })?;
    for (slot, value) in room.chunks_exact_mut(4).zip(values) {
        slot.copy_from_slice(&value);
    }
    let header = Header::new(Direction::ToHost, Kind::SAMPLES, seq, SESSION);
    let mut wire = vec![0; MAX_WIRE];
    let used = frame::encode(&header, payload.get(..len).unwrap_or(&payload), &mut wire)?;
    wire.truncate(used);
    Ok(wire)
}

/// Writes the GRIP frame of a force (mN) to `out`: its length.
///
/// # Errors
/// Never: the frame fits.
pub fn grip(seq: u16, force_mn: i32, out: &mut [u8; MAX_WIRE]) -> Result<usize> {
    let command = Grip {
        cmd_id: u32::from(seq),
        mode: GripMode::Force.code(),
        flags: 0,
        ttl_ms: 0,
        force_mn,
        slew_mn_s: 0,
        cause_sample: 10 * u32::from(seq),
    };
    let mut payload = [0; Grip::SIZE];
    command.write(&mut payload)?;
    let header = Header::new(Direction::ToDevice, Kind::GRIP, seq, SESSION);
    Ok(frame::encode(&header, &payload, out)?)
}
