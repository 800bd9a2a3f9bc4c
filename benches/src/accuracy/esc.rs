//! E_sc: tan S by seven evaluators, and the other readings, on ratios of machined surfaces.
#![expect(clippy::cast_possible_truncation, reason = "f32 is one of the formats compared")]

use super::{Candidate, Clock, Panel};
use crate::exact::{BITS, Draw, Exact, Lengths, Trial, exact, pool, ratio, relative_error, sum};
use slip_core::esc::{LiteralSum, Trial as Conditions, literal::PreciseSum, readings};

/// The value for force and speed 1, per irregularity where the reading is a tangent.
type Evaluator = (&'static str, fn(&[Lengths]) -> f64, fn(&Trial) -> Exact);

/// The first seven give the literal value; the others are compared among themselves.
const EVALUATORS: [Evaluator; 11] = [
    ("naive f32", naive_f32, literal),
    ("naive f64", naive_f64, literal),
    ("Neumaier f64", neumaier, literal),
    ("pairwise f64", pairwise, literal),
    ("split f32", split_f32, literal),
    ("split f64", split_f64, literal),
    ("split double-double", split_double, literal),
    ("arc_cot", arc_cot, |trial| trial.arc_cots.tan() * count(trial)),
    ("slope_power", slope_power, |trial| exact(2.0) * sum(&trial.lengths, ratio)),
    ("lift_work", lift_work, |trial| sum(&trial.lengths, |lengths| exact(lengths.0))),
    ("viscous_work", viscous_work, |trial| {
        let pi = Exact::pi(BITS);
        let damper = exact(Conditions::<f64>::new(1.0, 1.0).damping_n_s_m);
        &pi * &pi / exact(2.0)
            * damper
            * sum(&trial.lengths, |lengths| exact(lengths.0) * ratio(lengths))
    }),
];

/// One panel for each number of irregularities. All lengths are such that `f32` holds them, so that every evaluator gets
/// the same.
pub(super) fn panels(few: usize, clock: Clock<'_>) -> Vec<Panel> {
    let known = pool(false, true, 20_000 / few, 41);
    [
        ("esc_n1", 1, 4000),
        ("esc_n10", 10, 2000),
        ("esc_n100", 100, 500),
        ("esc_n1000", 1000, 200),
        ("esc_readings", 100, 500),
    ]
    .into_iter()
    .map(|(name, n, count)| {
        let count = (count / few).max(4);
        let mut draw = Draw::new(42);
        let trials: Vec<Trial> = (0..count).map(|_| Trial::random(&known, n, &mut draw)).collect();
        let timed = trials.get(..(4000 / n).clamp(4, count)).unwrap_or(&trials);
        let (literal, others) = EVALUATORS.split_at(7);
        let evaluators = if name == "esc_readings" { others } else { literal };
        let candidates = evaluators
            .iter()
            .map(|(name, run, wanted)| Candidate {
                name: (*name).into(),
                errors: trials
                    .iter()
                    .map(|t| relative_error(run(&t.lengths), &wanted(t)))
                    .collect(),
                work: Box::new(move || timed.iter().map(|trial| run(&trial.lengths)).sum()),
            })
            .collect();
        Panel {
            name,
            title: format!(
                "E_sc{}, n = {n}: run time against error",
                if name == "esc_readings" { ", other readings" } else { "" }
            ),
            item: "irregularity",
            measure: "relative error",
            error: format!(
                "relative to the value of the same reading, {count} machined surfaces, 67 digits"
            ),
            rows: Vec::new(),
        }
        .measure(candidates, timed.len() * n, clock)
    })
    .collect()
}

fn count(trial: &Trial) -> Exact {
    exact(trial.lengths.len() as f64)
}

fn literal(trial: &Trial) -> Exact {
    trial.cots.tan() * count(trial)
}

fn naive_f32(lengths: &[Lengths]) -> f64 {
    let sum: f32 = lengths.iter().map(|(d, s)| 1.0 / (*d as f32 / *s as f32).tan()).sum();
    f64::from(lengths.len() as f32 * sum.tan())
}

fn term(of: &Lengths) -> f64 {
    1.0 / (of.0 / of.1).tan()
}

fn naive_f64(lengths: &[Lengths]) -> f64 {
    lengths.len() as f64 * lengths.iter().map(term).sum::<f64>().tan()
}

fn neumaier(lengths: &[Lengths]) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for term in lengths.iter().map(term) {
        let total = sum + term;
        lost += if sum.abs() >= term.abs() { (sum - total) + term } else { (term - total) + sum };
        sum = total;
    }
    lengths.len() as f64 * (sum + lost).tan()
}

fn pairwise(lengths: &[Lengths]) -> f64 {
    fn sum(lengths: &[Lengths]) -> f64 {
        let (left, right) = lengths.split_at(lengths.len() / 2);
        if left.is_empty() { right.iter().map(term).sum() } else { sum(left) + sum(right) }
    }
    lengths.len() as f64 * sum(lengths).tan()
}

macro_rules! streaming {
    ($($name:ident $sum:ty),*) => {$(
        fn $name(lengths: &[Lengths]) -> f64 {
            let mut sum = <$sum>::default();
            lengths.iter().for_each(|(delta, spacing)| _ = sum.push(*delta as _, *spacing as _));
            sum.value(&Conditions::new(1.0, 1.0)).map_or(f64::NAN, |esc| esc.value.into())
        }
    )*};
}

streaming!(
    split_f32 LiteralSum<f32>,
    split_f64 LiteralSum<f64>,
    split_double PreciseSum<f64>,
    arc_cot readings::ArcCotSum,
    slope_power readings::SlopePowerSum,
    lift_work readings::LiftWorkSum,
    viscous_work readings::ViscousWorkSum
);
