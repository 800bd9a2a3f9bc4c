//! Ensemble of nets of one setting on rows of data, with the mean and the spread of their answers.

use mlp::train::{
    ColumnSpec, DataSet, EnsembleFile, FileError, Fit, FitConfig, Interval, LargeModel, ModelFile,
    SettingError, file::FileColumn, fit,
};
use mlp::{PredictError, ShapeError};
use ndarray::ArrayRef1;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use super::score::{OutlookError, Predict, Spread};

pub use mlp::train::ensemble_file::FORMAT;

/// What makes the members differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sampling {
    /// Other starting weights on the same rows.
    #[default]
    Starts,
    /// Other starting weights, and as many rows drawn with replacement (Breiman's bagging).
    Bagging,
}

/// What to train.
#[derive(Debug, Clone, PartialEq)]
pub struct EnsembleConfig {
    /// Number of nets, 2 to 100. Default 10.
    pub members: usize,
    /// What makes them differ. Default the starts.
    pub sampling: Sampling,
    /// Each net; its seed counts up from member to member, in steps of its repeats.
    pub fit: FitConfig,
}

impl Default for EnsembleConfig {
    fn default() -> Self {
        Self { members: 10, sampling: Sampling::Starts, fit: FitConfig::default() }
    }
}

impl EnsembleConfig {
    /// Whether the number of members is possible.
    ///
    /// # Errors
    /// [`SettingError`] outside 2 to 100.
    pub fn check(&self) -> Result<(), SettingError> {
        if (2..=100).contains(&self.members) {
            return Ok(());
        }
        let value = self.members as f64;
        Err(SettingError { name: "members", value, range: "2 to 100" })
    }
}

/// Several nets for the same columns.
#[derive(Debug, Clone)]
pub struct Ensemble {
    files: Vec<ModelFile>,
    models: Vec<LargeModel>,
    /// How far the truth may be from an answer, where that was measured.
    pub interval: Option<Interval>,
}

impl Ensemble {
    /// Trains the members, in parallel.
    ///
    /// # Errors
    /// [`OutlookError::Setting`] outside 2 to 100 members; [`OutlookError::Fit`] where a member can not be trained.
    pub fn fit(
        train: &DataSet,
        validation: Option<&DataSet>,
        config: &EnsembleConfig,
    ) -> Result<Self, OutlookError> {
        config.check()?;
        let fits: Vec<Fit> = (0..config.members)
            .into_par_iter()
            .map(|member| Self::member(train, validation, config, member))
            .collect::<Result<_, _>>()?;
        let (files, models) = fits.into_iter().map(|fit| (fit.file, *fit.model)).unzip();
        Ok(Self { files, models, interval: None })
    }

    fn member(
        train: &DataSet,
        validation: Option<&DataSet>,
        config: &EnsembleConfig,
        member: usize,
    ) -> Result<Fit, OutlookError> {
        let first = (member * config.fit.repeats) as u64;
        let own = FitConfig { seed: config.fit.seed.wrapping_add(first), ..config.fit.clone() };
        match config.sampling {
            Sampling::Starts => Ok(fit(train, validation, None, &own)?),
            Sampling::Bagging => {
                let drawn = train.subset(&drawn(train.rows(), own.seed))?;
                Ok(fit(&drawn, validation, None, &own)?)
            }
        }
    }

    /// The members' files.
    #[must_use]
    pub fn members(&self) -> &[ModelFile] {
        &self.files
    }

    /// Weights of all members.
    #[must_use]
    pub fn weights(&self) -> usize {
        let layer = |file: &ModelFile| -> usize {
            file.layers
                .iter()
                .map(|l| l.biases.len() + l.weights.iter().map(Vec::len).sum::<usize>())
                .sum()
        };
        self.files.iter().map(layer).sum()
    }

    /// The column specs with which a CSV file is read for it.
    #[must_use]
    pub fn specs(&self) -> (Vec<ColumnSpec>, Vec<ColumnSpec>) {
        self.files.first().map_or_else(Default::default, ModelFile::specs)
    }

    /// Targets with their ranges.
    #[must_use]
    pub fn targets(&self) -> &[FileColumn] {
        self.files.first().map_or(&[], |file| &file.targets)
    }

    /// The text of its file: the members' files in a list.
    ///
    /// # Errors
    /// [`FileError::Json`].
    pub fn to_json(&self) -> Result<String, FileError> {
        let mut file = EnsembleFile::new(self.files.clone())?;
        file.interval.clone_from(&self.interval);
        file.to_json()
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// Any [`FileError`] of [`EnsembleFile::from_json`].
    pub fn from_json(text: &str) -> Result<Self, FileError> {
        let file = EnsembleFile::from_json(text)?;
        let (interval, files) = (file.interval.clone(), file.into_members());
        let models = files.iter().map(ModelFile::large_model).collect::<Result<_, _>>()?;
        Ok(Self { files, models, interval })
    }
}

impl Predict for Ensemble {
    fn predict(&self, inputs: &ArrayRef1<f64>, outputs: &mut [f64]) -> Result<(), PredictError> {
        let spread = self.spread(inputs)?;
        let (needed, given) = (spread.len(), outputs.len());
        if needed != given {
            return Err(ShapeError::Outputs { needed, given }.into());
        }
        outputs.iter_mut().zip(spread).for_each(|(output, spread)| *output = spread.mean);
        Ok(())
    }

    fn spread(&self, inputs: &ArrayRef1<f64>) -> Result<Vec<Spread>, PredictError> {
        let targets = self.files.first().map_or(0, |file| file.targets.len());
        let mut answers = vec![0.0; targets];
        let (mut sums, mut squares) = (vec![0.0; targets], vec![0.0; targets]);
        for (done, model) in self.models.iter().enumerate() {
            Predict::predict(model, inputs, &mut answers)?;
            for ((sum, square), answer) in sums.iter_mut().zip(&mut squares).zip(&answers) {
                // Welford's update: no difference of large sums.
                let step = answer - *sum;
                *sum += step / (done + 1) as f64;
                *square += step * (answer - *sum);
            }
        }
        let others = (self.models.len().max(2) - 1) as f64;
        let spread =
            |(mean, square): (f64, f64)| Spread { mean, deviation: (square / others).sqrt() };
        Ok(sums.into_iter().zip(squares).map(spread).collect())
    }
}

/// As many rows as there are, with replacement.
fn drawn(rows: usize, seed: u64) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // The modulo favours low numbers by less than 2^-40.
    let mut draw = || usize::try_from(rng.next_u64() % rows as u64).unwrap_or(0);
    (0..rows).map(|_| draw()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outlook::{score, testing};
    use mlp::train::RunConfig;
    use ndarray::arr1;

    fn config(sampling: Sampling) -> EnsembleConfig {
        let run = RunConfig { epochs: 150, ..RunConfig::default() };
        let fit = FitConfig { hidden: vec![6], run, seed: 3, ..FitConfig::default() };
        EnsembleConfig { members: 6, sampling, fit }
    }

    /// The squared error of a mean is never above the mean squared error of its members.
    #[test]
    fn the_mean_is_no_worse_than_the_average_member() {
        let (train, test) = (testing::surface(80, 1), testing::surface(60, 2));
        let limits = train.target_scalings();
        for sampling in [Sampling::Starts, Sampling::Bagging] {
            let ensemble = Ensemble::fit(&train, None, &config(sampling)).unwrap();
            let error = |learner: &dyn Predict| score(learner, &test, &limits).unwrap().mse;
            let members: f64 = ensemble.models.iter().map(|model| error(model)).sum::<f64>() / 6.0;
            let joint = error(&ensemble);
            assert!(joint < members, "{sampling:?}: {joint} {members}");
            assert!(joint > 0.0 && ensemble.weights() == 6 * 25);
        }
    }

    #[test]
    fn the_spread_is_wide_where_no_rows_were() {
        let train = testing::surface(80, 1);
        let ensemble = Ensemble::fit(&train, None, &config(Sampling::Bagging)).unwrap();
        let [inside, outside] =
            [[0.1, 0.2], [3.0, -3.0]].map(|row| ensemble.spread(&arr1(&row)).unwrap()[0]);
        assert!(inside.deviation > 0.0 && outside.deviation > 4.0 * inside.deviation);
    }

    #[test]
    fn mean_and_deviation_are_those_of_the_members() {
        let train = testing::surface(40, 1);
        let ensemble = Ensemble::fit(&train, None, &config(Sampling::Starts)).unwrap();
        let answers: Vec<f64> = ensemble
            .models
            .iter()
            .map(|model| {
                let mut answer = [0.0];
                Predict::predict(model, &arr1(&[0.3_f32, -0.4].map(f64::from)), &mut answer)
                    .unwrap();
                answer[0]
            })
            .collect();
        let mean = answers.iter().sum::<f64>() / 6.0;
        let variance = answers.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / 5.0;
        let spread = ensemble.spread(&arr1(&[0.3_f32, -0.4].map(f64::from))).unwrap()[0];
        assert!((spread.mean - mean).abs() < 1e-12, "{spread:?} {mean}");
        assert!((spread.deviation - variance.sqrt()).abs() < 1e-12, "{spread:?} {variance}");
    }

    #[test]
    fn equal_seeds_give_equal_members_and_files_come_back() {
        let train = testing::surface(40, 1);
        let fit = |seed: u64| {
            let config = config(Sampling::Bagging);
            let fit = FitConfig { seed, ..config.fit.clone() };
            Ensemble::fit(&train, None, &EnsembleConfig { fit, ..config }).unwrap()
        };
        let text = fit(3).to_json().unwrap();
        assert_eq!(text, fit(3).to_json().unwrap());
        assert_ne!(text, fit(4).to_json().unwrap());
        let back = Ensemble::from_json(&text).unwrap();
        assert_eq!(back.files, fit(3).files);
        assert_eq!(
            back.spread(&arr1(&[0.5, 0.5])).unwrap(),
            fit(3).spread(&arr1(&[0.5, 0.5])).unwrap()
        );
        for broken in ["{}", r#"{"format":"ensemble-model","version":1,"members":[]}"#, "[1"] {
            assert!(Ensemble::from_json(broken).is_err(), "{broken}");
        }
    }
}
