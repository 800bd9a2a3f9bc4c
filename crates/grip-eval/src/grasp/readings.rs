//! Features, estimate and needed force of each slip of a scene: rows that networks are trained and judged on.
//!
//! Unlike the rows of `grip_sim::generator` these come from sensors with noise, through drive and line, and no formula has made them.

use super::{Bench, GraspError, GraspResult, Own, Setup, Way, play};
use crate::grasp::trial::TrialError;
use core::cell::Cell;
use grip_session::session::Update;
use grip_sim::Scene;
use slip_core::estimate::{Feature, Features, ForceEstimate, KAPPA};

/// One set of features while the object slips.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// What was measured.
    pub features: Features,
    /// What the model makes of it.
    pub estimate: Option<ForceEstimate>,
    /// Force of one finger that is needed at this moment (N).
    pub needed_n: f64,
}

impl Reading {
    /// The target of a training (N), with the margin of all estimates.
    #[must_use]
    pub fn adequate_n(&self) -> f64 {
        f64::from(KAPPA) * self.needed_n
    }

    /// Names of the columns of [`Reading::csv`] after scene and seed.
    #[must_use]
    pub fn columns() -> Vec<&'static str> {
        let model = ["estimate_n", "estimate_sigma_n", "estimate_lo_n", "estimate_hi_n"];
        let last = model.into_iter().chain(["needed_force_n", "adequate_force_n"]);
        Feature::ALL.map(Feature::name).into_iter().chain(last).collect()
    }

    /// A line of CSV without its end; what was not measured or estimated is empty.
    #[must_use]
    pub fn csv(&self) -> String {
        let text = |value: Option<f32>| value.map_or_else(String::new, |value| value.to_string());
        let mut cells = Feature::ALL.map(|feature| text(feature.value(&self.features))).to_vec();
        cells.push(text(self.estimate.map(|estimate| estimate.force_n)));
        cells.push(text(self.estimate.map(|estimate| estimate.sigma_n)));
        let limits_n = self.estimate.and_then(|estimate| estimate.limits_n);
        cells.extend([0, 1].map(|at| text(limits_n.map(|limits_n| limits_n[at]))));
        cells.extend([self.needed_n, self.adequate_n()].map(|force_n| force_n.to_string()));
        cells.join(",")
    }
}

impl Bench {
    /// gripd grasps the object that `seed` draws from `scene`; with what it measured of its slips.
    ///
    /// # Errors
    /// As [`Bench::grasp`].
    pub fn read(
        &self,
        scene: &Scene,
        seed: u64,
    ) -> Result<(GraspResult, Vec<Reading>), GraspError> {
        let way = Way::default();
        let scene = way.scene(scene, seed)?;
        let config = way.settings(&scene, &self.config);
        let line = way.line(&scene);
        let setup =
            Setup { scene: &scene, config: &config, duration: self.duration, line, incident: None };
        let needed_n = Cell::new(None);
        let mut watch = |truth: &grip_sim::Truth| {
            needed_n.set(truth.slipping.then_some(truth.needed_now_n));
        };
        let mut readings = Vec::new();
        let mut report = |update: Update<'_>| {
            if let Update::Step { step, .. } = update
                && let (Some(features), Some(needed_n)) = (step.features, needed_n.get())
            {
                readings.push(Reading { features, estimate: step.estimate, needed_n });
            }
        };
        let own = Own::new(&config, self.estimator.clone(), &mut report);
        let outcome = play(&setup, &mut own.map_err(TrialError::from)?.watched(&mut watch))?;
        Ok((self.result(&scene, &way, &outcome), readings))
    }
}
