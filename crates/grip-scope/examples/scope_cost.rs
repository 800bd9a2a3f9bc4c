//! What the scope costs: `scope_cost load [MB]` writes a recording of so many megabytes into the temporary folder and times how it comes
//! into the model; `scope_cost view` fills an hour of four channels at 20 kHz and times envelopes; `scope_cost export` writes two million samples
//! of nine channels to files and times how long anybody else waits for the model meanwhile.
#![expect(
    clippy::disallowed_methods,
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "this is what is measured, for people at a terminal"
)]

use core::time::Duration;
use grip_record::mcap::{McapWriter, Record, SampleRecord};
use grip_scope::export::{csv, mcap};
use grip_scope::feed::RowBlock;
use grip_scope::{Channel, Feed, Model, SourceHandle, SourceSpec, SourceStatus, Span};
use grip_session::HostConfig;
use grip_session::recording::pipeline_record;
use grip_session::session::Beginning;
use slip_core::{
    Sample, Signal,
    units::{Hertz, Micros},
};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

const MEMORY: usize = 600_000_000;
const RATE_US: u64 = 50;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let megabytes = arguments.get(1).and_then(|text| text.parse().ok()).unwrap_or(1000);
    match arguments.first().map(String::as_str) {
        Some("load") => load(megabytes),
        Some("view") => view(),
        Some("export") => export(),
        _ => println!("scope_cost load [MB] | view | export"),
    }
}

/// Readings as a gripper has them: noise of some digits, force and travel that wander.
struct Readings {
    state: u64,
}

impl Readings {
    fn noise(&mut self) -> f32 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        f32::from((self.state >> 54) as u16) - 511.5
    }

    fn row(&mut self, index: u64) -> [f32; 4] {
        let slow = (index as f64 * 1e-5).sin() as f32;
        let slip = if index % 200_000 < 4000 { 8.0 } else { 1.0 };
        let stylus = 1e-9 * (slip * self.noise()).round();
        let force = 1e-3 * (4000.0 + 500.0 * slow + 0.01 * self.noise()).round();
        let tangential = 1e-3 * (2000.0 + 100.0 * slow + 0.01 * self.noise()).round();
        [stylus, force, tangential, 1e-6 * (1000.0 * slow).round()]
    }
}

fn write(path: &Path, bytes: u64) -> u64 {
    let out = BufWriter::with_capacity(1 << 20, File::create(path).unwrap());
    let mut writer = McapWriter::new(out, "scope_cost", 0).unwrap();
    // With settings of a pipeline the observer runs over all samples, as with a recording of gripd.
    let beginning = Beginning {
        config: HostConfig::default().pipeline(Signal::Displacement, Hertz(20_000.0)),
        carried_n: None,
        least_n: 0.0,
        released: false,
        taxels: 0,
    };
    let mut json = Vec::new();
    let pipeline = pipeline_record(&beginning, &mut json).unwrap();
    writer.write(0, &Record::Pipeline(pipeline)).unwrap();
    let mut readings = Readings { state: 1 };
    let mut index = 0_u64;
    while writer.written().bytes < bytes {
        let [stylus, force, tangential, travel] = readings.row(index);
        let t = Micros(index * RATE_US);
        let sample = Sample {
            normal_force_n: Some(force),
            tangential_n: Some(tangential),
            travel_m: Some(travel),
            ..Sample::stylus(t, stylus)
        };
        let record = SampleRecord { index: index as u32, sample, taxels: &[] };
        writer.write(t.0, &Record::Sample(record)).unwrap();
        index += 1;
        if index.is_multiple_of(5000) {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    index
}

fn load(megabytes: u64) {
    let path = std::env::temp_dir().join(format!("scope-cost-{}.mcap", std::process::id()));
    let samples = write(&path, megabytes * 1_000_000);
    let size = fs::metadata(&path).unwrap().len();
    println!(
        "recording: {:.2} GB, {samples} samples of 4 channels, {:.1} min at 20 kHz",
        size as f64 / 1e9,
        samples as f64 / 20_000.0 / 60.0
    );
    let begun = Instant::now();
    let mut model = Model::new(MEMORY);
    let spec = SourceSpec::Recording(path.clone());
    let mut handle = SourceHandle::spawn(spec, grip_sim::mcu::peer, || {}).unwrap();
    let (mut first, mut all) = (None, None);
    let mut intake = Duration::ZERO;
    let mut parts = Vec::new();
    loop {
        let turn = Instant::now();
        handle.drain(&mut model, 16);
        intake += turn.elapsed();
        let span = model.span();
        if first.is_none() && model.series(Channel::Stylus).is_some() {
            first = Some(begun.elapsed());
        }
        if let (None, Some(series), Some(span)) = (all, model.series(Channel::Stylus), span) {
            series.envelope(span, 200, &mut parts);
            all = (parts.len() >= 190).then(|| begun.elapsed());
        }
        if matches!(model.status(), SourceStatus::Complete { .. } | SourceStatus::Failed { .. }) {
            break;
        }
        thread::sleep(Duration::from_micros(200));
    }
    let done = begun.elapsed();
    let count = model.series(Channel::Stylus).and_then(|s| s.stats(s.span()?)).unwrap().count;
    println!("first curve after {:.3} s", first.unwrap().as_secs_f64());
    println!("every 200th part of all of it shown after {:.3} s", all.unwrap().as_secs_f64());
    println!(
        "loaded after {:.2} s ({:.2} s of it in the model), {count} samples",
        done.as_secs_f64(),
        intake.as_secs_f64()
    );
    println!(
        "history: {:.0} MB, status: {}",
        model.bytes() as f64 / 1e6,
        model.status().sentence()
    );
    resident();
    drop(handle);
    fs::remove_file(&path).unwrap();
}

/// Memory of the whole program, as the system counts it.
fn resident() {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS")).unwrap_or("VmRSS: unknown");
    println!("{}", line.split_whitespace().collect::<Vec<_>>().join(" "));
}

fn view() {
    println!("the program alone:");
    resident();
    let mut model = Model::new(MEMORY);
    let mut readings = Readings { state: 1 };
    let begun = Instant::now();
    let (seconds, rate) = (3600_u64, 20_000_u64);
    for second in 0..seconds {
        let mut block = RowBlock::default();
        let channels =
            [Channel::Stylus, Channel::NormalForce, Channel::TangentialForce, Channel::Travel];
        block.columns = channels.map(|channel| (channel, Vec::new())).to_vec();
        for index in second * rate..(second + 1) * rate {
            block.times_us.push(index * RATE_US);
            for ((_, column), value) in block.columns.iter_mut().zip(readings.row(index)) {
                column.push(value);
            }
        }
        model.take(Feed::Rows(block));
    }
    println!(
        "an hour of 4 channels at 20 kHz: {:.1} MB, taken in {:.1} s",
        model.bytes() as f64 / 1e6,
        begun.elapsed().as_secs_f64()
    );
    resident();
    let series = model.series(Channel::Stylus).unwrap();
    let all = series.span().unwrap();
    let thin_s = series.thin_before_s().unwrap_or(0.0);
    println!("history from {:.0} s, whole samples from {thin_s:.0} s on", all.from_s);
    let mut parts = Vec::new();
    for length_s in [3600.0, 600.0, 50.0, 5.0, 0.5, 0.05] {
        let span = Span::new(all.to_s - length_s, all.to_s);
        let best = (0..200)
            .map(|_| {
                let turn = Instant::now();
                series.envelope(span, 1200, &mut parts);
                turn.elapsed()
            })
            .min();
        let best_us = best.unwrap().as_secs_f64() * 1e6;
        println!("{length_s:7} s in 1200 columns: {best_us:7.1} us, {} parts", parts.len());
    }
    let span = Span::new(all.from_s + 1.0, all.to_s - 1.0);
    let turn = Instant::now();
    let stats = series.stats(span).unwrap();
    println!("figures of {} samples: {:.1} us", stats.count, turn.elapsed().as_secs_f64() * 1e6);
}

/// Writes files of a model that another thread wants every 0.2 ms, as window and pump do.
fn export() {
    let mut model = Model::new(MEMORY);
    for block in 0..2000_u64 {
        let times_us = (0..1000).map(|row| RATE_US * (1000 * block + row)).collect();
        let columns = Channel::ROWS.map(|channel| (channel, vec![1.234e-6; 1000])).to_vec();
        model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
    }
    let begun = Instant::now();
    let bytes = model.clone().bytes();
    println!("a copy of the model ({:.0} MB): {:?}", bytes as f64 / 1e6, begun.elapsed());
    let (span, model) = (model.span().unwrap(), Mutex::new(model));
    for ending in ["csv", "mcap"] {
        let path = std::env::temp_dir().join(format!("scope-cost-{}.{ending}", std::process::id()));
        let look = || model.lock().unwrap();
        let begun = Instant::now();
        let longest = thread::scope(|scope| {
            let work = scope.spawn(|| match ending {
                "csv" => csv(look, span, &Channel::ROWS, &path).unwrap(),
                _ => mcap(look, span, &path).unwrap().samples,
            });
            let mut longest = Duration::ZERO;
            while !work.is_finished() {
                let asked = Instant::now();
                drop(model.lock().unwrap());
                longest = longest.max(asked.elapsed());
                thread::sleep(Duration::from_micros(200));
            }
            longest
        });
        println!("{ending}: {:?}, longest wait for the model {longest:?}", begun.elapsed());
        fs::remove_file(&path).unwrap();
    }
}
