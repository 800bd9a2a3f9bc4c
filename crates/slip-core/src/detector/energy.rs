//! The energy detector: mean energy of two bands over their noise floor, against fixed thresholds.
//!
//! ```text
//! z = (y / sigma)^2      e <- e + a (z - e),  a = 1 - exp(-1/(tau fs))      slip when e > h in a band
//! ```
//!
//! The shear band (20-400 Hz) sees the first elastic movement, the vibration band (100-800 Hz) the
//! texture passing under the stylus; above `gross` times the floor there, the object slides.
//!
//! Thresholds: at rest e is close to chi-square with nu degrees of freedom over nu, where nu = 4.1 (shear)
//! and 14.6 (vibration) was measured on rest noise for tau = 5 ms. The quantile by Wilson and Hilferty (1931)
//! q = (1 - 2/(9 nu) + z sqrt(2/(9 nu)))^3 at z = 4.68 (tail tau / 1 h = 1.4e-6) is 8.1 and 3.8; the defaults
//! 25 and 12 are three times that, because sensor noise has heavier tails than a Gaussian. The false-alarm
//! interval itself is not claimed: it can only be measured on a run longer than it.

use super::primed::{PrimedBank, samples};
use crate::{
    config::ConfigError,
    filter::Envelope,
    floor::{Floor, FloorConfig},
};

/// Bands of the detector: shear and vibration.
pub const BANDS: usize = 2;

const VIBRATION: usize = 1;

/// One band with its threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct BandThreshold {
    /// Lower corner (Hz).
    pub low_hz: f32,
    /// Upper corner (Hz), lowered to 0.4 of the sample rate where it lies above.
    pub high_hz: f32,
    /// Energy over the noise floor that is a slip.
    pub threshold: f32,
}

/// Bands, thresholds and times of the detector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct DetectorConfig {
    /// The band of elastic shear and first movement.
    pub shear: BandThreshold,
    /// The band of the texture.
    pub vibration: BandThreshold,
    /// Energy of the vibration band over its floor at which a slip is gross.
    pub gross: f32,
    /// Time constant of the energy (ms).
    pub envelope_ms: f32,
    /// Fraction of the thresholds below which both bands must stay for the slip to end.
    pub release: f32,
    /// How long they must stay there (ms).
    pub release_ms: f32,
}

impl Default for DetectorConfig {
    fn default() -> Self {
        Self {
            shear: BandThreshold { low_hz: 20.0, high_hz: 400.0, threshold: 25.0 },
            vibration: BandThreshold { low_hz: 100.0, high_hz: 800.0, threshold: 12.0 },
            gross: 25.0,
            envelope_ms: 5.0,
            release: 0.25,
            release_ms: 50.0,
        }
    }
}

/// What the detector sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SlipState {
    /// Nothing above the noise.
    #[default]
    Quiet,
    /// Movement without sliding, or before it.
    Incipient,
    /// The object slides.
    Gross,
}

/// Filter bank, floor and thresholds with their memory.
#[derive(Clone, Copy, Debug)]
pub struct SlipDetector {
    bank: PrimedBank,
    envelope: Envelope<BANDS>,
    floor: Floor<BANDS>,
    /// Reciprocal rms of the floor, once it is known.
    scale: Option<[f32; BANDS]>,
    per_threshold: [f32; BANDS],
    gross: f32,
    release: f32,
    release_len: u32,
    quiet_run: u32,
    state: SlipState,
    statistic: f32,
    /// The highest statistic of the last milliseconds, decaying half as fast as the energy does at rest.
    recent_peak: f32,
    peak_decay: f32,
}

/// Below this fraction of its recent peak the statistic is the fading memory of a slip that has stopped.
const FRESH: f32 = 0.5;

impl SlipDetector {
    /// A detector for samples at `rate_hz` that learns its floor, or takes `known` floor energies.
    ///
    /// # Errors
    /// Where a band does not fit the sample rate.
    pub fn new(
        config: &DetectorConfig,
        floor: FloorConfig,
        known: Option<[f32; BANDS]>,
        rate_hz: f32,
    ) -> Result<Self, ConfigError> {
        let bands = [config.shear, config.vibration];
        let floor = known.map_or_else(|| Floor::learn(floor, rate_hz), |e| Floor::known(floor, e));
        Ok(Self {
            bank: PrimedBank::new(config, rate_hz)?,
            envelope: Envelope::new(&[1e-3 * config.envelope_ms; BANDS], rate_hz, [1.0; BANDS]),
            scale: floor.energy().map(reciprocal_rms),
            floor,
            per_threshold: bands.map(|band| 1.0 / band.threshold),
            gross: config.gross,
            release: config.release,
            release_len: samples(config.release_ms, rate_hz),
            quiet_run: 0,
            state: SlipState::Quiet,
            statistic: 0.0,
            recent_peak: 0.0,
            peak_decay: libm::expf(-1.0 / (2e-3 * config.envelope_ms * rate_hz)),
        })
    }

    /// Whether the noise floor is still being learned.
    #[must_use]
    #[inline]
    pub fn is_learning(&self) -> bool {
        self.scale.is_none()
    }

    /// Noise energy of the bands (signal unit squared), once it is known.
    #[must_use]
    pub fn floor(&self) -> Option<[f32; BANDS]> {
        self.floor.energy()
    }

    /// Deviation of the noise in the vibration band (signal unit, rms); 0 while the floor is unknown.
    #[must_use]
    pub fn noise_rms(&self) -> f32 {
        self.floor.energy().map_or(0.0, |energy| libm::sqrtf(energy[VIBRATION]))
    }

    /// Whether the signal is above its threshold now, and not only the mean of the last milliseconds.
    #[must_use]
    pub fn is_fresh(&self) -> bool {
        self.statistic > 1.0 && self.statistic >= FRESH * self.recent_peak
    }

    /// Starts the filters afresh with the next samples; the floor stays.
    pub fn prime(&mut self) {
        self.bank.start();
        self.envelope.prime([1.0; BANDS]);
        self.quiet_run = 0;
        self.state = SlipState::Quiet;
        self.statistic = 0.0;
        self.recent_peak = 0.0;
    }

    /// Takes the next reading (finite). Gives the statistic, 1 and above being a slip, and the slip state;
    /// `None` while the filters start and while the floor is unknown.
    #[inline]
    pub fn step(&mut self, x: f32) -> Option<(f32, SlipState)> {
        let y = self.bank.step(x)?;
        let Some(scale) = self.scale else {
            self.floor.push(&y);
            self.scale = self.floor.energy().map(reciprocal_rms);
            return None;
        };
        let energy = self.envelope.step(&core::array::from_fn(|i| y[i] * scale[i]));
        let statistic = (energy[0] * self.per_threshold[0]).max(energy[1] * self.per_threshold[1]);
        self.statistic = statistic;
        self.recent_peak = statistic.max(self.recent_peak * self.peak_decay);
        self.decide(statistic, energy[VIBRATION] > self.gross);
        Some((statistic, self.state))
    }

    #[inline]
    fn decide(&mut self, statistic: f32, gross: bool) {
        if statistic > 1.0 {
            self.quiet_run = 0;
            if gross {
                self.state = SlipState::Gross;
            } else if self.state == SlipState::Quiet {
                self.state = SlipState::Incipient;
            }
        } else if statistic >= self.release {
            self.quiet_run = 0;
        } else {
            self.quiet_run = self.quiet_run.saturating_add(1);
            if self.quiet_run >= self.release_len {
                self.state = SlipState::Quiet;
            }
        }
    }
}

fn reciprocal_rms(energy: [f32; BANDS]) -> [f32; BANDS] {
    energy.map(|e| 1.0 / libm::sqrtf(e))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{DetectorConfig, SlipDetector, SlipState};
    use crate::floor::FloorConfig;

    /// Uniform noise of deviation 0.1 um, seeded.
    fn noise(seed: u32) -> impl FnMut() -> f32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let unit = f64::from(state) / f64::from(u32::MAX) - 0.5;
            #[expect(clippy::cast_possible_truncation, reason = "test signal")]
            let x = (unit * 3.4641e-7) as f32;
            x
        }
    }

    fn detector(rate_hz: f32) -> SlipDetector {
        SlipDetector::new(&DetectorConfig::default(), FloorConfig::default(), None, rate_hz)
            .unwrap()
    }

    #[test]
    fn rest_is_quiet_and_a_texture_is_gross_slip_within_milliseconds() {
        for rate in [1000_u16, 2200, 10_000, 20_000] {
            let mut detector = detector(f32::from(rate));
            let mut noise = noise(7);
            for _ in 0..20 * u32::from(rate) {
                if let Some((_, state)) = detector.step(1e-3 + noise()) {
                    assert_eq!(state, SlipState::Quiet, "at {rate} Hz");
                }
            }
            assert!(!detector.is_learning());
            let mut found = None;
            for i in 0..rate {
                let phase = core::f32::consts::TAU * 250.0 * f32::from(i) / f32::from(rate);
                let verdict = detector.step(1e-3 + 3e-6 * libm::sinf(phase) + noise());
                if verdict.is_some_and(|(_, state)| state == SlipState::Gross) {
                    found = Some(f32::from(i) / f32::from(rate));
                    break;
                }
            }
            assert!(found.unwrap() < 0.006, "at {rate} Hz: {found:?}");
        }
    }

    #[test]
    fn a_slip_ends_after_the_release_time() {
        let mut detector = detector(1000.0);
        let mut noise = noise(3);
        for _ in 0..1000 {
            detector.step(noise());
        }
        for i in 0..100_u16 {
            detector.step(noise() + if i % 4 < 2 { 3e-6 } else { -3e-6 });
        }
        let mut lasted = 0_u32;
        while detector.step(noise()).is_some_and(|(_, state)| state != SlipState::Quiet) {
            lasted += 1;
        }
        assert!((50..200).contains(&lasted), "{lasted} ms");
    }

    #[test]
    fn an_offset_does_not_look_like_a_step_when_the_filters_start() {
        let mut detector = detector(20_000.0);
        let mut noise = noise(11);
        for _ in 0..20_000 {
            detector.step(noise());
        }
        for start in 0..50_u8 {
            detector.prime();
            let offset = 1e-4 * f32::from(start);
            for _ in 0..2000 {
                let verdict = detector.step(offset + noise());
                assert!(verdict.is_none_or(|(statistic, _)| statistic < 1.0), "start {start}");
            }
        }
    }
}
