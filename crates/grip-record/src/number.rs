//! The text of a cell in, microseconds out.

use grip_table::Row;
use slip_core::units::Micros;

use crate::error::{CsvError, excerpt};

/// Why a cell is not a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimeFault {
    NotANumber,
    OutOfRange,
}

/// Seconds as decimal text to whole microseconds, halves rounded up.
///
/// The digits are shifted, never multiplied as floating point, so every `u64` count survives a round trip.
pub(crate) fn parse_micros(text: &str) -> Result<Micros, TimeFault> {
    let seconds: f64 = text.parse().map_err(|_| TimeFault::NotANumber)?;
    if seconds.abs() < 1e-7 {
        return Ok(Micros(0));
    }
    if !(seconds > 0.0 && seconds < 2e13) {
        return Err(TimeFault::OutOfRange);
    }
    shifted_digits(text.trim_start_matches('+')).map(Micros).ok_or(TimeFault::OutOfRange)
}

/// The cell at `column` as a time (s) that is not before `previous`.
pub(crate) fn time(
    row: &Row<'_>,
    column: usize,
    previous: Option<Micros>,
) -> Result<Micros, CsvError> {
    let text = row.digits(column);
    let place = || (row.file().to_owned(), row.line, row.name(column));
    let time = parse_micros(&text).map_err(|fault| match fault {
        TimeFault::NotANumber => {
            row.not_a_number(column, "write digits with a decimal point").into()
        }
        TimeFault::OutOfRange => {
            let ((file, line, column), text) = (place(), excerpt(&text));
            CsvError::TimeOutOfRange { file, line, column, text }
        }
    })?;
    match previous.filter(|before| *before > time) {
        None => Ok(time),
        Some(before) => {
            let (file, line, column) = place();
            let (before, time) = (before.as_seconds(), time.as_seconds());
            Err(CsvError::TimeBackwards { file, line, column, before, time })
        }
    }
}

/// The decimal `digits[.digits][e[+-]digits]` times 10^6, rounded; `None` beyond 64 bits.
fn shifted_digits(decimal: &str) -> Option<u64> {
    let (mantissa, exponent) = match decimal.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse().ok()?),
        None => (decimal, 0_i64),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let kept = i64::try_from(whole.len()).ok()?.checked_add(exponent)?.checked_add(6)?;
    let mut micros = 0_u64;
    let mut position = 0_i64;
    for byte in whole.bytes().chain(fraction.bytes()) {
        let digit = u64::from(byte.wrapping_sub(b'0'));
        if position >= kept {
            let round_up = position == kept && digit >= 5;
            return micros.checked_add(u64::from(round_up));
        }
        micros = micros.checked_mul(10)?.checked_add(digit)?;
        position += 1;
    }
    for _ in position..kept {
        micros = micros.checked_mul(10)?;
    }
    Some(micros)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn times_round_to_microseconds() {
        let cases = [
            ("0", 0),
            ("-0", 0),
            ("0.000455", 455),
            ("0.0004545", 455),
            ("0.00045449999", 454),
            ("1", 1_000_000),
            ("+1.5", 1_500_000),
            (".5", 500_000),
            ("2.", 2_000_000),
            ("1e-3", 1_000),
            ("12.5E1", 125_000_000),
            ("4.9e-7", 0),
            ("5e-7", 1),
            ("0e99999999999999999999", 0),
            ("18446744073709.551615", u64::MAX),
        ];
        for (text, micros) in cases {
            assert_eq!(parse_micros(text), Ok(Micros(micros)), "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in ["", "abc", "1,5", "0x10", "1e", "--1", "1 2"] {
            assert_eq!(parse_micros(text), Err(TimeFault::NotANumber), "{text}");
        }
        for text in ["NaN", "inf", "-inf", "-1", "1e400", "1e30", "18446744073709.551616"] {
            assert_eq!(parse_micros(text), Err(TimeFault::OutOfRange), "{text}");
        }
    }

    proptest! {
        #[test]
        fn six_decimals_are_exact(micros: u64) {
            let text = format!("{}.{:06}", micros / 1_000_000, micros % 1_000_000);
            prop_assert_eq!(parse_micros(&text), Ok(Micros(micros)));
        }

        #[test]
        fn an_exponent_changes_nothing(micros in 0_u64..1 << 50) {
            prop_assert_eq!(parse_micros(&format!("{micros}e-6")), Ok(Micros(micros)));
        }

        #[test]
        fn close_to_floating_point(seconds in 0.0_f64..1e6) {
            let Ok(Micros(micros)) = parse_micros(&seconds.to_string()) else { panic!("{seconds}") };
            let bound = 0.5e-6 + f64::EPSILON * seconds;
            prop_assert!((Micros(micros).as_seconds() - seconds).abs() <= bound);
        }
    }
}
