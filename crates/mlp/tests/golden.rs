//! Trainers on recorded sets: against error curves of an independent double-precision implementation, how many of twenty given
//! starts reach the goal, and against the published error of building1.
//!
//! Rules of the first order are in `tests/reference.rs`, weight by weight. The data have no licence and lie outside the repository:
//! in the folder `GRIP_DATA`, or in `shared/data` beside it; `src/train/trainer/tests.rs` needs none.
//!
//! The files of surface2 hold nine digits, the golden curves come from unrounded data: both part by 2e-10 at epoch 0
//! already. Rules that build on curvature magnify that; `parting_is_no_more_than_the_rounding_of_the_data`
//! shows that nothing else is magnified.

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use mlp::train::trainer::{Damping, LevenbergMarquardtConfig, ScgConfig};
    use mlp::train::{
        Algorithm, DataSet, NetworkObjective, Objective as _, Real, Run, RunConfig, Stop, Topology,
        Training, init::nguyen_widrow, run,
    };
    use ndarray::Array2;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng as _, SeedableRng as _};

    /// The folder `learning` of the test data.
    fn learning() -> PathBuf {
        let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
        let folder = std::env::var_os("GRIP_DATA").map_or_else(beside, PathBuf::from);
        let folder = folder.join("learning");
        assert!(folder.is_dir(), "no folder {}: set GRIP_DATA", folder.display());
        folder
    }

    fn read(name: &str, inputs: &[&str], targets: &[&str]) -> DataSet {
        let bytes = std::fs::read(learning().join(name)).unwrap();
        let [inputs, targets] = [inputs, targets]
            .map(|names| names.iter().map(|name| name.parse().unwrap()).collect::<Vec<_>>());
        DataSet::from_csv(name, &bytes, &inputs, &targets).unwrap()
    }

    /// Training rows of `surface2` for a 2-10-1 network: inputs and scaled targets.
    struct Surface2 {
        topology: Topology,
        rows: [Array2<f64>; 2],
    }

    fn surface2() -> Surface2 {
        let data = read("surface2_train.csv", &["x1", "x2"], &["y"]);
        // Inputs lie in [-1, 1] already and are used as they are.
        let [_, targets] = data.scaled(&data.input_scalings(), &data.target_scalings());
        let topology = Topology::regression(2, &[10], 1).unwrap();
        Surface2 { topology, rows: [data.input_values().to_owned(), targets] }
    }

    impl Surface2 {
        fn objective<T: Real>(&self) -> NetworkObjective<T> {
            let [inputs, targets] = &self.rows;
            NetworkObjective::new(&self.topology, inputs, targets).unwrap()
        }

        /// The same rows, each value moved by up to half a unit of its ninth decimal.
        fn moved_within_rounding(&self, seed: u64) -> Self {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut shift = || f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5;
            let rows =
                self.rows.each_ref().map(|values| values.map(|value| value + 1e-9 * shift()));
            Self { topology: self.topology.clone(), rows }
        }

        fn error_after(&self, algorithm: Algorithm, start: usize, epochs: usize) -> f64 {
            let (mut weights, mut objective) = (starting(start), self.objective());
            let mut trainer = algorithm.trainer(weights.len());
            for _ in 0..epochs {
                trainer.step(&mut objective, &mut weights);
            }
            objective.mse(&weights)
        }
    }

    /// Starting weights number `start`.
    fn starting(start: usize) -> Vec<f64> {
        let path = learning().join(format!("starts/surface2_2-10-1_{start}.txt"));
        let text = std::fs::read_to_string(path).unwrap();
        text.split_whitespace().map(|number| number.parse().unwrap()).collect()
    }

    /// Start, epoch and training error of each row of the golden file with this label.
    fn golden(label: &str) -> Vec<(usize, usize, f64)> {
        let text = std::fs::read_to_string(learning().join("golden.csv")).unwrap();
        let rows: Vec<_> = text
            .lines()
            .map(|line| line.split(',').collect::<Vec<_>>())
            .filter(|fields| fields[0] == label)
            .map(|f| (f[1].parse().unwrap(), f[2].parse().unwrap(), f[3].parse().unwrap()))
            .collect();
        assert!(!rows.is_empty(), "no golden rows for {label}");
        rows
    }

    /// The rules of the golden curves.
    const SCG: Algorithm = Algorithm::Scg(ScgConfig { sigma: None, lambda: 5e-7 });
    const LM: Algorithm =
        Algorithm::Lm(LevenbergMarquardtConfig { damping: Damping::Factors, mu: 0.001 });

    /// Compares the starts 0-4 at every golden epoch: epochs, and the largest relative deviation up to and including them.
    fn compare(label: &str, algorithm: Algorithm, bounds: &[(usize, f64)]) {
        let surface = surface2();
        for (start, epoch, expected) in golden(label) {
            let got = surface.error_after(algorithm, start, epoch);
            let deviation = (got / expected - 1.0).abs();
            eprintln!("{label} start {start} epoch {epoch}: {got:.9e}, deviation {deviation:.1e}");
            let (_, bound) = bounds.iter().find(|(until, _)| epoch <= *until).unwrap();
            assert!(deviation <= *bound, "deviation {deviation:e} > {bound}");
        }
    }

    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn curves_are_those_of_an_independent_implementation() {
        compare("scg", SCG, &[(10, 5e-9), (20, 5e-7), (50, 5e-6), (100, 1e-2)]);
        compare("lm", LM, &[(1, 5e-9), (5, 5e-7), (20, 5e-6), (100, 5e-8)]);
    }

    /// The curves of data moved within their rounding spread about as far as the golden curve lies away.
    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn parting_is_no_more_than_the_rounding_of_the_data() {
        let surface = surface2();
        for (label, algorithm) in [("scg", SCG), ("lm", LM)] {
            for (start, epoch, expected) in golden(label) {
                let own = surface.error_after(algorithm, start, epoch);
                let spread = (0..8)
                    .map(|seed| surface.moved_within_rounding(seed))
                    .map(|moved| moved.error_after(algorithm, start, epoch))
                    .map(|other| (other - own).abs())
                    .fold(0.0, f64::max);
                let ratio = (own - expected).abs() / spread;
                eprintln!(
                    "{label} start {start} epoch {epoch}: {ratio:.2} of the spread {spread:.1e}"
                );
                assert!(ratio < 3.0, "{label} start {start} epoch {epoch}: {ratio}");
            }
        }
    }

    fn all_reach<T: Real>(algorithm: &str, epochs: usize) {
        let surface = surface2();
        let config = RunConfig { epochs, goal: 2.5e-3, ..RunConfig::default() };
        let one = |start: usize| {
            let mut objective: NetworkObjective<T> = surface.objective();
            let weights: Vec<T> = starting(start).into_iter().map(T::of).collect();
            let mut trainer = algorithm.parse::<Algorithm>().unwrap().trainer(weights.len());
            run(Training::new(trainer.as_mut(), &mut objective), weights, &config)
        };
        let runs: Vec<Run> = (0..20).map(one).collect();
        let reached = runs.iter().filter(|run| run.stop == Stop::Goal).count();
        let epochs: Vec<usize> = runs.iter().map(|run| run.epochs).collect();
        eprintln!("{algorithm} {}: {reached}/20, epochs {epochs:?}", T::NAME);
        assert_eq!(reached, 20, "{algorithm} {}", T::NAME);
    }

    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn the_goal_is_reached_from_every_start() {
        for (algorithm, epochs) in [("scg", 1000), ("lm", 40), ("lbfgs", 1000)] {
            all_reach::<f32>(algorithm, epochs);
            all_reach::<f64>(algorithm, epochs);
        }
    }

    /// 100 times the mean squared error on the test rows, and the epoch, of the best validation; 14 inputs, 16 hidden neurons.
    fn building1<T: Real>(parts: &[DataSet; 3], seed: u64) -> (f64, usize) {
        let topology = Topology::regression(14, &[16], 3).unwrap();
        // Used as they are: Proben1 has scaled them already.
        let [mut rows, mut validation, mut test] = parts.each_ref().map(|part| {
            let [x, y] = [part.input_values(), part.target_values()];
            NetworkObjective::<T>::new(&topology, &x, &y).unwrap()
        });
        let weights: Vec<T> = nguyen_widrow(&topology, seed).into_iter().map(T::of).collect();
        let mut trainer = "rprop".parse::<Algorithm>().unwrap().trainer(weights.len());
        let config = RunConfig { epochs: 3000, max_fail: 500, ..RunConfig::default() };
        let training = Training::new(trainer.as_mut(), &mut rows);
        let training = Training { validation: Some(&mut validation), ..training };
        let run = run(training, weights, &config);
        let best: Vec<T> = run.weights.iter().map(|&w| T::of(w)).collect();
        (100.0 * test.mse(&best), run.best_epoch)
    }

    fn below_the_published_error<T: Real>(parts: &[DataSet; 3], starts: u64) {
        let runs = (0..starts).map(|seed| building1::<T>(parts, seed));
        let (errors, epochs): (Vec<f64>, Vec<usize>) = runs.unzip();
        let mean = errors.iter().sum::<f64>() / starts as f64;
        let squares = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>();
        let deviation = (squares / (starts - 1) as f64).sqrt();
        eprintln!(
            "building1 {}: {mean:.3} +- {deviation:.3}, {starts} starts, epochs {epochs:?}",
            T::NAME
        );
        assert!(mean <= 0.75, "{mean} +- {deviation}");
    }

    /// Proben1 (Prechelt 1994) with its own partition. Its error for RPROP with linear outputs and the best of the validation, 100
    /// times the mean squared error over rows and outputs, is 1.36 +- 0.63.
    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn improved_rprop_stays_below_the_published_error_of_building1() {
        let inputs: Vec<String> = (1..=14).map(|at| format!("x{at}")).collect();
        let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
        let parts = ["train", "valid", "test"].map(|part| {
            let name = format!("building1_{part}.csv");
            read(&name, &inputs, &["energy", "hot_water", "cold_water"])
        });
        below_the_published_error::<f32>(&parts, 10);
        below_the_published_error::<f64>(&parts, 4);
    }
}
