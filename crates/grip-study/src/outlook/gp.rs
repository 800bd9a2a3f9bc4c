//! Gaussian process regression: squared-exponential kernel with a length for each input, and noise, by their evidence.
//!
//! With features x and targets z scaled to [-1, 1], z about its mean m, and the ratio r of noise to signal variance (Rasmussen and
//! Williams 2006, chapters 2 and 5):
//!
//! ```text
//! K_ij = exp(-1/2 sum_d (x_id - x_jd)^2 / l_d^2)      A = K + r I      s^2 = (z - m)' A^-1 (z - m) / n
//! ln evidence = -n/2 ln s^2 - 1/2 ln |A| - n/2 ln 2 pi e
//! answer = m + k' A^-1 (z - m)       its variance, noise included = s^2 (1 + r - k' A^-1 k)
//! ```
//! Lengths and r maximise the evidence under wide normal priors of their logarithms, by L-BFGS from two starts on at most
//! [`TUNED_ROWS`] rows spread over all; then all rows answer.

use mlp::PredictError;
use mlp::train::linear::{forward, inverse_columns, log_determinant, product, solve_shifted};
use mlp::train::trainer::Lbfgs;
use mlp::train::{DataSet, FileError, Objective, RunConfig, Training, run};
use ndarray::ArrayRef1;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use serde::{Deserialize, Serialize};

use super::columns::{self, Columns, raw_deviation};
use super::score::{OutlookError, Predict, Spread};

/// Most training rows: their matrix fills 72 MB.
pub const MAX_ROWS: usize = 3000;

/// Most rows that decide on lengths and noise: each look at their evidence grows with the cube.
pub const TUNED_ROWS: usize = 300;

/// Value of the field `format`.
pub const FORMAT: &str = "gp-model";

/// Added to the noise, so that rows that stand twice leave the matrix definite.
const JITTER: f64 = 1e-9;
/// Means and deviations of the priors of ln length and ln r.
const PRIORS: [[f64; 2]; 2] = [[0.0, 2.0], [-4.6, 5.0]];
/// First lengths and noise ratio of each start.
const STARTS: [[f64; 2]; 2] = [[1.0, 0.05], [3.0, 0.5]];
/// What is minimised is the negative evidence a row, raised by this: a run takes errors to be positive.
const RAISED: f64 = 100.0;

/// What one target is answered by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Machine {
    /// A length for each input, in scaled units.
    lengths: Vec<f64>,
    /// Noise variance over signal variance.
    noise: f64,
    /// Signal variance, scaled units squared.
    signal: f64,
    mean: f64,
    ln_evidence: f64,
    /// `A^-1 (z - m)`.
    weights: Vec<f64>,
    #[serde(skip)]
    factor: Vec<f64>,
}

/// A fitted Gaussian process with the ranges of its columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gp {
    /// Columns with their limits.
    #[serde(flatten)]
    pub columns: Columns,
    /// Scaled features of the training rows.
    instances: Vec<Vec<f64>>,
    machines: Vec<Machine>,
}

impl Gp {
    /// Whether so many training rows are possible.
    ///
    /// # Errors
    /// [`OutlookError::Count`] above [`MAX_ROWS`].
    pub const fn fits(given: usize) -> Result<(), OutlookError> {
        let what = "rows for a Gaussian process";
        if given > MAX_ROWS {
            return Err(OutlookError::Count { what, given, range: "1 to 3000" });
        }
        Ok(())
    }

    /// Fits one process for each target.
    ///
    /// # Errors
    /// [`OutlookError::Count`] above [`MAX_ROWS`]; [`OutlookError::Singular`].
    pub fn fit(train: &DataSet) -> Result<Self, OutlookError> {
        Self::fits(train.rows())?;
        let [inputs, targets] = train.scaled(&train.input_scalings(), &train.target_scalings());
        let instances: Vec<Vec<f64>> = inputs.rows().into_iter().map(|row| row.to_vec()).collect();
        let machines = (0..train.targets.len())
            .into_par_iter()
            .map(|target| Machine::fit(&instances, &targets.column(target).to_vec()))
            .collect::<Option<_>>();
        let machines = machines.ok_or(OutlookError::Singular)?;
        let machines: Vec<Machine> = machines;
        let noise = machines.iter().map(|machine| machine.noise * machine.signal);
        Ok(Self { columns: Columns::of(FORMAT, train).with_noise(noise), instances, machines })
    }

    /// Logarithm of the evidence of all targets, in scaled units.
    #[must_use]
    pub fn ln_evidence(&self) -> f64 {
        self.machines.iter().map(|machine| machine.ln_evidence).sum()
    }

    /// Lengths and noise of each target in a line, in scaled units.
    #[must_use]
    pub fn detail(&self) -> String {
        let one = |machine: &Machine| {
            let lengths: Vec<String> = machine.lengths.iter().map(|l| format!("{l:.2}")).collect();
            let noise = (machine.noise * machine.signal).sqrt();
            format!("lengths {}, noise {noise:.2e}", lengths.join(" "))
        };
        self.machines.iter().map(one).collect::<Vec<_>>().join("; ")
    }

    /// Numbers it consists of.
    #[must_use]
    pub fn size(&self) -> usize {
        self.instances.len() * (self.columns.inputs.len() + self.machines.len())
    }

    /// The text of its file.
    ///
    /// # Errors
    /// [`FileError::Json`].
    pub fn to_json(&self) -> Result<String, FileError> {
        columns::to_json(self)
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// [`FileError::Json`], [`FileError::Format`], [`FileError::Version`]; [`FileError::Shape`] where rows, lengths and weights do not
    /// fit each other, or are no Gaussian process.
    pub fn from_json(text: &str) -> Result<Self, FileError> {
        let mut gp: Self = columns::from_json(text, FORMAT)?;
        let rows = gp.instances.len();
        let lengths = gp.machines.iter().map(|machine| &machine.lengths);
        gp.columns.check(gp.machines.len(), gp.instances.iter().chain(lengths))?;
        let wrong = mlp::ShapeError::Rows { inputs: rows, outputs: MAX_ROWS };
        for machine in &mut gp.machines {
            if machine.weights.len() != rows || rows > MAX_ROWS {
                return Err(wrong.into());
            }
            let kernel = matrix(&gp.instances, &machine.lengths);
            machine.factor = factor(&kernel, machine.noise, &mut vec![0.0; rows]).ok_or(wrong)?;
        }
        Ok(gp)
    }
}

/// The Cholesky factor of `kernel + noise I`; `right` becomes the solution.
fn factor(kernel: &[f64], noise: f64, right: &mut [f64]) -> Option<Vec<f64>> {
    let mut factor = vec![0.0; kernel.len()];
    solve_shifted(kernel, noise + JITTER, &mut factor, right)?;
    Some(factor)
}

fn kernel(lengths: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let parts = a.iter().zip(b).zip(lengths);
    libm::exp(-0.5 * parts.map(|((a, b), l)| ((a - b) / l).powi(2)).sum::<f64>())
}

/// The kernel between all rows: a lower triangle, row by row in a square.
fn matrix(rows: &[Vec<f64>], lengths: &[f64]) -> Vec<f64> {
    let size = rows.len();
    let mut matrix = vec![0.0; size * size];
    for (at, (line, a)) in matrix.chunks_exact_mut(size.max(1)).zip(rows).enumerate() {
        line[..=at].iter_mut().zip(rows).for_each(|(place, b)| *place = kernel(lengths, a, b));
    }
    matrix
}

/// Negative evidence a row of rows and centred targets; weights are the logarithms of the lengths and of r.
struct Evidence<'a> {
    rows: &'a [Vec<f64>],
    centred: &'a [f64],
}

impl Evidence<'_> {
    /// It and, where wanted, its gradient; infinite where the matrix is not definite.
    fn look(&self, weights: &[f64], gradient: Option<&mut [f64]>) -> f64 {
        let n = self.rows.len() as f64;
        let values: Vec<f64> = weights.iter().map(|w| w.clamp(-50.0, 50.0).exp()).collect();
        let Some((noise, lengths)) = values.split_last() else { return f64::INFINITY };
        let prior = |at: usize| PRIORS[usize::from(at == lengths.len())];
        let off = |(at, w): (usize, &f64)| (w - prior(at)[0]) / prior(at)[1];
        let kernel = matrix(self.rows, lengths);
        let mut solved = self.centred.to_vec();
        let Some(factor) = factor(&kernel, *noise, &mut solved) else { return f64::INFINITY };
        let signal = (product(&solved, self.centred) / n).max(1e-30);
        let determinant = log_determinant(&factor, self.rows.len());
        let penalty: f64 = weights.iter().enumerate().map(off).map(|z| 0.5 * z * z).sum();
        if let Some(gradient) = gradient {
            solved.iter_mut().for_each(|value| *value /= signal.sqrt());
            self.slopes(&kernel, &factor, lengths, &solved, gradient);
            let size = gradient.len();
            gradient[size - 1] *= noise;
            for (at, place) in gradient.iter_mut().enumerate() {
                *place = (*place + off((at, &weights[at])) / prior(at)[1]) / n;
            }
        }
        RAISED + 0.5 * signal.ln() + (0.5 * determinant + penalty) / n
    }

    /// `1/2 tr((A^-1 - a a') dA)` for each ln length and for r, with a the solution over the signal's deviation.
    fn slopes(
        &self,
        kernel: &[f64],
        factor: &[f64],
        lengths: &[f64],
        solved: &[f64],
        gradient: &mut [f64],
    ) {
        let size = self.rows.len();
        let mut columns = vec![0.0; size * size];
        inverse_columns(factor, size, |at, column| {
            columns[at * size + at..(at + 1) * size].copy_from_slice(column);
        });
        gradient.fill(0.0);
        for (i, a) in self.rows.iter().enumerate() {
            for (j, b) in self.rows[..=i].iter().enumerate() {
                let inverse = product(
                    &columns[i * size + i..(i + 1) * size],
                    &columns[j * size + i..(j + 1) * size],
                );
                let part = inverse - solved[i] * solved[j];
                if i == j {
                    gradient[lengths.len()] += 0.5 * part;
                    continue;
                }
                let part = part * kernel[i * size + j];
                for ((slope, l), (a, b)) in gradient.iter_mut().zip(lengths).zip(a.iter().zip(b)) {
                    *slope += part * ((a - b) / l).powi(2);
                }
            }
        }
    }
}

impl Objective for Evidence<'_> {
    fn weights(&self) -> usize {
        self.rows.first().map_or(0, Vec::len) + 1
    }

    fn residuals(&self) -> usize {
        self.rows.len()
    }

    fn mse(&mut self, weights: &[f64]) -> f64 {
        self.look(weights, None)
    }

    fn gradient(&mut self, weights: &[f64], gradient: &mut [f64]) -> f64 {
        self.look(weights, Some(gradient))
    }

    /// Of no use to L-BFGS: no Jacobian.
    fn normal_equations(&mut self, weights: &[f64], _: &mut [f64], _: &mut [f64]) -> f64 {
        self.look(weights, None)
    }
}

impl Machine {
    fn fit(instances: &[Vec<f64>], targets: &[f64]) -> Option<Self> {
        let rows = instances.len();
        let mean = targets.iter().sum::<f64>() / rows as f64;
        let centred: Vec<f64> = targets.iter().map(|z| z - mean).collect();
        let some = rows.min(TUNED_ROWS);
        let spread = || (0..some).map(|at| at * rows / some);
        let tuned: Vec<Vec<f64>> = spread().map(|at| instances[at].clone()).collect();
        let wanted: Vec<f64> = spread().map(|at| centred[at]).collect();
        let mut evidence = Evidence { rows: &tuned, centred: &wanted };
        let size = evidence.weights();
        let config = RunConfig { epochs: 60, min_gradient: 1e-5, ..RunConfig::default() };
        let best = STARTS
            .map(|[length, noise]| {
                let mut start = vec![length.ln(); size];
                start[size - 1] = noise.ln();
                let mut trainer = Lbfgs::new(size);
                run(Training::new(&mut trainer, &mut evidence), start, &config)
            })
            .into_iter()
            .filter(|run| run.mse.is_finite())
            .min_by(|a, b| a.mse.total_cmp(&b.mse))?;
        let mut lengths: Vec<f64> = best.weights.iter().map(|w| w.exp()).collect();
        let noise = lengths.pop()?;
        let mut weights = centred.clone();
        let factor = factor(&matrix(instances, &lengths), noise, &mut weights)?;
        let n = rows as f64;
        let signal = (product(&weights, &centred) / n).max(1e-30);
        let ln_evidence = -0.5 * n * ((core::f64::consts::TAU * signal).ln() + 1.0)
            - 0.5 * log_determinant(&factor, rows);
        Some(Self { lengths, noise, signal, mean, ln_evidence, weights, factor })
    }

    fn near(&self, instances: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
        instances.iter().map(|row| kernel(&self.lengths, row, x)).collect()
    }

    /// Deviation of an answer, noise included, in scaled units; `near` is the kernel to each row.
    fn deviation(&self, mut near: Vec<f64>) -> f64 {
        forward(&self.factor, &mut near);
        (self.signal * (1.0 + self.noise - product(&near, &near)).max(self.noise)).sqrt()
    }
}

impl Predict for Gp {
    fn predict(&self, inputs: &ArrayRef1<f64>, outputs: &mut [f64]) -> Result<(), PredictError> {
        let x = self.columns.scaled(inputs)?;
        let value = |machine: &Machine| {
            machine.mean + product(&machine.near(&self.instances, &x), &machine.weights)
        };
        self.columns.answer(self.machines.iter().map(value), outputs)
    }

    /// Mean and standard deviation of what a new row will show, its noise included; under a logarithm the deviation is the relative
    /// one times the mean.
    fn spread(&self, inputs: &ArrayRef1<f64>) -> Result<Vec<Spread>, PredictError> {
        let mut means = vec![0.0; self.machines.len()];
        self.predict(inputs, &mut means)?;
        let x = self.columns.scaled(inputs)?;
        let parts = self.machines.iter().zip(&self.columns.targets).zip(means);
        let spread = |((machine, column), mean): ((&Machine, _), f64)| {
            let scaled = machine.deviation(machine.near(&self.instances, &x));
            Spread { mean, deviation: raw_deviation(column, scaled, mean) }
        };
        Ok(parts.map(spread).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outlook::{compare::uncertainty, score, testing};
    use ndarray::arr1;

    #[test]
    fn the_gradient_is_that_of_the_evidence() {
        let train = testing::surface(25, 1);
        let [inputs, targets] = train.scaled(&train.input_scalings(), &train.target_scalings());
        let rows: Vec<Vec<f64>> = inputs.rows().into_iter().map(|row| row.to_vec()).collect();
        let centred = targets.column(0).to_vec();
        let evidence = Evidence { rows: &rows, centred: &centred };
        let (at, mut gradient) = ([-0.3, 0.4, -2.0], [0.0; 3]);
        evidence.look(&at, Some(&mut gradient));
        for (place, found) in gradient.iter().enumerate() {
            let moved = |step: f64| {
                let mut at = at;
                at[place] += step;
                evidence.look(&at, None)
            };
            let wanted = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!((found - wanted).abs() < 1e-6, "{place}: {found} {wanted}");
        }
    }

    #[test]
    fn a_noisy_surface_is_learned_and_the_noise_is_known() {
        let (train, test) = (testing::surface(120, 1), testing::surface(400, 2));
        let gp = Gp::fit(&train).unwrap();
        let got = score(&gp, &test, &train.target_scalings()).unwrap();
        // The noise alone has 0.0025.
        assert!(got.mse > 0.002 && got.mse < 0.0036, "{got:?}");
        let found = uncertainty(&gp, &test).unwrap().unwrap();
        // Uniform noise lies within two deviations more often than normal noise, which does so in 95 %.
        assert!((0.042..0.065).contains(&found.spread), "{found:?}");
        assert!((0.93..1.0).contains(&found.within_two), "{found:?}");
        let [inside, outside] =
            [[0.1, 0.2], [3.0, -3.0]].map(|at| gp.spread(&arr1(&at)).unwrap()[0]);
        assert!(outside.deviation > 3.0 * inside.deviation, "{inside:?} {outside:?}");
        let back = Gp::from_json(&gp.to_json().unwrap()).unwrap();
        assert_eq!(back.spread(&arr1(&[0.1, 0.2])).unwrap()[0], inside);
    }

    #[test]
    fn what_is_no_process_is_refused() {
        let many = Gp::fit(&testing::surface(MAX_ROWS + 1, 1)).unwrap_err().to_string();
        assert_eq!(many, "3001 rows for a Gaussian process: 1 to 3000 are possible");
        let text = Gp::fit(&testing::surface(9, 1)).unwrap().to_json().unwrap();
        assert!(matches!(
            Gp::from_json(&text.replace("gp-model", "svr-model")),
            Err(FileError::Format { .. })
        ));
        let negative = text.replacen("\"noise\": ", "\"noise\": -7", 1);
        assert!(matches!(Gp::from_json(&negative), Err(FileError::Shape(_))), "not definite");
    }
}
