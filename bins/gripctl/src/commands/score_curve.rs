//! Scores in; a curve of latency and misses against false alarms out, as JSON or as a chart.

use crate::output;
use grip_eval::score::{Point, Score};
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

/// Writes the curves of `scores`; the ending of the file selects the form.
pub(super) fn write<'a>(
    out: &OutputPath,
    scores: impl Iterator<Item = &'a Score>,
    guard_ms: f64,
) -> anyhow::Result<()> {
    let curve = |score: &Score| (score.detector.name, score.curve());
    let curves: Vec<_> = scores.map(curve).collect();
    if out.file().extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
        let detectors = curves.into_iter().map(|(detector, points)| Curve { detector, points });
        let text =
            serde_json::to_string_pretty(&Curves { guard_ms, detectors: detectors.collect() })?;
        return Ok(out.write(text + "\n")?);
    }
    output::draw(&chart(&curves), out)
}

/// Median latency over the false alarms per hour of labelled rest. A logarithmic axis has no place for no alarm at all: such
/// points stand at half the smallest rate that the rest could show.
fn chart(curves: &[(&str, Vec<Point>)]) -> Chart {
    let x = Axis::log("false alarms per hour of labelled rest");
    let y = Axis::linear("median latency from the onset (ms)");
    let chart = Chart::new("Latency against false alarms", x, y);
    curves.iter().fold(chart, |chart, (name, points)| {
        let place = |point: &Point| {
            let least = 0.5 * 3600.0 / point.rest_s;
            let rate = point.false_per_hour.filter(|_| least.is_finite())?;
            Some((rate.max(least), point.latency_ms.p50?))
        };
        chart.with(Layer::line(*name, points.iter().filter_map(place).collect()))
    })
}
