//! Ticks of a range, for a number of them: round places and their labels.

use crate::num;

/// Places of ticks and the digits behind the point that distinguish them.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    /// Distance of two ticks.
    pub step: f64,
    /// Digits behind the point.
    pub decimals: usize,
    /// The places, rising.
    pub at: Vec<f64>,
}

/// At most `most` + 1 ticks at multiples of 1, 2 or 5 times a power of ten between `from` and `to`; none where the range is empty
/// or not finite.
#[must_use]
pub fn ticks(from: f64, to: f64, most: usize) -> Ticks {
    let length = to - from;
    if !(length > 0.0 && length.is_finite()) || most == 0 {
        return Ticks { step: 0.0, decimals: 0, at: Vec::new() };
    }
    let rough = length / num::count(most);
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|times| times * power)
        .into_iter()
        .find(|&step| step >= rough * (1.0 - 1e-9))
        .unwrap_or(10.0 * power);
    let first = (from / step).ceil();
    let count = num::whole(((to - first * step) / step + 1e-9).floor() + 1.0).min(most + 1);
    let at = (0..count).map(|i| (first + num::count(i)) * step).collect();
    let decimals = num::whole((-(step.log10() + 1e-9).floor()).max(0.0));
    Ticks { step, decimals, at }
}

/// Powers of ten between two positive values, at most `most` + 1 of them.
#[must_use]
pub fn decades(from: f64, to: f64, most: usize) -> Vec<f64> {
    if !(from > 0.0 && to > from && to.is_finite()) || most == 0 {
        return Vec::new();
    }
    let (low, high) = (from.log10().ceil(), to.log10().floor());
    let every = ((high - low) / num::count(most)).ceil().max(1.0);
    let count = num::whole(((high - low) / every).floor() + 1.0).min(most + 1);
    (0..count).map(|i| 10f64.powf(low + every * num::count(i))).collect()
}

/// A plain number as text.
#[must_use]
pub fn number(value: f64, ticks: &Ticks) -> String {
    format!("{value:.*}", ticks.decimals.min(9))
}

/// A time (s) as text: seconds, or hours, minutes and seconds where seconds alone state little.
#[must_use]
pub fn label(t_s: f64, ticks: &Ticks) -> String {
    let decimals = ticks.decimals.min(9);
    if t_s.abs() < 1000.0 || ticks.step < 0.1 {
        return number(t_s, ticks);
    }
    let (sign, t_s) = if t_s < 0.0 { ("-", -t_s) } else { ("", t_s) };
    let minutes = (t_s / 60.0).floor();
    let hours = (minutes / 60.0).floor();
    let width = if decimals > 0 { decimals + 3 } else { 2 };
    let (seconds, minute) = (t_s - minutes * 60.0, minutes - hours * 60.0);
    format!("{sign}{hours:.0}:{minute:02.0}:{seconds:0width$.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::{decades, label, ticks};

    #[test]
    fn ticks_are_round_and_inside() {
        let found = ticks(0.13, 0.97, 5);
        assert_eq!((found.step, found.decimals), (0.2, 1));
        assert_eq!(found.at.len(), 4);
        for (from, to) in [(-1e-7, 3e-7), (1e9, 1e9 + 3.0), (-5.0, 5.0), (0.0, 1e30)] {
            let found = ticks(from, to, 8);
            assert!((3..=9).contains(&found.at.len()), "{from} {to}: {found:?}");
            let slack = found.step * 1e-6;
            assert!(found.at.iter().all(|&t| t >= from - slack && t <= to + slack), "{found:?}");
        }
    }

    #[test]
    fn impossible_ranges_have_none() {
        for (from, to) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
            assert!(ticks(from, to, 5).at.is_empty());
        }
        assert!(decades(0.0, 1.0, 5).is_empty() && decades(1.0, f64::NAN, 5).is_empty());
    }

    #[test]
    fn decades_are_powers_of_ten() {
        assert_eq!(decades(0.5, 2000.0, 8), [1.0, 10.0, 100.0, 1000.0]);
        assert!(decades(1e-30, 1e30, 6).len() <= 7);
    }

    #[test]
    fn long_times_are_clock_times() {
        assert_eq!(label(1.25, &ticks(1.0, 2.0, 4)), "1.2");
        assert_eq!(label(12.5, &ticks(12.0, 12.1, 5)), "12.50");
        assert_eq!(label(3725.0, &ticks(3700.0, 3760.0, 6)), "1:02:05");
    }
}
