//! The curves of detectors over their thresholds: misses, latency and false alarms as JSON, found against false alarms (ROC) as a chart.

use super::score::without_slip;
use crate::output;
use grip_eval::score::{Decides, Point, Score};
use grip_plot::{Axis, Chart, Layer};
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
    let (own, scores): (Vec<_>, Vec<_>) =
        scores.partition(|score| score.detector.decides == Decides::Own);
    let curve = |score: &&Score| (score.detector.name, score.curve());
    let curves: Vec<_> = scores.iter().map(curve).collect();
    if out.file().extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
        let detectors = curves.into_iter().map(|(detector, points)| Curve { detector, points });
        let text =
            serde_json::to_string_pretty(&Curves { guard_ms, detectors: detectors.collect() })?;
        out.write(text + "\n")?;
    } else {
        output::draw(&chart(&curves, &own, guard_ms), out)?;
    }
    eprintln!("written: {}", out.file().display());
    Ok(())
}

/// Share of the onsets that are found (%) over the false alarms per minute of labelled rest, with a circle where a detector stands as it is
/// configured. A logarithmic axis has no place for no alarm at all: such points stand at half the smallest rate that the rest could show.
fn chart(curves: &[(&str, Vec<Point>)], own: &[&Score], guard_ms: f64) -> Chart {
    let x = Axis::log("false alarms per minute of labelled rest");
    let y = Axis::linear("onsets found (%)");
    let mut chart = Chart::new("Found against false alarms (ROC)", x, y);
    let place = |alarms: f64, rest_s: f64, found: usize, onsets: usize| {
        let per_min = 60.0 / rest_s;
        let shown = onsets > 0 && per_min.is_finite();
        let percent = 100.0 * found as f64 / onsets as f64;
        shown.then(|| ((alarms * per_min).max(0.5 * per_min), percent))
    };
    for (name, points) in curves {
        let place = |point: &Point| {
            let found = point.onsets - point.missed - point.inside;
            place(f64::from(point.false_alarms), point.rest_s, found, point.onsets)
        };
        chart = chart.with(Layer::line(*name, points.iter().filter_map(place).collect()));
        let set = points.iter().filter(|point| point.threshold == 1.0).filter_map(place).collect();
        chart = chart.with(Layer::markers(format!("{name}, as configured"), set));
    }
    for score in own {
        let (total, [rest_s, _, alarms]) = (score.total(guard_ms), without_slip(score));
        let found = total.onsets - total.missed - total.inside;
        let point = place(alarms, rest_s, found, total.onsets).into_iter().collect();
        chart = chart.with(Layer::markers(total.detector, point));
    }
    chart
}
