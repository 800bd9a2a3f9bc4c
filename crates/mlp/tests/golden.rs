//! Trainers against error curves of an independent double-precision implementation, and how many of twenty given starts
//! reach the goal.
//!
//! Rules of the first order are in `tests/reference.rs`, weight by weight.
//!
//! The data lie outside the repository: in the folder `GRIP_DATA`, or in `shared/data` beside it. Without
//! them each test prints that and checks nothing; `src/train/trainer/tests.rs` needs no data.
//!
//! The data files hold nine digits, the golden curves come from unrounded data: both part by 2e-10 at epoch 0
//! already. Rules that build on curvature magnify that; `parting_is_no_more_than_the_rounding_of_the_data`
//! shows that nothing else is magnified.

#[cfg(test)]
mod common;

#[cfg(test)]
mod tests {
    use super::common::{Surface2, curve, surface2};
    use mlp::train::trainer::{Damping, LevenbergMarquardtConfig, ScgConfig};
    use mlp::train::{Algorithm, NetworkObjective, Real, Run, RunConfig, Stop, Training, run};

    /// The damping of the golden curves.
    const FACTORS: Algorithm = Algorithm::Lm(LevenbergMarquardtConfig {
        damping: Damping::Factors,
        mu: 0.001,
        decrease: 0.1,
        increase: 10.0,
        max: 1e10,
    });

    /// Largest relative deviation allowed up to and including an epoch.
    struct Bound {
        epoch: usize,
        relative: f64,
    }

    const fn bound(epoch: usize, relative: f64) -> Bound {
        Bound { epoch, relative }
    }

    fn error_after(surface: &Surface2, algorithm: Algorithm, start: usize, epoch: usize) -> f64 {
        let mut weights = surface.start(start);
        let mut trainer = algorithm.trainer(weights.len());
        curve(trainer.as_mut(), &mut surface.objective(), &mut weights, epoch)
    }

    /// Compares the starts 0-4 at every golden epoch.
    fn compare(label: &str, algorithm: Algorithm, bounds: &[Bound]) {
        let surface = surface2();
        for (start, epoch, expected) in surface.golden(label) {
            let got = error_after(&surface, algorithm, start, epoch);
            let deviation = (got / expected - 1.0).abs();
            eprintln!("{label} start {start} epoch {epoch}: {got:.9e}, deviation {deviation:.1e}");
            let bound = bounds.iter().find(|bound| epoch <= bound.epoch).unwrap();
            assert!(deviation <= bound.relative, "deviation {deviation:e} > {}", bound.relative);
        }
    }

    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn scaled_conjugate_gradient() {
        let bounds = [bound(10, 5e-9), bound(20, 5e-7), bound(50, 5e-6), bound(100, 1e-2)];
        compare("scg", Algorithm::Scg(ScgConfig::default()), &bounds);
    }

    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn levenberg_marquardt() {
        let bounds = [bound(1, 5e-9), bound(5, 5e-7), bound(20, 5e-6), bound(100, 5e-8)];
        compare("lm", FACTORS, &bounds);
    }

    /// The curves of data moved within their rounding spread about as far as the golden curve lies away.
    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn parting_is_no_more_than_the_rounding_of_the_data() {
        let surface = surface2();
        for (label, algorithm) in [("scg", Algorithm::Scg(ScgConfig::default())), ("lm", FACTORS)] {
            for (start, epoch, expected) in surface.golden(label) {
                let own = error_after(&surface, algorithm, start, epoch);
                let spread = (0..8)
                    .map(|seed| surface.moved_within_rounding(seed))
                    .map(|moved| error_after(&moved, algorithm, start, epoch))
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

    /// Mean squared error in scaled units that counts as reached.
    const GOAL: f64 = 2.5e-3;

    fn runs<T: Real>(algorithm: &str, epochs: usize) -> Vec<Run> {
        let surface = surface2();
        let algorithm: Algorithm = algorithm.parse().unwrap();
        let config = RunConfig { epochs, goal: GOAL, ..RunConfig::default() };
        let one = |start: usize| {
            let mut objective: NetworkObjective<T> = surface.objective();
            let weights: Vec<T> = surface.start(start).into_iter().map(T::of).collect();
            let mut trainer = algorithm.trainer(weights.len());
            run(Training::new(trainer.as_mut(), &mut objective), weights, &config)
        };
        (0..20).map(one).collect()
    }

    fn all_reach<T: Real>(algorithm: &str, epochs: usize) {
        let runs = runs::<T>(algorithm, epochs);
        let reached = runs.iter().filter(|run| run.stop == Stop::Goal).count();
        let epochs: Vec<usize> = runs.iter().map(|run| run.epochs).collect();
        eprintln!("{algorithm} {}: {reached}/20, epochs {epochs:?}", T::NAME);
        assert_eq!(reached, 20, "{algorithm} {}", T::NAME);
    }

    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn scaled_conjugate_gradient_reaches_the_goal_from_every_start() {
        all_reach::<f32>("scg", 1000);
        all_reach::<f64>("scg", 1000);
    }

    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn levenberg_marquardt_reaches_the_goal_from_every_start_within_40_epochs() {
        all_reach::<f64>("lm", 40);
        all_reach::<f32>("lm", 40);
    }

    #[test]
    #[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
    fn limited_memory_bfgs_reaches_the_goal_from_every_start() {
        all_reach::<f64>("lbfgs", 1000);
        all_reach::<f32>("lbfgs", 1000);
    }
}
