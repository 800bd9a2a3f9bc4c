//! Writer of samples as a CSV recording that reads back bit by bit the same.

use std::io::{self, Write};

use slip_core::sample::{Arrival, FURTHER_AXES, Sample};
use slip_core::units::Micros;

use crate::channels::{Channel, ChannelSet};

/// Why a sample was not written; nothing of it stands in the file.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file or stream refused the bytes.
    #[error("cannot write the recording: {0}")]
    Io(#[from] io::Error),
    /// The sample has a reading in a channel without a column, which would be lost.
    #[error(
        "the sample at {:.6} s has a reading of {channel:?}, but the recording has no column for it",
        time.as_seconds()
    )]
    NoColumn {
        /// Time of the sample.
        time: Micros,
        /// The channel without a column.
        channel: Channel,
    },
    /// The sample has an axis without a column, which would be lost.
    #[error("the sample at {:.6} s has more axes than the recording has columns for", time.as_seconds())]
    NoAxis {
        /// Time of the sample.
        time: Micros,
    },
    /// The frame of the taxel array has another size than the columns.
    #[error(
        "the sample at {:.6} s has a frame of {found} taxels, but the recording has {expected} columns for them",
        time.as_seconds()
    )]
    Taxels {
        /// Time of the sample.
        time: Micros,
        /// Taxels of the frame.
        found: usize,
        /// Columns of the recording.
        expected: usize,
    },
    /// The sample is earlier than the one before.
    #[error("time goes backwards from {:.6} s to {:.6} s", before.as_seconds(), time.as_seconds())]
    TimeBackwards {
        /// Time of the sample before.
        before: Micros,
        /// Time of the sample.
        time: Micros,
    },
}

/// Writes a recording row by row.
///
/// Columns: `t_s` (six decimals), `stylus` or `vibration` where there is one, then those of the [`ChannelSet`] under the names of
/// [`Channel::column`], and at the end when the computer took the sample in, where the set reports it (`arrived_us`, `age_us`). Readings have the fewest digits that give the same `f32` back; travel is written in
/// metres so that no unit conversion rounds it. Of a NaN the sign survives, the payload does not.
/// Every row is one write: give a buffered `W`.
#[derive(Debug)]
pub struct CsvWriter<W: Write> {
    out: W,
    stylus: bool,
    /// Further axes of stylus and reference that have a column.
    axes: usize,
    reference_axes: usize,
    columns: Vec<Channel>,
    taxels: usize,
    arrivals: bool,
    line: Vec<u8>,
    last: Option<Micros>,
}

impl<W: Write> CsvWriter<W> {
    /// Writes the header of a recording with `channels`.
    ///
    /// # Errors
    /// [`WriteError::Io`] if `out` refuses the bytes.
    pub fn new(mut out: W, channels: &ChannelSet) -> Result<Self, WriteError> {
        let columns: Vec<Channel> = channels.optional.keys().copied().collect();
        let mut line = Vec::new();
        line.extend_from_slice(b"t_s");
        for column in channels.columns() {
            write!(line, ",{column}")?;
        }
        let stylus = channels.stylus.column();
        let further = |axes: &Vec<String>| axes.len().saturating_sub(1).min(FURTHER_AXES);
        let (axes, reference_axes) = (further(&channels.axes), further(&channels.reference_axes));
        for taxel in 0..channels.taxels {
            write!(line, ",{}{taxel}", crate::taxels::PREFIX)?;
        }
        if channels.arrivals {
            let [at, age] = crate::channels::ARRIVAL;
            write!(line, ",{at},{age}")?;
        }
        line.push(b'\n');
        out.write_all(&line)?;
        let (taxels, arrivals) = (channels.taxels, channels.arrivals);
        let stylus = stylus.is_some();
        Ok(Self { out, stylus, axes, reference_axes, columns, taxels, arrivals, line, last: None })
    }

    /// Writes `sample` as one row.
    ///
    /// # Errors
    /// [`WriteError::NoColumn`] and [`WriteError::TimeBackwards`] before anything is written,
    /// [`WriteError::Io`] if the output refuses the bytes.
    pub fn write(&mut self, sample: &Sample) -> Result<(), WriteError> {
        self.write_with(sample, &[])
    }

    /// Writes `sample` and the frame of the taxel array that came with it, empty where none did.
    ///
    /// # Errors
    /// As [`CsvWriter::write`]; [`WriteError::Taxels`] for a frame of another size than the header has.
    pub fn write_with(&mut self, sample: &Sample, frame: &[f32]) -> Result<(), WriteError> {
        self.check(sample)?;
        if !frame.is_empty() && frame.len() != self.taxels {
            let (found, expected) = (frame.len(), self.taxels);
            return Err(WriteError::Taxels { time: sample.t, found, expected });
        }
        let micros = sample.t.0;
        self.line.clear();
        write!(self.line, "{}.{:06}", micros / 1_000_000, micros % 1_000_000)?;
        if self.stylus {
            self.line.push(b',');
            append_reading(&mut self.line, sample.stylus)?;
        }
        for axis in sample.stylus_axes.iter().take(self.axes) {
            self.line.push(b',');
            append_reading(&mut self.line, *axis)?;
        }
        for channel in &self.columns {
            self.line.push(b',');
            if let Some(value) = channel.reading(sample) {
                append_reading(&mut self.line, value)?;
            }
            let further = if *channel == Channel::Reference { self.reference_axes } else { 0 };
            for axis in sample.reference_axes.iter().take(further) {
                self.line.push(b',');
                if sample.reference.is_some() {
                    append_reading(&mut self.line, *axis)?;
                }
            }
        }
        for taxel in 0..self.taxels {
            self.line.push(b',');
            if let Some(value) = frame.get(taxel) {
                append_reading(&mut self.line, *value)?;
            }
        }
        match sample.arrival.filter(|_| self.arrivals) {
            Some(Arrival { at, age }) => write!(self.line, ",{},{}", at.0, age.0)?,
            None if self.arrivals => self.line.extend(b",,"),
            None => {}
        }
        self.line.push(b'\n');
        self.out.write_all(&self.line)?;
        self.last = Some(sample.t);
        Ok(())
    }

    /// Hands every row to whatever is behind the output.
    ///
    /// # Errors
    /// [`WriteError::Io`] if flushing fails.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        Ok(self.out.flush()?)
    }

    /// Flushes and gives the output back.
    ///
    /// # Errors
    /// [`WriteError::Io`] if flushing fails.
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.out.flush()?;
        Ok(self.out)
    }

    fn check(&self, sample: &Sample) -> Result<(), WriteError> {
        if let Some(before) = self.last.filter(|before| *before > sample.t) {
            return Err(WriteError::TimeBackwards { before, time: sample.t });
        }
        let lost = |channel: &Channel| {
            channel.reading(sample).is_some() && !self.columns.contains(channel)
        };
        let unwritten = |axes: &[f32], written| axes.iter().skip(written).any(|axis| *axis != 0.0);
        if unwritten(&sample.stylus_axes, self.axes)
            || unwritten(&sample.reference_axes, self.reference_axes)
        {
            return Err(WriteError::NoAxis { time: sample.t });
        }
        match Channel::ALL.into_iter().find(lost) {
            Some(channel) => Err(WriteError::NoColumn { time: sample.t, channel }),
            None => Ok(()),
        }
    }
}

fn append_reading(line: &mut Vec<u8>, value: f32) -> io::Result<()> {
    match value.is_nan() {
        true if value.is_sign_negative() => write!(line, "-NaN"),
        true => write!(line, "NaN"),
        false => write!(line, "{value:?}"),
    }
}
