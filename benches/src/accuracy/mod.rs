//! Ways to compute the same thing in; time and error of each, as table, JSON and chart, out.
//!
//! A [`Panel`] is one question ("tan S for a hundred irregularities") with its [`Row`]s. A new one is a function that
//! returns a panel, named in one of [`GROUPS`].

mod esc;
mod filters;
mod networks;
mod trainers;

use std::{borrow::Cow, path::Path};

use grip_plot::{Axis, Chart, Layer, Mark, PlotError};
use serde::Serialize;

/// Nanoseconds since any fixed moment. Time is an argument: only the program reads a clock.
pub type Clock<'a> = &'a dyn Fn() -> f64;

/// One way to compute it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Time per item (ns), the shortest of many rounds.
    pub ns: f64,
    /// Median error.
    pub median: f64,
    /// Largest error.
    pub max: f64,
    /// Whether no other row is both faster and closer.
    pub pareto: bool,
}

/// One question and the ways to answer it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Panel {
    /// Name of files and fields.
    pub name: &'static str,
    /// What is computed.
    pub title: String,
    /// What the time is that of.
    pub item: &'static str,
    /// What the errors are: title of the axis.
    pub measure: &'static str,
    /// What the error is relative to, and how many there are.
    pub error: String,
    /// The ways.
    pub rows: Vec<Row>,
}

/// A way to compute something: what is timed, and its errors.
pub(crate) struct Candidate<'a> {
    pub(crate) name: Cow<'static, str>,
    pub(crate) errors: Vec<f64>,
    /// Does the work once and gives something that depends on all of it.
    pub(crate) work: Box<dyn FnMut() -> f64 + 'a>,
}

/// Groups of panels.
pub const GROUPS: [&str; 4] = ["esc", "filters", "networks", "trainers"];

/// The panels of a group of [`GROUPS`]. `data` is the folder of real data, without which the panel of building1 is left
/// out and surface2 is drawn from its formula.
#[must_use]
pub fn panels(group: &str, clock: Clock<'_>, data: Option<&Path>) -> Vec<Panel> {
    match group {
        "esc" => esc::panels(clock),
        "filters" => filters::panels(clock),
        "networks" => networks::panels(clock),
        "trainers" => trainers::panels(clock, data),
        _ => Vec::new(),
    }
}

/// Marks the rows that no other one beats in both time and largest error.
fn rank(rows: &mut [Row]) {
    let others = rows.to_vec();
    for row in rows {
        row.pareto = !others.iter().any(|other| {
            other.ns <= row.ns && other.max <= row.max && (other.ns < row.ns || other.max < row.max)
        });
    }
}

impl Panel {
    /// Times the candidates in turns, so that a busy moment strikes all of them, and ranks them. `items` is what one call
    /// of `work` handles.
    pub(crate) fn measure(
        self,
        mut candidates: Vec<Candidate<'_>>,
        items: usize,
        clock: Clock<'_>,
    ) -> Self {
        const ROUNDS: usize = 60;
        let mut shortest = vec![f64::INFINITY; candidates.len()];
        let mut sink = 0.0;
        for _ in 0..ROUNDS {
            for (candidate, shortest) in candidates.iter_mut().zip(&mut shortest) {
                let start = clock();
                sink += (candidate.work)();
                *shortest = shortest.min(clock() - start);
            }
        }
        core::hint::black_box(sink);
        let mut rows: Vec<Row> = candidates
            .into_iter()
            .zip(shortest)
            .map(|(candidate, ns)| {
                let mut errors = candidate.errors;
                errors.sort_by(f64::total_cmp);
                Row {
                    name: candidate.name.into_owned(),
                    ns: ns / items as f64,
                    median: errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN),
                    max: errors.last().copied().unwrap_or(f64::NAN),
                    pareto: false,
                }
            })
            .collect();
        rank(&mut rows);
        Self { rows, ..self }
    }

    /// Time against error, both by decades, the Pareto front joined. An error of zero is drawn at 1e-20.
    ///
    /// # Errors
    /// Where a figure has no place on the axes.
    pub fn chart(&self) -> Result<Chart, PlotError> {
        let shown = |error: f64| error.max(1e-20);
        let mut front: Vec<(f64, f64)> =
            self.rows.iter().filter(|row| row.pareto).map(|row| (row.ns, shown(row.max))).collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        let names = self.rows.iter().map(|row| row.name.clone()).collect();
        let at = |error: fn(&Row) -> f64| {
            self.rows.iter().map(|row| (row.ns, shown(error(row)))).collect::<Vec<_>>()
        };
        let chart = Chart::new(
            self.title.as_str(),
            Axis::log(format!("time per {} (ns)", self.item)),
            Axis::log(self.measure),
        )
        .with(Layer::line("Pareto front", front).drawn_as(Mark::DashedLine))
        .with(Layer::markers("largest error", at(|row| row.max)).labelled(names))
        .with(Layer::markers("median error", at(|row| row.median)).drawn_as(Mark::TrianglesDown));
        chart.svg()?;
        Ok(chart)
    }
}

impl core::fmt::Display for Panel {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        writeln!(f, "{} ({})", self.title, self.error)?;
        writeln!(
            f,
            "{:28} {:>12} {:>10} {:>10}  Pareto",
            "",
            format!("ns/{}", self.item),
            "median",
            "max"
        )?;
        for row in &self.rows {
            let front = if row.pareto { "*" } else { "" };
            writeln!(
                f,
                "{:28} {:12.2} {:10.1e} {:10.1e}  {front}",
                row.name, row.ns, row.median, row.max
            )?;
        }
        Ok(())
    }
}
