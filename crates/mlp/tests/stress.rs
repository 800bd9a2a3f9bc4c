//! Rows and weights that break trainers: each ends with a stated reason and finite weights, in both precisions.

#[cfg(test)]
mod tests {
    use mlp::Activation;
    use mlp::train::trainer::{
        Damping, GradientDescentConfig, LevenbergMarquardtConfig, ScgConfig,
    };
    use mlp::train::{
        Algorithm, DataSet, FitConfig, ModelFile, NetworkObjective, Precision, Real, Run,
        RunConfig, Stop, Topology, Training, file::FileLayer, fit, init::nguyen_widrow, run,
    };

    use ndarray::{Array2, Axis, concatenate};

    fn topology() -> Topology {
        Topology::regression(2, &[4], 1).unwrap()
    }

    /// Inputs and targets.
    type Rows = [Array2<f64>; 2];

    fn rows(count: usize) -> Rows {
        let t = |row: usize| row as f64 * 0.7;
        let input = |(row, column)| if column == 0 { t(row).sin() } else { (1.3 * t(row)).cos() };
        let target = |(row, _)| 0.5 * (t(row).sin() * 2.0).sin();
        [Array2::from_shape_fn((count, 2), input), Array2::from_shape_fn((count, 1), target)]
    }

    fn objective<T: Real>(topology: &Topology, [inputs, targets]: &Rows) -> NetworkObjective<T> {
        NetworkObjective::new(topology, inputs, targets).unwrap()
    }

    fn train<T: Real>(algorithm: Algorithm, patterns: &Rows, weights: &[f64]) -> Run {
        train_net::<T>(&topology(), weights, algorithm, patterns, 200)
    }

    fn train_net<T: Real>(
        topology: &Topology,
        weights: &[f64],
        algorithm: Algorithm,
        patterns: &Rows,
        epochs: usize,
    ) -> Run {
        let mut objective = objective::<T>(topology, patterns);
        let mut trainer = algorithm.trainer(weights.len());
        let weights = weights.iter().map(|&w| T::of(w)).collect();
        let config = RunConfig { epochs, ..RunConfig::default() };
        run(Training::new(trainer.as_mut(), &mut objective), weights, &config)
    }

    fn both(algorithm: Algorithm, patterns: &Rows, weights: &[f64]) -> [Run; 2] {
        [train::<f32>(algorithm, patterns, weights), train::<f64>(algorithm, patterns, weights)]
    }

    /// Every rule in both precisions; weights must be finite where the start was.
    fn each(patterns: &Rows, weights: &[f64], check: impl Fn(&str, &Run)) {
        for algorithm in Algorithm::all() {
            for (precision, run) in ["f32", "f64"].iter().zip(both(algorithm, patterns, weights)) {
                let name = format!("{} {precision}: {}", algorithm.name(), run.stop);
                let finite = run.weights.iter().all(|w| w.is_finite());
                assert!(finite, "{name}: weights that are not finite");
                check(&name, &run);
            }
        }
    }

    fn start() -> Vec<f64> {
        nguyen_widrow(&topology(), 3)
    }

    #[test]
    fn saturated_neurons_a_single_row_and_rows_all_alike() {
        let saturated: Vec<f64> = start().iter().map(|w| 1e4 * w).collect();
        let alike = rows(1).map(|one| concatenate(Axis(0), &[one.view(); 40]).unwrap());
        for (patterns, weights) in [(rows(50), saturated), (rows(1), start()), (alike, start())] {
            each(&patterns, &weights, |name, run| {
                assert!(run.mse <= run.history[0], "{name}: {} {}", run.mse, run.history[0]);
            });
        }
    }

    #[test]
    fn targets_that_are_not_finite_are_divergence_at_once() {
        for wild in [f64::NAN, f64::INFINITY, 1e300] {
            let mut patterns = rows(50);
            patterns[1][[17, 0]] = wild;
            each(&patterns, &start(), |name, run| {
                let at_once = matches!(run.stop, Stop::Diverged { epoch: 0, .. });
                assert!(at_once && run.epochs == 0, "{name}");
                assert_eq!(run.weights.len(), start().len());
            });
        }
    }

    #[test]
    fn zero_gradients_end_or_stand_still() {
        let mut patterns = rows(20);
        patterns[1].fill(0.0);
        let zeros = vec![0.0; start().len()];
        each(&patterns, &zeros, |name, run| {
            assert!((run.mse, run.weights.iter().all(|w| *w == 0.0)) == (0.0, true), "{name}");
            assert!(matches!(run.stop, Stop::Goal | Stop::Finished(_) | Stop::Gradient), "{name}");
        });
    }

    #[test]
    fn weights_that_overflow_are_reported_and_the_best_ones_kept() {
        let wild = Algorithm::Gd(GradientDescentConfig { rate: 1e30 });
        let run = train::<f32>(wild, &rows(50), &start());
        assert!(matches!(run.stop, Stop::Diverged { .. }), "{}", run.stop);
        assert!(run.weights.iter().all(|w| w.is_finite()));
        // Infinite from the start, hidden behind saturated neurons.
        let mut weights = start();
        weights[8] = f64::INFINITY;
        let run = train::<f64>(wild, &rows(50), &weights);
        assert!(matches!(run.stop, Stop::Diverged { epoch: 0, .. }), "{}", run.stop);
    }

    fn data(csv: &str) -> DataSet {
        let specs =
            |names: &[&str]| names.iter().map(|name| name.parse().unwrap()).collect::<Vec<_>>();
        DataSet::from_csv("rows.csv", csv.as_bytes(), &specs(&["a", "b"]), &specs(&["y"])).unwrap()
    }

    /// Neurons without an upper limit: the sums overflow f32, which is divergence and nothing worse. With one there is none.
    #[test]
    fn huge_inputs() {
        let mut patterns = rows(50);
        patterns[0].column_mut(0).mapv_inplace(|x| x * 1e30);
        for activation in [Activation::Tanh, Activation::Relu] {
            let topology = Topology::with_hidden(2, &[4], activation, 1).unwrap();
            let start = nguyen_widrow(&topology, 3);
            for algorithm in Algorithm::all() {
                for run in [
                    train_net::<f32>(&topology, &start, algorithm, &patterns, 200),
                    train_net::<f64>(&topology, &start, algorithm, &patterns, 200),
                ] {
                    let name =
                        format!("{} {activation}: {} {}", algorithm.name(), run.mse, run.stop);
                    assert!(run.weights.iter().all(|w| w.is_finite()), "{name}");
                    let diverged = matches!(run.stop, Stop::Diverged { .. });
                    assert!(
                        run.mse.is_finite() || diverged && activation == Activation::Relu,
                        "{name}"
                    );
                }
            }
        }
    }

    /// Damping that starts at its limit or leaps over it.
    #[test]
    fn the_largest_damping_does_not_overflow() {
        let scg = |lambda| Algorithm::Scg(ScgConfig { sigma: None, lambda });
        let mut wild = vec![scg(1e20), scg(f64::MAX)];
        for damping in [Damping::Factors, Damping::Gain] {
            let lm = |mu| Algorithm::Lm(LevenbergMarquardtConfig { damping, mu });
            wild.extend([lm(f64::MAX), lm(1e10), lm(f64::MIN_POSITIVE)]);
        }
        for wild in wild {
            for run in both(wild, &rows(50), &start()) {
                assert!(run.mse.is_finite() && run.mse <= run.history[0], "{wild:?}");
                assert!(run.weights.iter().all(|w| w.is_finite()), "{wild:?}");
            }
        }
    }

    /// Whatever is saved is finite; otherwise the error states why nothing is. A constant column and wide ranges have a model.
    #[test]
    fn weights_that_are_not_finite_are_never_saved() {
        let wide = "a,b,y\n1,1e30,3\n1,-1e30,4\n1,5e29,3.5\n1,0,3.25\n";
        let wild = "a,b,y\n1e30,1,1e30\n-1e30,2,-1e30\n5e29,3,2\n0,4,1e-30\n1e38,5,3e38\n";
        let fast = Algorithm::Gd(GradientDescentConfig { rate: 1e30 });
        let activations = [Activation::Tanh, Activation::Logistic, Activation::Relu];
        let saved = |csv: &str, algorithm: Algorithm, activation: Activation| {
            let saves = |precision: &Precision| {
                let precision = *precision;
                let config = FitConfig { algorithm, precision, activation, ..FitConfig::default() };
                let Ok(fit) = fit(&data(csv), None, None, &config) else { return false };
                let back = ModelFile::from_json(&fit.file.to_json().unwrap()).unwrap();
                let weights = |layer: &FileLayer| [layer.weights.concat(), layer.biases.clone()];
                let mut values = back.layers.iter().flat_map(weights).flatten();
                assert!(values.all(|w| w.is_finite()), "{} {activation}", algorithm.name());
                assert!(fit.train.mse.is_finite(), "{} {activation}", algorithm.name());
                true
            };
            [Precision::Single, Precision::Double].iter().filter(|p| saves(p)).count()
        };
        let all = Algorithm::all().into_iter();
        assert!(all.clone().all(|rule| saved(wide, rule, Activation::Tanh) == 2));
        let rules = all.chain([fast]).flat_map(|rule| activations.map(|f| saved(wild, rule, f)));
        let models: usize = rules.sum();
        assert!(models >= 42, "only {models} of 54 trainings gave a model");
    }
}
