//! Polynomials of the scaled features by least squares: the mean, a line, a cubic. The baselines that a network has to beat.

use mlp::PredictError;
use mlp::train::linear::{product, solve_shifted};
use mlp::train::{DataSet, FileError, SettingError};
use ndarray::ArrayRef1;
use serde::{Deserialize, Serialize};

use super::columns::{self, Columns};
use super::score::{OutlookError, Predict};

/// Value of the field `format`.
pub const FORMAT: &str = "poly-model";

/// Most terms: products of powers of the inputs.
pub const MAX_TERMS: usize = 1024;

/// Highest degree.
pub const MAX_DEGREE: usize = 5;

/// Added to the diagonal of the normal equations for each row, so that as many terms as rows have a solution too.
const RIDGE: f64 = 1e-9;

/// A fitted polynomial of all products of inputs up to a degree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Poly {
    /// Columns with their limits.
    #[serde(flatten)]
    pub columns: Columns,
    /// 0 is the mean, 1 a line, 3 a cubic.
    pub degree: usize,
    /// For each target the coefficients, in the order of [`terms`].
    coefficients: Vec<Vec<f64>>,
}

impl Poly {
    /// Fits one polynomial for each target.
    ///
    /// # Errors
    /// [`OutlookError::Setting`] above [`MAX_DEGREE`]; [`OutlookError::Count`] above [`MAX_TERMS`]; [`OutlookError::Singular`].
    pub fn fit(train: &DataSet, degree: usize) -> Result<Self, OutlookError> {
        if degree > MAX_DEGREE {
            let (name, value) = ("degree", degree as f64);
            return Err(SettingError { name, value, range: "0 to 5" }.into());
        }
        let given = count(train.inputs.len(), degree);
        if given > MAX_TERMS {
            return Err(OutlookError::Count {
                what: "terms of a polynomial",
                given,
                range: "1 to 1024",
            });
        }
        let [inputs, wanted] = train.scaled(&train.input_scalings(), &train.target_scalings());
        let rows: Vec<Vec<f64>> =
            inputs.rows().into_iter().map(|row| terms(&row.to_vec(), degree)).collect();
        let mut normal = vec![0.0; given * given];
        for row in &rows {
            for (line, a) in normal.chunks_exact_mut(given).zip(row) {
                line.iter_mut().zip(row).for_each(|(place, b)| *place += a * b);
            }
        }
        let (ridge, mut factor) = (RIDGE * rows.len() as f64, vec![0.0; given * given]);
        let mut solve = |target: usize| {
            let mut right = vec![0.0; given];
            for (row, wanted) in rows.iter().zip(wanted.column(target)) {
                right.iter_mut().zip(row).for_each(|(place, term)| *place += term * wanted);
            }
            solve_shifted(&normal, ridge, &mut factor, &mut right).map(|()| right)
        };
        let coefficients: Option<Vec<_>> = (0..train.targets.len()).map(&mut solve).collect();
        let coefficients = coefficients.ok_or(OutlookError::Singular)?;
        let noise = coefficients.iter().zip(wanted.columns()).map(|(coefficients, wanted)| {
            let left = rows.iter().zip(wanted).map(|(row, z)| z - product(row, coefficients));
            left.map(|left| left * left).sum::<f64>() / rows.len() as f64
        });
        let columns = Columns::of(FORMAT, train).with_noise(noise);
        Ok(Self { columns, degree, coefficients })
    }

    /// `mean`, `linear` or `poly`, as `--model` has it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        ["mean", "linear"].get(self.degree).copied().unwrap_or("poly")
    }

    /// Coefficients of all targets.
    #[must_use]
    pub fn size(&self) -> usize {
        self.coefficients.iter().map(Vec::len).sum()
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
    /// [`FileError::Json`], [`FileError::Format`], [`FileError::Version`]; [`FileError::Shape`] where the coefficients do not fit.
    pub fn from_json(text: &str) -> Result<Self, FileError> {
        let poly: Self = columns::from_json(text, FORMAT)?;
        poly.columns.check(poly.coefficients.len(), None)?;
        let needed = count(poly.columns.inputs.len(), poly.degree.min(MAX_DEGREE + 1));
        if poly.degree > MAX_DEGREE || needed > MAX_TERMS {
            return Err(mlp::ShapeError::Inputs { needed: MAX_TERMS, given: needed }.into());
        }
        match poly.coefficients.iter().map(Vec::len).find(|given| *given != needed) {
            Some(given) => Err(mlp::ShapeError::Inputs { needed, given }.into()),
            None => Ok(poly),
        }
    }
}

/// Number of [`terms`].
fn count(inputs: usize, degree: usize) -> usize {
    (1..=degree).fold(1_usize, |terms, at| terms.saturating_mul(inputs + at) / at)
}

/// All products of the values of `x` up to `degree`, 1 first.
fn terms(x: &[f64], degree: usize) -> Vec<f64> {
    let mut all = vec![1.0];
    // Terms of the last degree, each with the first input it may still be multiplied by.
    let mut last = vec![(1.0, 0)];
    for _ in 0..degree {
        let next = last.iter().flat_map(|&(term, from)| {
            x.iter().enumerate().skip(from).map(move |(at, value)| (term * value, at))
        });
        last = next.collect();
        all.extend(last.iter().map(|(term, _)| term));
    }
    all
}

impl Predict for Poly {
    fn predict(&self, inputs: &ArrayRef1<f64>, outputs: &mut [f64]) -> Result<(), PredictError> {
        let terms = terms(&self.columns.scaled(inputs)?, self.degree);
        let value = |weights: &Vec<f64>| product(weights, &terms);
        self.columns.answer(self.coefficients.iter().map(value), outputs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::arr1;

    fn data() -> DataSet {
        let y = |a: f64, b: f64| 3.0 - a + 2.0 * a * b * b - 0.5 * a * a * a;
        let row = |i: i32| {
            let (a, b) = (f64::from(i % 7) - 2.0, f64::from(i / 7) * 0.5);
            format!("{a},{b},{}\n", y(a, b))
        };
        let csv = format!("a,b,y\n{}", (0..42).map(row).collect::<String>());
        let specs = |names: &[&str]| names.iter().map(|n| n.parse().unwrap()).collect::<Vec<_>>();
        DataSet::from_csv("p.csv", csv.as_bytes(), &specs(&["a", "b"]), &specs(&["y"])).unwrap()
    }

    #[test]
    fn a_cubic_is_found_exactly_and_the_mean_is_the_mean() {
        let data = data();
        let at = |degree: usize, place: [f64; 2]| {
            let poly = Poly::fit(&data, degree).unwrap();
            let back = Poly::from_json(&poly.to_json().unwrap()).unwrap();
            assert_eq!(back, poly);
            let mut answer = [0.0];
            back.predict(&arr1(&place), &mut answer).unwrap();
            answer[0]
        };
        assert!((at(3, [1.5, 0.7]) - (1.5 + 3.0 * 0.49 - 0.5 * 3.375)).abs() < 1e-5);
        let mean = data.target_values().mean().unwrap();
        assert!((at(0, [9.0, -9.0]) - mean).abs() < 1e-6);
        assert_eq!(terms(&[2.0, 3.0], 2), [1.0, 2.0, 3.0, 4.0, 6.0, 9.0]);
        assert!(matches!(Poly::fit(&data, 6), Err(OutlookError::Setting(_))));
        let short = Poly::fit(&data, 1)
            .unwrap()
            .to_json()
            .unwrap()
            .replace("\"degree\": 1", "\"degree\": 3");
        assert!(matches!(Poly::from_json(&short), Err(FileError::Shape(_))));
    }
}
