//! `gripctl demo`: one simulated grasp as curves in the terminal.

use super::{estimator, host_config};
use crate::{cli::DemoArgs, output, terminal};
use core::ops::Range;
use grip_eval::trial::{self, Outcome};
use grip_record::{ChannelSet, CsvWriter, StylusKind, outputs::OutputPath};
use grip_session::{exit::Exit, report::Event, session::Update};
use slip_core::{Phase, Sample, SlipReport, Step, units::Micros};
use std::path::Path;

/// Length of the grasp.
const LENGTH: Micros = Micros(2_000_000);
/// What is drawn of it (s): the fingers have closed, the lift comes.
const SHOWN: Range<f64> = 0.4..2.0;
/// Share of a sample in the running mean of the stylus: 1 ms at 10 kHz.
const MEAN_SHARE: f64 = 0.1;

/// Points of the curves, and what happened.
#[derive(Debug, Default)]
struct Seen {
    /// Less its running mean, which is where the finger stands.
    vibration_um: Vec<(f64, f64)>,
    mean_um: f64,
    /// Logarithm of the statistic to base 10.
    statistic: Vec<(f64, f64)>,
    command_n: Vec<(f64, f64)>,
    moved_mm: Vec<(f64, f64)>,
    slips: Vec<SlipReport>,
    samples: Vec<Sample>,
}

impl Seen {
    fn take(&mut self, sample: &Sample, step: &Step) {
        let t_s = sample.t.as_seconds();
        self.samples.push(*sample);
        let stylus_um = 1e6 * f64::from(sample.stylus);
        self.mean_um += MEAN_SHARE * (stylus_um - self.mean_um);
        if !SHOWN.contains(&t_s) {
            return;
        }
        self.vibration_um.push((t_s, stylus_um - self.mean_um));
        self.statistic.push((t_s, f64::from(step.statistic.max(0.01)).log10()));
        if let Some(command) = step.command {
            self.command_n.push((t_s, f64::from(command.0)));
        }
        if let Some(travel) = sample.travel_m {
            self.moved_mm.push((t_s, 1e3 * f64::from(travel)));
        }
    }
}

pub(crate) fn run(args: &DemoArgs) -> anyhow::Result<Exit> {
    let inputs = [Some(Path::new(&args.scene))];
    let out = output::optional(args.output.as_deref(), output::TABLE, &args.force, &inputs)?;
    let scene = super::scene(&args.scene, args.seed)?;
    let config = host_config(None)?;
    let estimator = estimator(None, &config)?;
    let mut seen = Seen::default();
    let outcome = trial::grasp(&scene, &config, estimator, LENGTH, &mut |update| match update {
        Update::Step { sample, step, .. } => seen.take(sample, step),
        Update::Event(Event::Slip(slip)) => seen.slips.push(slip),
        _ => {}
    })?;
    output::line(&format!(
        "A simulated gripper closes with {} N on an object (scene {}) that needs {:.2} N, and lifts it.\n",
        config.grip.trial_force_n,
        scene.config().name,
        outcome.truth.force_needed_n
    ))?;
    curves(&seen, outcome.truth.force_needed_n)?;
    for slip in &seen.slips {
        output::line(&sentence(slip))?;
    }
    output::line(&end(&outcome))?;
    if let Some(out) = &out {
        write(out, &seen.samples)?;
    }
    next(args)?;
    Ok(Exit::Done)
}

fn curves(seen: &Seen, needed_n: f64) -> anyhow::Result<()> {
    let plot =
        |title, points, rows, level| terminal::Plot { title, points, time: SHOWN, rows, level };
    let plots = [
        plot(
            "vibration of the stylus, um: its tip rides over the surface while the object slips",
            &seen.vibration_um[..],
            4,
            None,
        ),
        plot(
            "slip statistic as a power of ten; dotted: its threshold, 10^0 = 1",
            &seen.statistic,
            4,
            Some(0.0),
        ),
        plot(
            "commanded force, N; dotted: what the object needs",
            &seen.command_n,
            4,
            Some(needed_n),
        ),
        plot(
            "moved distance, mm: first the pads shear, then the object slips",
            &seen.moved_mm,
            3,
            None,
        ),
    ];
    for plot in plots.iter().filter(|plot| !plot.points.is_empty()) {
        plot.lines().iter().try_for_each(|line| output::line(line))?;
    }
    let marks: Vec<f64> = seen.slips.iter().map(|slip| slip.t.as_seconds()).collect();
    for line in terminal::time_axis(&SHOWN, 0.5, &marks) {
        output::line(&line)?;
    }
    Ok(output::line("")?)
}

/// A slip without its details, which `gripctl replay` prints.
fn sentence(slip: &SlipReport) -> String {
    let t_s = slip.t.as_seconds();
    let mut text = match slip.phase {
        Phase::Ended => format!("{t_s:8.4} s  the slip has ended"),
        phase => format!("{t_s:8.4} s  {phase} slip, seen by the {}", slip.method),
    };
    if let Some(speed) = slip.speed_m_s {
        text += &format!(", {:.1} mm/s", 1e3 * speed);
    }
    if let Some(moved) = slip.moved_m {
        text += &format!(", moved {:.2} mm", 1e3 * moved);
    }
    if let Some(estimate) = slip.estimate_n {
        text += &format!(", estimated force {estimate:.2} N");
    }
    if let Some(command) = slip.command_n {
        text += &format!(", command {command:.2} N");
    }
    text
}

fn end(outcome: &Outcome) -> String {
    let fate = match (outcome.held(), outcome.truth.crushed) {
        (true, _) => "held",
        (false, true) => "crushed",
        (false, false) => "dropped",
    };
    format!(
        "\nThe object was {fate}. It slipped {:.2} mm; the force is {:.2} times what it needs.",
        outcome.truth.slip_mm(),
        outcome.force_ratio()
    )
}

/// The recording that gripd would have made.
fn write(out: &OutputPath, samples: &[Sample]) -> anyhow::Result<()> {
    let channels = ChannelSet::all(StylusKind::Displacement);
    let mut writer = CsvWriter::new(out.create()?, &channels)?;
    samples.iter().try_for_each(|sample| writer.write(sample))?;
    Ok(writer.finish()?.finish()?)
}

/// What to type now.
fn next(args: &DemoArgs) -> anyhow::Result<()> {
    let (first, watch) = match &args.output {
        Some(file) => {
            let file = file.display();
            let replay = (format!("gripctl replay {file}"), "its events, with all details");
            (replay, format!("gripmon {file}"))
        }
        None => {
            let again = ("gripctl demo -o demo.csv".to_owned(), "the same, with a recording");
            (again, "gripmon --demo".to_owned())
        }
    };
    let commands = [
        first,
        (watch, "live curves in a window"),
        ("gripd --port sim --duration 10".to_owned(), "the same in real time, by the daemon"),
        ("gripctl replay FILE.csv".to_owned(), "slips in a recording of your own"),
        ("gripctl grasp".to_owned(), "a hundred objects"),
    ];
    output::line("Next:")?;
    for (command, what) in &commands {
        output::line(&format!("  {command:<32} {what}"))?;
    }
    Ok(())
}
