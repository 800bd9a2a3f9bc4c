//! From CSV bytes to a saved model: every rule learns, every fault is reported.

#[cfg(test)]
mod tests {
    use core::fmt::Write;

    use mlp::Transform;
    use mlp::train::trainer::{GradientDescentConfig, MomentumConfig, MomentumForm};
    use mlp::train::{
        Algorithm, DataSet, Fit, FitConfig, FitError, Fitting, Method, ModelFile, NetworkObjective,
        Precision, RunConfig, Stop, Topology, Training, evaluate, fit, fit::by_evidence, run,
    };
    use ndarray::{Array2, ArrayView2};
    use proptest::prelude::*;

    fn read(csv: &str) -> DataSet {
        let specs =
            |texts: &[&str]| texts.iter().map(|text| text.parse().unwrap()).collect::<Vec<_>>();
        DataSet::from_csv(
            "grasps.csv",
            csv.as_bytes(),
            &specs(&["v_m_s", "m_kg:ln"]),
            &specs(&["f_n"]),
        )
        .unwrap()
    }

    /// A smooth made-up force over a grid of speeds and masses, shifted by `offset` of a cell.
    fn grasps(offset: f64) -> DataSet {
        let mut csv = String::from("v_m_s,m_kg,f_n\n");
        for row in 0..8_i32 {
            for column in 0..8_i32 {
                let v = 0.01 + 0.03 * (f64::from(row) + offset);
                let m = 0.2 * 1.22_f64.powf(f64::from(column) + offset);
                let f = 9.81 * m * (1.2 + 2.0 * v + (10.0 * v).sin() * 0.2);
                writeln!(csv, "{v:.6},{m:.6},{f:.6}").unwrap();
            }
        }
        read(&csv)
    }

    fn config(algorithm: &str, epochs: usize) -> FitConfig {
        let algorithm = match algorithm {
            "gd" => Algorithm::Gd(GradientDescentConfig { rate: 0.1 }),
            "gdm" => Algorithm::Gdm(MomentumConfig {
                rate: 0.02,
                momentum: 0.9,
                form: MomentumForm::HeavyBall,
            }),
            name => name.parse().unwrap(),
        };
        let run = RunConfig { epochs, ..RunConfig::default() };
        FitConfig { algorithm, run, hidden: vec![6], repeats: 3, ..FitConfig::default() }
    }

    /// y = sin 6 x with noise of 0.2 rms, uniform in shape, at `rows` places.
    fn noisy(rows: i32, seed: u64) -> DataSet {
        let mut csv = String::from("x,y\n");
        let mut state = seed;
        for row in 0..rows {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let unit =
                f64::from(u32::try_from(state >> 33).unwrap()) / f64::from(1_u32 << 31) - 0.5;
            let x = f64::from(row) / f64::from(rows);
            writeln!(csv, "{x:.6},{:.6}", (6.0 * x).sin() + 0.2 * 12_f64.sqrt() * unit).unwrap();
        }
        let specs = |text: &str| vec![text.parse().unwrap()];
        DataSet::from_csv("noisy.csv", csv.as_bytes(), &specs("x"), &specs("y")).unwrap()
    }

    #[test]
    fn bayesian_regularisation_learns_the_curve_and_not_the_noise_and_knows_both() {
        let (train, test) = (noisy(40, 1), noisy(400, 2));
        let of = |algorithm: &str| {
            let config = FitConfig { hidden: vec![15], repeats: 5, ..config(algorithm, 600) };
            fit(&train, None, Some(&test), &config).unwrap()
        };
        let (br, lm) = (of("br"), of("lm"));
        let mse = |fit: &Fit| fit.test.as_ref().unwrap().mse;
        // The noise alone has 0.04; forty rows leave the curve a few hundredths of it unknown.
        assert!(mse(&br) < 0.055 && mse(&lm) > 1.2 * mse(&br), "{} {}", mse(&br), mse(&lm));
        let found = br.runs[br.chosen].evidence.unwrap();
        assert!((3.0..15.0).contains(&found.effective), "of 46: {found:?}");
        // In scaled units, where the target spans 2.
        let span = 2.0 / (br.file.targets[0].max - br.file.targets[0].min);
        let noise = (0.5 / found.beta).sqrt() / span;
        assert!((0.15..0.27).contains(&noise), "{noise}");
        assert!(lm.runs[lm.chosen].evidence.is_none());
        let decay = FitConfig { decay: 0.1, ..config("br", 1) };
        assert!(matches!(fit(&train, None, None, &decay), Err(FitError::Decay)));
        let best =
            br.runs.iter().map(|run| run.evidence.unwrap().ln_evidence).fold(f64::MIN, f64::max);
        assert!(found.ln_evidence >= best);
    }

    /// The evidence finds the form whose noise is the same everywhere; the file keeps the noise, and answers are better for it.
    #[test]
    fn a_reciprocal_is_found_and_its_noise_makes_relative_errors_less() {
        let specs = |text: &str| [text.parse().unwrap()];
        let rows = |count: i32, seed: u64| {
            let rows = noisy(count, seed);
            let targets = rows.target_values().mapv(|y| 1.0 / (1.8 + y));
            let inputs = rows.input_values().to_owned();
            DataSet::from_values("r", &specs("x"), &specs("y"), inputs, targets).unwrap()
        };
        for scaler in [Method::MinMax, Method::ZScore] {
            let config = FitConfig { scaler, ..config("br", 60) };
            let fits = rows(80, 5).target_forms().into_iter().map(|form| {
                let fit = fit(&form, None, None, &config).unwrap();
                (form, fit)
            });
            let fits: Vec<(DataSet, Fit)> = fits.collect();
            let (form, fit) = &fits[by_evidence(&fits)];
            let target = &fit.file.targets[0];
            assert_eq!((form.targets[0].transform, fits.len()), (Transform::Reciprocal, 3));
            assert!((0.15..0.27).contains(&target.noise), "{}", target.noise);
            let test = rows(500, 6).with_target(Transform::Reciprocal).unwrap();
            let error = |noise: f32| {
                let mut file = fit.file.clone();
                file.targets[0].noise = noise;
                let found = evaluate(&file.large_model().unwrap(), &test).unwrap();
                found.relative_errors.mapv(|error| error * error).mean().unwrap()
            };
            let (known, unknown) = (error(target.noise), error(0.0));
            assert!(known < 0.95 * unknown, "{known} {unknown}");
        }
    }

    /// A run has one error of all targets: that of `z`, which is noise, is not that of `y`.
    #[test]
    fn the_error_of_other_targets_is_no_noise_of_a_reciprocal() {
        let mut csv = String::from("x,y,z\n");
        for row in 1..40_i32 {
            let x = 0.2 + 0.02 * f64::from(row);
            writeln!(csv, "{x},{},{}", 1.0 / x, row * 7919 % 13).unwrap();
        }
        let noise = |targets: &[&str]| {
            let targets: Vec<_> = targets.iter().map(|text| text.parse().unwrap()).collect();
            let specs = ["x".parse().unwrap()];
            let data = DataSet::from_csv("t.csv", csv.as_bytes(), &specs, &targets).unwrap();
            fit(&data, None, None, &config("lm", 20)).unwrap().file.targets[0].noise
        };
        let alone = noise(&["y:reciprocal"]);
        assert!(alone > 0.0 && alone < 0.01, "{alone}");
        assert_eq!(noise(&["y:reciprocal", "z"]), 0.0);
    }

    /// The saved model, whose limits are min-max, makes the very errors that the training saw in z-scores.
    #[test]
    fn z_scores_are_folded_into_the_saved_weights() {
        let data = grasps(0.0);
        let config = FitConfig { scaler: Method::ZScore, ..config("lm", 60) };
        let fit = fit(&data, None, Some(&grasps(0.4)), &config).unwrap();
        let Some([_, deviation]) = data.scalings(Method::ZScore).1[0].moments else {
            panic!("no z-score");
        };
        let seen = fit.runs[fit.chosen].mse * deviation * deviation;
        let saved = fit.train.mse;
        assert!((saved / seen - 1.0).abs() < 1e-2, "{saved} saved, {seen} seen");
        assert!(fit.train.scaled_mse < 1e-4 && fit.test.unwrap().scaled_mse < 1e-3);
        let text = fit.file.to_json().unwrap();
        assert_eq!(ModelFile::from_json(&text).unwrap().inputs[0].min, 0.01);
    }

    /// Offsets that `f32` holds no range at: Pa, ticks, an epoch.
    #[test]
    fn columns_far_from_zero_are_learned_in_either_precision() {
        let specs = [["x".parse().unwrap()], ["y".parse().unwrap()]];
        let at = |x_offset: f64, y_offset: f64| {
            let x = |row: i32| f64::from(row) / 100.0 - 1.0;
            let rows =
                (0..200).map(|row| (x_offset + 1e-3 * x(row), y_offset + 1.5 * x(row).sin()));
            let (x, y): (Vec<f64>, Vec<f64>) = rows.unzip();
            let column = |values| Array2::from_shape_vec((200, 1), values).unwrap();
            DataSet::from_values("far", &specs[0], &specs[1], column(x), column(y)).unwrap()
        };
        for precision in [Precision::Single, Precision::Double] {
            let config = FitConfig { precision, ..config("lm", 60) };
            let [near, far] =
                [at(0.0, 0.0), at(1e6, 1e9)].map(|rows| fit(&rows, None, None, &config).unwrap());
            assert!(near.warnings.is_empty(), "{:?}", near.warnings);
            assert!(far.train.mse < 1e-6 && far.train.r2.unwrap() > 0.999_99, "{:?}", far.train);
            let again = ModelFile::from_json(&far.file.to_json().unwrap()).unwrap();
            assert_eq!(evaluate(&again.large_model().unwrap(), &at(1e6, 1e9)).unwrap(), far.train);
            assert_eq!(far.warnings.len(), 2, "{:?}", far.warnings);
            assert!(far.warnings.iter().all(|text| text.contains("will see a constant")));
        }
    }

    #[test]
    fn what_speaks_against_rows_and_models_is_stated() {
        let warnings = |csv: &str, algorithm: &str| {
            let rows = read(&format!("v_m_s,m_kg,f_n\n{csv}"));
            fit(&rows, None, None, &config(algorithm, 20)).unwrap().warnings.join("; ")
        };
        let few = warnings("0.1,1,2\n0.2,2,5\n0.3,4,1\n", "rprop");
        assert!(few.contains("3 rows for 25 weights"), "{few}");
        let constant = warnings(&"0.1,1,2\n0.1,2,2\n".repeat(20), "rprop");
        for words in ["input \"v_m_s\" is 0.1 in every row", "target \"f_n\" is 2 in every row"] {
            assert!(constant.contains(words) && !constant.contains("weights"), "{constant}");
        }
        let same = "0.1,1,2\n0.2,2,5\n".repeat(20);
        let (rows, other) = (read(&format!("v_m_s,m_kg,f_n\n{same}")), "0.1,1,5\n0.2,2,2\n");
        let other = read(&format!("v_m_s,m_kg,f_n\n{other}"));
        let fit = fit(&rows, None, Some(&other), &config("lm", 20)).unwrap();
        assert!(
            fit.warnings.join(";").contains("on the test rows: no better"),
            "{:?}",
            fit.warnings
        );
    }

    fn train(algorithm: &str, epochs: usize) -> Fit {
        fit(&grasps(0.0), None, Some(&grasps(0.4)), &config(algorithm, epochs)).unwrap()
    }

    #[test]
    fn every_rule_learns_a_force_surface() {
        for (algorithm, epochs, within) in [
            ("gd", 2000, 0.9),
            ("gdm", 2000, 0.9),
            ("rprop", 300, 0.95),
            ("scg", 300, 0.95),
            ("lm", 50, 0.95),
            ("gdx", 2000, 0.9),
            ("lbfgs", 300, 0.95),
            ("br", 100, 0.95),
        ] {
            let fit = train(algorithm, epochs);
            let test = fit.test.as_ref().unwrap();
            let share = test.within_fraction(0.10);
            assert!(share >= within, "{algorithm}: {share} within 10 %, mse {}", test.mse);
            let first = fit.runs[fit.chosen].history[0];
            assert!(fit.train.scaled_mse < 0.05 * first, "{algorithm}: {}", fit.train.scaled_mse);
        }
    }

    #[test]
    fn equal_seeds_give_equal_files_and_the_file_predicts_the_same() {
        let (first, second) = (train("rprop", 50), train("rprop", 50));
        let text = first.file.to_json().unwrap();
        assert_eq!(text, second.file.to_json().unwrap());
        let again = ModelFile::from_json(&text).unwrap();
        assert_eq!(again.large_model().unwrap(), *first.model);
        assert_eq!((again.inputs[1].unit.as_str(), again.targets[0].unit.as_str()), ("kg", "N"));
        let note = again.training.unwrap();
        assert_eq!((note.rows, note.repeats, note.algorithm.as_str()), (64, 3, "rprop"));
        assert_eq!(note.train_mse.to_bits(), first.train.mse.to_bits());
    }

    #[test]
    fn a_rate_that_is_far_too_large_is_reported_as_divergence() {
        let mut wild = config("gd", 200);
        wild.algorithm = Algorithm::Gd(GradientDescentConfig { rate: 50.0 });
        let rows = grasps(0.0);
        for run in (0..3).map(|repeat| Fitting::new(&rows, None, &wild).unwrap().run(repeat)) {
            assert!(matches!(run.stop, Stop::Diverged { .. }), "{}", run.stop);
            assert_eq!(run.best_epoch, 0);
            assert!(run.weights.iter().all(|weight| weight.is_finite()));
        }
        let error = fit(&rows, None, None, &wild).unwrap_err();
        assert_eq!(error, FitError::Diverged { runs: 3 });
        assert!(error.to_string().starts_with("diverged at once"), "{error}");
    }

    #[test]
    fn settings_that_can_not_work_are_refused() {
        let rows = grasps(0.0);
        let refuse = |config: FitConfig| fit(&rows, None, None, &config).unwrap_err();
        let none = refuse(FitConfig { repeats: 0, ..FitConfig::default() }).to_string();
        assert_eq!(none, "repeats is 0: it must be 1 or more");
        let wide = FitConfig { hidden: vec![1025], ..FitConfig::default() };
        assert!(matches!(refuse(wide), FitError::Shape(_)));
        let large = FitConfig { hidden: vec![64, 64], ..config("lm", 1) };
        assert!(matches!(refuse(large), FitError::TooManyWeights { weights: 4417, .. }));
        let mut backward = config("gd", 1);
        backward.algorithm = Algorithm::Gd(GradientDescentConfig { rate: -0.1 });
        assert_eq!(refuse(backward).to_string(), "rate is -0.1: it must be a positive number");
        let mut endless = config("gdm", 1);
        endless.algorithm =
            Algorithm::Gdm(MomentumConfig { momentum: 1.0, ..MomentumConfig::default() });
        assert_eq!(refuse(endless).to_string(), "momentum is 1: it must be between 0 and 1");
        let mut goal = config("gd", 1);
        goal.run.goal = f64::NAN;
        assert!(refuse(goal).to_string().starts_with("goal is NaN"));
        let decaying = FitConfig { decay: -1.0, ..FitConfig::default() };
        assert!(matches!(refuse(decaying), FitError::Setting(_)));
        let mut other = grasps(0.0);
        other.inputs.swap(0, 1);
        other.file = "other.csv".to_owned();
        let error = fit(&rows, Some(&other), None, &FitConfig::default()).unwrap_err();
        assert_eq!(error, FitError::OtherColumns { file: "other.csv".to_owned() });
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

        #[test]
        fn any_start_ends_without_panic_and_with_finite_weights(
            weights in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 13),
            rows in prop::collection::vec(-1.0_f64..1.0, 30),
            rule in 0_usize..7,
        ) {
            let topology = Topology::regression(2, &[3], 1).unwrap();
            let inputs = ArrayView2::from_shape((10, 2), &rows[..20]).unwrap();
            let targets = ArrayView2::from_shape((10, 1), &rows[20..]).unwrap();
            let mut objective = NetworkObjective::new(&topology, &inputs, &targets).unwrap();
            let mut trainer = Algorithm::all()[rule].trainer(weights.len());
            let config = RunConfig { epochs: 20, ..RunConfig::default() };
            let outcome = run(Training::new(trainer.as_mut(), &mut objective), weights, &config);
            prop_assert!(outcome.weights.iter().all(|weight| weight.is_finite()));
            prop_assert!(outcome.mse.is_finite() || outcome.best_epoch == 0);
        }

        #[test]
        fn a_damaged_model_file_is_a_model_or_an_error(at in 0_usize..1000, byte in 32_u8..127) {
            let topology = Topology::regression(1, &[2], 1).unwrap();
            let data = read("v_m_s,m_kg,f_n\n0.1,0.5,3\n0.2,0.6,4\n");
            let columns = mlp::train::scaling::columns(&data.targets, &data.target_scalings());
            let file = ModelFile::new(&columns, &columns, &topology, &[0.5; 7]);
            let mut text = file.to_json().unwrap().into_bytes();
            let place = at % text.len();
            text[place] = byte;
            if let Ok(file) = ModelFile::from_json(&String::from_utf8(text).unwrap()) {
                prop_assert!(file.model().is_ok());
            }
        }
    }
}
