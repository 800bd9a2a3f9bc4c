//! The curves of detectors over their thresholds: misses, latency and false alarms as JSON, found against false alarms (ROC) as a chart.

use super::score::without_slip;
use crate::output;
use grip_eval::score::{Decides, Point, Score};
use grip_plot::{Axis, Chart, Layer, Mark};
use grip_record::outputs::{OutputKind, OutputPath};
use serde::Serialize;

#[derive(Serialize)]
struct Curves<'a> {
    guard_ms: f64,
    detectors: Vec<Curve<'a>>,
}

#[derive(Serialize)]
struct Curve<'a> {
    detector: &'a str,
    points: Vec<Point>,
}

pub(super) const CURVE: OutputKind = OutputKind {
    endings: &["json", "svg", "png"],
    strict: true,
    is_ours: |head| output::is_picture(head) || head.starts_with(b"{\n  \"guard_ms\""),
};

/// Writes the curves of `scores`, as a chart with a detector of one's own as one point; the ending of the file selects the form.
pub(super) fn write<'a>(
    out: &OutputPath,
    scores: impl Iterator<Item = &'a Score>,
    guard_ms: f64,
) -> anyhow::Result<()> {
    let drawn: Vec<_> = scores
        .map(|score| {
            let has_threshold = score.detector.decides != Decides::Own;
            (score, if has_threshold { score.curve() } else { Vec::new() })
        })
        .collect();
    if out.file().extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
        let curves = drawn.into_iter().filter(|(_, points)| !points.is_empty());
        let curve =
            |(score, points): (&'a Score, _)| Curve { detector: score.detector.name, points };
        let text = serde_json::to_string_pretty(&Curves {
            guard_ms,
            detectors: curves.map(curve).collect(),
        })?;
        out.write(text + "\n")?;
    } else {
        output::draw(&chart(&drawn, guard_ms), out)?;
    }
    eprintln!("written: {}", out.file().display());
    Ok(())
}

/// Share of the onsets that are found (%) over the false alarms per minute without slip, of a threshold or of one above it, which may cut one
/// long alarm into several; and a mark where the table has a detector. A logarithmic axis has no place for
/// no alarm at all: such points stand at half the smallest rate that the rest could show. Lines and marks differ, so that two that coincide are
/// both seen.
fn chart(scores: &[(&Score, Vec<Point>)], guard_ms: f64) -> Chart {
    let x = Axis::log(
        "false alarms per minute without slip; where there is none, half of one is drawn",
    );
    let y = Axis::percent("onsets found (%)");
    let title = "Found against false alarms (ROC); marks: as configured";
    let mut chart = Chart::new(title, x, y);
    let place = |alarms: f64, rest_s: f64, found: usize, onsets: usize| {
        let per_min = 60.0 / rest_s;
        let shown = onsets > 0 && per_min.is_finite();
        let percent = 100.0 * found as f64 / onsets as f64;
        shown.then(|| ((alarms * per_min).max(0.5 * per_min), percent))
    };
    let lines = [Mark::Line, Mark::DashedLine].into_iter().cycle();
    let marks = [Mark::Circles, Mark::Triangles, Mark::TrianglesDown].into_iter().cycle();
    for ((score, points), (line, mark)) in scores.iter().zip(lines.zip(marks)) {
        let at = |point: &Point| {
            let found = point.onsets - point.missed - point.inside;
            place(f64::from(point.false_alarms), point.rest_s, found, point.onsets)
        };
        let (total, [rest_s, _, alarms]) = (score.total(guard_ms), without_slip(score));
        let found = total.onsets - total.missed - total.inside;
        let own = place(alarms, rest_s, found, total.onsets).into_iter().collect();
        let own = |name| Layer::line(name, own).drawn_as(mark);
        let name = total.detector;
        chart = if points.is_empty() {
            chart.with(own(name))
        } else {
            let curve = Layer::line(name, rising(points.iter().filter_map(at).collect()));
            chart.with(curve.drawn_as(line)).with(own(""))
        };
    }
    chart
}

/// Points from the lowest threshold to the highest, each with the most false alarms of its own and of all above it.
fn rising(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut most = f64::NEG_INFINITY;
    for (alarms, _) in points.iter_mut().rev() {
        most = most.max(*alarms);
        *alarms = most;
    }
    points
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_line_never_turns_back() {
        let points = vec![(1.2, 100.0), (12.0, 90.0), (0.5, 80.0), (0.6, 20.0), (0.5, 0.0)];
        let drawn = [(12.0, 100.0), (12.0, 90.0), (0.6, 80.0), (0.6, 20.0), (0.5, 0.0)];
        assert_eq!(super::rising(points), drawn);
    }
}
