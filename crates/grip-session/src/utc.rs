//! Seconds since 1970 in, dates and times of day in UTC out.

/// A date and a time of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Moment {
    year: u64,
    month: u64,
    day: u64,
    hour: u64,
    minute: u64,
    second: u64,
}

/// Days become dates by eras of 400 years that begin in March, so that the leap day is the last of its year.
fn moment(seconds: u64) -> Moment {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let shifted = days + 719_468;
    let (era, day) = (shifted / 146_097, shifted % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    Moment { year: 400 * era + year + next, month, day, hour, minute, second }
}

/// `20261121T225908Z`: for names of files.
#[must_use]
pub fn compact(seconds: u64) -> String {
    let Moment { year, month, day, hour, minute, second } = moment(seconds);
    format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}Z")
}

/// `2026-11-21T22:59:08.125Z` of microseconds: for lines.
#[must_use]
pub fn line(us: u64) -> String {
    let Moment { year, month, day, hour, minute, second } = moment(us / 1_000_000);
    let ms = us / 1000 % 1000;
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{ms:03}Z")
}

#[cfg(test)]
mod tests {
    use super::{compact, line};

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
        }
        assert_eq!(line(1_795_301_948_125_999), "2026-11-21T22:59:08.125Z");
    }
}
