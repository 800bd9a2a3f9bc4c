//! Support vector regression with a Gaussian kernel on rows of data.
//!
//! For features x scaled to [-1, 1] the prediction is `b + sum w_i exp(-gamma |x - x_i|^2)` over the support vectors x_i; one
//! such machine a target. Fitted by sequential minimal optimisation (`smartcore`), which stops after 50,000 steps whether
//! it has converged or not, so a large `c` on many rows gives a machine that is only nearly optimal. Memory grows with the
//! square of the rows, hence [`MAX_ROWS`].

use mlp::PredictError;
use mlp::train::{DataSet, FileError, SettingError};
use ndarray::{ArrayRef1, ArrayRef2};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use serde::{Deserialize, Serialize};
use smartcore::linalg::basic::matrix::DenseMatrix;
use smartcore::svm::{
    Kernels,
    svr::{SVR, SVRParameters},
};

use super::columns::{self, Columns};
use super::score::{OutlookError, Predict, score};

/// Most training rows.
pub const MAX_ROWS: usize = 5000;

/// Value of the field `format`.
pub const FORMAT: &str = "svr-model";

/// Settings of a support vector regression.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SvrConfig {
    /// Price of an error beyond `epsilon`, positive. Default 10.
    pub c: f64,
    /// Errors up to this one cost nothing, in scaled units, 0 or more. Default 0.01.
    pub epsilon: f64,
    /// Narrowness of the kernel, positive. Default 1.
    pub gamma: f64,
}

impl Default for SvrConfig {
    fn default() -> Self {
        Self { c: 10.0, epsilon: 0.01, gamma: 1.0 }
    }
}

impl SvrConfig {
    /// The combinations that [`Svr::choose`] tries by default.
    #[must_use]
    pub fn grid() -> Vec<Self> {
        let mut grid = Vec::new();
        for c in [1.0, 10.0, 100.0] {
            for gamma in [0.03, 0.1, 0.3, 1.0, 3.0] {
                grid.push(Self { c, gamma, ..Self::default() });
            }
        }
        grid
    }

    /// Whether the settings are within their ranges.
    ///
    /// # Errors
    /// [`SettingError`] for the first that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, value) in [("c", self.c), ("gamma", self.gamma)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SettingError { name, value, range: "a positive number" });
            }
        }
        if self.epsilon >= 0.0 && self.epsilon.is_finite() {
            return Ok(());
        }
        Err(SettingError { name: "epsilon", value: self.epsilon, range: "0 or a positive number" })
    }
}

/// One fitted machine: scaled features in, one scaled target out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Machine {
    /// Scaled features of the support vectors.
    instances: Vec<Vec<f64>>,
    /// Their weights.
    w: Vec<f64>,
    /// Added to the sum.
    b: f64,
}

/// A fitted support vector regression with the ranges of its columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Svr {
    /// Columns with their limits.
    #[serde(flatten)]
    pub columns: Columns,
    /// How it was fitted.
    pub config: SvrConfig,
    machines: Vec<Machine>,
}

impl Svr {
    /// Fits one machine for each target.
    ///
    /// # Errors
    /// [`OutlookError::Setting`]; [`OutlookError::Count`] above [`MAX_ROWS`]; [`OutlookError::Svr`].
    pub fn fit(train: &DataSet, config: &SvrConfig) -> Result<Self, OutlookError> {
        config.check()?;
        Self::check_rows(train)?;
        let [features, wanted] = train.scaled(&train.input_scalings(), &train.target_scalings());
        let machines = (0..train.targets.len())
            .into_par_iter()
            .map(|target| machine(&features, &wanted.column(target), config))
            .collect::<Result<Vec<Machine>, OutlookError>>()?;
        let noise = machines.iter().zip(wanted.columns()).map(|(machine, wanted)| {
            let left = features.rows().into_iter().zip(wanted);
            let left = left.map(|(x, z)| z - machine.value(&x.to_vec(), config.gamma));
            left.map(|left| left * left).sum::<f64>() / train.rows() as f64
        });
        let columns = Columns::of(FORMAT, train).with_noise(noise);
        Ok(Self { columns, config: *config, machines })
    }

    /// Whether there are few enough rows, before any work is done on them.
    ///
    /// # Errors
    /// [`OutlookError::Count`] above [`MAX_ROWS`].
    pub fn check_rows(rows: &DataSet) -> Result<(), OutlookError> {
        if rows.rows() > MAX_ROWS {
            let what = "rows for support vector regression";
            return Err(OutlookError::Count { what, given: rows.rows(), range: "1 to 5000" });
        }
        Ok(())
    }

    /// Fits every combination of `grid` on the training rows and keeps the one with the least scaled error on the
    /// validation rows; the first of equals.
    ///
    /// # Errors
    /// As [`Svr::fit`] and [`score`]; [`OutlookError::Count`] for an empty grid.
    pub fn choose(
        train: &DataSet,
        validation: &DataSet,
        grid: &[SvrConfig],
    ) -> Result<Self, OutlookError> {
        let limits = train.target_scalings();
        let fitted: Vec<(Self, f64)> = grid
            .into_par_iter()
            .map(|config| {
                let svr = Self::fit(train, config)?;
                let error = score(&svr, validation, &limits)?.scaled_mse;
                Ok::<_, OutlookError>((svr, error))
            })
            .collect::<Result<_, _>>()?;
        fitted
            .into_iter()
            .min_by(|(_, left), (_, right)| left.total_cmp(right))
            .map(|(svr, _)| svr)
            .ok_or(OutlookError::Count { what: "combinations", given: 0, range: "1 or more" })
    }

    /// Support vectors of all machines.
    #[must_use]
    pub fn support_vectors(&self) -> usize {
        self.machines.iter().map(|machine| machine.w.len()).sum()
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
    /// [`FileError::Json`], [`FileError::Format`], [`FileError::Version`]; [`FileError::Shape`] where the support vectors do not
    /// fit the columns.
    pub fn from_json(text: &str) -> Result<Self, FileError> {
        let svr: Self = columns::from_json(text, FORMAT)?;
        let instances = svr.machines.iter().flat_map(|machine| &machine.instances);
        svr.columns.check(svr.machines.len(), instances)?;
        Ok(svr)
    }
}

fn machine(
    features: &ArrayRef2<f64>,
    wanted: &ArrayRef1<f64>,
    config: &SvrConfig,
) -> Result<Machine, OutlookError> {
    let failed = |error: &dyn core::fmt::Display| OutlookError::Svr { message: error.to_string() };
    let (rows, columns) = features.dim();
    let values = features.iter().copied().collect();
    let wanted = wanted.to_vec();
    let x = DenseMatrix::new(rows, columns, values, false).map_err(|error| failed(&error))?;
    let parameters = SVRParameters::default()
        .with_c(config.c)
        .with_eps(config.epsilon)
        .with_kernel(Kernels::rbf().with_gamma(config.gamma));
    let fitted = SVR::fit(&x, &wanted, &parameters).map_err(|error| failed(&error))?;
    // The expansion is private there, but it is what the machine writes.
    let written = serde_json::to_value(&fitted).map_err(|error| failed(&error))?;
    let machine: Machine = serde_json::from_value(written).map_err(|error| failed(&error))?;
    if machine.w.iter().all(|w| w.is_finite()) && machine.b.is_finite() {
        return Ok(machine);
    }
    Err(failed(&"weights that are not finite"))
}

impl Predict for Svr {
    fn predict(&self, inputs: &ArrayRef1<f64>, outputs: &mut [f64]) -> Result<(), PredictError> {
        let x = self.columns.scaled(inputs)?;
        let value = |machine: &Machine| machine.value(&x, self.config.gamma);
        self.columns.answer(self.machines.iter().map(value), outputs)
    }
}

impl Machine {
    fn value(&self, x: &[f64], gamma: f64) -> f64 {
        let kernel = |other: &Vec<f64>| {
            let square: f64 = x.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
            libm::exp(-gamma * square)
        };
        self.b + self.instances.iter().zip(&self.w).map(|(x, w)| w * kernel(x)).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outlook::testing;
    use ndarray::arr1;

    #[test]
    fn a_smooth_surface_is_learned_and_the_file_comes_back() {
        let (train, test) = (testing::surface(150, 1), testing::surface(80, 2));
        let svr = Svr::fit(&train, &SvrConfig::default()).unwrap();
        let got = score(&svr, &test, &train.target_scalings()).unwrap();
        // The noise alone, N(0, 0.05), is 0.0025.
        assert!(got.mse > 0.0015 && got.mse < 0.006, "{got:?}");
        let back = Svr::from_json(&svr.to_json().unwrap()).unwrap();
        assert_eq!(back, svr);
        assert!(svr.support_vectors() > 0 && svr.support_vectors() <= 150);
    }

    /// Karush, Kuhn and Tucker: weights lie within c and sum up to 0; inside the tube they are 0, outside it c.
    #[test]
    fn the_machine_meets_the_conditions_of_the_optimum() {
        let train = testing::surface(60, 3);
        let config = SvrConfig { c: 5.0, epsilon: 0.05, gamma: 1.0 };
        let svr = Svr::fit(&train, &config).unwrap();
        let machine = &svr.machines[0];
        let [features, wanted] = train.scaled(&train.input_scalings(), &train.target_scalings());
        assert!(machine.w.iter().sum::<f64>().abs() < 1e-9);
        for (x, y) in features.rows().into_iter().zip(&wanted) {
            let x = x.to_vec();
            let error = y - machine.value(&x, config.gamma);
            let same = |other: &Vec<f64>| *other == x;
            let place = machine.instances.iter().position(same);
            let w = place.map_or(0.0, |at| machine.w[at]);
            assert!(w.abs() <= config.c + 1e-9, "{w}");
            let slack = 2e-3;
            if error.abs() < config.epsilon - slack {
                assert!(w == 0.0, "{w} where the error is {error}");
            }
            if error.abs() > config.epsilon + slack {
                assert!((w - config.c * error.signum()).abs() < 1e-9, "{w} at {error}");
            }
        }
    }

    #[test]
    fn the_grid_is_decided_by_the_validation_rows() {
        let (train, other) = (testing::surface(100, 1), testing::surface(60, 2));
        let limits = train.target_scalings();
        let grid = SvrConfig::grid();
        let chosen = Svr::choose(&train, &other, &grid).unwrap();
        let error = |svr: &Svr| score(svr, &other, &limits).unwrap().scaled_mse;
        for config in &grid {
            assert!(error(&Svr::fit(&train, config).unwrap()) >= error(&chosen), "{config:?}");
        }
        let empty = Svr::choose(&train, &other, &[]);
        assert!(matches!(empty, Err(OutlookError::Count { .. })));
    }

    #[test]
    fn logarithmic_columns_and_constant_ones_work() {
        let csv = "a,b,y\n1,7,1\n10,7,10\n100,7,100\n1000,7,1000\n";
        let specs = |names: &[&str]| names.iter().map(|n| n.parse().unwrap()).collect::<Vec<_>>();
        let columns = (specs(&["a:ln", "b"]), specs(&["y:ln"]));
        let data = DataSet::from_csv("l.csv", csv.as_bytes(), &columns.0, &columns.1).unwrap();
        let svr = Svr::fit(&data, &SvrConfig { c: 100.0, ..SvrConfig::default() }).unwrap();
        let mut answer = [0.0];
        svr.predict(&arr1(&[100.0, 7.0]), &mut answer).unwrap();
        assert!((answer[0] / 100.0 - 1.0).abs() < 0.06, "{answer:?}");
        assert!(svr.predict(&arr1(&[-1.0, 7.0]), &mut answer).is_err());
        assert!(svr.predict(&arr1(&[1.0]), &mut answer).is_err());
    }

    #[test]
    fn settings_out_of_range_and_broken_files_are_refused() {
        let data = testing::surface(10, 1);
        for config in [
            SvrConfig { c: 0.0, ..SvrConfig::default() },
            SvrConfig { gamma: f64::NAN, ..SvrConfig::default() },
            SvrConfig { epsilon: -1.0, ..SvrConfig::default() },
        ] {
            assert!(matches!(Svr::fit(&data, &config), Err(OutlookError::Setting(_))));
        }
        let text = Svr::fit(&data, &SvrConfig::default()).unwrap().to_json().unwrap();
        let wrong = text.replace("svr-model", "mlp-model");
        assert!(matches!(Svr::from_json(&wrong), Err(FileError::Format { .. })));
        assert!(Svr::from_json(&text.replacen("\"x2\"", "\"x2\", \"unit\": 3", 1)).is_err());
    }
}
