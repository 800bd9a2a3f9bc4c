//! Chart of grasps and totals.

use super::text;
use grip_eval::grasp::{GraspResult, Total, Way};
use grip_plot::{Axis, Chart, Layer, Mark};

/// As many scenes have room for their names below the bars.
const MOST_SCENES: usize = 6;

/// Every grasp by its needed force, where there is one way of grasping; else the objects that were lost: a bar for each scene and way, or, with
/// many scenes, a point for each way.
pub(super) fn chart(totals: &[Total], grasps: &[GraspResult], ways: &[Way]) -> Chart {
    match ways {
        [_] => every_grasp(grasps),
        _ if totals.len() > MOST_SCENES * ways.len() => dropped_and_crushed(totals, ways),
        _ => lost(totals, ways),
    }
}

fn every_grasp(grasps: &[GraspResult]) -> Chart {
    let held = grasps.iter().filter(|grasp| grasp.held).count();
    let title = format!("Force over the needed one: {held} of {} objects held", grasps.len());
    let (x, y) = (Axis::log("needed force (N)"), Axis::linear("force over the needed one"));
    let points = |of: &dyn Fn(&GraspResult) -> Option<f64>| {
        let point = |grasp: &GraspResult| Some((grasp.force_needed_n, of(grasp)?));
        grasps.iter().filter_map(point).collect::<Vec<_>>()
    };
    let layers = [
        (
            "largest",
            Mark::Triangles,
            points(&|g| g.held.then_some(g.force_peak_n / g.force_needed_n)),
        ),
        ("at the end", Mark::Circles, points(&|g| g.held.then_some(g.force_ratio))),
        (
            "crushed",
            Mark::Triangles,
            points(&|g| g.crushed.then_some(g.force_peak_n / g.force_needed_n)),
        ),
        (
            "dropped, largest",
            Mark::TrianglesDown,
            points(&|g| (g.dropped && !g.crushed).then_some(g.force_peak_n / g.force_needed_n)),
        ),
    ];
    let chart = Chart::new(title, x, y);
    layers.into_iter().fold(chart, |chart, (name, mark, points)| {
        if points.is_empty() {
            chart
        } else {
            chart.with(Layer::markers(name, points).drawn_as(mark))
        }
    })
}

fn lost(totals: &[Total], ways: &[Way]) -> Chart {
    let (x, y) = (Axis::linear(""), Axis::linear("dropped or crushed (%)"));
    let chart = Chart::new("Objects lost", x, y);
    ways.iter().enumerate().fold(chart, |chart, (at, way)| {
        let name = text::way(way.law.name(), way.sensors.name(), way.stress.name);
        let own = totals.iter().skip(at).step_by(ways.len());
        chart
            .with(Layer::bars(name, own.map(|total| (total.scene.clone(), share(total))).collect()))
    })
}

fn dropped_and_crushed(totals: &[Total], ways: &[Way]) -> Chart {
    let (x, y) = (Axis::linear("dropped (%)"), Axis::linear("crushed (%)"));
    let share = |at: usize, of: fn(&Total) -> usize| {
        let own = || totals.iter().skip(at).step_by(ways.len());
        let (lost, all) = (own().map(of).sum::<usize>(), own().map(|total| total.trials).sum());
        100.0 * lost as f64 / usize::max(all, 1) as f64
    };
    let points = (0..ways.len()).map(|at| (share(at, |t| t.dropped), share(at, |t| t.crushed)));
    let names =
        ways.iter().map(|way| text::way(way.law.name(), way.sensors.name(), way.stress.name));
    let layer = Layer::markers("", points.collect()).labelled(names.collect());
    Chart::new("Objects lost, over all scenes", x, y).with(layer)
}

/// Objects lost (%).
fn share(total: &Total) -> f64 {
    100.0 * total.lost as f64 / total.trials.max(1) as f64
}
