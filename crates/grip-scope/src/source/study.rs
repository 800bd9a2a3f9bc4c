//! The report of a study (JSON) in; its learning curves and summary out.
//!
//! Read are `gripctl study` (results with nets, each with a learning curve) and nothing else: another JSON file is reported as such.

use super::outlet::Outlet;
use crate::feed::{Feed, SourceStatus, StudyCurve, StudyCurves, StudyPlot};
use serde_json::Value;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest report that is read (bytes): read into memory it takes some ten times as much.
const MOST: u64 = 16 << 20;

/// Reads the report.
pub(super) fn run(file: &Path, outlet: &mut Outlet) {
    outlet.status(SourceStatus::Loading { done: 0.0 });
    let status = match read(file) {
        Ok(study) => {
            outlet.offer(Feed::Study(Box::new(study)));
            SourceStatus::Complete { note: String::new() }
        }
        Err(sentence) => SourceStatus::Failed { sentence },
    };
    outlet.status(status);
}

fn read(file: &Path) -> Result<StudyCurves, String> {
    let name = file.display();
    let mut text = String::new();
    // Not by its length: a pipe has none.
    let read = File::open(file).and_then(|input| input.take(MOST + 1).read_to_string(&mut text));
    read.map_err(|error| {
        format!("{name}: cannot be read ({error}); check the path and its permissions")
    })?;
    if text.len() as u64 > MOST {
        let most_mb = MOST >> 20;
        return Err(format!(
            "{name}: is larger than {most_mb} MiB: no report of a study has so much"
        ));
    }
    let value: Value =
        serde_json::from_str(&text).map_err(|error| format!("{name}: is no JSON: {error}"))?;
    curves(&value).ok_or_else(|| {
        format!("{name}: is no report of a study: `gripctl study --out DIR` writes one")
    })
}

/// The curves of each result; `None` where the file is none of a study.
fn curves(value: &Value) -> Option<StudyCurves> {
    let results = value.get("results")?.as_array()?;
    let title = value.get("title").and_then(Value::as_str).unwrap_or("study").to_owned();
    let plots = results.iter().filter_map(plot).collect();
    let summary = value.get("summary").and_then(Value::as_array);
    let lines = summary.into_iter().flatten().filter_map(Value::as_str);
    Some(StudyCurves { title, plots, notes: lines.map(str::to_owned).collect() })
}

fn plot(result: &Value) -> Option<StudyPlot> {
    let nets = result.get("nets")?.as_array()?;
    let curves: Vec<StudyCurve> = nets.iter().filter_map(curves_of).flatten().collect();
    (!curves.is_empty()).then(|| StudyPlot { title: text(result, "title"), curves })
}

/// Errors over epochs: on the rows that were trained on, and on the others.
fn curves_of(net: &Value) -> Option<[StudyCurve; 2]> {
    let curve = net.get("curve")?;
    let numbers = |key: &str| curve.get(key).and_then(Value::as_array);
    let epochs = numbers("epoch")?;
    let (net, trainer) = (text(net, "net"), text(net, "trainer"));
    // Most nets beside the four published ones have the name of their trainer.
    let name = if trainer.replace('-', "") == net { trainer } else { format!("{net} {trainer}") };
    let of = |key: &str| {
        let pairs = epochs.iter().zip(numbers(key).into_iter().flatten());
        let points = pairs.filter_map(|(x, y)| Some([x.as_f64()?, y.as_f64()?])).collect();
        StudyCurve { name: format!("{name}, {key}"), points }
    };
    Some([of("train"), of("test")])
}

fn text(value: &Value, key: &str) -> String {
    value.get(key).and_then(Value::as_str).unwrap_or_default().to_owned()
}
