//! The sentences of the source study on its Figs. 3 to 7 and Tables 1 and 2, each held against many draws of rows.
//!
//! Every net is trained from every start on every draw, and the run nearest the average is kept, as in the study. Then each
//! claim is true or not for a draw. Goal and number of epochs are not in the study: without a goal of its own a claim about it is
//! true where some goal makes it so.

mod sentences;

use self::sentences::CLAIMS;
use super::training::{Trained, train};
use super::{HEAVY_BALL, NETS, Net, Progress, StudyConfig};
use crate::{Cell, Condition, Report, Scores, Section, StudyError, Table, Tolerance};
use mlp::train::{Hyper, Run, Stop};
use rayon::iter::{IntoParallelIterator as _, IntoParallelRefIterator as _, ParallelIterator as _};
use serde::Serialize;
use serde_json::json;
use statrs::distribution::{Binomial, DiscreteCDF as _};

/// Learning rates of the sweep: from too small for any training to beyond what is stable.
pub const RATES: [f64; 9] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];

/// The conditions under which claims are judged: the physics with and without noise, and the targets by Eq. 1.
pub const CONDITIONS: [&str; 6] =
    ["fixed-0", "paper", "eq1", "eq1-slope", "eq1-surface", "eq1-trial"];

/// What `slightly` and `similar` mean: by a quarter.
const SIMILAR: f64 = 1.25;
/// An error that rises by so much above its least was not stable.
const RISE: f64 = 1.1;
/// Falling by so much over the last tenth of the epochs is no rest.
const STILL_FALLING: f64 = 0.99;

/// One net on one draw.
#[derive(Clone, Debug)]
struct Kept {
    /// Training error of the kept run, scaled.
    mse: f64,
    scores: Scores,
    reached_goal: bool,
    /// Errors after each epoch.
    history: Vec<f64>,
    /// Starts whose error still fell at the end.
    still_falling: f64,
}

/// GD at one rate.
#[derive(Clone, Debug, Serialize)]
pub struct AtRate {
    /// The rate.
    pub rate: f64,
    /// Mean training error over the starts, scaled.
    pub mse: f64,
    /// Share of the starts whose error rose.
    pub unstable: f64,
}

/// What one draw shows.
#[derive(Clone, Debug)]
struct Draw {
    /// M1 to M4.
    nets: [Kept; 4],
    heavy: Kept,
    sweep: Vec<AtRate>,
    goal: bool,
}

/// A sentence of the study.
struct Claim {
    place: &'static str,
    /// In our words.
    claim: &'static str,
    /// What makes it true for a draw.
    measured: &'static str,
    /// Nothing where the draw does not decide.
    holds: fn(&Draw) -> Option<bool>,
}

slip_msg::named! {
    /// Verdicts over many draws.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Verdict {
        fn title: "As people read it.";
    }
    Reproduced: "True for most draws under every condition.", "reproduced";
    Refuted: "False for most draws under every condition.", "refuted";
    Undecided: "Neither.", "cannot be decided";
}

impl Verdict {
    /// Of one condition: whether more, or fewer, than half of all draws of its kind make the claim true (sign test, 2.5 % each way).
    #[must_use]
    pub fn of(holds: usize, draws: usize) -> Self {
        let Ok(fair) = Binomial::new(0.5, draws as u64) else { return Self::Undecided };
        let fewer = holds.checked_sub(1).map_or(0.0, |fewer| fair.cdf(fewer as u64));
        if 1.0 - fewer < 0.025 {
            Self::Reproduced
        } else if fair.cdf(holds as u64) < 0.025 {
            Self::Refuted
        } else {
            Self::Undecided
        }
    }
}

/// A claim with the draws that decide it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// Its place in the study.
    pub place: &'static str,
    /// The claim in our words.
    pub claim: &'static str,
    /// What makes it true for a draw.
    pub measured: &'static str,
    /// Condition, draws for which it is true, draws that decide.
    pub draws: Vec<(&'static str, usize, usize)>,
    /// Over all conditions.
    pub verdict: Verdict,
}

/// What a net shows, mean of the draws.
#[derive(Clone, Debug, Serialize)]
pub struct NetMeans {
    /// `M1` to `M4`, and `M2b`.
    pub net: &'static str,
    /// Epochs of the run kept.
    pub epochs: f64,
    /// Its training error (scaled).
    pub mse: f64,
    /// The same, and that on the test rows (N^2).
    pub mse_n2: [f64; 2],
    /// Shares of training and test rows within 10 %.
    pub within_10pct: [f64; 2],
}

/// Means of the draws under a condition.
#[derive(Clone, Debug, Serialize)]
pub struct ConditionMeans {
    /// Its name.
    pub condition: &'static str,
    /// The nets.
    pub nets: Vec<NetMeans>,
    /// M1 at each of [`RATES`].
    pub sweep: Vec<AtRate>,
}

impl ConditionMeans {
    fn of(condition: &Condition, draws: &[Draw]) -> Self {
        let mean =
            |of: &dyn Fn(&Draw) -> f64| draws.iter().map(of).sum::<f64>() / draws.len() as f64;
        let nets = NETS[..4].iter().chain([&HEAVY_BALL]).enumerate().map(|(at, net)| {
            let mean = |what: &dyn Fn(&Kept) -> f64| {
                mean(&|draw| what(draw.nets.get(at).unwrap_or(&draw.heavy)))
            };
            NetMeans {
                net: net.name,
                epochs: mean(&|net| (net.history.len() - 1) as f64),
                mse: mean(&|net| net.mse),
                mse_n2: [mean(&Kept::train_mse), mean(&Kept::test_mse)],
                within_10pct: [mean(&Kept::train_share), mean(&Kept::test_share)],
            }
        });
        let sweep = RATES.iter().enumerate().map(|(at, rate)| AtRate {
            rate: *rate,
            mse: mean(&|draw| draw.sweep[at].mse),
            unstable: mean(&|draw| draw.sweep[at].unstable),
        });
        Self { condition: condition.name, nets: nets.collect(), sweep: sweep.collect() }
    }
}

/// Every claim, judged, and the sweep of the learning rate.
#[derive(Clone, Debug)]
pub struct Claims {
    config: StudyConfig,
    /// In the order of the study.
    pub judged: Vec<Judged>,
    draws: Vec<(Condition, Vec<Draw>)>,
}

impl StudyConfig {
    /// What claims are judged by: 20 draws of rows, 20 starts of each net.
    #[must_use]
    pub fn claims(seed: u64) -> Self {
        let conditions = CONDITIONS.iter().filter_map(|name| Condition::named(name)).collect();
        Self { draws: 20, conditions, ..Self::full(seed) }
    }

    /// Trainings that [`judge`] takes.
    #[must_use]
    pub fn claim_trainings(&self) -> usize {
        self.conditions.len() * self.draws * self.repeats * (5 + RATES.len())
    }
}

/// Trains what the claims are about and judges them.
///
/// # Errors
/// As [`super::run`].
pub fn judge(config: &StudyConfig, progress: Progress<'_>) -> Result<Claims, StudyError> {
    config.check()?;
    let draws = config
        .conditions
        .iter()
        .map(|condition| {
            let draws = (0..config.draws as u64).into_par_iter();
            let draws = draws.map(|at| draw(condition, at, config, progress));
            Ok((*condition, draws.collect::<Result<Vec<_>, StudyError>>()?))
        })
        .collect::<Result<Vec<_>, StudyError>>()?;
    let judged = CLAIMS.iter().map(|claim| claim.judge(&draws)).collect();
    Ok(Claims { config: config.clone(), judged, draws })
}

impl Claim {
    fn judge(&self, draws: &[(Condition, Vec<Draw>)]) -> Judged {
        let count = |(condition, draws): &(Condition, Vec<Draw>)| {
            let reported: Vec<bool> = draws.iter().filter_map(self.holds).collect();
            (condition.name, reported.iter().filter(|holds| **holds).count(), reported.len())
        };
        let draws: Vec<_> = draws.iter().map(count).collect();
        // A condition that decides nothing leaves the claim open.
        let reported: Vec<Verdict> =
            draws.iter().map(|(_, holds, draws)| Verdict::of(*holds, *draws)).collect();
        let verdict = match reported.split_first() {
            Some((first, others)) if others.iter().all(|other| other == first) => *first,
            _ => Verdict::Undecided,
        };
        let Self { place, claim, measured, .. } = *self;
        Judged { place, claim, measured, draws, verdict }
    }
}

fn draw(
    condition: &Condition,
    at: u64,
    config: &StudyConfig,
    progress: Progress<'_>,
) -> Result<Draw, StudyError> {
    let sets = condition.sets(config.seed, at)?;
    let kept = |net: &Net| train(condition, net, &sets, config, progress).map(Kept::of);
    let [m1, m2, m3, m4, ..] = &NETS;
    let nets = [kept(m1)?, kept(m2)?, kept(m3)?, kept(m4)?];
    let sweep = RATES
        .par_iter()
        .map(|&rate| {
            let hyper = Hyper { rate: Some(rate), ..config.hyper };
            let config = StudyConfig { hyper, goal: 0.0, ..config.clone() };
            Ok(AtRate::of(rate, &train(condition, m1, &sets, &config, progress)?))
        })
        .collect::<Result<Vec<_>, StudyError>>()?;
    Ok(Draw { nets, heavy: kept(&HEAVY_BALL)?, sweep, goal: config.goal > 0.0 })
}

fn share(runs: &[Run], of: impl Fn(&Run) -> bool) -> f64 {
    runs.iter().filter(|run| of(run)).count() as f64 / runs.len() as f64
}

impl Kept {
    fn of(trained: Trained) -> Self {
        let Trained { summary, scores, fit } = trained;
        let falls = |run: &Run| {
            let last = run.history.len() - 1;
            run.history[last] < STILL_FALLING * run.history[last - last / 10]
        };
        let still_falling = share(&fit.runs, falls);
        let run = &fit.runs[fit.chosen];
        let (reached_goal, history) = (run.stop == Stop::Goal, run.history.clone());
        Self { mse: summary.mse, scores, reached_goal, history, still_falling }
    }

    /// Epochs until its error is at most `mse`.
    fn epochs_to(&self, mse: f64) -> Option<usize> {
        self.history.iter().position(|error| *error <= mse)
    }

    fn train_share(&self) -> f64 {
        self.scores.train.share(Tolerance::Relative10)
    }

    fn test_share(&self) -> f64 {
        self.scores.test.share(Tolerance::Relative10)
    }

    fn train_mse(&self) -> f64 {
        self.scores.train.mse
    }

    fn test_mse(&self) -> f64 {
        self.scores.test.mse
    }
}

impl AtRate {
    fn of(rate: f64, trained: &Trained) -> Self {
        let rises = |run: &Run| {
            let mut least = f64::INFINITY;
            let risen = run.history.iter().any(|error| {
                least = least.min(*error);
                *error > RISE * least || !error.is_finite()
            });
            risen || matches!(run.stop, Stop::Diverged { .. })
        };
        Self { rate, mse: trained.summary.mean, unstable: share(&trained.fit.runs, rises) }
    }
}

/// Whether `values` fall from the first to the last.
fn falling(values: [f64; 4]) -> bool {
    values.windows(2).all(|pair| pair[0] > pair[1])
}

/// Whether the largest is at most a quarter above the least.
fn similar(values: &[f64]) -> bool {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    values.iter().all(|value| *value <= SIMILAR * least)
}

impl Draw {
    /// Whether M4 stops at the goal and the others at the last epoch; without a goal, whether one makes them do so.
    fn m4_alone_reaches_a_goal(&self) -> bool {
        let [m1, m2, m3, m4] = &self.nets;
        if self.goal {
            return m4.reached_goal && ![m1, m2, m3].iter().any(|net| net.reached_goal);
        }
        [m1, m2, m3].iter().all(|net| m4.mse < net.mse)
    }

    fn m3_has_the_lowest_training_error(&self) -> bool {
        let [m1, m2, m3, m4] = &self.nets;
        [m1, m2, m4].iter().all(|net| m3.train_mse() < net.train_mse())
    }

    /// Epochs that `net` needs for the error at which M1 ends, over those of M1.
    fn over_m1(&self, net: &Kept) -> Option<f64> {
        let m1 = &self.nets[0];
        let epochs = |net: &Kept| net.epochs_to(m1.mse).map(|epochs| epochs.max(1) as f64);
        Some(epochs(net).unwrap_or(f64::INFINITY) / epochs(m1)?)
    }

    fn by_table_2(&self, of: fn(&Kept) -> f64) -> bool {
        let [m1, m2, m3, m4] = &self.nets;
        falling([m3, m4, m1, m2].map(of))
    }

    fn best_rate(&self) -> f64 {
        self.sweep.iter().map(|at| at.mse).fold(f64::INFINITY, f64::min)
    }
}

impl StudyConfig {
    /// What the report of a study of this size judges claims by: 6 draws, the fewest that can decide, and at most 10 starts;
    /// `--claims` takes 20 of both.
    #[must_use]
    pub fn claims_beside(&self) -> Self {
        let claims = Self::claims(self.seed);
        let repeats = self.repeats.min(10);
        Self { draws: 6, repeats, conditions: claims.conditions, ..self.clone() }
    }
}

impl Claims {
    /// The table of claims.
    #[must_use]
    pub fn table(&self) -> Table {
        let names: Vec<&str> = self.draws.iter().map(|(condition, _)| condition.name).collect();
        let heads =
            [&["where", "claim", "verdict"][..], &names, &["true for a draw where"]].concat();
        let caption = format!(
            "Claims of the source study: draws (of {}, {} starts, at most {} epochs) for which they are true; a dash where no draw decides",
            self.config.draws, self.config.repeats, self.config.epochs
        );
        let mut table = Table::new("claims", caption, &heads);
        for judged in &self.judged {
            let count = |(_, holds, draws): &(&str, usize, usize)| match draws {
                0 => Cell::Empty,
                _ if *draws == self.config.draws => Cell::Count(*holds),
                _ => Cell::text(format!("{holds} of {draws}")),
            };
            let mut row = vec![
                Cell::text(judged.place),
                Cell::text(judged.claim),
                Cell::text(judged.verdict.title()),
            ];
            row.extend(judged.draws.iter().map(count));
            row.push(Cell::text(judged.measured));
            table.push(row);
        }
        table
    }

    /// Mean over the draws of what the runs kept show (Fig. 7, Table 2), and of M1 at every learning rate: one row a condition.
    #[must_use]
    pub fn means(&self) -> Vec<ConditionMeans> {
        self.draws.iter().map(|(condition, draws)| ConditionMeans::of(condition, draws)).collect()
    }

    /// The report.
    #[must_use]
    pub fn report(&self) -> Report {
        let StudyConfig { seed, draws, repeats, epochs, goal, hidden, .. } = self.config;
        let goal = if goal > 0.0 { format!("goal {goal}") } else { "no goal".to_owned() };
        let method = format!(
            "{draws} draws of 100 training and 60 test rows, {repeats} starts of each net on each, 2-{hidden}-1, at most {epochs} \
             epochs, {goal}, seed {seed}; of the starts the run nearest the average training error counts. A claim is \
             reproduced (refuted) where under every condition more (fewer) than half of all such draws make it \
             true (sign test, 2.5 % each way): 15 (5) of 20 draws or more (fewer)."
        );
        let section =
            Section::new("claims", "Claims of the source study").with(method).with(self.table());
        let mut report =
            Report { title: "The source study, claim by claim".to_owned(), ..Report::default() };
        report.fields.insert("type".to_owned(), "claims".into());
        report.fields.insert("claims".to_owned(), json!(self.judged));
        report.fields.insert("means".to_owned(), json!(self.means()));
        report.push(section);
        report
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_draws_decide_nothing() {
        let verdicts = [0, 5, 6, 10, 14, 15, 20].map(|holds| Verdict::of(holds, 20));
        use Verdict::{Refuted, Reproduced, Undecided};
        assert_eq!(
            verdicts,
            [Refuted, Refuted, Undecided, Undecided, Undecided, Reproduced, Reproduced]
        );
        assert_eq!((Verdict::of(1, 1), Verdict::of(0, 0)), (Undecided, Undecided));
        let beside = StudyConfig::claims(1).claims_beside().draws;
        let verdicts = [beside, 0].map(|holds| Verdict::of(holds, beside));
        assert_eq!(verdicts, [Reproduced, Refuted], "those of a report can decide");
    }

    #[test]
    fn claims_are_judged_by_every_draw() {
        let conditions = ["paper", "eq1-surface"].map(|name| Condition::named(name).unwrap());
        let config = StudyConfig {
            draws: 2,
            repeats: 3,
            epochs: 60,
            conditions: conditions.to_vec(),
            ..StudyConfig::claims(7)
        };
        let claims = judge(&config, &|| ()).unwrap();
        let goal = claims.judged.iter().find(|judged| judged.place == "Figs. 3-7").unwrap();
        assert!(goal.draws.iter().all(|(_, holds, draws)| (*holds, *draws) == (0, 2)), "{goal:?}");
        let rates = &claims.judged[0];
        assert_eq!(rates.draws[0], ("paper", 2, 2), "a rate of 10 is unstable");
        assert_eq!(claims.table().rows.len(), CLAIMS.len());
        assert!(claims.report().html().unwrap().contains("eq1-surface"));
        let again = judge(&config, &|| ()).unwrap();
        assert_eq!(again.report().json(), claims.report().json());
        // A goal that every net reaches at once: nobody ends at the last epoch.
        let easy = judge(&StudyConfig { goal: 100.0, ..config }, &|| ()).unwrap();
        let stops = easy.judged.iter().find(|judged| judged.place == "Figs. 3-6").unwrap();
        assert!(stops.draws.iter().all(|(_, holds, _)| *holds == 0), "{stops:?}");
    }
}
