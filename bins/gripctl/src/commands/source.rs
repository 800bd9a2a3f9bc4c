//! A recording and its samples, which are read again from files that can be of any length.

use super::import;
use grip_import::{ArrayRows, Imported, Use};
use grip_record::{CsvOptions, CsvSamples, Recording, pace::Pace};
use slip_core::Sample;
use std::path::{Path, PathBuf};

/// What is known of a recording before its first sample, and its samples.
pub(super) struct Source {
    /// Without its samples, but where they had to be held.
    pub(super) recording: Recording,
    /// How many there are.
    pub(super) count: usize,
    samples: Samples,
}

/// How an imported recording came about.
pub(super) struct About {
    pub(super) format: &'static str,
    pub(super) clock: String,
    pub(super) uses: Vec<Use>,
    pub(super) unused: Vec<String>,
    pub(super) notes: Vec<String>,
}

/// Where samples come from.
enum Samples {
    Held,
    Csv(PathBuf, CsvOptions, Option<Pace>),
    Rows(Box<ArrayRows>),
}

impl Source {
    /// A recording that is no MCAP. A file is read twice, so that one of any length can be replayed: for its rate and its
    /// faults, and then for its samples.
    pub(super) fn open(file: &Path, csv: &CsvOptions) -> anyhow::Result<Self> {
        if grip_import::is_foreign(file) {
            return Ok(Self::of(import::opened(file, csv)?).1);
        }
        let (recording, count, pace) = CsvSamples::surveyed(file, csv)?;
        import::show_uses(file, &recording.notes.uses);
        let samples = Samples::Csv(file.to_owned(), csv.clone(), pace);
        Ok(Self { recording, count, samples })
    }

    /// What was imported.
    pub(super) fn of(imported: Imported) -> (About, Self) {
        let Imported { format, clock, uses, unused, notes, recording, rows } = imported;
        let (count, samples) = match rows {
            Some(rows) => (rows.count(), Samples::Rows(Box::new(rows))),
            None => (recording.samples.len(), Samples::Held),
        };
        (About { format, clock, uses, unused, notes }, Self { recording, count, samples })
    }

    /// Gives each sample, and the frame of taxels that came with it, to `each`.
    pub(super) fn each(
        &self,
        mut each: impl FnMut(&Sample, &[f32]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut rows = match &self.samples {
            Samples::Held => {
                let taxels = self.recording.taxels.as_ref();
                for (at, sample) in self.recording.samples.iter().enumerate() {
                    each(sample, taxels.map_or(&[] as &[f32], |taxels| taxels.frame(at)))?;
                }
                return Ok(());
            }
            Samples::Csv(file, csv, pace) => {
                let mut samples = CsvSamples::open_paced(file, csv, *pace)?;
                while let Some((sample, frame)) = samples.next_sample()? {
                    each(&sample, frame)?;
                }
                return Ok(());
            }
            Samples::Rows(rows) => rows.samples()?,
        };
        while let Some((sample, frame)) = rows.next_sample()? {
            each(&sample, frame)?;
        }
        Ok(())
    }

    /// Time from the first sample to the last (s).
    pub(super) fn duration_s(&self) -> anyhow::Result<f64> {
        let (mut first, mut last) = (None, 0.0);
        self.each(|sample, _| {
            last = sample.t.as_seconds();
            first.get_or_insert(last);
            Ok(())
        })?;
        Ok(last - first.unwrap_or(last))
    }
}
