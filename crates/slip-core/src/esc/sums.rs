//! Every reading at once, or the literal one and a chosen one.

use super::{
    Esc, LiteralSum, Reading, Trial,
    readings::{ArcCotSum, LiftWorkSum, SlopePowerSum, ViscousWorkSum},
};

/// The running sums of all readings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EscSums {
    literal: LiteralSum,
    arc_cot: ArcCotSum,
    slope_power: SlopePowerSum,
    lift_work: LiftWorkSum,
    viscous_work: ViscousWorkSum,
}

impl EscSums {
    /// Adds an irregularity of height `delta_m` (m) and spacing `spacing_m` (m); `false` where it is degenerate and
    /// counted instead.
    pub fn push(&mut self, delta_m: f64, spacing_m: f64) -> bool {
        self.arc_cot.push(delta_m, spacing_m);
        self.slope_power.push(delta_m, spacing_m);
        self.lift_work.push(delta_m, spacing_m);
        self.viscous_work.push(delta_m, spacing_m);
        self.literal.push(delta_m, spacing_m)
    }

    /// One reading; `None` before the first irregularity and where the value is not finite.
    #[must_use]
    pub fn value(&self, reading: Reading, trial: &Trial) -> Option<Esc> {
        match reading {
            Reading::Literal => self.literal.value(trial),
            Reading::ArcCot => self.arc_cot.value(trial),
            Reading::SlopePower => self.slope_power.value(trial),
            Reading::LiftWork => self.lift_work.value(trial),
            Reading::ViscousWork => self.viscous_work.value(trial),
            Reading::None | Reading::Other(_) => None,
        }
    }
}

/// The running sum of a chosen reading beside the literal one, which is always there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EscSum {
    literal: LiteralSum,
    chosen: Chosen,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Chosen {
    #[default]
    Literal,
    ArcCot(ArcCotSum),
    SlopePower(SlopePowerSum),
    LiftWork(LiftWorkSum),
    ViscousWork(ViscousWorkSum),
}

impl EscSum {
    /// Empty sums of the literal reading and of `reading`.
    #[must_use]
    pub fn new(reading: Reading) -> Self {
        let chosen = match reading {
            Reading::Literal | Reading::None | Reading::Other(_) => Chosen::Literal,
            Reading::ArcCot => Chosen::ArcCot(ArcCotSum::default()),
            Reading::SlopePower => Chosen::SlopePower(SlopePowerSum::default()),
            Reading::LiftWork => Chosen::LiftWork(LiftWorkSum::default()),
            Reading::ViscousWork => Chosen::ViscousWork(ViscousWorkSum::default()),
        };
        Self { literal: LiteralSum::default(), chosen }
    }

    /// Adds an irregularity as [`EscSums::push`].
    #[inline]
    pub fn push(&mut self, delta_m: f64, spacing_m: f64) -> bool {
        match &mut self.chosen {
            Chosen::Literal => true,
            Chosen::ArcCot(sum) => sum.push(delta_m, spacing_m),
            Chosen::SlopePower(sum) => sum.push(delta_m, spacing_m),
            Chosen::LiftWork(sum) => sum.push(delta_m, spacing_m),
            Chosen::ViscousWork(sum) => sum.push(delta_m, spacing_m),
        };
        self.literal.push(delta_m, spacing_m)
    }

    /// Irregularities in the sum.
    #[must_use]
    pub fn n(&self) -> u32 {
        self.literal.n()
    }

    /// Irregularities that were left out.
    #[must_use]
    pub fn degenerate(&self) -> u32 {
        self.literal.degenerate()
    }

    /// E_sc as printed.
    #[must_use]
    pub fn literal(&self, trial: &Trial) -> Option<Esc> {
        self.literal.value(trial)
    }

    /// The chosen reading, given the literal one of the same trial.
    #[must_use]
    pub fn chosen(&self, trial: &Trial, literal: Option<Esc>) -> Option<Esc> {
        match &self.chosen {
            Chosen::Literal => literal,
            Chosen::ArcCot(sum) => sum.value(trial),
            Chosen::SlopePower(sum) => sum.value(trial),
            Chosen::LiftWork(sum) => sum.value(trial),
            Chosen::ViscousWork(sum) => sum.value(trial),
        }
    }
}
