//! Benchmark of the recorder on a simulated grasp: the recording, and the processor time it takes: `recording SCENE SECONDS FILE`.
//!
//! The grasp runs first and is kept; then it is recorded five times, to the file and beside it, and the fastest counts.

use core::error::Error;
use grip_daemon::{
    Item,
    recorder::{About, Recorder, RecordingOptions},
};
use grip_eval::trial;
use grip_record::mcap::Attached;
use grip_session::{HostConfig, Update, model, recording, report::Event, session::Beginning};
use rustix::time::{ClockId, clock_gettime};
use slip_core::PipelineState;
use slip_core::{Sample, Step, units::Micros};
use std::{fs, path::Path};

/// Samples of a frame, after which there is a state.
const FRAME: usize = 10;

enum Kept {
    Began(Box<Beginning>),
    Sample(u32, Sample, Vec<f32>),
    Event(Event),
    State(PipelineState),
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, scene, seconds, file] = args.as_slice() else {
        return Err("usage: recording SCENE SECONDS FILE".into());
    };
    let items = grasp(scene, seconds.parse()?)?;
    let mut best_ns = f64::INFINITY;
    let mut samples = 0;
    for turn in 0..5 {
        let again = format!("{file}.again");
        let file = if turn == 0 { file } else { &again };
        let start = busy_ns();
        samples = record(Path::new(file), &items)?;
        let ns = (busy_ns() - start) as f64 / samples as f64;
        best_ns = best_ns.min(ns);
        if turn > 0 {
            fs::remove_file(file)?;
        }
    }
    let bytes = fs::metadata(file)?.len();
    #[expect(clippy::print_stdout, reason = "the result")]
    {
        println!(
            "{samples} samples, {best_ns:.0} ns each with everything beside them, {:.1} bytes each; {:.2} % of a core at 10 kHz",
            bytes as f64 / samples as f64,
            best_ns * 1e4 / 1e9 * 100.0
        );
    }
    Ok(())
}

/// Processor time of this thread (ns): what waiting for the disk or for other programs costs is not in it.
fn busy_ns() -> i64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

fn grasp(scene: &str, seconds: f64) -> Result<Vec<(u64, Kept)>, Box<dyn Error>> {
    let scene = grip_sim::scene::load(scene)?;
    let (mut items, mut now_us, mut rows) = (Vec::new(), 0, 0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates"
    )]
    let duration = Micros((seconds * 1e6) as u64);
    let mut report = |updates: Update<'_>| match updates {
        Update::Began(beginning) => items.push((now_us, Kept::Began(Box::new(*beginning)))),
        Update::Step { index, sample, taxels, step } => {
            now_us = sample.t.0;
            items.push((now_us, Kept::Sample(index, *sample, taxels.to_vec())));
            rows += 1;
            if rows % FRAME == 0 {
                items.push((now_us, Kept::State(state(step, sample))));
            }
        }
        Update::Event(line) => items.push((now_us, Kept::Event(line))),
        Update::Gripper { .. } | Update::Link(_) => {}
    };
    trial::grasp(
        &scene,
        &HostConfig::default(),
        model::default_estimator()?,
        duration,
        &mut report,
    )?;
    Ok(items)
}

fn state(step: &Step, sample: &Sample) -> PipelineState {
    let state = step.state(None, None, step.estimate);
    PipelineState { applied_n: sample.normal_force_n, rate_hz: 10_000, ..state }
}

fn record(file: &Path, items: &[(u64, Kept)]) -> Result<u64, Box<dyn Error>> {
    let text = |name: &str, media_type: &str, data: &str| Attached {
        name: name.to_owned(),
        media_type: media_type.to_owned(),
        data: data.as_bytes().to_vec(),
    };
    let about = About {
        program: "recording 0.1.0".to_owned(),
        run: "example".to_owned(),
        wall_ns: 1_763_766_000_000_000_000,
        attached: vec![
            text(recording::CONFIG_NAME, "application/toml", "port = \"sim\"\n"),
            text(recording::MODEL_NAME, "application/json", model::default_text()),
        ],
        ..About::default()
    };
    let mut recorder = Recorder::create(file, RecordingOptions::default(), about)?;
    let mut last_us = 0;
    for (host_us, kept) in items {
        let host_us = *host_us;
        let item = match kept {
            Kept::Began(beginning) => Item::Began { host_us, beginning },
            Kept::Sample(index, sample, taxels) => {
                Item::Sample { host_us, index: *index, sample, taxels }
            }
            Kept::Event(event) => Item::Event { host_us, event },
            Kept::State(state) => Item::State(state),
        };
        recorder.take(&item, host_us);
        if host_us >= last_us + 50_000 {
            last_us = host_us;
            recorder.tick(host_us);
        }
    }
    Ok(recorder.finish()?.samples)
}
