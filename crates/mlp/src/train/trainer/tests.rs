//! First updates of rules that build on curvature against their formulas, worked out for one weight; the others: `tests/reference.rs`.

use super::*;

/// `mse = (a w - b)^2` of one residual `e = a w - b`.
struct Parabola {
    a: f64,
    b: f64,
}

impl Objective for Parabola {
    fn weights(&self) -> usize {
        1
    }

    fn residuals(&self) -> usize {
        1
    }

    fn mse(&mut self, weights: &[f64]) -> f64 {
        (self.a * weights[0] - self.b).powi(2)
    }

    fn gradient(&mut self, weights: &[f64], gradient: &mut [f64]) -> f64 {
        gradient[0] = 2.0 * self.a * (self.a * weights[0] - self.b);
        self.mse(weights)
    }

    fn normal_equations(&mut self, w: &[f64], normal: &mut [f64], projected: &mut [f64]) -> f64 {
        normal[0] = self.a * self.a;
        projected[0] = self.a * (self.a * w[0] - self.b);
        self.mse(w)
    }
}

/// Weights after each of three steps from 3, for `mse = (2 w - 1)^2`, gradient `8 w - 4`.
fn path(algorithm: Algorithm) -> [f64; 3] {
    let mut trainer = algorithm.trainer(1);
    let mut weights = [3.0];
    core::array::from_fn(|_| {
        trainer.step(&mut Parabola { a: 2.0, b: 1.0 }, &mut weights);
        weights[0]
    })
}

fn assert_path(algorithm: Algorithm, expected: [f64; 3]) {
    let got = path(algorithm);
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() < 1e-12, "{algorithm:?}: {got} instead of {expected}");
    }
}

#[test]
fn scaled_conjugate_gradient_takes_newton_steps_on_a_parabola() {
    // p = r = -20, delta = 8 * 400 + 5e-7 * 400, alpha = 400 / delta: w = 3 - 20 / (8 + 5e-7).
    let first = 3.0 - 20.0 / (8.0 + 5e-7);
    let got = path(Algorithm::Scg(ScgConfig::default()));
    // The probe measures the curvature by a difference: 1e-16 * 20 / 5e-5 relative to 8.
    assert!((got[0] - first).abs() < 1e-9, "{} {first}", got[0]);
    // The remaining error of 1.6e-7 shrinks by lambda / 8 again.
    assert!((got[2] - 0.5).abs() < 1e-12, "{got:?}");
}

#[test]
fn levenberg_marquardt_follows_its_formula() {
    // dw = -(4 + mu)^-1 * 2 e with e = 2 w - 1, mu = 1, 0.1, 0.01.
    let config = LevenbergMarquardtConfig { mu: 1.0, damping: Damping::Factors };
    let mut w: f64 = 3.0;
    let expected = [1.0, 0.1, 0.01].map(|mu| {
        w -= 2.0 * (2.0 * w - 1.0) / (4.0 + mu);
        w
    });
    assert_path(Algorithm::Lm(config), expected);
}

#[test]
fn names_are_read_back() {
    for algorithm in Algorithm::all() {
        assert_eq!(algorithm.name().parse(), Ok(algorithm));
    }
    assert!("adam".parse::<Algorithm>().unwrap_err().to_string().contains("rprop"));
}
