//! A folder of real data in, or none; the regression sets on which trainers are compared out.

use anyhow::{Context as _, Result};
use std::{fs, path::Path};

use mlp::train::{ColumnSpec, ColumnSpecError, DataSet, Topology};
use ndarray::Array2;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rand_distr::{Distribution as _, Normal, Uniform};

/// A network, rows to train it on, and rows it never sees.
#[derive(Clone, Debug)]
pub struct Parts {
    /// Its name.
    pub name: &'static str,
    /// Where the rows come from.
    pub source: &'static str,
    /// Shape: tanh, then linear.
    pub topology: Topology,
    /// Rows to train on, inputs and targets.
    pub train: [Array2<f64>; 2],
    /// Rows that decide which epoch is kept, if there are any.
    pub validation: Option<[Array2<f64>; 2]>,
    /// Rows for the error.
    pub test: [Array2<f64>; 2],
}

/// The surface of two inputs, 2-10-1: the rows in `data/learning`, or rows drawn from the same formula. Targets are scaled
/// to [-1, 1] over the training rows.
///
/// # Errors
/// Where a file is missing or broken.
pub fn surface2(data: Option<&Path>) -> Result<Parts> {
    let (inputs, targets) = (specs(&["x1", "x2"])?, specs(&["y"])?);
    let read = |part: &str, seed: u64, rows: usize| match data {
        Some(folder) => read(folder, &format!("surface2_{part}.csv"), &inputs, &targets),
        None => {
            let bytes = surface_rows(rows, seed)?;
            Ok(DataSet::from_csv("surface2", bytes.as_bytes(), &inputs, &targets)?)
        }
    };
    let (train, test) = (read("train", 1, 100)?, read("test", 2, 60)?);
    let limits = train.target_scalings();
    // Inputs lie in [-1, 1] already and stay as they are.
    let scaled = |part: &DataSet| part.scaled(&[], &limits);
    Ok(Parts {
        name: "surface2",
        source: if data.is_some() { "rows of GRIP_DATA" } else { "rows drawn from its formula" },
        topology: Topology::regression(2, &[10], 1)?,
        train: scaled(&train),
        validation: None,
        test: scaled(&test),
    })
}

/// The real set building1 of Proben1, 14-16-3, its own partition, values as they are.
///
/// # Errors
/// Where a file is missing or broken.
pub fn building1(data: &Path) -> Result<Parts> {
    let names: Vec<String> = (1..=14).map(|at| format!("x{at}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let (inputs, targets) = (specs(&names)?, specs(&["energy", "hot_water", "cold_water"])?);
    let part = |name: &str| {
        let rows = read(data, &format!("building1_{name}.csv"), &inputs, &targets)?;
        anyhow::Ok([rows.input_values().to_owned(), rows.target_values().to_owned()])
    };
    Ok(Parts {
        name: "building1",
        source: "rows of GRIP_DATA",
        topology: Topology::regression(14, &[16], 3)?,
        train: part("train")?,
        validation: Some(part("valid")?),
        test: part("test")?,
    })
}

fn specs(names: &[&str]) -> Result<Vec<ColumnSpec>, ColumnSpecError> {
    names.iter().map(|name| name.parse()).collect()
}

fn read(data: &Path, name: &str, inputs: &[ColumnSpec], targets: &[ColumnSpec]) -> Result<DataSet> {
    let file = data.join("learning").join(name);
    let bytes = fs::read(&file).with_context(|| file.display().to_string())?;
    Ok(DataSet::from_csv(name, &bytes, inputs, targets)?)
}

/// y = 0.6 sin(pi x1) x2 + 0.4 cos(2.5 x2) + 0.3 x1 + N(0, 0.05), inputs evenly from [-1, 1).
fn surface_rows(rows: usize, seed: u64) -> Result<String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (place, noise) = (Uniform::new(-1.0, 1.0)?, Normal::new(0.0, 0.05)?);
    let mut csv = String::from("x1,x2,y\n");
    for _ in 0..rows {
        let [x, y]: [f64; 2] = [(); 2].map(|()| place.sample(&mut rng));
        let smooth = 0.6 * (core::f64::consts::PI * x).sin() * y + 0.4 * (2.5 * y).cos() + 0.3 * x;
        csv.push_str(&format!("{x},{y},{}\n", smooth + noise.sample(&mut rng)));
    }
    Ok(csv)
}
