//! A file of float32 (little-endian, one channel `vibration`) and its rate in; the seconds of one pass through the pipeline of
//! `gripctl replay` out, in JSON: over samples that stand in memory, and over rows as the Python package takes them.
//!
//! `cargo run --release --example rust_time -- FILE RATE`

#![expect(clippy::print_stdout, clippy::disallowed_methods, reason = "a program that takes time")]

use grip_record::{Recording, Rows};
use grip_session::{HostConfig, model, replay, report::EventLog};
use slip_core::Pipeline;
use std::{error::Error, time::Instant};

const ROUNDS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, file, rate] = arguments.as_slice() else { return Err("FILE RATE".into()) };
    let bytes = std::fs::read(file)?;
    let values: Vec<f32> =
        bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let names = ["vibration".to_owned()];
    let rows = || Rows::new("rows", &names, rate.parse::<f32>().unwrap_or(0.0));
    let mut held = rows()?;
    for value in &values {
        held.keep(None, core::slice::from_ref(value))?;
    }
    let recording = held.finish()?;
    let samples: Vec<f64> =
        (0..ROUNDS).map(|_| of_samples(&recording)).collect::<Result<_, _>>()?;
    let streamed: Vec<f64> =
        (0..ROUNDS).map(|_| of_rows(rows()?, &values)).collect::<Result<_, _>>()?;
    println!("{{\"samples_s\":{:.4},\"rows_s\":{:.4}}}", least(&samples), least(&streamed));
    Ok(())
}

fn least(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

fn pipeline(about: &Recording) -> Result<Pipeline<std::sync::Arc<[f32]>>, Box<dyn Error>> {
    let config = replay::pipeline_config(about, &HostConfig::default(), true);
    Ok(Pipeline::new(config, Some(model::default_estimator()?))?)
}

fn of_samples(recording: &Recording) -> Result<f64, Box<dyn Error>> {
    let (mut pipeline, mut log, mut events) = (pipeline(recording)?, EventLog::default(), 0);
    let begin = Instant::now();
    for sample in &recording.samples {
        let step = pipeline.handle(sample);
        events += log.events(&step).into_iter().flatten().count();
    }
    core::hint::black_box(events);
    Ok(begin.elapsed().as_secs_f64())
}

fn of_rows(mut rows: Rows, values: &[f32]) -> Result<f64, Box<dyn Error>> {
    let (mut pipeline, mut log, mut events) = (pipeline(&rows.about())?, EventLog::default(), 0);
    let begin = Instant::now();
    for value in values {
        let (sample, frame) = rows.sample(None, core::slice::from_ref(value));
        let step = pipeline.handle_with(sample, frame);
        events += log.events(&step).into_iter().flatten().count();
    }
    core::hint::black_box(events);
    Ok(begin.elapsed().as_secs_f64())
}
