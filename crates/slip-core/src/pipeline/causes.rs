//! An alarm in, what is known of its causes other than a slip out.

use super::Pipeline;
use crate::{
    causes::{Cause, Causes},
    fusion::Told,
    methods::Method,
    pressure::Standing,
    sample::Sample,
    units::Micros,
};

/// What is remembered of the grip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Grasp {
    force: Standing,
    stands: bool,
    since: Micros,
}

impl Grasp {
    /// An object is held from `t` on.
    pub(super) fn begin(&mut self, t: Micros) {
        *self = Self { since: t, ..Self::default() };
    }

    /// Takes the measured, or commanded, grip force (N).
    #[inline]
    pub(super) fn step(&mut self, t: Micros, force_n: Option<f32>) {
        self.stands = self.force.step(t, force_n);
    }
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// The measured grip force (N), or the commanded one.
    #[inline]
    pub(super) fn force_known(&self, sample: &Sample) -> Option<f32> {
        sample.normal_force_n.or_else(|| self.grip.map(|grip| grip.command_n()))
    }

    /// What is known of the causes of an alarm at this sample; of the grip only what was known when the slip was `first` noticed.
    #[cold]
    pub(super) fn causes(
        &mut self,
        sample: &Sample,
        told: Option<Told>,
        (first, certified): (bool, bool),
    ) -> Causes {
        let grip = match &mut self.slip {
            Some(slip) if !first => slip.grip_causes,
            slip => {
                let measured = sample.normal_force_n.is_some() || self.grip.is_some();
                let held = sample.t.since(self.grasp.since) >= Standing::WAIT;
                let causes = Causes::default()
                    .with(Cause::GripChange, measured.then_some(self.grasp.stands))
                    .with(Cause::Closing, measured.then_some(held));
                if let Some(slip) = slip {
                    slip.grip_causes = causes;
                }
                causes
            }
        };
        let felt = told.filter(|told| told.method == Method::Stylus);
        let felt = felt.map_or(0.0, |told| told.statistic);
        self.detector.add_causes(grip, felt, certified, sample.motion.is_some())
    }
}
