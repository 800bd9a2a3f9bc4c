//! Rows and weights that break trainers: each ends with a stated reason and finite weights, in both precisions.

#[cfg(test)]
mod tests {
    use mlp::Activation;
    use mlp::train::trainer::{
        Damping, GradientDescentConfig, LevenbergMarquardtConfig, ScgConfig,
    };
    use mlp::train::{
        Algorithm, DataSet, FitConfig, Fitting, ModelFile, NetworkObjective, Precision, Real, Run,
        RunConfig, Stop, Topology, Training, fit, init::nguyen_widrow, run,
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

    /// All rows, `times` times one after the other.
    fn repeated(rows: &Rows, times: usize) -> Rows {
        rows.each_ref().map(|rows| concatenate(Axis(0), &vec![rows.view(); times]).unwrap())
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
    fn saturated_neurons() {
        let weights: Vec<f64> = start().iter().map(|w| 1e4 * w).collect();
        each(&rows(50), &weights, |name, run| {
            assert!(run.mse.is_finite() && run.mse <= run.history[0], "{name}: {}", run.mse);
        });
    }

    #[test]
    fn a_single_row_and_rows_all_alike() {
        let one = rows(1);
        let alike = repeated(&one, 40);
        for patterns in [one, alike] {
            each(&patterns, &start(), |name, run| {
                assert!(run.mse <= run.history[0], "{name}: {} {}", run.mse, run.history[0]);
            });
        }
    }

    #[test]
    fn duplicate_rows_change_nothing_but_rounding() {
        let once = rows(30);
        let twice = repeated(&once, 2);
        for algorithm in Algorithm::all() {
            let errors = [&once, &twice]
                .map(|rows| train_net::<f64>(&topology(), &start(), algorithm, rows, 5).mse);
            // Damping of lm and penalty of br count against sums, which are twice as large.
            let bound = match algorithm.name() {
                "lm" => 0.5,
                "br" => 0.01,
                _ => 1e-6,
            };
            assert!(
                (errors[0] / errors[1] - 1.0).abs() < bound,
                "{}: {errors:?}",
                algorithm.name()
            );
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
    fn the_largest_damping_does_not_overflow() {
        let config = ScgConfig { sigma: None, lambda: 1e20 };
        for wild in
            [Algorithm::Scg(config), Algorithm::Scg(ScgConfig { lambda: f64::MAX, ..config })]
        {
            for run in both(wild, &rows(50), &start()) {
                assert!(run.mse.is_finite() && run.weights.iter().all(|w| w.is_finite()));
                assert!(run.mse <= run.history[0]);
            }
        }
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

    #[test]
    fn constant_columns_and_wide_ranges_give_a_model() {
        let csv = "a,b,y\n1,1e30,3\n1,-1e30,4\n1,5e29,3.5\n1,0,3.25\n";
        for precision in [Precision::Single, Precision::Double] {
            for algorithm in Algorithm::all() {
                let config =
                    FitConfig { algorithm, precision, hidden: vec![3], ..FitConfig::default() };
                let fit = fit(&data(csv), None, None, &config).unwrap();
                assert!(fit.train.mse.is_finite(), "{}", algorithm.name());
            }
        }
    }

    #[test]
    fn a_million_rows() {
        let patterns = rows(1_000_000);
        for algorithm in Algorithm::all() {
            for run in [
                train_net::<f32>(&topology(), &start(), algorithm, &patterns, 2),
                train_net::<f64>(&topology(), &start(), algorithm, &patterns, 2),
            ] {
                let name = algorithm.name();
                assert_eq!((run.stop, run.history.len()), (Stop::Epochs, 3), "{name}");
                assert!(run.mse.is_finite() && run.mse < run.history[0], "{name}: {}", run.mse);
                assert!(run.weights.iter().all(|w| w.is_finite()), "{name}");
            }
        }
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
    fn the_damping_of_levenberg_and_marquardt_does_not_overflow() {
        let usual = LevenbergMarquardtConfig::default();
        for damping in [Damping::Factors, Damping::Gain] {
            for config in [
                LevenbergMarquardtConfig { damping, mu: f64::MAX, max: f64::MAX, ..usual },
                LevenbergMarquardtConfig { damping, increase: 1e300, max: f64::MAX, ..usual },
                LevenbergMarquardtConfig { damping, mu: f64::MIN_POSITIVE, ..usual },
            ] {
                let wild = Algorithm::Lm(config);
                for run in both(wild, &rows(50), &start()) {
                    assert!(run.mse.is_finite() && run.mse <= run.history[0], "{config:?}");
                    assert!(run.weights.iter().all(|w| w.is_finite()), "{config:?}");
                }
            }
        }
    }

    /// Whatever is saved is finite; otherwise the error states why nothing is.
    #[test]
    fn weights_that_are_not_finite_are_never_saved() {
        let csv = "a,b,y\n1e30,1,1e30\n-1e30,2,-1e30\n5e29,3,2\n0,4,1e-30\n1e38,5,3e38\n";
        let mut saved = 0;
        for activation in [Activation::Tanh, Activation::Logistic, Activation::Relu] {
            for algorithm in Algorithm::all()
                .into_iter()
                .chain([Algorithm::Gd(GradientDescentConfig { rate: 1e30 })])
            {
                for precision in [Precision::Single, Precision::Double] {
                    let config =
                        FitConfig { algorithm, precision, activation, ..FitConfig::default() };
                    if let Ok(fit) = fit(&data(csv), None, None, &config) {
                        let text = fit.file.to_json().unwrap();
                        let back = ModelFile::from_json(&text).unwrap();
                        let mut values = back
                            .layers
                            .iter()
                            .flat_map(|layer| layer.weights.iter().flatten().chain(&layer.biases));
                        let name = algorithm.name();
                        assert!(values.all(|w| w.is_finite()), "{name} {activation}");
                        saved += 1;
                    }
                }
            }
        }
        assert!(saved >= 42, "only {saved} of 48 trainings gave a model");
    }

    #[test]
    fn every_thread_gives_the_same_runs() {
        let rows = data("a,b,y\n1,2,3\n2,1,4\n3,5,3.5\n4,0,3.25\n5,2,1\n");
        for precision in [Precision::Single, Precision::Double] {
            for algorithm in Algorithm::all() {
                let run = RunConfig { epochs: 50, ..RunConfig::default() };
                let config =
                    FitConfig { algorithm, precision, run, repeats: 4, ..FitConfig::default() };
                let fitting = Fitting::new(&rows, None, &config).unwrap();
                let alone: Vec<Run> = (0..4).map(|repeat| fitting.run(repeat)).collect();
                let together: Vec<Run> = std::thread::scope(|scope| {
                    let threads: Vec<_> = (0..4)
                        .map(|repeat| {
                            scope.spawn({
                                let fitting = &fitting;
                                move || fitting.run(repeat)
                            })
                        })
                        .collect();
                    threads.into_iter().map(|thread| thread.join().unwrap()).collect()
                });
                assert_eq!(alone, together, "{}", algorithm.name());
            }
        }
    }
}
