//! The choice among mean, line, cubic, nets and Gaussian process by cross-validation on the training rows.

use core::fmt;

use mlp::Transform;
use mlp::train::{Algorithm, DataSet, FitConfig, Split, SplitError, fit};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use serde::Serialize;

use super::score::{OutlookError, Predict, Score, score};
use super::{Gp, Poly};

/// Folds, each the test of what the others teach; as many as there are groups where these are fewer.
pub const FOLDS: usize = 5;
/// Up to so many rows the folds are dealt out [`DEALS`] times: one deal of few rows leaves much to chance.
const FEW: usize = 300;
const DEALS: u64 = 3;
/// A simpler model is chosen where its error is at most this multiple of the least.
const AS_GOOD: f64 = 1.02;

/// A way to learn, the simplest first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// A polynomial: 0 the mean, 1 a line, 3 a cubic.
    Poly(usize),
    /// A net with one rule.
    Net(Algorithm),
    /// A Gaussian process.
    Gp,
}

impl Way {
    fn all() -> Vec<Self> {
        let rule = |name: &str| Algorithm::all().into_iter().find(|rule| rule.name() == name);
        let nets = ["br", "scg", "rprop"].into_iter().filter_map(rule).map(Self::Net);
        [0, 1, 3].map(Self::Poly).into_iter().chain(nets).chain([Self::Gp]).collect()
    }

    /// As `--model` has it: `mean`, `linear`, `poly`, `mlp` or `gp`.
    #[must_use]
    pub fn model(self) -> &'static str {
        match self {
            Self::Poly(0) => "mean",
            Self::Poly(1) => "linear",
            Self::Poly(_) => "poly",
            Self::Net(_) => "mlp",
            Self::Gp => "gp",
        }
    }

    fn learn(self, rows: &DataSet, config: &FitConfig) -> Result<Box<dyn Predict>, OutlookError> {
        Ok(match self {
            Self::Poly(degree) => Box::new(Poly::fit(rows, degree)?),
            Self::Gp => Box::new(Gp::fit(rows)?),
            Self::Net(algorithm) => {
                let repeats = config.repeats.max(2);
                let config = FitConfig { algorithm, repeats, ..config.clone() };
                fit(rows, None, None, &config)?.model
            }
        })
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Poly(0) => f.write_str("mean"),
            Self::Poly(1) => f.write_str("line"),
            Self::Poly(_) => f.write_str("cubic"),
            Self::Net(algorithm) => write!(f, "net, {}", algorithm.name()),
            Self::Gp => f.write_str("Gaussian process"),
        }
    }
}

/// One way on one form of the target.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tried {
    /// The way.
    #[serde(serialize_with = "shown")]
    pub learner: Way,
    /// `identity`, `ln` or `reciprocal`: what is learned of the target.
    #[serde(serialize_with = "shown")]
    pub target: Transform,
    /// On rows held out, raw; none where it could not be trained.
    pub held_out: Option<Score>,
    /// Why not.
    pub refused: Option<String>,
}

fn shown<T: fmt::Display, S: serde::Serializer>(
    value: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

/// All that was tried and what is best.
#[derive(Debug, Clone, PartialEq)]
pub struct Auto {
    /// In the order of [`Way`], the target as asked for first.
    pub tried: Vec<Tried>,
    /// Place of the one to take: the simplest whose error is within two per cent of the least.
    pub chosen: usize,
    /// Why, in one sentence.
    pub reason: String,
    /// Folds of each deal.
    pub folds: usize,
}

/// Tries every way on every [form](DataSet::target_forms) of the target of `rows`. `config` has the shape of the nets, their epochs and
/// seed; the seed deals out the folds too. Errors are compared in the form asked for.
///
/// # Errors
/// [`OutlookError::Split`] for too few rows or groups; [`OutlookError::NoCandidate`] where nothing can be trained.
pub fn auto(
    rows: &DataSet,
    config: &FitConfig,
    done: &(dyn Fn() + Sync),
) -> Result<Auto, OutlookError> {
    let deals = if rows.rows() <= FEW { DEALS } else { 1 };
    let seeds = (0..deals).map(|deal| config.seed.wrapping_add(deal));
    let folds = |seed| match Split::folds(rows, FOLDS, seed) {
        Err(SplitError::TooFewGroups { groups, .. }) => Split::folds(rows, groups, seed),
        folds => folds,
    };
    let deals = seeds.map(folds).collect::<Result<Vec<_>, _>>()?;
    let (folds, splits) = (deals.first().map_or(0, Vec::len), deals.concat());
    let forms = rows.target_forms();
    let ways = Way::all();
    // The mean of a logarithm is no baseline.
    let fits = |way: Way, form: usize| way != Way::Poly(0) || form == 0;
    let all: Vec<(Way, &DataSet)> = (ways.iter())
        .flat_map(|way| forms.iter().enumerate().map(move |(at, form)| (*way, at, form)))
        .filter_map(|(way, at, form)| fits(way, at).then_some((way, form)))
        .collect();
    let tried: Vec<Tried> = all
        .par_iter()
        .map(|&(learner, form)| {
            let held_out = cross_validated(learner, rows, form, &splits, config);
            done();
            let refused = held_out.as_ref().err().map(ToString::to_string);
            Tried { learner, target: form.targets[0].transform, held_out: held_out.ok(), refused }
        })
        .collect();
    let error = |tried: &Tried| tried.held_out.map_or(f64::INFINITY, |score| score.scaled_mse);
    let least = tried.iter().map(error).fold(f64::INFINITY, f64::min);
    let chosen =
        tried.iter().position(|tried| error(tried) <= AS_GOOD * least && least.is_finite());
    let chosen = chosen.ok_or(OutlookError::NoCandidate { candidates: tried.len() })?;
    let reason = reason(&tried, chosen, &error);
    Ok(Auto { tried, chosen, reason, folds })
}

/// Number of trials that [`auto`] makes at most.
#[must_use]
pub fn count() -> usize {
    3 * Way::all().len() - 2
}

fn reason(tried: &[Tried], chosen: usize, error: &dyn Fn(&Tried) -> f64) -> String {
    let least = tried.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
    let found = error(&tried[chosen]);
    let simple = tried.iter().filter(|tried| matches!(tried.learner, Way::Poly(_)));
    let simple = simple.map(error).fold(f64::INFINITY, f64::min);
    match tried[chosen].learner {
        Way::Poly(0) => {
            "nothing in these columns predicts the target better than its mean".to_owned()
        }
        _ if least.is_some_and(|least| error(least) < found) => {
            "the simplest within 2 % of the least error on rows held out".to_owned()
        }
        Way::Poly(_) => "the least error on rows held out".to_owned(),
        _ => {
            let less = 100.0 * (1.0 - found / simple);
            format!(
                "the least error on rows held out, {less:.0} % below the best of mean, line and cubic"
            )
        }
    }
}

/// Every row once a deal, answered by what never saw it.
fn cross_validated(
    way: Way,
    rows: &DataSet,
    form: &DataSet,
    splits: &[Split],
    config: &FitConfig,
) -> Result<Score, OutlookError> {
    // All rows may be too many for what the folds can fit.
    if way == Way::Gp {
        Gp::fits(rows.rows())?;
    }
    let limits = rows.target_scalings();
    let scores = splits
        .par_iter()
        .map(|split| {
            let learner = way.learn(&form.subset(&split.train)?, config)?;
            score(learner.as_ref(), &rows.subset(&split.held_out)?, &limits)
        })
        .collect::<Result<Vec<Score>, OutlookError>>()?;
    let all: usize = scores.iter().map(|score| score.rows).sum();
    let mean = |of: fn(&Score) -> f64| {
        scores.iter().map(|score| score.rows as f64 * of(score)).sum::<f64>() / all as f64
    };
    let mse = mean(|score| score.mse);
    let variance = rows.target_values().columns().into_iter().map(|y| y.var(0.0)).sum::<f64>();
    let variance = variance / rows.targets.len() as f64;
    Ok(Score {
        rows: rows.rows(),
        mse,
        scaled_mse: mean(|score| score.scaled_mse),
        within_10pct: mean(|score| score.within_10pct),
        r2: (variance > 0.0 && rows.targets.len() == 1).then(|| 1.0 - mse / variance),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mlp::train::RunConfig;

    fn rows(y: impl Fn(f64, f64) -> f64) -> DataSet {
        let mut state = 1_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f64::from(u32::try_from(state >> 33).unwrap()) / f64::from(1_u32 << 31) - 0.5
        };
        let row = |_: usize| {
            let (x, noise) = (unit(), unit());
            format!("{x},{}\n", y(x, noise))
        };
        let csv = format!("x,y\n{}", (0..60).map(row).collect::<String>());
        let spec = |name: &str| vec![name.parse().unwrap()];
        DataSet::from_csv("a.csv", csv.as_bytes(), &spec("x"), &spec("y")).unwrap()
    }

    fn chosen(y: impl Fn(f64, f64) -> f64) -> (String, Transform, Auto) {
        let run = RunConfig { epochs: 60, ..RunConfig::default() };
        let config = FitConfig { seed: 3, hidden: vec![5], run, ..FitConfig::default() };
        let auto = auto(&rows(y), &config, &|| ()).unwrap();
        let Tried { learner, target, .. } = &auto.tried[auto.chosen];
        (learner.to_string(), *target, auto)
    }

    #[test]
    fn the_simplest_that_holds_is_chosen() {
        let (name, _, auto) = chosen(|_, noise| noise);
        assert_eq!((name.as_str(), auto.tried.len()), ("mean", 7), "{auto:?}");
        assert_eq!(chosen(|x, noise| 3.0 * x + 0.1 * noise).0, "line");
        assert_eq!(chosen(|x, noise| (2.0 + 4.0 * x + 0.1 * noise).exp()).1, Transform::Ln);
        let (name, _, auto) = chosen(|x, noise| (9.0 * x).sin() + 0.05 * noise);
        assert!(["net, br", "Gaussian process"].contains(&name.as_str()), "{name}");
        assert!(auto.reason.contains("% below") || auto.reason.contains("simplest"), "{auto:?}");
    }
}
