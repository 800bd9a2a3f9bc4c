//! Slip detection as the source study has it: its statistic is the scattered energy of the last milliseconds over a threshold.
//!
//! ```text
//! stylus -> vibration band -> over its noise -> irregularities (delta, s) of the last 10 ms -> |E_sc| / threshold
//! ```
//!
//! The study takes the trial force as set and the falling speed as one constant; here they are [`FORCE_N`] and [`SPEED_M_S`], so that
//! s is that speed times the time between two valleys. Heights count in deviations of the noise at rest, one being [`NOISE_M`], so
//! that the unit of the recording drops out: E_sc needs the ratio delta/s, which a vibration in counts does not have. A proportional
//! reading feels these three constants as one factor, which the threshold takes up. The literal reading does not: its tangent changes
//! with them altogether, and no choice is right.
//!
//! Limits: the first axis of a sensor alone, and nothing is known of the motion of the robot.

use slip_core::{
    ConfigError, Sample,
    detector::DetectorConfig,
    esc::{EscSum, Reading, Trial},
    filter::{Band, FilterBank, MAX_CORNER},
    irregularity::{Irregularity, IrregularityExtractor},
};
use std::collections::VecDeque;

/// Irregularities older than this do not count (s).
const WINDOW_S: f64 = 0.010;
/// Falling speed (m/s).
const SPEED_M_S: f64 = 0.05;
/// Trial force (N).
const FORCE_N: f64 = 1.0;
/// Length that one deviation of the noise at rest counts as (m): that of the simulated stylus.
const NOISE_M: f32 = 1e-7;
/// Reversals up to this many deviations of the noise are none.
const HYSTERESIS: f32 = 3.0;
/// A longer step is a gap, after which the window begins anew (s).
const GAP_S: f64 = 0.1;
/// Lower corner over the highest one where the rate does not carry the band, as in the detector.
const LOWERED: f32 = 0.25;

/// |E_sc| (W) that is a slip, by the reading: what white Gaussian noise at 1 to 10 kHz passes once an hour at most (test
/// `levels_of_noise`, up to commit 8c10c857: 1.2 to 3.5 mW). Of the literal reading the tail gives 29 to 48 kW and the highest of an hour is 0.8 to 1.9 MW.
const fn threshold_w(reading: Reading) -> f64 {
    match reading {
        Reading::Literal => 1.2e5,
        _ => 3.5e-3,
    }
}

/// E_sc over a window, and its memory.
#[derive(Clone, Debug)]
pub struct EscTest {
    reading: Reading,
    threshold_w: f64,
    bank: FilterBank<1>,
    extractor: IrregularityExtractor,
    /// Irregularities with the time (s) at which they were complete, oldest first.
    window: VecDeque<(f64, Irregularity)>,
    /// Time of the first sample after the start or a gap, and of the last one (s).
    began_s: f64,
    last_s: f64,
    statistic: f32,
}

impl EscTest {
    /// A test in the vibration band of `config` at `rate_hz`, with the shipped threshold.
    ///
    /// # Errors
    /// Where the band does not fit the sample rate.
    pub fn new(
        reading: Reading,
        config: &DetectorConfig,
        rate_hz: f32,
    ) -> Result<Self, ConfigError> {
        Ok(Self {
            reading,
            threshold_w: threshold_w(reading),
            bank: FilterBank::new(&[band(config, rate_hz)], rate_hz)?,
            extractor: IrregularityExtractor::new(HYSTERESIS * NOISE_M),
            window: VecDeque::new(),
            began_s: f64::NEG_INFINITY,
            last_s: f64::NEG_INFINITY,
            statistic: 0.0,
        })
    }

    /// Takes the next sample, with the deviation of the noise in the band (unit of the stylus; 0 while it is unknown). Gives the
    /// statistic: above 1 is a slip.
    pub fn step(&mut self, sample: &Sample, noise_rms: f32) -> f32 {
        let t = sample.t.as_seconds();
        if !sample.stylus.is_finite() {
            return self.statistic;
        }
        if t - self.last_s > GAP_S {
            self.start(t, sample.stylus);
        }
        self.last_s = t;
        let [y] = self.bank.step(sample.stylus);
        self.bank.flush_tiny();
        if noise_rms <= 0.0 {
            return 0.0;
        }
        let complete = self.extractor.push(SPEED_M_S * t, y / noise_rms * NOISE_M);
        // The filters settle as long as the window is long.
        let complete = complete.filter(|_| t - self.began_s > WINDOW_S);
        let before = self.window.len();
        while self.window.front().is_some_and(|(then, _)| t - then > WINDOW_S) {
            self.window.pop_front();
        }
        if complete.is_some() || self.window.len() < before {
            self.window.extend(complete.map(|irregularity| (t, irregularity)));
            let energy_w = esc_w(self.reading, self.window.iter().map(|(_, i)| *i));
            #[expect(clippy::cast_possible_truncation, reason = "a ratio; the cast saturates")]
            let statistic = (energy_w / self.threshold_w) as f32;
            self.statistic = statistic;
        }
        self.statistic
    }

    fn start(&mut self, t_s: f64, x: f32) {
        self.bank.prime(x);
        self.extractor = IrregularityExtractor::new(HYSTERESIS * NOISE_M);
        self.window.clear();
        self.began_s = t_s;
        self.statistic = 0.0;
    }
}

/// |E_sc| (W) of irregularities at [`FORCE_N`] and [`SPEED_M_S`]; 0 of none, and where it has no value.
fn esc_w(reading: Reading, irregularities: impl Iterator<Item = Irregularity>) -> f64 {
    let mut sum = EscSum::new(reading);
    for Irregularity { delta_m, spacing_m } in irregularities {
        sum.push(f64::from(delta_m), f64::from(spacing_m));
    }
    let trial = Trial::new(FORCE_N, SPEED_M_S);
    let literal = if reading == Reading::Literal { sum.literal(&trial) } else { None };
    sum.chosen(&trial, literal).map_or(0.0, |esc| esc.value.abs())
}

/// The vibration band as the detector places it.
fn band(config: &DetectorConfig, rate_hz: f32) -> Band {
    let limit_hz = MAX_CORNER * rate_hz;
    let wanted = config.vibration;
    if wanted.low_hz < 0.8 * limit_hz {
        Band { low_hz: wanted.low_hz, high_hz: wanted.high_hz }
    } else {
        Band { low_hz: LOWERED * limit_hz, high_hz: limit_hz }
    }
}

#[cfg(test)]
mod tests {
    use super::{
        EscTest, FORCE_N, HYSTERESIS, NOISE_M, SPEED_M_S, WINDOW_S, band, esc_w, threshold_w,
    };
    use crate::dice::Dice;
    use slip_core::{
        Sample,
        detector::DetectorConfig,
        esc::Reading,
        filter::FilterBank,
        irregularity::{Irregularity, IrregularityExtractor},
        units::Micros,
    };

    const RATE_HZ: f32 = 2000.0;
    const READINGS: [Reading; 2] = [Reading::SlopePower, Reading::Literal];

    /// A second of noise, between 0.4 and 0.6 s with a tone.
    fn signal(unit: f32) -> Vec<Sample> {
        let mut state = 5_u32;
        let reading = |i: u16| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (state >> 8) as f32 / (1 << 23) as f32 - 1.0;
            let tone = if (800..1200).contains(&i) { 8.0 } else { 0.0 };
            let x = noise + tone * (core::f32::consts::TAU * 0.1 * f32::from(i)).sin();
            Sample::stylus(Micros(500 * u64::from(i)), unit * (300.0 + x))
        };
        (0..2000_u16).map(reading).collect()
    }

    fn statistics(reading: Reading, samples: &[Sample], noise_rms: f32) -> Vec<f32> {
        let mut test = EscTest::new(reading, &DetectorConfig::default(), RATE_HZ).unwrap();
        samples.iter().map(|sample| test.step(sample, noise_rms)).collect()
    }

    /// Eq. 1 as printed, and its reading as a sum of slopes, by the plain formula.
    fn by_formula(reading: Reading, window: &[Irregularity]) -> f64 {
        let ratio = |i: &Irregularity| f64::from(i.delta_m) / f64::from(i.spacing_m);
        let n = f64::from(u32::try_from(window.len()).unwrap());
        let value = match reading {
            Reading::Literal => n * window.iter().map(|i| 1.0 / ratio(i).tan()).sum::<f64>().tan(),
            _ => window.iter().map(|i| 2.0 * ratio(i)).sum(),
        };
        (FORCE_N * SPEED_M_S * value).abs()
    }

    /// At every sample the sum over all irregularities of the whole signal that were complete in the window before.
    #[test]
    fn the_window_is_the_sum_over_all_irregularities_in_it() {
        let (samples, noise_rms) = (signal(1.0), 0.4);
        let band = band(&DetectorConfig::default(), RATE_HZ);
        let mut bank = FilterBank::new(&[band], RATE_HZ).unwrap();
        bank.prime(samples[0].stylus);
        let mut extractor = IrregularityExtractor::new(HYSTERESIS * NOISE_M);
        let mut all = Vec::new();
        for sample in &samples {
            let t = sample.t.as_seconds();
            let height_m = bank.step(sample.stylus)[0] / noise_rms * NOISE_M;
            all.extend(extractor.push(SPEED_M_S * t, height_m).map(|found| (t, found)));
        }
        assert!(all.len() > 50, "{}", all.len());
        for reading in READINGS {
            let got = statistics(reading, &samples, noise_rms);
            let (mut highest, mut compared) = (0.0_f64, 0);
            for (sample, got) in samples.iter().zip(got) {
                let t = sample.t.as_seconds();
                let counts = |then: f64| then > WINDOW_S && then <= t && t - then <= WINDOW_S;
                let window: Vec<Irregularity> =
                    all.iter().filter(|(then, _)| counts(*then)).map(|(_, i)| *i).collect();
                let wanted = by_formula(reading, &window) / threshold_w(reading);
                // The tangent of some hundred turns, in f64 alone.
                let near = if reading == Reading::Literal { 1e-4 } else { 1e-6 };
                let apart = (f64::from(got) - wanted).abs();
                assert!(apart <= near * wanted.max(1e-9), "{t}: {got}, wanted {wanted}");
                highest = highest.max(wanted);
                compared += u32::from(!window.is_empty());
            }
            assert!(compared > 400 && highest > 0.0, "{compared} {highest}");
        }
    }

    #[test]
    fn the_unit_drops_out() {
        for reading in READINGS {
            let plain = statistics(reading, &signal(1.0), 0.4);
            assert!(plain.iter().any(|statistic| *statistic > 0.0));
            // A power of two changes no digit.
            let exact = statistics(reading, &signal(1.0 / 1024.0), 0.4 / 1024.0);
            assert_eq!(plain, exact);
        }
        let plain = statistics(Reading::SlopePower, &signal(1.0), 0.4);
        let thousandth = statistics(Reading::SlopePower, &signal(1e-3), 4e-4);
        let mean = |all: &[f32]| all.iter().sum::<f32>() / all.len() as f32;
        assert!((mean(&thousandth) / mean(&plain) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_tone_is_far_above_noise_for_slopes_and_nothing_is_known_without_a_floor() {
        let samples = signal(1.0);
        let got = statistics(Reading::SlopePower, &samples, 0.4);
        let mean = |range: core::ops::Range<usize>| {
            let len = range.len() as f32;
            got[range].iter().sum::<f32>() / len
        };
        assert!(mean(850..1200) > 5.0 * mean(100..780), "{} {}", mean(850..1200), mean(100..780));
        assert!(statistics(Reading::SlopePower, &samples, 0.0).iter().all(|s| *s == 0.0));
    }

    /// The highest statistic (W) of each second of white Gaussian noise at `rate_hz`, in rising order.
    fn noise_peaks(reading: Reading, rate_hz: u32, seconds: u32, seed: u64) -> Vec<f32> {
        let mut dice = Dice(seed);
        #[expect(clippy::cast_possible_truncation, reason = "noise needs no more digits")]
        let mut noise = || {
            let radius = (-2.0 * (1.0 - dice.share()).ln()).sqrt();
            (radius * (core::f64::consts::TAU * dice.share()).cos()) as f32
        };
        let config = DetectorConfig::default();
        let rate = rate_hz as f32;
        let mut bank = FilterBank::new(&[band(&config, rate)], rate).unwrap();
        let count = 50_000_u32;
        let energy: f32 = (0..count).map(|_| bank.step(noise())[0].powi(2)).sum();
        let noise_rms = (energy / count as f32).sqrt();
        let mut test = EscTest::new(reading, &config, rate).unwrap();
        let mut peaks: Vec<f32> = (0..seconds)
            .map(|second| {
                let steps = (0..rate_hz).map(|i| {
                    let t = u64::from(second) * 1_000_000
                        + u64::from(i) * 1_000_000 / u64::from(rate_hz);
                    test.step(&Sample::stylus(Micros(t), noise()), noise_rms)
                });
                steps.fold(0.0, f32::max)
            })
            .collect();
        peaks.sort_by(f32::total_cmp);
        peaks
    }

    /// Other seeds than those of the thresholds: ten minutes have one alarm at most, where an hour should have one.
    #[test]
    fn white_noise_is_hardly_ever_a_slip() {
        for reading in READINGS {
            let peaks = noise_peaks(reading, 2200, 600, 31_000_000);
            assert!(peaks[598] < 1.0, "{reading:?} {:?}", &peaks[595..]);
            assert!(peaks[300] > 0.0, "noise makes irregularities");
        }
    }

    #[test]
    fn a_bad_reading_changes_nothing_and_a_gap_begins_anew() {
        let mut samples = signal(1.0);
        samples[1000].stylus = f32::NAN;
        let got = statistics(Reading::SlopePower, &samples, 0.4);
        assert!(got[1000] == got[999] && got.iter().all(|s| s.is_finite()) && got[1100] > 0.0);
        samples.iter_mut().skip(1000).for_each(|sample| sample.t = Micros(sample.t.0 + 200_000));
        let got = statistics(Reading::SlopePower, &samples, 0.4);
        assert!(got[999] > 0.0 && got[1001..1015].iter().all(|s| *s == 0.0));
    }

    #[test]
    fn slopes_grow_with_number_and_height_and_the_tangent_does_not() {
        let rows = |n: usize, delta_m: f32| {
            esc_w_of(Reading::SlopePower, n, delta_m) / esc_w_of(Reading::SlopePower, 1, 1e-6)
        };
        assert!((rows(3, 1e-6) - 3.0).abs() < 1e-9 && (rows(1, 2e-6) - 2.0).abs() < 1e-6);
        let literal: Vec<f64> = (1..8).map(|n| esc_w_of(Reading::Literal, n, 1e-6)).collect();
        assert!(literal.windows(2).any(|pair| pair[1] < pair[0]), "{literal:?}");
        assert_eq!(esc_w(Reading::Literal, core::iter::empty()), 0.0);
    }

    fn esc_w_of(reading: Reading, n: usize, delta_m: f32) -> f64 {
        esc_w(reading, core::iter::repeat_n(Irregularity { delta_m, spacing_m: 2e-4 }, n))
    }
}
