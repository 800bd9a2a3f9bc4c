//! Evidence of a slip that goes on in, the force that stops it and the force to hold with afterwards out.

use super::{Evidence, GripConfig, GripInput, SlipNow};

/// Lead of the command over the target, at most: fingers that lose the object measure no force.
const LARGEST_LEAD: f32 = 0.5;
/// Estimates that the force to hold with is a mean of, at most.
const MEAN_OF: f32 = 6.0;
/// Of the force that has stopped a slip this share is kept.
const KEPT: f32 = 0.95;
/// Estimates over which the growth of the load is judged.
const GROWTH_OF: usize = 4;

/// Memory of the slip that goes on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Braking {
    /// Command when the slip began (N).
    base_n: f32,
    /// What the object was held with before the slip (N).
    hold_before_n: f32,
    confirmed: bool,
    /// Mean of the last estimates, with their margin (N).
    mean_n: Option<f32>,
    estimates: f32,
    /// The last estimates, oldest first (N).
    last_n: Option<[f32; GROWTH_OF]>,
    /// What the measured force should become (N); never falls.
    target_n: f32,
}

impl Braking {
    /// A slip that begins under `command_n`, while `hold_n` (N) was to be held.
    pub(super) fn begin(config: &GripConfig, command_n: f32, hold_n: f32) -> Self {
        let target_n = (command_n * (1.0 + config.reflex_step)).min(config.ceiling_n());
        Self { base_n: command_n, hold_before_n: hold_n, target_n, ..Self::default() }
    }

    /// What the measured force should become (N).
    pub(super) fn target_n(&self) -> f32 {
        self.target_n
    }

    /// Whether the object was seen to move, where that is measured.
    pub(super) fn confirmed(&self) -> bool {
        self.confirmed
    }

    /// Takes what is new.
    pub(super) fn hear(
        &mut self,
        config: &GripConfig,
        input: &GripInput,
        command_n: f32,
        dt_s: f32,
    ) {
        self.confirmed |= input.moved_m.is_none_or(|moved| moved >= config.confirm_m);
        if let Some(evidence) = input.evidence.filter(Evidence::is_usable) {
            let with_margin = evidence.with_margin(config);
            let growth_n = self.learn(with_margin);
            if self.confirmed {
                // The estimate is some milliseconds old, and a load that has grown goes on growing.
                let ahead_n = (config.ahead * growth_n).max(0.0).min(LARGEST_LEAD * with_margin);
                self.aim(config, config.brake_gain * (with_margin + ahead_n));
            }
        }
        let blind = self.mean_n.is_none() && input.slip == SlipNow::Evident;
        if blind && self.confirmed && command_n >= self.target_n {
            let tau_ms = match input.moved_m {
                Some(_) => config.measured_tau_ms,
                None => config.reflex_tau_ms,
            };
            let rise_n = self.target_n.max(1.0) * dt_s / (1e-3 * tau_ms);
            self.aim(config, self.target_n + rise_n);
        }
    }

    /// Takes an estimate with its margin; how much the estimates have grown in the time of the last [`GROWTH_OF`] (N).
    fn learn(&mut self, with_margin: f32) -> f32 {
        self.estimates = (self.estimates + 1.0).min(MEAN_OF);
        let mean = self.mean_n.unwrap_or(with_margin);
        self.mean_n = Some(mean + (with_margin - mean) / self.estimates);
        let before = self.last_n.unwrap_or([with_margin; GROWTH_OF]);
        let [_, kept @ ..] = before;
        let mut now = [with_margin; GROWTH_OF];
        for (place, value) in now.iter_mut().zip(kept) {
            *place = value;
        }
        self.last_n = Some(now);
        with_margin - before[0]
    }

    fn aim(&mut self, config: &GripConfig, force_n: f32) {
        self.target_n = self.target_n.max(force_n.min(config.ceiling_n()));
    }

    /// What the command has to be for the measured force to become the target soon (N).
    pub(super) fn command_n(&self, config: &GripConfig, applied_n: Option<f32>) -> f32 {
        let missing_n = applied_n.map_or(0.0, |applied| (self.target_n - applied).max(0.0));
        let lead_n = (config.lead * missing_n).min(LARGEST_LEAD * self.target_n);
        (self.target_n + lead_n).min(config.ceiling_n())
    }

    /// The slip has ended: what is the force to hold with (N)?
    pub(super) fn hold_n(&self, config: &GripConfig) -> f32 {
        // The object slipped at `base_n`, so less than a step above it is not enough.
        let step_n = self.base_n * (1.0 + config.reflex_step);
        let hold_n = match self.mean_n {
            _ if !self.confirmed => self.hold_before_n,
            // What stopped the slip is enough; the estimates may be from before the whole load was there.
            Some(mean_n) => mean_n.max(step_n).max(KEPT * self.target_n),
            None => self.target_n,
        };
        hold_n.min(config.ceiling_n())
    }
}

impl Evidence {
    fn is_usable(&self) -> bool {
        self.estimate_n > 0.0 && self.estimate_n.is_finite()
    }

    /// The estimate with the margin for its uncertainty (N).
    fn with_margin(&self, config: &GripConfig) -> f32 {
        let sigma = self.sigma_n.max(0.0);
        // An estimate that says nothing adds no more than itself.
        self.estimate_n + (config.margin_sigmas * sigma).min(self.estimate_n)
    }
}
