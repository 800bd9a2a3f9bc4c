//! Every trainer in both precisions: time of a whole training against the error on rows it never saw.

use super::{Clock, Panel, Row, rank};
use crate::learning::{Parts, building1, surface2};
use mlp::{
    ShapeError,
    train::{
        Algorithm, NetworkObjective, Objective, Real, RunConfig, Training, init::nguyen_widrow, run,
    },
};
use ndarray::Array2;
use std::path::Path;

/// How each rule trains.
#[derive(Clone, Copy)]
struct Effort {
    starts: u64,
    /// Trainings from the same start; the shortest counts.
    rounds: usize,
    epochs: usize,
    /// Epochs of Levenberg-Marquardt, each of which costs dozens of the others.
    costly: usize,
}

/// One panel for each set there is.
pub(super) fn panels(clock: Clock<'_>, data: Option<&Path>) -> Vec<Panel> {
    let surface = Effort { starts: 20, rounds: 3, epochs: 1000, costly: 100 };
    let building = Effort { starts: 5, rounds: 1, epochs: 2000, costly: 40 };
    let mut panels = Vec::new();
    panels.extend(surface2(data).ok().map(|parts| panel(&parts, surface, clock)));
    let real = data.and_then(|folder| building1(folder).ok());
    panels.extend(real.map(|parts| panel(&parts, building, clock)));
    panels
}

fn panel(parts: &Parts, effort: Effort, clock: Clock<'_>) -> Panel {
    let mut rows = Vec::new();
    for algorithm in Algorithm::all() {
        rows.extend(row::<f32>(parts, algorithm, effort, clock));
        rows.extend(row::<f64>(parts, algorithm, effort, clock));
    }
    let sizes: Vec<String> = parts.topology.sizes().iter().map(ToString::to_string).collect();
    let kept = if parts.validation.is_some() { "the best validation" } else { "the end" };
    let (name, title) = match parts.name {
        "building1" => ("trainers_building1", "Trainers on building1"),
        _ => ("trainers_surface2", "Trainers on surface2"),
    };
    rank(&mut rows);
    Panel {
        name,
        title: format!("{title}, {}: time of a training against error", sizes.join("-")),
        item: "training",
        measure: "mean squared error on the test rows",
        error: format!(
            "test rows at {kept}, {} starts, at most {} epochs (lm {}), {}",
            effort.starts, effort.epochs, effort.costly, parts.source
        ),
        rows,
    }
}

/// None where the rows do not fit the network, which they do.
fn row<T: Real>(
    parts: &Parts,
    algorithm: Algorithm,
    effort: Effort,
    clock: Clock<'_>,
) -> Option<Row> {
    let trained: Vec<(f64, f64)> = (0..effort.starts)
        .map(|seed| start::<T>(parts, algorithm, effort, seed, clock))
        .collect::<Result<_, _>>()
        .ok()?;
    let mut errors: Vec<f64> = trained.iter().map(|(_, error)| *error).collect();
    errors.sort_by(f64::total_cmp);
    Some(Row {
        name: format!("{} {}", algorithm.name(), T::NAME),
        ns: trained.iter().map(|(ns, _)| ns).sum::<f64>() / trained.len() as f64,
        median: errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN),
        max: errors.last().copied().unwrap_or(f64::NAN),
        pareto: false,
    })
}

/// Time of a training (ns) and its error.
fn start<T: Real>(
    parts: &Parts,
    algorithm: Algorithm,
    effort: Effort,
    seed: u64,
    clock: Clock<'_>,
) -> Result<(f64, f64), ShapeError> {
    let objective = |[inputs, targets]: &[Array2<f64>; 2]| {
        NetworkObjective::<T>::new(&parts.topology, inputs, targets)
    };
    let (mut rows, mut test) = (objective(&parts.train)?, objective(&parts.test)?);
    let mut validation = parts.validation.as_ref().map(objective).transpose()?;
    let weights: Vec<T> = nguyen_widrow(&parts.topology, seed).into_iter().map(T::of).collect();
    let epochs = if algorithm.name() == "lm" { effort.costly } else { effort.epochs };
    let config = RunConfig { epochs, max_fail: epochs / 4, ..RunConfig::default() };
    let (mut least, mut error) = (f64::INFINITY, f64::NAN);
    for _ in 0..effort.rounds {
        let mut trainer = algorithm.trainer(weights.len());
        let validation = validation.as_mut().map(|rows| rows as &mut dyn Objective<T>);
        let training = Training { validation, ..Training::new(trainer.as_mut(), &mut rows) };
        let begin = clock();
        let outcome = run(training, weights.clone(), &config);
        least = least.min(clock() - begin);
        let best: Vec<T> = outcome.weights.iter().map(|&weight| T::of(weight)).collect();
        error = test.mse(&best);
    }
    Ok((least, error))
}
