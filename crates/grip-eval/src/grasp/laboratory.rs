//! Experiment on a scene with an incident, gripd beside an oracle: what the tables of faults and stalls share.

use super::{
    baseline::{Baseline, Oracle},
    hand::{Hand, Own},
    line::Line,
    play::{Incident, Setup, play},
};
use crate::grasp::{GraspError, trial::TrialError};
use grip_session::{
    config::HostConfig,
    model::HostEstimator,
    session::{SessionError, Update},
};
use grip_sim::{Phase, Scene, Truth};
use serde::Serialize;
use slip_core::units::Micros;

/// Forces over the needed one that an oracle may apply.
pub const ORACLE_FACTORS: [f64; 5] = [1.3, 1.1, 1.2, 1.4, 1.5];
/// An object is crushed by more than this over the largest needed force.
pub const CRUSH_RATIO: f64 = 2.5;
/// After a rest of this length the object is held (s).
const REST_S: f64 = 0.3;

/// What became of an object, in few numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fate {
    /// It left the fingers.
    pub dropped: bool,
    /// It was pressed with more than 2.5 times the largest force it needed.
    pub crushed: bool,
    /// Largest force over the largest needed one.
    pub peak_ratio: f64,
    /// Force at the end over the needed one of that time.
    pub final_ratio: f64,
    /// How far it slipped (mm).
    pub slip_mm: f64,
}

impl Fate {
    /// Neither dropped nor crushed.
    #[must_use]
    pub fn whole(&self) -> bool {
        !self.dropped && !self.crushed
    }
}

/// What an oracle makes of an object ([`super::Law::Oracle`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OracleFate {
    /// With 1.3 times the needed force.
    pub usual: Fate,
    /// At least one factor of 1.1, 1.2, 1.3, 1.4 and 1.5 neither drops nor crushes it.
    pub holds: bool,
}

/// One grasp of the laboratory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Experiment<'a> {
    pub(super) scene: &'a Scene,
    pub(super) config: &'a HostConfig,
    pub(super) end: Micros,
    pub(super) incident: Option<Incident>,
}

impl Experiment<'_> {
    fn setup(&self) -> Setup<'_> {
        let Self { scene, config, end, incident } = *self;
        Setup { scene, config, duration: end, line: Line::default(), incident }
    }

    /// gripd holds it.
    pub(super) fn own(&self, estimator: &HostEstimator) -> Result<Fate, GraspError> {
        let mut silent = |_: Update<'_>| ();
        let mut own = Own::new(self.config, estimator.clone(), &mut silent).map_err(session)?;
        self.fate(&mut own)
    }

    /// gripd holds it; with the times that the truth went through.
    pub(super) fn marked(&self, estimator: &HostEstimator) -> Result<(Fate, Marks), GraspError> {
        let mut silent = |_: Update<'_>| ();
        let own = Own::new(self.config, estimator.clone(), &mut silent).map_err(session)?;
        let ramp_s = self.scene.config().lift_ramp_s;
        let mut marks = Marks::default();
        let fate = self.fate(&mut own.watched(&mut |truth| marks.witness(truth, ramp_s)))?;
        Ok((fate, marks))
    }

    /// An oracle holds it.
    pub(super) fn oracle(&self) -> Result<OracleFate, GraspError> {
        let [usual, others @ ..] = ORACLE_FACTORS;
        let usual = self.oracle_with(usual)?;
        let mut holds = usual.whole();
        for factor in others {
            holds = holds || self.oracle_with(factor)?.whole();
        }
        Ok(OracleFate { usual, holds })
    }

    fn oracle_with(&self, factor: f64) -> Result<Fate, GraspError> {
        let law = Box::new(Oracle::new(&self.setup(), factor));
        self.fate(&mut Baseline::new(self.config, law).map_err(session)?)
    }

    fn fate(&self, hand: &mut dyn Hand) -> Result<Fate, GraspError> {
        let truth = play(&self.setup(), hand)?.truth;
        let config = self.scene.config();
        let lift_s = 1e-3 * config.drive.approach_ms + config.lift_at_s;
        let needed_n = self.scene.force_needed_n(self.end.as_seconds() - lift_s);
        let peak_ratio = truth.force_peak_n / needed_n;
        Ok(Fate {
            dropped: truth.dropped(),
            crushed: peak_ratio > CRUSH_RATIO,
            peak_ratio,
            final_ratio: truth.applied_n / truth.needed_now_n,
            slip_mm: truth.slip_mm(),
        })
    }
}

fn session(error: SessionError) -> GraspError {
    GraspError::Trial(TrialError::Session(error))
}

/// Times of the truth (s from the start) in a grasp of gripd; `None` for what did not happen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Marks {
    /// The lift begins.
    pub(super) lift_s: Option<f64>,
    /// The object begins to slip.
    pub(super) slip_s: Option<f64>,
    /// It slips at half the needed force or more.
    pub(super) half_s: Option<f64>,
    /// It slips at the needed force or more.
    pub(super) enough_s: Option<f64>,
    /// It slips faster than 1 mm/s at half the needed force or more.
    pub(super) fast_s: Option<f64>,
    /// The lift is over and nothing has slipped for 0.3 s.
    pub(super) rest_s: Option<f64>,
}

impl Marks {
    fn witness(&mut self, truth: &Truth, ramp_s: f64) {
        if truth.phase != Phase::Lifted {
            return;
        }
        let now_s = truth.time_s;
        let lift_s = *self.lift_s.get_or_insert(now_s);
        let share = truth.applied_n / truth.needed_now_n;
        let slips = truth.slipping;
        let rests_s = now_s - lift_s - truth.stable_after_s.max(ramp_s);
        for (mark, seen) in [
            (&mut self.slip_s, slips || truth.stable_after_s > 0.0),
            (&mut self.half_s, slips && share >= 0.5),
            (&mut self.enough_s, slips && share >= 1.0),
            (&mut self.fast_s, slips && share > 0.5 && truth.speed_m_s > 1e-3),
            (&mut self.rest_s, !slips && rests_s >= REST_S),
        ] {
            if seen && mark.is_none() {
                *mark = Some(now_s);
            }
        }
    }
}

/// A time in seconds as microseconds.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some seconds")]
pub(super) fn micros(time_s: f64) -> Micros {
    Micros((1e6 * time_s).round() as u64)
}

/// Median, 95 % quantile and largest value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Median.
    pub p50: Option<f64>,
    /// 95 % quantile.
    pub p95: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
}

impl Spread {
    /// Of `values`.
    #[must_use]
    pub fn of(values: Vec<f64>) -> Self {
        let max = values.iter().copied().max_by(f64::total_cmp);
        let crate::score::Quantiles { p50, p95 } = crate::score::Quantiles::of(values);
        Self { p50, p95, max }
    }
}

/// How an object slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Its name on the command line.
    pub name: &'static str,
    /// Static over kinetic friction.
    pub ratio: f64,
    /// Stribeck speed (mm/s).
    pub stribeck_mm_s: f64,
    /// Viscous friction of both fingers (N s/m).
    pub viscous_n_s_m: f64,
}

impl Friction {
    /// Dry friction that is the same at every speed.
    pub const COULOMB: Self =
        Self { name: "coulomb", ratio: 1.0, stribeck_mm_s: 5.0, viscous_n_s_m: 0.0 };
    /// Friction that falls as the object begins to slide.
    pub const STRIBECK: Self =
        Self { name: "stribeck", ratio: 1.3, stribeck_mm_s: 10.0, viscous_n_s_m: 0.0 };
    /// The frictions of the table of faults.
    pub const ALL: [Self; 6] = [
        Self::COULOMB,
        Self::STRIBECK,
        Self { name: "viscous10", ratio: 1.1, viscous_n_s_m: 10.0, ..Self::COULOMB },
        Self { name: "viscous60", ratio: 1.1, viscous_n_s_m: 60.0, ..Self::COULOMB },
        Self { name: "viscous150", ratio: 1.1, viscous_n_s_m: 150.0, ..Self::COULOMB },
        Self { name: "static1.6", ratio: 1.6, ..Self::COULOMB },
    ];

    /// The friction of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|friction| friction.name == name)
    }
}
