//! Columns `pressure_0`, `pressure_1`, .. of a recording, or the file `NAME_taxels.csv` beside it, in; a frame of the taxel
//! array for each sample out.

use std::path::{Path, PathBuf};

use slip_core::pressure::MAX_TAXELS;
use slip_core::sample::Sample;
use slip_core::units::Micros;

use crate::csv_read::{read_optional, time};
use crate::error::CsvError;
use grip_table::Table;

/// Prefix of the columns of an array in a recording.
pub(crate) const PREFIX: &str = "pressure_";

/// Frames of a taxel array, one place for each sample of a recording; a place may be empty.
#[derive(Clone, Debug, Default)]
pub struct Taxels {
    count: usize,
    /// Frame after frame; NaN for a taxel without a reading.
    values: Vec<f32>,
    /// Whether sample i came with a frame.
    present: Vec<bool>,
}

/// Bit by bit, so that a NaN equals itself.
impl PartialEq for Taxels {
    fn eq(&self, other: &Self) -> bool {
        let bits = |taxels: &Self| taxels.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        self.count == other.count && self.present == other.present && bits(self) == bits(other)
    }
}

impl Taxels {
    /// No frames yet, of `count` taxels each.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { count, ..Self::default() }
    }

    /// Taxels of a frame.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The frame that came with sample `index`; empty where none did.
    #[must_use]
    pub fn frame(&self, index: usize) -> &[f32] {
        if self.present.get(index) == Some(&true) {
            let from = index * self.count;
            self.values.get(from..from + self.count).unwrap_or_default()
        } else {
            &[]
        }
    }

    /// Appends the frame of the next sample: one value a taxel, NaN where there is no reading; empty where no frame came.
    pub fn push(&mut self, frame: &[f32]) {
        self.present.push(!frame.is_empty());
        let filled = frame.iter().copied().chain(core::iter::repeat(f32::NAN));
        self.values.extend(filled.take(self.count));
    }

    /// Keeps the frames of the first `count` samples alone.
    pub(crate) fn truncate(&mut self, count: usize) {
        self.present.truncate(count);
        self.present.shrink_to_fit();
        self.values.truncate(count.saturating_mul(self.count));
        self.values.shrink_to_fit();
    }

    /// The companion of the recording `NAME.csv`: `NAME_taxels.csv` or `NAME_electrodes.csv` in the same folder.
    #[must_use]
    pub fn companions(recording: &Path) -> [PathBuf; 2] {
        let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
        ["taxels", "electrodes"]
            .map(|ending| recording.with_file_name(format!("{stem}_{ending}.csv")))
    }

    /// Reads the companion of `recording`, `None` if there is none. A frame goes to the first of `samples` that is not earlier;
    /// one that finds no later sample, or a place already taken, is left out.
    ///
    /// # Errors
    /// Where the companion exists and its columns are not `t_s` and 1 to [`MAX_TAXELS`] taxels, or a cell is no number.
    pub fn read_beside(recording: &Path, samples: &[Sample]) -> Result<Option<Self>, CsvError> {
        for file in Self::companions(recording) {
            if let Some(bytes) = read_optional(&file)? {
                return Self::parse(&file, &bytes, samples).map(Some);
            }
        }
        Ok(None)
    }

    fn parse(file: &Path, bytes: &[u8], samples: &[Sample]) -> Result<Self, CsvError> {
        let mut table = Table::open(file, bytes)?;
        let t_s = table.required("t_s")?;
        let columns: Vec<usize> = (0..table.header().len()).filter(|c| *c != t_s).collect();
        check_count(file, columns.len())?;
        let mut taxels = Self::new(columns.len());
        let mut frame: Vec<f32> = vec![f32::NAN; columns.len()];
        let mut before: Option<Micros> = None;
        while let Some(row) = table.next_row()? {
            let t = time(&row, t_s, before)?;
            before = Some(t);
            for (value, &column) in frame.iter_mut().zip(&columns) {
                *value = narrow(row.finite(column)?);
            }
            let place = samples.partition_point(|sample| sample.t < t);
            if place >= samples.len() {
                break;
            }
            while taxels.present.len() < place {
                taxels.push(&[]);
            }
            if taxels.present.len() == place {
                taxels.push(&frame);
            }
        }
        Ok(taxels)
    }
}

/// # Errors
/// Where an array has no taxels, or more than the link can carry.
pub(crate) fn check_count(file: &Path, count: usize) -> Result<(), CsvError> {
    if (1..=MAX_TAXELS).contains(&count) {
        return Ok(());
    }
    Err(CsvError::TaxelCount { file: file.to_owned(), count })
}

#[expect(clippy::cast_possible_truncation, reason = "a sensor reading has the 24 bits of an f32")]
fn narrow(value: f64) -> f32 {
    value as f32
}
