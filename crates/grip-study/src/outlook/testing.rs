//! Rows of a smooth noisy surface by number and seed, for the tests.

use mlp::train::DataSet;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

/// `y = 0.6 sin(pi x1) x2 + 0.4 cos(2.5 x2) + 0.3 x1` with uniform noise of standard deviation 0.05.
pub(super) fn surface(rows: usize, seed: u64) -> DataSet {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || f64::from(rng.next_u32()) / 2_147_483_648.0 - 1.0;
    let mut csv = String::from("x1,x2,y\n");
    for _ in 0..rows {
        let (x1, x2) = (draw(), draw());
        let smooth =
            0.6 * (core::f64::consts::PI * x1).sin() * x2 + 0.4 * (2.5 * x2).cos() + 0.3 * x1;
        let noise = 0.05 * 3_f64.sqrt() * draw();
        csv.push_str(&format!("{x1},{x2},{}\n", smooth + noise));
    }
    let specs = |names: &[&str]| names.iter().map(|n| n.parse().unwrap()).collect::<Vec<_>>();
    DataSet::from_csv("surface.csv", csv.as_bytes(), &specs(&["x1", "x2"]), &specs(&["y"])).unwrap()
}
