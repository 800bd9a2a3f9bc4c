//! Trials in, the count of enclosures that do not hold the exact value out.

use crate::exact::{
    Exact,
    angle::tan,
    exact,
    pool::{Draw, Known, Width, rounded},
    trial::{Target, Trial},
};
use slip_core::esc::{Esc, LiteralSum, Real, Trial as Conditions, literal::PreciseSum, readings};

slip_msg::named! {
    /// What is checked.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Path {
        fn name: "Its name.";
    }
    SplitF64: "[`LiteralSum<f64>`]", "split f64";
    SplitDouble: "[`PreciseSum<f64>`]", "split double-double";
    SplitF32: "[`LiteralSum<f32>`]", "split f32";
    ArcCot: "[`readings::ArcCotSum`]", "arc_cot";
    Proportional: "[`readings::SlopePowerSum`], [`readings::LiftWorkSum`] and [`readings::ViscousWorkSum`] together.",
        "slope_power, lift_work, viscous_work";
}

impl Path {
    /// The numbers it takes.
    #[must_use]
    pub fn width(self) -> Width {
        if self == Self::SplitF32 { Width::Single } else { Width::Double }
    }

    /// The sum whose poles and zeros its steered trials aim at.
    #[must_use]
    pub fn target(self) -> Target {
        if self == Self::ArcCot { Target::ArcCots } else { Target::Cots }
    }
}

/// Counts of one path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Trials.
    pub trials: u64,
    /// Enclosures that do not hold the exact value.
    pub failures: u64,
    /// Enclosures that hold every number, because a pole is possible or a ratio is hopeless.
    pub open: u64,
    /// No value at all although the trial is finite.
    pub missing: u64,
    /// Largest distance of the value from the exact one over the half width of the enclosure.
    pub tightest: f64,
}

impl Tally {
    fn check<T: Real + Into<f64>>(
        &mut self,
        esc: Option<Esc<T>>,
        exact_value: impl FnOnce() -> Exact,
    ) {
        self.trials += 1;
        let Some(esc) = esc else {
            // A value that the format cannot hold is none, nor one whose sum passes the largest number before it is scaled.
            let largest = exact(T::LARGEST.into() * 1e-8);
            let wanted = exact_value();
            self.missing += u64::from(wanted < largest && -wanted < largest);
            return;
        };
        let (value, lo, hi): (f64, f64, f64) = (esc.value.into(), esc.lo.into(), esc.hi.into());
        if lo == f64::NEG_INFINITY && hi == f64::INFINITY {
            self.open += 1;
            return;
        }
        let wanted = exact_value();
        let above_lo = lo == f64::NEG_INFINITY || exact(lo) <= wanted;
        let below_hi = hi == f64::INFINITY || wanted <= exact(hi);
        if !(above_lo && below_hi && lo <= value && value <= hi) {
            self.failures += 1;
        }
        let off = crate::exact::to_f64(&(exact(value) - wanted)).abs();
        if hi > lo && (hi - lo).is_finite() {
            self.tightest = self.tightest.max(off / (0.5 * (hi - lo)));
        }
    }
}

/// Checks one path on `count` trials from `pool`, steered ones or random ones.
#[must_use]
pub fn check(path: Path, pool: &[Known], count: u64, steered: bool, seed: u64) -> Tally {
    let mut draw = Draw::new(seed);
    let mut tally = Tally::default();
    for _ in 0..count {
        let n = length(&mut draw);
        let trial = Trial::random(pool, n, &mut draw);
        let trial =
            if steered { trial.steered(path.target(), &mut draw, path.width()) } else { trial };
        let (force, speed) = (draw.log(1e-3, 1e3), draw.sign() * draw.log(1e-4, 10.0));
        let (force, speed) = rounded((force, speed), path.width());
        one(path, &trial, force, speed, &mut tally);
    }
    tally
}

/// How many irregularities: mostly few, sometimes a thousand.
fn length(draw: &mut Draw) -> usize {
    let most = if draw.below(100) == 0 { 1000.0 } else { 40.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1000")]
    let n = draw.log(1.0, most) as usize;
    n
}

/// Checks one trial on one path.
pub fn one(path: Path, trial: &Trial, force: f64, speed: f64, tally: &mut Tally) {
    let conditions = Conditions::new(force, speed);
    let scale = exact(trial.lengths.len() as f64) * exact(force) * exact(speed);
    let literal = || &scale * tan(&trial.cots);
    match path {
        Path::SplitF64 => {
            let mut sum = LiteralSum::<f64>::default();
            trial.lengths.iter().for_each(|(delta, spacing)| _ = sum.push(*delta, *spacing));
            tally.check(sum.value(&conditions), literal);
        }
        Path::SplitDouble => {
            let mut sum = PreciseSum::<f64>::default();
            trial.lengths.iter().for_each(|(delta, spacing)| _ = sum.push(*delta, *spacing));
            tally.check(sum.value(&conditions), literal);
        }
        Path::SplitF32 => {
            let mut sum = LiteralSum::<f32>::default();
            #[expect(clippy::cast_possible_truncation, reason = "f32 numbers")]
            let narrow = |value: f64| value as f32;
            trial
                .lengths
                .iter()
                .for_each(|(delta, spacing)| _ = sum.push(narrow(*delta), narrow(*spacing)));
            tally.check(sum.value(&Conditions::new(narrow(force), narrow(speed))), literal);
        }
        Path::ArcCot => {
            let mut sum = readings::ArcCotSum::default();
            trial.lengths.iter().for_each(|(delta, spacing)| _ = sum.push(*delta, *spacing));
            tally.check(sum.value(&conditions), || &scale * tan(&trial.arc_cots));
        }
        Path::Proportional => proportional(trial, &conditions, tally),
    }
}

fn proportional(trial: &Trial, conditions: &Conditions, tally: &mut Tally) {
    let (force, speed) = (exact(conditions.force_n), exact(conditions.speed_m_s));
    let mut slope = readings::SlopePowerSum::default();
    let mut lift = readings::LiftWorkSum::default();
    let mut viscous = readings::ViscousWorkSum::default();
    let [mut slopes, mut heights, mut squares] = [exact(0.0), exact(0.0), exact(0.0)];
    for (delta, spacing) in &trial.lengths {
        slope.push(*delta, *spacing);
        lift.push(*delta, *spacing);
        viscous.push(*delta, *spacing);
        let r = crate::exact::ratio(*delta, *spacing);
        slopes += exact(2.0) * &r;
        heights += exact(*delta);
        squares += exact(*delta) * r;
    }
    tally.check(slope.value(conditions), || &force * &speed * &slopes);
    tally.check(lift.value(conditions), || &force * &heights);
    let pi = Exact::pi(crate::exact::BITS);
    let damper = exact(conditions.damping_n_s_m);
    tally.check(viscous.value(conditions), || &pi * &pi / exact(2.0) * damper * &speed * &squares);
}
