//! Grip force controllers by name, each with the hand that follows it.

use super::{
    baseline::{Baseline, Fft, Fixed, ForceLaw, Oracle, Pr2},
    play::Setup,
};
use grip_session::session::SessionError;

slip_core::named! {
    /// Who commands the force.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Law {
        fn name: "Its name on the command line.";
    }
    #[default]
    Own: "gripd.", "gripd";
    Fixed: "The same force for everything.", "fixed";
    Pr2: "The law of the PR2's gripper.", "pr2";
    Fft: "A step of force for every block of vibration.", "fft";
    Oracle:
        "1.3 times the largest force that the hold will need, known exactly, from the first sample of the slip on: a bound, no law.",
        "oracle";
}

impl Law {
    /// The older laws.
    pub const BASELINES: [Self; 4] = [Self::Fixed, Self::Pr2, Self::Fft, Self::Oracle];

    /// The law of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }

    /// The hand that follows an older law; `None` for gripd.
    pub(super) fn baseline(self, setup: &Setup<'_>) -> Result<Option<Baseline>, SessionError> {
        let trial_n = f64::from(setup.config.grip.trial_force_n);
        let rate_hz = f64::from(setup.config.link.sample_rate_hz);
        let law: Box<dyn ForceLaw> = match self {
            Self::Own => return Ok(None),
            Self::Fixed => Box::new(Fixed::new(Fixed::USUAL_N)),
            Self::Pr2 => Box::new(Pr2::new(trial_n, rate_hz)),
            Self::Fft => Box::new(Fft::new(trial_n, rate_hz)),
            Self::Oracle => Box::new(Oracle::new(setup, Oracle::FACTOR)),
        };
        Ok(Some(Baseline::new(setup.config, law)?))
    }
}
