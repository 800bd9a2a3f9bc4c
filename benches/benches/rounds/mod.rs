//! A piece of work that takes items one by one in; the time of one item out.

use core::time::Duration;
use criterion::{
    Bencher,
    measurement::{Measurement, WallTime},
};

/// Makes one iteration of a bench one item, so that criterion prints the time of an item.
///
/// Items are handled in rounds of at most `len`: `begin` sets a round up outside the time, `work` handles that many
/// items of it.
pub(crate) fn by_item<S>(
    bencher: &mut Bencher<'_>,
    len: usize,
    mut begin: impl FnMut() -> S,
    mut work: impl FnMut(&mut S, usize),
) {
    bencher.iter_custom(|iterations| {
        let mut total = Duration::ZERO;
        let mut left = usize::try_from(iterations).unwrap_or(usize::MAX);
        while left > 0 {
            let items = left.min(len);
            let mut round = begin();
            let start = WallTime.start();
            work(&mut round, items);
            total += WallTime.end(start);
            left -= items;
        }
        total
    });
}
