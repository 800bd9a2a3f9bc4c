//! The share of answers that the best possible learner would get right under a condition.
//!
//! Two estimates, both honest lower bounds since each answers rows that had no part in making it; the higher one counts:
//!
//! - **closed form**: f = kappa F / (1 - a/g) from the measured force and the acceleration as the features report it (a, or
//!   v/T, or v^2 / 2d with the known travel d). Exact without noise.
//! - **neighbours**, an estimate of Bayes' answer: among many thousand other rows those whose features are nearest, and
//!   the answer that is within 10 % of most of them. It knows the noise and how common which object is. Features are
//!   compared by their ranks. Number of neighbours and subset of the features are those that serve best on one half of
//!   the asked rows; the other half gives the figure.

use crate::{Condition, StudyError, Tolerance, score::SAFETY, sets::draw_seed};
use grip_sim::{GRAVITY_M_S2, Row, generator::Source};
use mlp::train::DataSet;
use ndarray::{Array1, Array2};
use serde::Serialize;
use std::collections::BinaryHeap;

/// Rows that are asked, half to choose and half to count.
const ASKED: usize = 2000;
/// Numbers of neighbours that are tried.
const NEIGHBOURS: [usize; 3] = [15, 60, 240];

/// What the best possible learner reaches within 10 %, 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ceiling {
    /// The higher of both estimates.
    pub within_10pct: f64,
    /// By the closed form, where the features allow it.
    pub closed_form: Option<f64>,
    /// By the neighbours; none where the closed form is right about all rows.
    pub neighbours: Option<f64>,
    /// The features by which these were found.
    pub neighbours_by: String,
}

/// The ceiling of `condition` from `known` rows.
///
/// # Errors
/// As [`Condition::sets`].
pub fn ceiling(condition: &Condition, seed: u64, known: usize) -> Result<Ceiling, StudyError> {
    // Far from the draws, which count up from 0.
    let rows = condition.rows(draw_seed(seed, 1 << 40), ASKED + known)?;
    let (asked, known) = rows.split_at(ASKED);
    let closed_form = closed_form(condition, asked);
    let (neighbours, neighbours_by) = match closed_form {
        Some(1.0) => (None, String::new()),
        _ => by_neighbours(condition, asked, known).map(|(found, by)| (Some(found), by))?,
    };
    let within_10pct = closed_form.unwrap_or(0.0).max(neighbours.unwrap_or(0.0));
    Ok(Ceiling { within_10pct, closed_form, neighbours, neighbours_by })
}

fn share(hits: impl Iterator<Item = bool>) -> f64 {
    let (hit, all) = hits.fold((0, 0), |(hit, all), is| (hit + u32::from(is), all + 1));
    f64::from(hit) / f64::from(all)
}

fn correct(answer: f64, target: f64) -> bool {
    Tolerance::Relative10.correct(answer, target, 0.0)
}

fn closed_form(condition: &Condition, asked: &[Row]) -> Option<f64> {
    let has = |name: &str| {
        condition.features.inputs.iter().any(|spec| spec.split(':').next() == Some(name))
    };
    if !(condition.fixed_force() || has("trial_force_n")) {
        return None;
    }
    let trial = condition.source != Source::Stretch;
    let acceleration: fn(&Row) -> f64 = if has("slip_acceleration_m_s2") {
        |row| row.slip_acceleration_m_s2
    } else if trial && has("slip_speed_m_s") && has("contact_time_s") {
        |row| row.slip_speed_m_s / row.contact_time_s
    } else if trial && has("slip_speed_m_s") {
        |row| row.slip_speed_m_s.powi(2) / (2.0 * row.micro_displacement_m)
    } else {
        return None;
    };
    Some(share(asked.iter().map(|row| {
        // Noise may bring the acceleration to that of free fall.
        let left = (1.0 - acceleration(row) / GRAVITY_M_S2).max(0.01);
        correct(SAFETY * row.trial_force_n / left, row.adequate_force_n)
    })))
}

/// Ranks of features, 0 to 1, and the true forces.
struct Ranked {
    /// Features x rows: a search goes along one feature.
    features: Array2<f64>,
    targets: Array1<f64>,
}

fn by_neighbours(
    condition: &Condition,
    asked: &[Row],
    known: &[Row],
) -> Result<(f64, String), StudyError> {
    let (asked, known) = (condition.data("asked", asked)?, condition.data("known", known)?);
    let width = condition.features.inputs.len();
    let sorted: Vec<Vec<f64>> = known
        .input_values()
        .columns()
        .into_iter()
        .map(|column| {
            let mut values = column.to_vec();
            values.sort_by(f64::total_cmp);
            values
        })
        .collect();
    let ranked = |data: &DataSet| Ranked {
        features: Array2::from_shape_fn((width, data.rows()), |(at, row)| {
            rank(&sorted[at], data.input_values()[[row, at]])
        }),
        targets: data.target_values().column(0).to_owned(),
    };
    let (asked, known) = (ranked(&asked), ranked(&known));
    let mut best = (0.0, 0.0, String::new());
    for subset in 1..(1_usize << width) {
        let chosen: Vec<usize> = (0..width).filter(|at| subset & (1 << at) != 0).collect();
        let hits = hits(&asked, &known, &chosen);
        for hits in hits {
            let (choose, count) = hits.split_at(hits.len() / 2);
            let chance = share(choose.iter().copied());
            if chance > best.0 {
                let names: Vec<&str> =
                    chosen.iter().map(|&at| condition.features.inputs[at]).collect();
                best = (chance, share(count.iter().copied()), names.join(", "));
            }
        }
    }
    Ok((best.1, best.2))
}

/// Share of the sorted values below `value`; equal values share their middle.
fn rank(sorted: &[f64], value: f64) -> f64 {
    let below = sorted.partition_point(|other| *other < value);
    let not_above = sorted.partition_point(|other| *other <= value);
    0.5 * (below + not_above) as f64 / sorted.len() as f64
}

/// For each number of neighbours, which asked rows are answered correctly.
fn hits(asked: &Ranked, known: &Ranked, chosen: &[usize]) -> [Vec<bool>; NEIGHBOURS.len()] {
    let first = known.features.row(chosen[0]);
    let mut order: Vec<usize> = (0..known.targets.len()).collect();
    order.sort_by(|&a, &b| first[a].total_cmp(&first[b]));
    let mut hits: [Vec<bool>; NEIGHBOURS.len()] = Default::default();
    for (row, &target) in asked.targets.iter().enumerate() {
        let place: Vec<f64> = chosen.iter().map(|&at| asked.features[[at, row]]).collect();
        let near = nearest(known, chosen, &order, &place);
        for (hits, count) in hits.iter_mut().zip(NEIGHBOURS) {
            let mut forces: Vec<f64> =
                near.iter().take(count).map(|&row| known.targets[row]).collect();
            hits.push(correct(best_answer(&mut forces), target));
        }
    }
    hits
}

/// The nearest known rows, nearest first. `order` sorts them by the first chosen feature, so the search goes outwards
/// from there and ends where that one alone is too far away.
fn nearest(known: &Ranked, chosen: &[usize], order: &[usize], place: &[f64]) -> Vec<usize> {
    let wanted = NEIGHBOURS[NEIGHBOURS.len() - 1];
    let first = known.features.row(chosen[0]);
    let start = order.partition_point(|&row| first[row] < place[0]);
    let (mut below, mut above) =
        (order[..start].iter().rev().peekable(), order[start..].iter().peekable());
    // Squares of distances as bits: those of numbers that are not negative sort as they do.
    let mut heap: BinaryHeap<(u64, usize)> = BinaryHeap::with_capacity(wanted + 1);
    let gap =
        |row: Option<&&usize>| row.map_or(f64::INFINITY, |row| (first[**row] - place[0]).abs());
    loop {
        let (down, up) = (gap(below.peek()), gap(above.peek()));
        let next = if down < up { below.next() } else { above.next() };
        let (Some(&row), step) = (next, down.min(up)) else { break };
        let full = heap.len() == wanted;
        if full && heap.peek().is_some_and(|(far, _)| step * step > f64::from_bits(*far)) {
            break;
        }
        let square: f64 =
            chosen.iter().zip(place).map(|(&at, x)| (known.features[[at, row]] - x).powi(2)).sum();
        heap.push((square.to_bits(), row));
        if full {
            heap.pop();
        }
    }
    heap.into_sorted_vec().into_iter().map(|(_, row)| row).collect()
}

/// The answer that is within 10 % of most of `forces`.
fn best_answer(forces: &mut [f64]) -> f64 {
    forces.sort_by(f64::total_cmp);
    let mut best = (0, f64::NAN);
    let mut end = 0;
    for (start, low) in forces.iter().enumerate() {
        // An answer within 10 % of both ends exists while 0.9 high <= 1.1 low.
        while end < forces.len() && 0.9 * forces[end] <= 1.1 * low {
            end += 1;
        }
        if end - start > best.0 {
            best = (end - start, 0.5 * (1.1 * low + 0.9 * forces[end - 1]));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::PAPER;

    fn of(name: &str) -> Ceiling {
        ceiling(&Condition::named(name).unwrap(), 1, 20_000).unwrap()
    }

    #[test]
    fn the_best_answer_covers_most() {
        assert!((best_answer(&mut [10.0, 30.0, 10.5, 11.5, 50.0]) - 10.675).abs() < 1e-9);
        let answer = best_answer(&mut [10.0]);
        assert!(correct(answer, 10.0));
    }

    #[test]
    fn neighbours_are_the_nearest() {
        let spread = |(at, i)| (i * [977, 1409][at] % 3001) as f64 / 3001.0;
        let features = Array2::from_shape_fn((2, 3000), spread);
        let known = Ranked { features, targets: Array1::zeros(3000) };
        let mut order: Vec<usize> = (0..3000).collect();
        order.sort_by(|&a, &b| known.features[[0, a]].total_cmp(&known.features[[0, b]]));
        for place in [[0.5, 0.5], [0.0, 1.0], [0.99, 0.2]] {
            let square = |row: usize| {
                (known.features[[0, row]] - place[0]).powi(2)
                    + (known.features[[1, row]] - place[1]).powi(2)
            };
            let mut all: Vec<f64> = (0..3000).map(square).collect();
            all.sort_by(f64::total_cmp);
            let near: Vec<f64> =
                nearest(&known, &[0, 1], &order, &place).into_iter().map(square).collect();
            assert_eq!(near, all[..240]);
        }
    }

    #[test]
    fn force_and_speed_say_all_and_speed_alone_states_little() {
        assert!(of("v-f").within_10pct > 0.999 && of("default").closed_form == Some(1.0));
        let varied = of("varied-v");
        assert!((0.08..0.18).contains(&varied.within_10pct), "{varied:?}");
        assert!(varied.closed_form.is_none());
    }

    #[test]
    fn noise_lowers_the_ceiling_of_a_fixed_force() {
        assert_eq!(of("fixed-0").closed_form, Some(1.0));
        let [three, six] = ["paper", "fixed-6"].map(|name| of(name).within_10pct);
        assert!(three > 0.6 && three < 0.95 && six < three - 0.1, "{three} {six}");
    }

    #[test]
    fn ceilings_do_not_depend_on_more_than_seed_and_condition() {
        assert_eq!(ceiling(&PAPER, 4, 3000).unwrap(), ceiling(&PAPER, 4, 3000).unwrap());
        assert_ne!(ceiling(&PAPER, 4, 3000).unwrap(), ceiling(&PAPER, 5, 3000).unwrap());
    }
}
