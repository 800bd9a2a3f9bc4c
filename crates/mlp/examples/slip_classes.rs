//! Recordings of a tactile array in, how well a network recognises the kind of slip of an object that it never touched out.
//!
//! `GRIP_DATA=DIR cargo run --release -p mlp --example slip_classes`, DIR as in CONTRIBUTING.md. Its `taxels_dos` has 24
//! electrodes at 100 Hz, seven objects, and in each recording a touch or a slip in one of six directions. Each object in turn is
//! left out: no recording of it trains anything.
#![expect(clippy::print_stdout, clippy::disallowed_methods, reason = "a measurement that prints")]

use core::{error::Error, hint::black_box};
use std::{env, fs, path::Path, time::Instant};

use mlp::train::{
    Classes, ColumnSpec, DataSet, FitConfig, LargeModel, Method, Precision, RunConfig, fit,
    metrics::softmax, predict,
};
use ndarray::{Array1, Array2, ArrayView2, Axis, Slice, concatenate};

/// Half a second: long beside the vibration of a slip, short beside a recording (2.8 s).
const FRAMES: usize = 50;
/// Frames between two windows.
const STEP: usize = 5;
/// Training goes on for few epochs, since other objects differ from those of the training; so does the penalty on weights.
const EPOCHS: usize = 60;
const DECAY: f64 = 0.01;
const HIDDEN: usize = 16;
/// Trainings from other starting weights.
const STARTS: u64 = 5;
/// Noise of an electrode and more (counts): a pattern below it is none.
const FAINT: f64 = 10.0;

type Fallible<T> = Result<T, Box<dyn Error>>;

struct Touch {
    object: String,
    class: String,
    /// Windows x features.
    windows: Array2<f64>,
}

fn main() -> Fallible<()> {
    let folder = env::var_os("GRIP_DATA").ok_or("GRIP_DATA names no folder of recordings")?;
    let touches = read(&Path::new(&folder).join("taxels_dos"))?;
    let mut objects: Vec<&str> = touches.iter().map(|touch| touch.object.as_str()).collect();
    objects.sort_unstable();
    objects.dedup();
    let mut shares = [Vec::new(), Vec::new()];
    let mut model = None;
    for seed in 0..STARTS {
        let (mut right, mut all) = ([0.0; 2], [0.0; 2]);
        for object in &objects {
            let (others, own): (Vec<&Touch>, Vec<&Touch>) =
                touches.iter().partition(|touch| touch.object != *object);
            let trained = train(&others, seed)?;
            let found = judged(&trained, &own)?;
            println!(
                "start {seed}, {object}: {:.1} % of windows, {} of {} touches",
                100.0 * found[0] / found[1],
                found[2],
                found[3]
            );
            for at in 0..2 {
                right[at] += found[2 * at];
                all[at] += found[2 * at + 1];
            }
            model = Some(trained.0);
        }
        for at in 0..2 {
            shares[at].push(100.0 * right[at] / all[at]);
        }
    }
    for (what, shares) in ["windows of 0.5 s", "touches"].iter().zip(&shares) {
        let shares = Array1::from(shares.clone());
        println!(
            "{what}: {:.1} +- {:.1} % right, {STARTS} starts",
            shares.mean().unwrap_or(0.0),
            shares.std(1.0)
        );
    }
    if let Some(model) = &model {
        println!("one window of features: {:.2} us", time_us(model, &touches)?);
    }
    Ok(())
}

/// The model, and its classes in order.
fn train(touches: &[&Touch], seed: u64) -> Fallible<(LargeModel, Vec<String>)> {
    let views: Vec<ArrayView2<'_, f64>> =
        touches.iter().map(|touch| touch.windows.view()).collect();
    let values = concatenate(Axis(0), &views)?;
    let texts = touches.iter().flat_map(|touch| vec![touch.class.clone(); touch.windows.nrows()]);
    let texts: Vec<String> = texts.collect();
    let inputs: Vec<ColumnSpec> =
        (0..values.ncols()).map(|at| format!("x{at}").parse()).collect::<Result<_, _>>()?;
    let classes = Classes { column: "slip".to_owned(), names: Vec::new() };
    let rows = DataSet::from_classes("windows", &inputs, values, &classes, &texts)?;
    let config = FitConfig {
        hidden: vec![HIDDEN],
        run: RunConfig { epochs: EPOCHS, ..RunConfig::default() },
        precision: Precision::Single,
        scaler: Method::ZScore,
        decay: DECAY,
        seed,
        ..FitConfig::default()
    };
    let names = rows.targets.iter().map(|class| class.name.clone()).collect();
    Ok((fit(&rows, None, None, &config)?.model, names))
}

/// Windows right and in all, touches right and in all. A touch is of the class whose probability is largest over its windows.
fn judged(net: &(LargeModel, Vec<String>), touches: &[&Touch]) -> Fallible<[f64; 4]> {
    let (model, names) = net;
    let mut counts = [0.0; 4];
    for touch in touches {
        let mut sum = vec![0.0; names.len()];
        let is_right = |scores: &[f64]| {
            let best = scores.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
            f64::from(u8::from(best.is_some_and(|(at, _)| names[at] == touch.class)))
        };
        for row in predict(model, &touch.windows)?.0.rows() {
            let mut scores: Vec<f64> = row.to_vec();
            counts[0] += is_right(&scores);
            counts[1] += 1.0;
            softmax(&mut scores);
            // One window that is sure of the wrong class does not overrule all others.
            sum.iter_mut().zip(&scores).for_each(|(sum, p)| *sum += p.max(1e-3).ln());
        }
        counts[2] += is_right(&sum);
        counts[3] += 1.0;
    }
    Ok(counts)
}

/// Time of a forward pass with its scaling.
fn time_us(model: &LargeModel, touches: &[Touch]) -> Fallible<f64> {
    let mut best = f64::INFINITY;
    let mut out = vec![0.0; model.targets().len()];
    for touch in touches {
        let rows = touch.windows.mapv(mlp::train::file::rounded);
        let rows: Vec<Vec<f32>> = rows.rows().into_iter().map(|row| row.to_vec()).collect();
        let start = Instant::now();
        for row in &rows {
            model.predict(black_box(row), &mut out)?;
            black_box(&out);
        }
        best = best.min(1e6 * start.elapsed().as_secs_f64() / rows.len() as f64);
    }
    Ok(best)
}

fn read(folder: &Path) -> Fallible<Vec<Touch>> {
    let labels = folder.join("labels.csv");
    let text =
        fs::read_to_string(&labels).map_err(|error| format!("{}: {error}", labels.display()))?;
    let touch = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [name, _, material, ..] = cells[..] else { return Err(line.into()) };
        let (class, object) = material.split_once('_').ok_or(line)?;
        // One recording of the striped object is spelled otherwise.
        let object = if object == "strippes" { "striped" } else { object };
        let frames = frames(&fs::read_to_string(folder.join(format!("{name}.csv")))?)?;
        let windows = windows(&frames)?;
        Ok(Touch { object: object.to_owned(), class: class.to_owned(), windows })
    };
    text.lines().skip(1).map(touch).collect()
}

/// Frames x electrodes.
fn frames(csv: &str) -> Fallible<Array2<f64>> {
    let mut lines = csv.lines();
    let electrodes = lines.next().map_or(0, |head| head.split(',').count().saturating_sub(1));
    let cells = lines.flat_map(|line| line.split(',').skip(1)).map(str::parse);
    let cells: Vec<f64> = cells.collect::<Result<_, _>>()?;
    Ok(Array2::from_shape_vec((cells.len() / electrodes.max(1), electrodes), cells)?)
}

/// Of each window the pattern on the array, and the pattern of its fluctuations, both without their size: that hangs on how hard
/// the object is pressed.
fn windows(frames: &Array2<f64>) -> Fallible<Array2<f64>> {
    let mut rows = Vec::new();
    for end in (FRAMES..=frames.nrows()).step_by(STEP) {
        let window = frames.slice_axis(Axis(0), Slice::from(end - FRAMES..end));
        let mean = window.mean_axis(Axis(0)).ok_or("an empty window")?;
        let middle = mean.mean().ok_or("no electrodes")?;
        for pattern in [mean - middle, window.std_axis(Axis(0), 0.0)] {
            let size = pattern.dot(&pattern).sqrt() + FAINT;
            rows.extend(pattern.iter().map(|value| value / size));
        }
    }
    let width = 2 * frames.ncols();
    Ok(Array2::from_shape_vec((rows.len() / width.max(1), width), rows)?)
}
