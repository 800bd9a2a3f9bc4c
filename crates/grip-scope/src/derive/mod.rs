//! Observer of samples at full rate, a detector of the scope's own: band energies, peaks and valleys, E_sc with its
//! enclosure, spectra.
//!
//! The observer runs the pipeline with every stage on and without a controller, at a fixed cost a sample. It has the settings that the
//! recording reports, or the shipped ones.

mod spectrum;

use crate::channel::Channel;
use crate::feed::{DerivedBlock, Turn};

use grip_session::HostEstimator;

use slip_core::detector::BANDS;
use slip_core::esc::Esc;
use slip_core::estimate::Features;
use slip_core::irregularity::{TurnFinder, TurnKind};
use slip_core::velocity::Velocity;
use slip_core::{ConfigError, Pipeline, PipelineConfig, Sample, Step};
use spectrum::Spectra;
use std::sync::Arc;

/// Time from one point of the bands to the next (s): each shows the highest values of it.
const POINT_S: f32 = 4e-3;
/// Time from one look at the bands to the next (s): that of the detector's blocks.
const LOOK_S: f32 = 5e-4;
/// Turns kept of one block; a signal that turns more often shows nothing one by one.
const MOST_TURNS: usize = 20_000;

/// What looks at the samples: spectra at any rate, and a pipeline where the rate is enough for its bands.
pub(crate) struct Observer {
    detail: Option<Detail>,
    spectra: Spectra,
    block: DerivedBlock,
    last_us: Option<u64>,
}

/// A pipeline that only looks.
struct Detail {
    pipeline: Pipeline<Arc<[f32]>>,
    estimator: HostEstimator,
    config: PipelineConfig,
    finder: TurnFinder,
    noise: f32,
    point: Looks,
}

/// The highest of what was seen since the last point.
#[derive(Clone, Copy, Debug)]
struct Looks {
    samples: u32,
    per_look: u32,
    per_point: u32,
    energy: [f32; BANDS],
    evidence_s: f32,
}

impl Observer {
    /// An observer with these settings; those of a controller are left out.
    ///
    /// # Errors
    /// Where a setting does not fit the sample rate.
    pub(crate) fn new(
        config: PipelineConfig,
        estimator: HostEstimator,
    ) -> Result<Self, ConfigError> {
        let detail = Detail::new(config, estimator)?;
        Ok(Self { detail: Some(detail), ..Self::spectra_only(config.sample_rate.0) })
    }

    /// An observer that makes spectra and nothing else, for samples at this rate (Hz).
    pub(crate) fn spectra_only(rate_hz: f32) -> Self {
        let block = DerivedBlock::default();
        Self { detail: None, spectra: Spectra::new(rate_hz), block, last_us: None }
    }

    /// The next samples do not join the last ones.
    pub(crate) fn interrupt(&mut self) {
        self.spectra.restart();
        self.block.broken = true;
        if let Some(detail) = &mut self.detail {
            detail.finder = TurnFinder::new(detail.hysteresis());
        }
    }

    /// Takes a sample and the frame of the array that came with it: what the pipeline reports, where there is one. A sample that is not later
    /// than the one before changes nothing.
    pub(crate) fn push(&mut self, sample: &Sample, taxels: &[f32]) -> Option<Step> {
        if self.last_us.is_some_and(|last_us| sample.t.0 <= last_us) {
            return None;
        }
        self.last_us = Some(sample.t.0);
        let t_s = sample.t.as_seconds();
        self.block.spectra.extend(self.spectra.push(t_s, sample.stylus));
        let detail = self.detail.as_mut()?;
        Some(detail.push(sample, taxels, &mut self.block))
    }

    /// What was derived since the last time.
    pub(crate) fn take(&mut self) -> DerivedBlock {
        let block = core::mem::take(&mut self.block);
        // A break stays one until something is behind it.
        self.block.broken = block.broken && block.values.is_empty();
        block
    }
}

impl Detail {
    fn new(config: PipelineConfig, estimator: HostEstimator) -> Result<Self, ConfigError> {
        let config = PipelineConfig { grip: None, no_skip: true, ..config };
        Ok(Self {
            pipeline: Pipeline::new(config, Some(estimator.clone()))?,
            estimator,
            config,
            finder: TurnFinder::new(config.observation.min_hysteresis_m),
            noise: 0.0,
            point: Looks::new(config.sample_rate.0),
        })
    }

    fn push(&mut self, sample: &Sample, taxels: &[f32], block: &mut DerivedBlock) -> Step {
        let step = self.pipeline.handle_with(sample, taxels);
        let t_s = sample.t.as_seconds();
        self.look(t_s, &step, block);
        if block.turns.len() < MOST_TURNS {
            block.turns.extend(self.turn(t_s, sample.stylus));
        }
        if step.features.is_some() || step.velocity.is_some() {
            block.put(t_s, self.evidence(&step));
        }
        step
    }

    /// The highest of some milliseconds, at their end.
    fn look(&mut self, t_s: f64, step: &Step, block: &mut DerivedBlock) {
        let point = &mut self.point;
        point.samples += 1;
        point.evidence_s = point.evidence_s.max(step.statistic * self.config.detector.interval_s);
        if point.samples.is_multiple_of(point.per_look) {
            let detector = self.pipeline.detector();
            let energy = detector.levels().energy;
            let known = !detector.is_learning();
            for (highest, energy) in point.energy.iter_mut().zip(energy) {
                *highest = if known { highest.max(energy) } else { *highest };
            }
        }
        if point.samples >= point.per_point {
            let energies = Channel::BANDS.into_iter().zip(point.energy);
            block.put(t_s, energies.chain([(Channel::OwnStatistic, point.evidence_s)]));
            *point = point.next();
        }
    }

    /// The peak or valley that a reading confirms.
    fn turn(&mut self, t_s: f64, x: f32) -> Option<Turn> {
        let noise = self.pipeline.detector().noise_rms();
        if noise != self.noise {
            self.noise = noise;
            self.finder = TurnFinder::new(self.hysteresis());
        }
        if noise <= 0.0 || x.abs() >= grip_record::HUGE_READING {
            return None;
        }
        let turn = self.finder.push(t_s, x)?;
        let is_peak = turn.kind == TurnKind::Peak;
        Some(Turn { t_s: turn.position_m, height: turn.height_m, is_peak })
    }

    /// As for the irregularities of a slip.
    fn hysteresis(&self) -> f32 {
        let observation = &self.config.observation;
        let least = match self.config.signal {
            slip_core::Signal::Displacement => observation.min_hysteresis_m,
            slip_core::Signal::Vibration => 0.0,
        };
        (observation.hysteresis_sigmas * self.noise).max(least)
    }

    /// What is known of a slip that goes on: E_sc with its enclosure, the estimate with its margin, slip speed and its deviation.
    fn evidence(&self, step: &Step) -> [(Channel, Option<f32>); 8] {
        let esc = step.features.and_then(|features| features.esc_chosen);
        let [esc, esc_low, esc_high] = esc.map_or([None; 3], |esc| esc_point(&esc).map(Some));
        let estimate = step.features.zip(step.estimate).map(|(features, estimate)| {
            let [low, high] = self.margin(&features, step.velocity, estimate.force_n);
            [estimate.force_n, low, high].map(Some)
        });
        let [estimate, low, high] = estimate.unwrap_or_default();
        [
            (Channel::OwnEsc, esc),
            (Channel::EscLow, esc_low),
            (Channel::EscHigh, esc_high),
            (Channel::OwnEstimate, estimate),
            (Channel::EstimateLow, low),
            (Channel::EstimateHigh, high),
            (Channel::SlipSpeed, step.velocity.map(|velocity| velocity.speed_m_s)),
            (Channel::SlipSpeedSigma, step.velocity.map(|velocity| velocity.sigma_m_s)),
        ]
    }

    /// The estimates where the acceleration is one standard deviation off: that of a difference of two speeds over the stretch.
    fn margin(&self, features: &Features, velocity: Option<Velocity>, force_n: f32) -> [f32; 2] {
        let sigma_m_s = velocity.map_or(f32::NAN, |velocity| velocity.sigma_m_s);
        let sigma_m_s2 = core::f32::consts::SQRT_2 * sigma_m_s / features.contact_time_s;
        let at = |off: f32| {
            let slip_acceleration_m_s2 = features.slip_acceleration_m_s2 + off;
            let moved = Features { slip_acceleration_m_s2, ..*features };
            self.estimator.estimate(&moved).map_or(f32::NAN, |estimate| estimate.force_n)
        };
        let (a, b) = (at(-sigma_m_s2), at(sigma_m_s2));
        [a.min(b).min(force_n), a.max(b).max(force_n)]
    }
}

impl Looks {
    fn new(rate_hz: f32) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let samples = |time_s: f32| ((time_s * rate_hz) as u32).max(1);
        let (per_look, per_point) = (samples(LOOK_S), samples(POINT_S));
        let energy = [f32::NAN; BANDS];
        Self { samples: 0, per_look, per_point, energy, evidence_s: 0.0 }
    }

    const fn next(self) -> Self {
        let energy = [f32::NAN; BANDS];
        Self { samples: 0, energy, evidence_s: 0.0, ..self }
    }
}

/// E_sc and the ends of its enclosure as the scope shows them: with seven digits.
fn esc_point(esc: &Esc) -> [f32; 3] {
    let [value, low, high] = [esc.value, esc.lo, esc.hi].map(crate::num::narrow);
    // Rounding must not put the value outside its own enclosure.
    [value, low.next_down(), high.next_up()]
}

#[cfg(test)]
mod tests;
