//! Histogram of times with fixed buckets: small enough to be copied once a second, fine enough for quantiles.

/// Times below this (ns) share the first bucket.
const LEAST: u64 = 1 << LEAST_BITS;
const LEAST_BITS: u32 = 8;
/// Buckets to each doubling: a quantile is off by at most an eighth.
const PARTS: u32 = 1 << PART_BITS;
const PART_BITS: u32 = 3;
/// Doublings from 256 ns to 1.07 s.
const DOUBLINGS: u32 = 22;
/// One for short times, the doublings, one for long ones.
const BUCKETS: usize = (DOUBLINGS * PARTS) as usize + 2;

/// How often a time fell into each bucket. `record` is a handful of instructions, without branches on data of before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latency {
    buckets: [u64; BUCKETS],
    sum_ns: u64,
    max_ns: u64,
}

impl Default for Latency {
    fn default() -> Self {
        Self { buckets: [0; BUCKETS], sum_ns: 0, max_ns: 0 }
    }
}

impl Latency {
    /// Takes one time (ns).
    #[inline]
    pub fn record(&mut self, ns: u64) {
        if let Some(bucket) = self.buckets.get_mut(index(ns)) {
            *bucket += 1;
        }
        self.sum_ns = self.sum_ns.saturating_add(ns);
        self.max_ns = self.max_ns.max(ns);
    }

    /// Times taken.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.buckets.iter().sum()
    }

    /// Their sum (ns).
    #[must_use]
    pub fn sum_ns(&self) -> u64 {
        self.sum_ns
    }

    /// The longest (ns).
    #[must_use]
    pub fn max_ns(&self) -> u64 {
        self.max_ns
    }

    /// The time (ns) that the share `q` (0 to 1) does not exceed, to an eighth of itself; `None` where nothing was taken.
    #[must_use]
    pub fn quantile_ns(&self, q: f64) -> Option<u64> {
        let count = self.count();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of a count"
        )]
        let wanted = ((q.clamp(0.0, 1.0) * count as f64).ceil() as u64).max(1);
        let mut seen = 0;
        for (index, bucket) in self.buckets.iter().enumerate() {
            seen += bucket;
            if seen >= wanted {
                return Some(upper_ns(index).map_or(self.max_ns, |upper| upper.min(self.max_ns)));
            }
        }
        None
    }

    /// Times by whole doublings: those below 256 ns, below 512 ns and so on up to 1.07 s, and all longer ones.
    #[must_use]
    pub fn doublings(&self) -> [u64; DOUBLINGS as usize + 2] {
        let mut below = 0;
        let mut all = self.cumulative().map(|(_, upto)| upto).chain([self.count()]);
        core::array::from_fn(|_| {
            let upto = all.next().unwrap_or(below);
            upto - core::mem::replace(&mut below, upto)
        })
    }

    /// Upper bounds (ns) of whole doublings, each with the number of times up to it: the buckets of a Prometheus histogram
    /// but the infinite one, which is [`Latency::count`].
    pub fn cumulative(&self) -> impl Iterator<Item = (u64, u64)> {
        (0..=DOUBLINGS).map(|doubling| {
            let upto = (doubling * PARTS) as usize + 1;
            (LEAST << doubling, self.buckets.iter().take(upto).sum())
        })
    }
}

/// The bucket of a time: the doubling it lies in and the eighth of it.
fn index(ns: u64) -> usize {
    if ns < LEAST {
        return 0;
    }
    let doubling = ns.ilog2() - LEAST_BITS;
    let part = (ns >> (doubling + LEAST_BITS - PART_BITS)) & u64::from(PARTS - 1);
    let index = u64::from(doubling * PARTS) + part + 1;
    usize::try_from(index).unwrap_or(BUCKETS).min(BUCKETS - 1)
}

/// The end of a bucket (ns); the last one has none.
fn upper_ns(index: usize) -> Option<u64> {
    let index = u32::try_from(index).ok()?;
    if index > DOUBLINGS * PARTS {
        return None;
    }
    let (doubling, part) = (index / PARTS, index % PARTS);
    Some((LEAST << doubling) + u64::from(part) * ((LEAST << doubling) >> PART_BITS))
}

#[cfg(test)]
mod tests {
    use super::{BUCKETS, Latency, index, upper_ns};
    use grip_link::message::daemon::Appended;

    #[test]
    fn every_time_lies_below_the_end_of_its_bucket_and_not_in_the_one_before() {
        let times = (0..5000).chain((0..34).flat_map(|bits| {
            let edge = 1_u64 << bits;
            [edge.saturating_sub(1), edge, edge + 1, edge + edge / 2]
        }));
        for ns in times {
            let at = index(ns);
            assert!(upper_ns(at).is_none_or(|upper| ns < upper), "{ns} in {at}");
            let before = at.checked_sub(1).and_then(upper_ns);
            assert!(before.is_none_or(|lower| ns >= lower), "{ns} in {at}");
        }
        assert_eq!(index(u64::MAX), BUCKETS - 1);
    }

    #[test]
    fn quantiles_are_within_an_eighth() {
        let mut latency = Latency::default();
        (1..=10_000).for_each(|us| latency.record(1000 * us));
        for (q, exact) in [(0.5, 5e6), (0.99, 9.9e6), (0.999, 9.99e6), (0.01, 1e5)] {
            let ratio = latency.quantile_ns(q).unwrap() as f64 / exact;
            assert!((1.0..=1.125).contains(&ratio), "{q}: {ratio}");
        }
        assert_eq!((latency.quantile_ns(1.0), latency.max_ns()), (Some(10_000_000), 10_000_000));
        assert_eq!(latency.sum_ns(), 1000 * 5000 * 10_001);
        assert_eq!(Latency::default().quantile_ns(0.5), None);
    }

    #[test]
    fn cumulative_counts_rise_to_all_but_the_longest() {
        let mut latency = Latency::default();
        for ns in [0, 255, 256, 511, 512, 1_000_000, 2_000_000_000] {
            latency.record(ns);
        }
        let rows: Vec<(u64, u64)> = latency.cumulative().collect();
        assert_eq!((rows[0], rows[1], rows[2]), ((256, 2), (512, 4), (1024, 5)));
        assert_eq!((rows.len(), rows[22], latency.count()), (23, (1 << 30, 6), 7));
        assert!(rows.is_sorted_by_key(|row| row.1));
        let counts = latency.doublings();
        assert_eq!((counts[0], counts[1], counts[2], counts[12]), (2, 2, 1, 1));
        assert_eq!((counts[23], counts.iter().sum()), (1, latency.count()));
        for (bucket, (upper_ns, _)) in rows.into_iter().enumerate() {
            assert_eq!(Appended::upper_ns(bucket), Some(upper_ns));
        }
        assert_eq!(counts.len(), Appended::BUCKETS);
    }
}
