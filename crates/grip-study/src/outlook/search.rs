//! Search for a net by a genetic algorithm, on training and validation rows.
//!
//! A genome is the widths of one or two hidden layers, their activation function, the trainer and the weight decay
//! ([`Genome`]). Its cost is the validation error of the best epoch, averaged over a few starts, times
//! `1 + size_cost * weights`: a net may be larger by a hundred weights only where that lowers the error by more than a hundred
//! times `size_cost`. Selection by tournament, uniform crossover and mutation of single genes come from the crate
//! `genetic_algorithm`. Equal seeds give equal searches on any number of threads.

use core::fmt;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use genetic_algorithm::strategy::evolve::prelude::{
    CrossoverUniform, Evolve, Fitness, FitnessChromosome, FitnessGenotype, FitnessOrdering,
    FitnessValue, Genotype as _, MultiListGenotype, MutateSingleGene, SelectTournament,
    StrategyConfig, StrategyReporter, StrategyState,
};
use mlp::train::fit::Fitting;
use mlp::train::{DataSet, Fit, FitConfig, RunConfig, fit};

use super::genome::Genome;
use super::score::OutlookError;

/// Settings of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchConfig {
    /// Generations after the first population, at least 1. Default 12.
    pub generations: usize,
    /// Genomes in a population, at least 4. Default 24.
    pub population: usize,
    /// Seed of the genetic algorithm. Default 0.
    pub seed: u64,
    /// Relative error that one more weight must earn, 0 or more. Default 0.001.
    pub size_cost: f64,
    /// How each candidate is trained; shape, activation, rule and decay are those of the genome. Default 300 epochs,
    /// validation patience 40, 3 starts.
    pub fit: FitConfig,
}

impl Default for SearchConfig {
    fn default() -> Self {
        let run = RunConfig { epochs: 300, max_fail: 40, ..RunConfig::default() };
        let fit = FitConfig { run, repeats: 3, ..FitConfig::default() };
        Self { generations: 12, population: 24, seed: 0, size_cost: 1e-3, fit }
    }
}

/// A genome that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The net and its training.
    pub genome: Genome,
    /// Weights and biases of the net.
    pub weights: usize,
    /// Mean squared validation error in scaled units: mean over the starts of each one's best epoch.
    pub validation_mse: f64,
    /// The same of the best start.
    pub best_mse: f64,
    /// Seed of that start.
    pub best_seed: u64,
    /// What the search minimised.
    pub cost: f64,
}

/// How far a search has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Generation {
    /// Generations done.
    pub done: usize,
    /// Different genomes tried so far.
    pub tried: usize,
    /// Least cost so far.
    pub cost: f64,
}

/// The outcome of a search.
#[derive(Debug, Clone)]
pub struct Search {
    /// All genomes with a finite error, the best first.
    pub candidates: Vec<Candidate>,
    /// Genomes whose training failed or diverged.
    pub failed: usize,
    /// State after each generation.
    pub generations: Vec<Generation>,
}

impl Search {
    /// The best candidate.
    ///
    /// # Errors
    /// [`OutlookError::NoCandidate`] where there is none.
    pub fn best(&self) -> Result<&Candidate, OutlookError> {
        self.candidates.first().ok_or(OutlookError::NoCandidate { candidates: self.failed })
    }

    /// Trains the best candidate again from its best start, as in the search.
    ///
    /// # Errors
    /// [`OutlookError::NoCandidate`] and [`OutlookError::Fit`].
    pub fn train_best(
        &self,
        train: &DataSet,
        validation: &DataSet,
        test: Option<&DataSet>,
        config: &SearchConfig,
    ) -> Result<Fit, OutlookError> {
        let best = self.best()?;
        let base = FitConfig { seed: best.best_seed, repeats: 1, ..config.fit.clone() };
        Ok(fit(train, Some(validation), test, &best.genome.config(&base))?)
    }
}

/// What the trials share.
struct Shared<'a> {
    train: &'a DataSet,
    validation: &'a DataSet,
    config: &'a SearchConfig,
    progress: &'a (dyn Fn(Generation) + Sync),
    tried: Mutex<Tried>,
}

#[derive(Default)]
struct Tried {
    candidates: BTreeMap<Vec<usize>, Option<Candidate>>,
    generations: Vec<Generation>,
}

impl fmt::Debug for Shared<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shared").field("config", self.config).finish_non_exhaustive()
    }
}

impl Shared<'_> {
    /// A trial that panicked has written nothing, so the memory stays good.
    fn tried(&self) -> std::sync::MutexGuard<'_, Tried> {
        self.tried.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn candidate(&self, genes: &[usize]) -> Option<Candidate> {
        let genome = Genome::from_genes(genes)?;
        let config = genome.config(&self.config.fit);
        let fitting = Fitting::new(self.train, Some(self.validation), &config).ok()?;
        let least = |repeat: usize| {
            let run = fitting.run(repeat);
            run.validation.get(run.best_epoch).copied().unwrap_or(f64::INFINITY)
        };
        let errors: Vec<f64> = (0..config.repeats).map(least).collect();
        let validation_mse = errors.iter().sum::<f64>() / errors.len() as f64;
        let best = errors.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let weights = fitting.weights();
        let cost = validation_mse * (1.0 + self.config.size_cost * weights as f64);
        cost.is_finite().then(|| Candidate {
            genome,
            weights,
            validation_mse,
            best_mse: *best.1,
            best_seed: config.seed.wrapping_add(best.0 as u64),
            cost,
        })
    }
}

#[derive(Clone, Copy, Debug)]
struct Trial<'a>(&'a Shared<'a>);

impl Fitness for Trial<'_> {
    type Genotype = MultiListGenotype<usize>;

    fn calculate_for_chromosome(
        &mut self,
        chromosome: &FitnessChromosome<Self>,
        _: &FitnessGenotype<Self>,
    ) -> Option<FitnessValue> {
        let genes = Genome::canonical(&chromosome.genes);
        let known = self.0.tried().candidates.get(&genes).cloned();
        let candidate = known.unwrap_or_else(|| {
            let candidate = self.0.candidate(&genes);
            self.0.tried().candidates.insert(genes, candidate.clone());
            candidate
        });
        candidate.map(|candidate| millionths(candidate.cost.max(1e-300).ln()))
    }
}

/// The crate compares whole numbers.
#[expect(clippy::cast_possible_truncation, reason = "a logarithm, so at most 7e8")]
fn millionths(value: f64) -> FitnessValue {
    (1e6 * value) as FitnessValue
}

#[derive(Clone, Copy)]
struct Watch<'a>(&'a Shared<'a>);

impl StrategyReporter for Watch<'_> {
    type Genotype = MultiListGenotype<usize>;

    fn on_generation_complete<S: StrategyState<Self::Genotype>, C: StrategyConfig>(
        &mut self,
        _: &Self::Genotype,
        state: &S,
        _: &C,
    ) {
        let mut tried = self.0.tried();
        let costs = tried.candidates.values().flatten().map(|candidate| candidate.cost);
        let generation = Generation {
            done: state.current_generation(),
            tried: tried.candidates.len(),
            cost: costs.fold(f64::INFINITY, f64::min),
        };
        tried.generations.push(generation);
        drop(tried);
        (self.0.progress)(generation);
    }
}

fn check(config: &SearchConfig) -> Result<(), OutlookError> {
    for (what, given, least, range) in [
        ("generations", config.generations, 1, "1 or more"),
        ("genomes in a population", config.population, 4, "4 or more"),
        ("starts of each candidate", config.fit.repeats, 1, "1 or more"),
    ] {
        if given < least {
            return Err(OutlookError::Count { what, given, range });
        }
    }
    if config.size_cost >= 0.0 && config.size_cost.is_finite() {
        return Ok(());
    }
    let (name, value) = ("size_cost", config.size_cost);
    Err(mlp::train::SettingError { name, value, range: "0 or a positive number" }.into())
}

/// Searches for the net with the least cost. `progress` is given each generation, from any thread.
///
/// # Errors
/// [`OutlookError::Count`] and [`OutlookError::Setting`] for settings out of range; [`OutlookError::Fit`] where the rows do not
/// fit; [`OutlookError::NoCandidate`] where every training failed.
pub fn search(
    train: &DataSet,
    validation: &DataSet,
    config: &SearchConfig,
    progress: &(dyn Fn(Generation) + Sync),
) -> Result<Search, OutlookError> {
    check(config)?;
    // What is wrong with the rows themselves is reported here, not counted as a failed candidate.
    Fitting::new(train, Some(validation), &config.fit)?;
    let tried = Mutex::new(Tried::default());
    let shared = Shared { train, validation, config, progress, tried };
    let alleles = Genome::ALLELES.map(|count| (0..count).collect()).to_vec();
    let failed = |message: &str| OutlookError::Search { message: message.to_owned() };
    let genotype = MultiListGenotype::builder()
        .with_allele_lists(alleles)
        .build()
        .map_err(|error| failed(error.0))?;
    Evolve::builder()
        .with_genotype(genotype)
        .with_target_population_size(config.population)
        .with_max_generations(config.generations)
        .with_fitness(Trial(&shared))
        .with_fitness_ordering(FitnessOrdering::Minimize)
        .with_par_fitness(true)
        .with_select(SelectTournament::new(0.5, 0.1, 4))
        .with_crossover(CrossoverUniform::new(0.7, 0.8))
        .with_mutate(MutateSingleGene::new(0.4))
        .with_reporter(Watch(&shared))
        .with_rng_seed_from_u64(config.seed)
        .call()
        .map_err(|error| failed(error.0))?;
    let tried = shared.tried.into_inner().unwrap_or_else(PoisonError::into_inner);
    let all = tried.candidates.len();
    let mut candidates: Vec<Candidate> = tried.candidates.into_values().flatten().collect();
    // The order of the genes decides between equals.
    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let search =
        Search { failed: all - candidates.len(), candidates, generations: tried.generations };
    search.best()?;
    Ok(search)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outlook::testing;

    fn config() -> SearchConfig {
        let run = RunConfig { epochs: 40, ..RunConfig::default() };
        let fit = FitConfig { run, repeats: 2, ..FitConfig::default() };
        SearchConfig { generations: 4, population: 8, fit, ..SearchConfig::default() }
    }

    fn find(config: &SearchConfig) -> Search {
        let (train, validation) = (testing::surface(60, 1), testing::surface(40, 2));
        search(&train, &validation, config, &|_| {}).unwrap()
    }

    #[test]
    fn a_search_improves_and_is_the_same_for_the_same_seed() {
        let found = find(&config());
        let first = found.generations[0].cost;
        let last = found.generations[found.generations.len() - 1];
        assert_eq!((last.done, found.generations.len()), (4, 4));
        assert!(found.best().unwrap().cost <= last.cost && last.cost <= first);
        assert!(
            found
                .candidates
                .windows(2)
                .all(|pair| { pair[0].cost <= pair[1].cost && pair[0].genome != pair[1].genome })
        );
        assert_eq!(found.candidates, find(&config()).candidates);
        let other = find(&SearchConfig { seed: 9, ..config() });
        assert_ne!(found.candidates, other.candidates);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(found.candidates, pool.install(|| find(&config())).candidates);
    }

    #[test]
    fn the_cost_is_the_error_with_a_price_on_each_weight() {
        for size_cost in [0.0, 0.05] {
            let found = find(&SearchConfig { size_cost, ..config() });
            for Candidate { genome, weights, validation_mse, best_mse, cost, .. } in
                &found.candidates
            {
                let wanted = validation_mse * (1.0 + size_cost * *weights as f64);
                assert!((cost / wanted - 1.0).abs() < 1e-12 && best_mse <= validation_mse);
                let sizes = [&[2][..], &genome.hidden, &[1]].concat();
                assert_eq!(*weights, mlp::weight_count(&sizes));
            }
        }
        let size =
            |size_cost: f64| find(&SearchConfig { size_cost, ..config() }).best().unwrap().weights;
        assert!(size(1.0) <= size(0.0));
    }

    #[test]
    fn the_best_start_is_trained_again_bit_by_bit() {
        let (train, validation) = (testing::surface(60, 1), testing::surface(40, 2));
        let config = config();
        let found = search(&train, &validation, &config, &|_| {}).unwrap();
        let fit = found.train_best(&train, &validation, Some(&validation), &config).unwrap();
        let best = found.best().unwrap();
        let run = &fit.runs[0];
        assert_eq!(run.validation[run.best_epoch].to_bits(), best.best_mse.to_bits());
        assert!(fit.test.unwrap().scaled_mse.is_finite());
        assert_eq!(fit.file.training.unwrap().algorithm, best.genome.algorithm.name());
    }
}
