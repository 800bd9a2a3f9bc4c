//! Lower bound on the delay of any detector of band energies, from signal over noise in the bands and the false-alarm interval.
//!
//! A band of width B gives 2 B independent readings a second, Gaussian with variance 1 before the slip and 1 + s in it. One reading
//! reports (s - ln(1 + s)) / 2 nats (the Kullback-Leibler divergence), so over bands that do not overlap
//!
//! ```text
//! delay >= ln(ARL) / KL      KL = sum of B (s - ln(1 + s)) a second      ARL = interval * sum of 2 B readings
//! ```
//!
//! G. Lorden, Ann. Math. Statist. 42 (1971): the expected delay of the best test at the least favourable moment, for long intervals. For a slip
//! that grows, [`simulated`] gives the moment at which the sum of KL over time reaches ln(ARL): a slip has shown no more by then.
//! A single slip may be noticed before, by luck; the median of many should not be.

use super::{
    robot::{Hand, INCIPIENT_S, RobotConfig},
    trials::{LATE_S, MOVES, SESSION, Slips},
};
use rayon::prelude::*;
use slip_core::{
    detector::DetectorConfig,
    filter::{Band, FilterBank, MAX_CORNER},
};

/// Bands that do not overlap.
const BANDS: usize = 4;

/// What a band of `width_hz` (Hz) shows in a second at a signal of `snr` times the energy of the noise (nats).
#[must_use]
pub fn information(width_hz: f64, snr: f64) -> f64 {
    width_hz * (snr - snr.ln_1p())
}

/// ln(ARL) of bands with these widths (Hz) at one false alarm in `interval_s`.
#[must_use]
pub fn needed(widths_hz: &[f64], interval_s: f64) -> f64 {
    (interval_s * 2.0 * widths_hz.iter().sum::<f64>()).ln()
}

/// The least delay (s) for a constant signal; `bands` are widths (Hz) and signal over noise (energy).
#[must_use]
pub fn delay_s(bands: &[(f64, f64)], interval_s: f64) -> f64 {
    let widths: Vec<f64> = bands.iter().map(|band| band.0).collect();
    needed(&widths, interval_s) / bands.iter().map(|(b, s)| information(*b, *s)).sum::<f64>()
}

/// Length of the pieces over which energies are summed (s).
const PIECE_S: f64 = 5e-4;
/// Time over which the noise is measured (s).
const NOISE_S: f64 = 30.0;

/// The bands of a bank: the shipped ones that do not overlap. Those that do not fit the rate have a width of 0.
struct Bank {
    filters: FilterBank<BANDS>,
    widths_hz: [f64; BANDS],
    piece: usize,
}

impl Bank {
    fn new(rate_hz: f64) -> Option<Self> {
        let rate = rate_hz as f32;
        let limit_hz = MAX_CORNER * rate;
        let octaves = DetectorConfig::default().octaves;
        let [first, ..] = octaves;
        let fits = octaves.map(|band| band.low_hz < 0.8 * limit_hz);
        let corners: [Band; BANDS] = core::array::from_fn(|b| {
            let band = if fits[b] { octaves[b] } else { first };
            Band { low_hz: band.low_hz, high_hz: band.high_hz.min(limit_hz) }
        });
        let width = |b: usize| f64::from(corners[b].high_hz - corners[b].low_hz);
        Some(Self {
            filters: FilterBank::new(&corners, rate).ok()?,
            widths_hz: core::array::from_fn(|b| if fits[b] { width(b) } else { 0.0 }),
            piece: (PIECE_S * rate_hz).round().max(1.0) as usize,
        })
    }

    /// Mean energies over the next piece of a signal (um).
    fn energies(&mut self, mut next_um: impl FnMut() -> f64) -> [f64; BANDS] {
        let block: Vec<f32> = (0..self.piece).map(|_| next_um() as f32).collect();
        let sums = self.filters.energy(&block, 0.0, &[1.0; BANDS]);
        sums.map(|sum| f64::from(sum) / self.piece as f64)
    }
}

/// The bound (ms from gross slip, negative while incipient; infinite where 200 ms do not show enough) for each of `slips` by all bands of the stylus together at one false alarm in `interval_s`, with the noise known: in motion that is the mean energy
/// of noise and motion together, as for a detector that does not receive the motion reference. Empty where the rate carries no band.
#[must_use]
pub fn simulated(robot: RobotConfig, slips: Slips, interval_s: f64) -> Vec<f64> {
    let robot = slips.robot(robot);
    (0..slips.count.div_ceil(SESSION))
        .into_par_iter()
        .flat_map_iter(|session| {
            let mut hand = Hand::new(robot, slips.ra_um, slips.seed + session);
            let noise = noise(&mut hand, robot.rate_hz, slips.moving);
            (0..SESSION)
                .filter_map(|_| one(&mut hand, robot.rate_hz, &noise?, interval_s))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Mean energy of each band without slip (um^2), while the robot moves if it does.
fn noise(hand: &mut Hand, rate_hz: f64, moving: bool) -> Option<[f64; BANDS]> {
    let mut bank = Bank::new(rate_hz)?;
    let still_um = 1e6 * hand.height_m();
    let (mut sums, mut count) = ([0.0; BANDS], 0.0);
    let pieces = (NOISE_S * rate_hz) as usize / bank.piece;
    for piece in 0..pieces {
        let energies = bank.energies(|| 1e6 * f64::from(hand.sample().stylus) - still_um);
        // The filters settle in the first sixteenth.
        if piece > pieces / 16 && (!moving || hand.envelope() >= MOVES) {
            count += 1.0;
            sums.iter_mut().zip(energies).for_each(|(sum, energy)| *sum += energy);
        }
    }
    (count > 0.0).then(|| sums.map(|sum| sum / count))
}

fn one(hand: &mut Hand, rate_hz: f64, noise: &[f64; BANDS], interval_s: f64) -> Option<f64> {
    let mut bank = Bank::new(rate_hz)?;
    let still_um = 1e6 * hand.height_m();
    hand.begin_slip();
    let widths = bank.widths_hz;
    let piece_s = bank.piece as f64 / rate_hz;
    let (mut shown, mut least_ms, mut t) = (0.0, f64::INFINITY, -INCIPIENT_S);
    while t < LATE_S {
        let energies = bank.energies(|| {
            hand.sample();
            1e6 * hand.height_m() - still_um
        });
        t += piece_s;
        let bands = widths.iter().zip(energies).zip(noise);
        let nats = bands.map(|((width, energy), noise)| information(*width, energy / noise));
        shown += piece_s * nats.sum::<f64>();
        if shown >= needed(&widths, interval_s) {
            least_ms = least_ms.min(1e3 * t);
        }
    }
    hand.end_slip();
    Some(least_ms)
}

#[cfg(test)]
mod tests {
    use super::{delay_s, simulated};
    use crate::detection::{RobotConfig, Slips};

    /// Figures worked out elsewhere for a band of 500 Hz and one false alarm an hour.
    #[test]
    fn delays_of_one_band_are_the_known_ones() {
        for (db, wanted_ms, half_digit) in
            [(0.0, 98.0, 0.5), (6.0, 12.7, 0.05), (10.0, 4.0, 0.05), (20.0, 0.3, 0.05)]
        {
            let ms = 1e3 * delay_s(&[(500.0, 10.0_f64.powf(0.1 * db))], 3600.0);
            assert!((ms - wanted_ms).abs() <= half_digit, "{db} dB: {ms} ms, wanted {wanted_ms}");
        }
    }

    #[test]
    fn a_second_band_and_a_shorter_interval_help() {
        let one = delay_s(&[(500.0, 4.0)], 3600.0);
        assert!(delay_s(&[(500.0, 4.0)], 60.0) < one);
        assert!(delay_s(&[(500.0, 4.0), (500.0, 4.0)], 3600.0) < 0.6 * one);
    }

    /// Rougher is sooner, motion costs time, and so does a rate that carries fewer bands.
    #[test]
    fn simulated_bounds_are_in_order() {
        let bound = |rate_hz, ra_um, moving| {
            let slips = Slips { ra_um, moving, count: 20, seed: 3 };
            let robot = RobotConfig { rate_hz, ..RobotConfig::default() };
            let mut ms = simulated(robot, slips, 3600.0);
            assert_eq!(ms.len(), 20);
            ms.sort_by(f64::total_cmp);
            ms[10]
        };
        let (smooth, rough) = (bound(1e4, 0.4, false), bound(1e4, 6.3, false));
        assert!(rough < smooth && smooth < 20.0, "{rough} {smooth}");
        assert!(bound(1e4, 0.4, true) > smooth);
        assert!(bound(1e3, 0.4, false) > smooth);
    }
}
