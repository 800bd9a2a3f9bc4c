//! Slip detection by a small network: it learns from labelled levels of the detector's bands and gives a statistic.
//!
//! ```text
//! ln(energy / floor) of each band -> 8 tanh neurons -> two scores -> logit L = score of slip - score of rest
//! statistic = exp(L - threshold)
//! ```
//!
//! The inputs are what the energy test of the pipeline sees: mean energies of about 5 ms over the noise floor, in motion over what the
//! motion reference makes of it. So the unit drops out, and floors come from where those of all detectors come from. Softmax makes
//! probabilities of the scores; rest and slip are learned from as many rows each, so that L estimates the log-likelihood ratio of the
//! two. As for the shipped tests, the lower one of the last two blocks counts.
//!
//! The threshold comes from the rest that was learned: the highest L there, and above it what a log-likelihood ratio needs to be passed
//! by noise once in [`INTERVAL_S`] only, ln([`INTERVAL_S`] / rest). A network does not have to keep to that law: it is an extrapolation.
//!
//! Trained by scaled conjugate gradients on the cross-entropy, from one fixed seed: the same rows give the same network.

use mlp::{
    Model,
    train::{
        Algorithm, Classes, ColumnSpec, DataSet, DataSetError, FitConfig, FitError, RunConfig, fit,
    },
};
use ndarray::Array2;
use slip_core::detector::{BANDS, SlipDetector};
use std::sync::Arc;

/// Wanted time between two false alarms (s).
const INTERVAL_S: f64 = 3600.0;
/// Rows of each kind that are learned from, at most; more are thinned out evenly.
const MOST_ROWS: usize = 4000;
/// Fewer rows of a kind are no training.
const LEAST_ROWS: usize = 50;
const HIDDEN: usize = 8;
const EPOCHS: usize = 300;
/// Penalty on the weights: without it the scores of rows that are easy to part grow without end.
const DECAY: f64 = 1e-4;
const SEED: u64 = 28;
/// Least energy over the floor that is distinguished.
const LEAST: f32 = 1e-3;
/// Logit over the threshold that is distinguished, at most.
const MOST: f32 = 40.0;

/// Why no network was trained.
#[derive(Debug, thiserror::Error)]
pub enum UntrainedError {
    /// Too little of one kind.
    #[error("{rows} rows of labelled {kind}; at least {LEAST_ROWS} are needed")]
    Few {
        /// `slip` or `rest`.
        kind: &'static str,
        /// How many there are.
        rows: usize,
    },
    /// The rows are refused.
    #[error(transparent)]
    Data(#[from] DataSetError),
    /// The training failed.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The network is too large for a detector.
    #[error(transparent)]
    File(#[from] mlp::train::FileError),
}

/// Labelled levels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    rest: Vec<[f32; BANDS]>,
    /// Time that the rows of rest cover (s).
    rest_s: f64,
    slip: Vec<[f32; BANDS]>,
}

impl Rows {
    /// Adds what `detector` shows at the end of a block of rest, `block_s` (s) long.
    pub fn push_rest(&mut self, detector: &SlipDetector, block_s: f64) {
        self.rest.push(inputs(detector));
        self.rest_s += block_s;
    }

    /// Adds what `detector` shows at the end of a block in which an object slips.
    pub fn push_slip(&mut self, detector: &SlipDetector) {
        self.slip.push(inputs(detector));
    }
}

/// ln(energy / floor) of each band; 0 of one that the rate does not carry.
fn inputs(detector: &SlipDetector) -> [f32; BANDS] {
    let (energy, has) = (detector.levels().energy, detector.has_bands());
    core::array::from_fn(|b| if has[b] { energy[b].max(LEAST).ln() } else { 0.0 })
}

/// A trained network.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipNetwork {
    model: Arc<Model<Box<[f32]>>>,
    /// Logit that is a slip.
    threshold: f32,
}

impl SlipNetwork {
    /// Trains on `rows`: as many of rest as of slip, at most 4000 each, at even distances.
    ///
    /// # Errors
    /// [`UntrainedError`]; fewer than 50 rows of rest or of slip.
    pub fn train(rows: &Rows) -> Result<Self, UntrainedError> {
        for (kind, rows) in [("rest", rows.rest.len()), ("slip", rows.slip.len())] {
            if rows < LEAST_ROWS {
                return Err(UntrainedError::Few { kind, rows });
            }
        }
        let count = rows.rest.len().min(rows.slip.len()).min(MOST_ROWS);
        let all: Vec<&[f32; BANDS]> =
            thinned(&rows.rest, count).chain(thinned(&rows.slip, count)).collect();
        let values = Array2::from_shape_fn((2 * count, BANDS), |(row, b)| f64::from(all[row][b]));
        let column = |b: usize| ColumnSpec {
            name: format!("ln_energy_{b}"),
            transform: mlp::Transform::Identity,
        };
        let columns: Vec<ColumnSpec> = (0..BANDS).map(column).collect();
        let classes = Classes {
            column: "state".to_owned(),
            names: vec!["rest".to_owned(), "slip".to_owned()],
        };
        let texts: Vec<String> =
            (0..2 * count).map(|row| classes.names[usize::from(row >= count)].clone()).collect();
        let data = DataSet::from_classes("labelled levels", &columns, values, &classes, &texts)?;
        let config = FitConfig {
            hidden: vec![HIDDEN],
            algorithm: Algorithm::Scg(Default::default()),
            run: RunConfig { epochs: EPOCHS, ..RunConfig::default() },
            seed: SEED,
            decay: DECAY,
            ..FitConfig::default()
        };
        let mut file = fit(&data, None, None, &config)?.file;
        // The scores themselves are wanted, which a model without classes gives.
        file.classes = None;
        let model = file.model()?;
        let network = Self { model: Arc::new(model), threshold: 0.0 };
        let logits: Vec<f32> = rows.rest.iter().map(|row| network.logit(row)).collect();
        let highest =
            logits.windows(2).map(|two| two[0].min(two[1])).fold(f32::NEG_INFINITY, f32::max);
        #[expect(clippy::cast_possible_truncation, reason = "a logarithm")]
        let beyond = (INTERVAL_S / rows.rest_s).ln().max(0.0) as f32;
        Ok(Self { threshold: highest + beyond, ..network })
    }

    /// Logit of the probability of a slip; minus infinity where there is none.
    fn logit(&self, inputs: &[f32; BANDS]) -> f32 {
        let mut scores = [0.0; 2];
        match self.model.predict(inputs, &mut scores) {
            Ok(_) => scores[1] - scores[0],
            Err(_) => f32::NEG_INFINITY,
        }
    }
}

/// `count` of `all`, at even distances.
fn thinned<T>(all: &[T], count: usize) -> impl Iterator<Item = &T> {
    (0..count).filter_map(move |i| all.get(i * all.len() / count))
}

/// A network beside the pipeline.
#[derive(Clone, Debug)]
pub struct NetworkTest {
    network: SlipNetwork,
    before: f32,
    statistic: f32,
}

impl NetworkTest {
    /// A test with the threshold of `network`.
    #[must_use]
    pub fn new(network: SlipNetwork) -> Self {
        Self { network, before: 0.0, statistic: 0.0 }
    }

    /// Looks at `detector`, which has taken the next sample. Gives the statistic: above 1 is a slip.
    pub fn step(&mut self, detector: &SlipDetector) -> f32 {
        if detector.is_learning() {
            (self.before, self.statistic) = (0.0, 0.0);
        } else if !detector.in_block() {
            let over = self.network.logit(&inputs(detector)) - self.network.threshold;
            let now = over.min(MOST).exp();
            self.statistic = now.min(self.before);
            self.before = now;
        }
        self.statistic
    }
}

#[cfg(test)]
mod tests {
    use super::{LEAST_ROWS, Rows, SlipNetwork, UntrainedError, thinned};
    use slip_core::detector::BANDS;

    /// Rest about 0, slip about 2 in every band, both with noise.
    fn rows(count: usize, seed: u32) -> Rows {
        let mut state = seed;
        let mut row = |middle: f32| -> [f32; BANDS] {
            core::array::from_fn(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                middle + (state >> 8) as f32 / (1 << 23) as f32 - 1.0
            })
        };
        let rest = (0..count).map(|_| row(0.0)).collect();
        Rows { rest, rest_s: 1e-3 * count as f64, slip: (0..count).map(|_| row(2.0)).collect() }
    }

    #[test]
    fn the_logit_parts_rows_that_were_not_learned() {
        let network = SlipNetwork::train(&rows(300, 1)).unwrap();
        let fresh = rows(200, 9);
        assert!(fresh.rest.iter().all(|row| network.logit(row) < 0.0));
        assert!(fresh.slip.iter().all(|row| network.logit(row) > 0.0));
        assert_eq!(network.logit(&[f32::NAN; BANDS]), f32::NEG_INFINITY);
    }

    /// The highest logit of two neighbours at rest, and the logarithm of how much longer than that rest an hour is.
    #[test]
    fn the_threshold_is_above_all_rest_by_what_an_hour_needs() {
        let rows = rows(300, 1);
        let network = SlipNetwork::train(&rows).unwrap();
        let mut highest = f32::NEG_INFINITY;
        for i in 1..rows.rest.len() {
            highest =
                highest.max(network.logit(&rows.rest[i]).min(network.logit(&rows.rest[i - 1])));
        }
        let wanted = highest + (3600.0_f32 / 0.3).ln();
        assert!((network.threshold - wanted).abs() < 1e-3, "{} {wanted}", network.threshold);
    }

    #[test]
    fn the_same_rows_give_the_same_network_and_others_another() {
        let network = SlipNetwork::train(&rows(100, 1)).unwrap();
        assert_eq!(network, SlipNetwork::train(&rows(100, 1)).unwrap());
        assert_ne!(network, SlipNetwork::train(&rows(100, 2)).unwrap());
    }

    #[test]
    fn too_little_of_either_kind_is_refused() {
        let enough = rows(LEAST_ROWS, 1);
        assert!(SlipNetwork::train(&enough).is_ok());
        let no_slip = Rows { slip: Vec::new(), ..enough.clone() };
        let error = SlipNetwork::train(&no_slip).unwrap_err();
        assert!(matches!(error, UntrainedError::Few { kind: "slip", rows: 0 }), "{error}");
        let mut little = enough;
        little.rest.pop();
        let error = SlipNetwork::train(&little).unwrap_err();
        assert!(matches!(error, UntrainedError::Few { kind: "rest", .. }), "{error}");
    }

    #[test]
    fn rows_are_thinned_evenly() {
        let all: Vec<usize> = (0..10).collect();
        assert_eq!(thinned(&all, 4).copied().collect::<Vec<_>>(), [0, 2, 5, 7]);
        assert_eq!(thinned(&all, 10).count(), 10);
    }
}
