//! A simulated slip by stylus and travel in; a picture of the needed force (10, 50, 90 %), the command and the force of a finger out.
//!
//! ```sh
//! cargo run --release -p grip-eval --example control_fan -- FILE.svg|png [SEED]
//! ```

use grip_eval::grasp::{Line, Own, Setup, play};
use grip_plot::{Axis, Chart, Layer, Mark};
use grip_session::{config::HostConfig, model::default_estimator, session::Update};
use grip_sim::{Truth, scene};
use slip_core::{SlipReport, units::Micros};
use std::path::PathBuf;

/// Object of the default scene, where no other is asked for.
const SEED: u64 = 3;
/// Shown before and after the slip is noticed (s).
const BEFORE_S: f64 = 0.005;
const AFTER_S: f64 = 0.08;

type Points = Vec<(f64, f64)>;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let mut args = std::env::args().skip(1);
    let file = PathBuf::from(args.next().ok_or("the picture's file is missing")?);
    let seed = args.next().map_or(Ok(SEED), |seed| seed.parse())?;
    let object = scene::open("default")?.reseeded(seed)?;
    let config = HostConfig::default();
    let (mut noticed, mut force, mut command) = (None, Points::new(), Points::new());
    let mut fan = [Points::new(), Points::new(), Points::new()];
    let mut needed = Points::new();
    let mut report = |update: Update<'_>| {
        let Update::Step { sample, step, .. } = update else { return };
        let t_s = sample.t.as_seconds();
        if let Some(SlipReport { first: true, .. }) = step.event {
            noticed.get_or_insert(t_s);
        }
        force.extend(sample.normal_force_n.map(|n| (t_s, f64::from(n))));
        command.extend(step.command.map(|n| (t_s, f64::from(n.0))));
        if let Some(need) = step.need {
            for (line, n) in fan.iter_mut().zip([need.low_n, need.median_n, need.high_n]) {
                line.push((t_s, f64::from(n)));
            }
        }
    };
    let mut watch = |truth: &Truth| needed.push((truth.time_s, truth.needed_now_n));
    let setup = Setup {
        scene: &object,
        config: &config,
        duration: Micros(3_000_000),
        line: Line::default(),
        incident: None,
    };
    let mut own = Own::new(&config, default_estimator()?, &mut report)?.watched(&mut watch);
    play(&setup, &mut own)?;
    let noticed_s = noticed.ok_or("nothing slipped")?;
    let shown = |points: Points| {
        let from_slip = points.into_iter().map(|(t_s, n)| (t_s - noticed_s, n));
        let near = from_slip.filter(|(t_s, _)| (-BEFORE_S..AFTER_S).contains(t_s));
        near.map(|(t_s, n)| (1e3 * t_s, n)).collect()
    };
    let [low, median, high] = fan.map(shown);
    let chart = Chart::new(
        "A slip in the lift: needed force while it is answered",
        Axis::linear("since the slip was noticed (ms)"),
        Axis::log("normal force of a finger (N)"),
    )
    .with(Layer::line("command", shown(command)))
    .with(Layer::line("measured force", shown(force)))
    .with(Layer::line("needed, median", median))
    .with(Layer::line("needed, 10 %", low).drawn_as(Mark::DashedLine))
    .with(Layer::line("needed, 90 %", high).drawn_as(Mark::DashedLine))
    .with(Layer::line("needed, truth", shown(needed)));
    std::fs::write(&file, chart.bytes(&file)?)?;
    Ok(())
}
