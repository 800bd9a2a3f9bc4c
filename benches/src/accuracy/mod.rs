//! Comparison of ways to compute the same thing: time and error of each, as table, JSON and chart.
//!
//! A [`Panel`] is one question ("tan S for a hundred irregularities") with its [`Row`]s. A new one is a function that
//! returns a panel, named in one of [`GROUPS`].

mod esc;
mod filters;
mod networks;

use std::borrow::Cow;

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
pub const GROUPS: [&str; 3] = ["esc", "filters", "networks"];

/// The panels of a group of [`GROUPS`], each from one `few`-th of its values.
#[must_use]
pub fn panels(group: &str, few: usize, clock: Clock<'_>) -> Vec<Panel> {
    match group {
        "esc" => esc::panels(few, clock),
        "filters" => filters::panels(few, clock),
        "networks" => networks::panels(few, clock),
        _ => Vec::new(),
    }
}

impl Panel {
    /// Times the candidates in turns, so that a busy moment strikes all of them, and marks what no other beats. `items` is what one call
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
        let others = rows.clone();
        for row in &mut rows {
            let beaten = |other: &Row| {
                other.ns <= row.ns
                    && other.max <= row.max
                    && (other.ns < row.ns || other.max < row.max)
            };
            row.pareto = !others.iter().any(beaten);
        }
        Self { rows, ..self }
    }

    /// An SVG of time against error, both by decades, the Pareto front joined. An error of zero is drawn at 1e-20.
    ///
    /// # Errors
    /// Where a figure has no place on the axes.
    pub fn svg(&self) -> Result<String, PlotError> {
        let shown = |error: f64| error.max(1e-20);
        let mut front: Vec<(f64, f64)> =
            self.rows.iter().filter(|row| row.pareto).map(|row| (row.ns, shown(row.max))).collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        let names = self.rows.iter().map(|row| row.name.clone()).collect();
        let at = |error: fn(&Row) -> f64| {
            self.rows.iter().map(|row| (row.ns, shown(error(row)))).collect::<Vec<_>>()
        };
        Chart::new(
            self.title.as_str(),
            Axis::log(format!("time per {} (ns)", self.item)),
            Axis::log(self.measure),
        )
        .with(Layer::line("Pareto front", front).drawn_as(Mark::DashedLine))
        .with(Layer::markers("largest error", at(|row| row.max)).labelled(names))
        .with(Layer::markers("median error", at(|row| row.median)).drawn_as(Mark::TrianglesDown))
        .svg()
    }
}

impl core::fmt::Display for Panel {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        writeln!(f, "{} ({})", self.title, self.error)?;
        let time = format!("ns/{}", self.item);
        writeln!(f, "{:28} {time:>12} {:>10} {:>10}  Pareto", "", "median", "max")?;
        for Row { name, ns, median, max, pareto } in &self.rows {
            let front = if *pareto { "*" } else { "" };
            writeln!(f, "{name:28} {ns:12.2} {median:10.1e} {max:10.1e}  {front}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{GROUPS, Panel, panels};
    use core::cell::Cell;

    /// The largest median and the largest error of rows by the beginning of their panel's name. `split f64` keeps what is stated of it; the
    /// others share no step with the reference, so it is right to that many digits.
    const LIMITS: [(&str, &str, f64, f64); 12] = [
        ("esc_n", "split double-double", 1e-16, 1.2e-16),
        ("esc_n10:", "split f64", 1e-16, 1e-9),
        ("esc_n100:", "split f64", 1e-15, 1e-9),
        ("esc_readings", "arc_cot", 1e-15, 1e-9),
        ("esc_readings", "slope_power", 1e-15, 1e-15),
        ("esc_readings", "lift_work", 1e-15, 1e-15),
        ("esc_readings", "viscous_work", 1e-15, 1e-15),
        ("filter", "state-variable f64", 1e-12, 1e-11),
        ("filter", "state-variable f32", 1e-4, 1e-3),
        ("tanh", "libm f64, rounded", 0.5, 0.501),
        ("tanh", "exact, a loop", 0.5, 0.501),
        ("forward", "Network, f64", 1e-15, 2e-15),
    ];

    #[test]
    fn references_are_right_and_every_candidate_has_its_errors() {
        let ticks = Cell::new(0.0);
        let clock = || ticks.replace(ticks.get() + 1.0);
        let all: Vec<Panel> = GROUPS.iter().flat_map(|group| panels(group, 8, &clock)).collect();
        for panel in &all {
            for row in &panel.rows {
                assert!(row.ns > 0.0 && row.median <= row.max && row.max.is_finite(), "{panel}");
            }
            // All take as long by this clock: the front is what is closest.
            let least = panel.rows.iter().map(|row| row.max).fold(f64::INFINITY, f64::min);
            assert!(panel.rows.iter().all(|row| row.pareto == (row.max == least)), "{panel}");
            assert!(panel.svg().unwrap().contains(&panel.title));
        }
        for (name, row, median, max) in LIMITS {
            let of = |panel: &&Panel| format!("{}:", panel.name).starts_with(name);
            let rows = all.iter().filter(of).flat_map(|panel| &panel.rows);
            let rows: Vec<_> = rows.filter(|kept| kept.name == row).collect();
            assert!(!rows.is_empty(), "{name} {row}");
            for row in rows {
                assert!(row.median <= median && row.max <= max, "{name}: {row:?}");
            }
        }
    }
}
