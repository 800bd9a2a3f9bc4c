//! A file of float32 (little-endian, one channel `vibration`) and its rate in; the processor seconds of one pass through the pipeline of
//! `gripctl replay` out, in JSON: over samples that stand in memory, and over rows as the Python package takes them.
//!
//! `cargo run --release --example rust_time -- FILE RATE`

#![expect(clippy::print_stdout, reason = "it is a program")]

use grip_record::{Recording, Rows};
use grip_session::{HostConfig, model, replay, report::EventLog};
use slip_core::Pipeline;
use std::error::Error;

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
    let (samples_s, rows_s) = (of_samples(&recording)?, of_rows(rows()?, &values)?);
    println!("{{\"samples_s\":{samples_s:.4},\"rows_s\":{rows_s:.4}}}");
    Ok(())
}

/// Processor time of this thread so far (s), which other work on the machine changes little.
fn processor_s() -> Result<f64, Box<dyn Error>> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    Ok(text.split(' ').next().unwrap_or_default().parse::<f64>()? / 1e9)
}

fn pipeline(about: &Recording) -> Result<Pipeline<std::sync::Arc<[f32]>>, Box<dyn Error>> {
    let config = replay::pipeline_config(about, &HostConfig::default(), true);
    Ok(Pipeline::new(config, Some(model::default_estimator()?))?)
}

fn of_samples(recording: &Recording) -> Result<f64, Box<dyn Error>> {
    let (mut pipeline, mut log, mut events) = (pipeline(recording)?, EventLog::default(), 0);
    let begin = processor_s()?;
    for sample in &recording.samples {
        let step = pipeline.handle(sample);
        events += log.events(&step).into_iter().flatten().count();
    }
    core::hint::black_box(events);
    Ok(processor_s()? - begin)
}

fn of_rows(mut rows: Rows, values: &[f32]) -> Result<f64, Box<dyn Error>> {
    let (mut pipeline, mut log, mut events) = (pipeline(&rows.about())?, EventLog::default(), 0);
    let begin = processor_s()?;
    for value in values {
        let (sample, frame) = rows.sample(None, core::slice::from_ref(value));
        let step = pipeline.handle_with(sample, frame);
        events += log.events(&step).into_iter().flatten().count();
    }
    core::hint::black_box(events);
    Ok(processor_s()? - begin)
}
