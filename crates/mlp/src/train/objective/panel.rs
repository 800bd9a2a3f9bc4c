//! Panels of a few vectors of scaled rows, transposed: for each column the values of all rows.

use super::super::aligned::Aligned;
use super::super::lanes::Real;
use ndarray::ArrayRef2;

/// Most vectors of rows in a panel: so many sums stay in registers while a neuron's inputs pass by.
pub(super) const VECTORS: usize = 4;

/// Up to [`VECTORS`] vectors of rows that go through the network together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    /// Vectors of rows, 1 to [`VECTORS`].
    pub(super) vectors: usize,
    /// Place of its first value in the data.
    pub(super) start: usize,
    /// Whether lanes of its last vector are empty.
    pub(super) ragged: bool,
}

/// All rows in panels, each with its inputs column by column, then its targets.
#[derive(Debug, Clone)]
pub(super) struct Panels<T> {
    pub(super) panels: Vec<Panel>,
    pub(super) values: Aligned<T>,
    /// One in the lanes of the last vector that hold rows, zero in the others.
    pub(super) mask: Aligned<T>,
}

impl<T: Real> Panels<T> {
    /// Lays out as many rows of `inputs` as of `targets`, at least one, for vectors of `width` numbers. Empty lanes repeat the
    /// last row.
    pub(super) fn new(inputs: &ArrayRef2<f64>, targets: &ArrayRef2<f64>, width: usize) -> Self {
        let (rows, columns) = (inputs.nrows(), inputs.ncols() + targets.ncols());
        let vectors = rows.div_ceil(width);
        let mut values = Aligned::zeros(vectors * width * columns);
        let mut panels = Vec::with_capacity(vectors.div_ceil(VECTORS));
        let (mut first, mut start) = (0, 0);
        while first < vectors {
            let left = vectors - first;
            // The last panels share what is left evenly: one vector alone would wait for its own sums.
            let take = left.div_ceil(left.div_ceil(VECTORS));
            let lanes = take * width;
            let rows_here = (first * width..first * width + lanes).map(|row| row.min(rows - 1));
            for (lane, row) in rows_here.enumerate() {
                let panel = &mut values.get_mut()[start..start + lanes * columns];
                for (column, &field) in inputs.row(row).iter().chain(targets.row(row)).enumerate() {
                    panel[column * lanes + lane] = T::of(field);
                }
            }
            let ragged = (first + take) * width > rows;
            panels.push(Panel { vectors: take, start, ragged });
            first += take;
            start += lanes * columns;
        }
        let mut mask = Aligned::zeros(width);
        mask.get_mut()[..rows - (vectors - 1) * width].fill(T::of(1.0));
        Self { panels, values, mask }
    }
}
