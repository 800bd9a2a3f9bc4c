//! Values in as they come, the lowest and highest of each of the last columns of time out: a curve of some minutes in fixed memory.

/// Columns of a curve.
pub const COLUMNS: usize = 90;
/// Seconds of a column: three minutes in all.
pub const COLUMN_S: f64 = 2.0;

/// The last minutes of one value of one gripper: 8 bytes a column.
#[derive(Clone, Debug)]
pub struct Spark {
    /// Lowest and highest of each column, at its number modulo [`COLUMNS`]; NaN where nothing came.
    columns: Box<[[f32; 2]; COLUMNS]>,
    /// Number of the newest one.
    newest: u64,
}

const EMPTY: [f32; 2] = [f32::NAN; 2];

impl Default for Spark {
    fn default() -> Self {
        Self { columns: Box::new([EMPTY; COLUMNS]), newest: 0 }
    }
}

impl Spark {
    /// Takes a value at a time (s). One that is not finite is none, and a time that goes back belongs to the newest column.
    pub fn push(&mut self, at_s: f64, value: f32) {
        let column = number(at_s).max(self.newest);
        // What was in the columns between belongs to an earlier turn.
        for passed in (self.newest + 1..=column).take(COLUMNS) {
            *self.column(passed) = EMPTY;
        }
        if column - self.newest > COLUMNS as u64 {
            *self.columns = [EMPTY; COLUMNS];
        }
        self.newest = column;
        if value.is_finite() {
            let [low, high] = self.column(column);
            // The other of two is taken where one is NaN.
            (*low, *high) = (low.min(value), high.max(value));
        }
    }

    /// The columns up to the one of this time (s), the oldest first: lowest and highest, `None` where nothing came.
    pub fn until(&self, now_s: f64) -> impl Iterator<Item = Option<(f32, f32)>> {
        let last = number(now_s).max(self.newest);
        let first = (last + 1).checked_sub(COLUMNS as u64);
        // Before the first column there is nothing.
        let before = if first.is_some() { 0 } else { COLUMNS as u64 - (last + 1) };
        let there = first.unwrap_or(0)..=last;
        (0..before).map(|_| None).chain(there.map(|column| self.at(column)))
    }

    /// The highest of all columns up to this time (s).
    #[must_use]
    pub fn highest(&self, now_s: f64) -> Option<f32> {
        self.until(now_s).flatten().map(|(_, high)| high).reduce(f32::max)
    }

    fn at(&self, column: u64) -> Option<(f32, f32)> {
        let kept = column <= self.newest && self.newest - column < COLUMNS as u64;
        let [low, high] = *self.columns.get(place(column)).filter(|_| kept)?;
        (!low.is_nan()).then_some((low, high))
    }

    fn column(&mut self, column: u64) -> &mut [f32; 2] {
        &mut self.columns[place(column)]
    }
}

/// The column of a time (s).
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
const fn number(at_s: f64) -> u64 {
    (at_s / COLUMN_S) as u64
}

#[expect(clippy::cast_possible_truncation, reason = "below COLUMNS")]
const fn place(column: u64) -> usize {
    (column % COLUMNS as u64) as usize
}

#[cfg(test)]
mod tests {
    use super::{COLUMN_S, COLUMNS, Spark};

    fn shown(spark: &Spark, now_s: f64) -> Vec<(usize, f32, f32)> {
        let columns: Vec<_> = spark.until(now_s).collect();
        assert_eq!(columns.len(), COLUMNS);
        let there = columns.into_iter().enumerate();
        there.filter_map(|(at, column)| column.map(|(low, high)| (at, low, high))).collect()
    }

    #[test]
    fn a_column_holds_its_lowest_and_highest_and_slides_away() {
        let mut spark = Spark::default();
        assert_eq!(shown(&spark, 0.0), []);
        for (at_s, value) in [(0.1, 3.0), (0.3, 1.0), (1.9, 7.0), (2.1, 5.0), (2.2, f32::NAN)] {
            spark.push(at_s, value);
        }
        let last = COLUMNS - 1;
        assert_eq!(shown(&spark, 2.2), [(last - 1, 1.0, 7.0), (last, 5.0, 5.0)]);
        assert_eq!(shown(&spark, 22.0), [(last - 11, 1.0, 7.0), (last - 10, 5.0, 5.0)]);
        assert_eq!(spark.highest(22.0), Some(7.0));
        let almost_s = COLUMN_S * (COLUMNS as f64 + 0.5);
        assert_eq!(shown(&spark, almost_s), [(0, 5.0, 5.0)]);
        assert_eq!(shown(&spark, 1e6), []);
        assert_eq!(spark.highest(1e6), None);
    }

    #[test]
    fn memory_is_used_again_and_old_values_do_not_come_back() {
        let mut spark = Spark::default();
        for turn in 0..(3 * COLUMNS) {
            spark.push(COLUMN_S * turn as f64, turn as f32);
        }
        let now_s = COLUMN_S * (3 * COLUMNS - 1) as f64;
        let found = shown(&spark, now_s);
        assert_eq!((found.len(), found[0].1), (COLUMNS, (2 * COLUMNS) as f32));
        // A pause that is longer than all columns, and one that is a little shorter.
        spark.push(now_s + COLUMN_S * (COLUMNS - 1) as f64, 1.0);
        let there: Vec<f32> = spark.until(now_s + 178.0).flatten().map(|(low, _)| low).collect();
        assert_eq!(there, [(3 * COLUMNS - 1) as f32, 1.0]);
        spark.push(1e5, 2.0);
        assert_eq!(shown(&spark, 1e5), [(COLUMNS - 1, 2.0, 2.0)]);
        // A clock that goes back, or is none.
        spark.push(3.0, 9.0);
        spark.push(f64::NAN, 8.0);
        assert_eq!(shown(&spark, 1e5), [(COLUMNS - 1, 2.0, 9.0)]);
    }
}
