//! Moments since 1970 as text, by `jiff`.

use jiff::Timestamp;

/// `20261121T225908Z`: for names of files.
#[must_use]
pub fn compact(seconds: u64) -> String {
    moment(seconds.saturating_mul(1_000_000)).strftime("%Y%m%dT%H%M%SZ").to_string()
}

/// `2026-11-21`: for names of files by day.
#[must_use]
pub fn day(seconds: u64) -> String {
    moment(seconds.saturating_mul(1_000_000)).strftime("%Y-%m-%d").to_string()
}

/// `2026-11-21T22:59:08.125Z` of microseconds: for lines.
#[must_use]
pub fn line(us: u64) -> String {
    format!("{:.3}", moment(us))
}

/// The last moment of the year 9999 for what is later.
fn moment(us: u64) -> Timestamp {
    let us = i64::try_from(us).unwrap_or(i64::MAX);
    Timestamp::from_microsecond(us).unwrap_or(Timestamp::MAX)
}

#[cfg(test)]
mod tests {
    use super::{Timestamp, compact, day, line};

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, text) in [
            (0, "19700101T000000Z"),
            (951_782_400, "20000229T000000Z"),
            (951_868_799, "20000229T235959Z"),
            (951_868_800, "20000301T000000Z"),
            (1_709_164_800, "20240229T000000Z"),
            (1_795_301_948, "20261121T225908Z"),
            (4_107_542_400, "21000301T000000Z"),
        ] {
            assert_eq!(compact(seconds), text);
            assert_eq!(day(seconds).replace('-', ""), text[..8]);
        }
        assert_eq!(line(1_795_301_948_125_999), "2026-11-21T22:59:08.125Z");
        assert_eq!(line(u64::MAX), line(Timestamp::MAX.as_microsecond().unsigned_abs()));
    }
}
