//! The vectorised objective against one row after the other in double precision, on every instruction set at hand.

#[cfg(test)]
mod tests {
    use mlp::Activation;
    use mlp::train::{Isa, NetworkObjective, Objective, Real, Topology};
    use ndarray::Array2;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    fn uniform(rng: &mut ChaCha8Rng) -> f64 {
        // 20 bits: exact in single precision too.
        f64::from(rng.next_u32() >> 12) / f64::from(1_u32 << 19) - 1.0
    }

    struct Case {
        topology: Topology,
        inputs: Array2<f64>,
        targets: Array2<f64>,
        weights: Vec<f64>,
    }

    impl Case {
        fn objective<T: Real>(&self, isa: Isa) -> NetworkObjective<T> {
            NetworkObjective::with_isa(&self.topology, &self.inputs, &self.targets, isa).unwrap()
        }
    }

    fn case(sizes: &[usize], activations: &[Activation], rows: usize, seed: u64) -> Case {
        let topology = Topology::new(sizes, activations).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw =
            |rows, columns| Array2::from_shape_simple_fn((rows, columns), || uniform(&mut rng));
        let (inputs, targets) = (draw(rows, topology.inputs()), draw(rows, topology.outputs()));
        let weights = draw(1, topology.weights()).into_raw_vec_and_offset().0;
        Case { topology, inputs, targets, weights }
    }

    fn slope(activation: Activation, y: f64) -> f64 {
        match activation {
            Activation::Tanh => 1.0 - y * y,
            Activation::Linear => 1.0,
            Activation::Logistic => y * (1.0 - y),
            Activation::Relu => f64::from(u8::from(y > 0.0)),
        }
    }

    /// Mean squared error and its gradient by the textbook, and the sums of the sizes of the gradient's terms.
    fn plain(case: &Case) -> (f64, Vec<f64>, Vec<f64>) {
        let Case { topology, inputs, targets, weights } = case;
        let (mut squares, n) = (0.0, targets.len() as f64);
        let (mut gradient, mut sizes) = (vec![0.0; weights.len()], vec![0.0; weights.len()]);
        for (row, target) in inputs.rows().into_iter().zip(targets.rows()) {
            let mut values = vec![row.to_vec()];
            for layer in topology.layers() {
                let before = &values[values.len() - 1];
                let neuron = |j: usize| {
                    let row = &weights[layer.start + j * layer.from..][..layer.from];
                    let products = row.iter().zip(before).map(|(w, x)| w * x);
                    layer.activation.double(weights[layer.biases() + j] + products.sum::<f64>())
                };
                values.push((0..layer.to).map(neuron).collect());
            }
            let outputs = &values[values.len() - 1];
            let mut deltas: Vec<f64> = outputs.iter().zip(target).map(|(y, t)| y - t).collect();
            squares += deltas.iter().map(|e| e * e).sum::<f64>();
            for (at, layer) in topology.layers().enumerate().collect::<Vec<_>>().into_iter().rev() {
                for (delta, y) in deltas.iter_mut().zip(&values[at + 1]) {
                    *delta *= slope(layer.activation, *y);
                }
                let mut add = |weight: usize, term: f64| {
                    gradient[weight] += 2.0 / n * term;
                    sizes[weight] += 2.0 / n * term.abs();
                };
                let mut before = vec![0.0; layer.from];
                for (j, delta) in deltas.iter().enumerate() {
                    add(layer.biases() + j, *delta);
                    for i in 0..layer.from {
                        let weight = layer.start + j * layer.from + i;
                        add(weight, delta * values[at][i]);
                        before[i] += delta * weights[weight];
                    }
                }
                deltas = before;
            }
        }
        (squares / n, gradient, sizes)
    }

    /// Compares error and gradient; `unit` is the rounding of one operation.
    fn compare<T: Real>(case: &Case, isa: Isa, unit: f64) {
        let mut objective = case.objective::<T>(isa);
        let weights: Vec<T> = case.weights.iter().map(|&w| T::of(w)).collect();
        let mut gradient = vec![T::default(); weights.len()];
        let mse = objective.gradient(&weights, &mut gradient);
        let (expected, plain, sizes) = plain(case);
        let name = format!("{:?} {} {isa}", case.topology.sizes(), T::NAME);
        // Residuals are differences of numbers near 1: each is off by some units, whatever its size.
        let bound = 20.0 * unit * (expected + expected.sqrt());
        assert!((mse - expected).abs() < bound, "{name}: {mse} {expected}");
        assert_eq!(mse.to_bits(), objective.mse(&weights).to_bits(), "{name}");
        let n = weights.len();
        let (mut normal, mut projected) = (vec![0.0; n * n], vec![0.0; n]);
        objective.normal_equations(&weights, &mut normal, &mut projected);
        let half = 0.5 * objective.residuals() as f64;
        for ((g, p), size) in gradient.iter().zip(projected).zip(&sizes) {
            assert!(
                (g.double() - p / half).abs() <= 30.0 * unit * (size + 0.1),
                "{name}: {g:?} {p}"
            );
        }
        // The rounding of the terms themselves, which does not shrink with their number, and of some scale.
        for ((g, plain), size) in gradient.iter().zip(plain).zip(sizes) {
            let error = (g.double() - plain).abs();
            assert!(error <= 30.0 * unit * (size + 0.1), "{name}: {error:e} of {size:e}");
        }
    }

    #[test]
    fn error_and_gradient_equal_the_textbook_on_every_machine() {
        let mut seed = 0;
        for rows in [1, 2, 3, 4, 7, 16, 17, 31, 33, 64, 65, 100, 129, 200] {
            for hidden in Activation::ALL {
                for (sizes, layers) in [(&[3, 1][..], 1), (&[2, 10, 1], 2), (&[5, 7, 3, 2], 3)] {
                    let mut activations = vec![hidden; layers];
                    activations[layers - 1] = Activation::ALL[seed % 2];
                    seed += 1;
                    let case = case(sizes, &activations, rows, seed as u64);
                    for isa in Isa::available() {
                        // A relu of a sum near zero may fall on either side in single precision.
                        if hidden != Activation::Relu {
                            compare::<f32>(&case, isa, 6e-8);
                        }
                        compare::<f64>(&case, isa, 1.2e-16);
                    }
                }
            }
        }
    }

    /// 40,000 rows: sums in single precision alone would lose three more digits.
    #[test]
    fn single_precision_sums_stay_accurate_over_many_rows() {
        let activations = [Activation::Tanh, Activation::Linear];
        let case = case(&[2, 4, 1], &activations, 40_000, 99);
        for isa in Isa::available() {
            compare::<f32>(&case, isa, 6e-8);
        }
    }

    #[test]
    fn the_penalty_enters_error_gradient_and_normal_equations() {
        let activations = [Activation::Tanh, Activation::Linear];
        let case = case(&[2, 3, 1], &activations, 20, 5);
        let (plain, weights) = (case.objective::<f64>(Isa::detect()), case.weights);
        let mut decaying = plain.clone().with_decay(0.3).unwrap();
        let mut plain = plain;
        let n = weights.len();
        let (mut g, mut h) = (vec![0.0; n], vec![0.0; n]);
        let difference = decaying.gradient(&weights, &mut h) - plain.gradient(&weights, &mut g);
        let biases = [6, 7, 8, 12];
        let penalised = |at: &usize| !biases.contains(at);
        let squares: f64 = (0..n).filter(penalised).map(|at| weights[at].powi(2)).sum();
        assert!((difference - 0.15 * squares).abs() < 1e-14);
        for at in 0..n {
            let expected = if penalised(&at) { 0.3 * weights[at] } else { 0.0 };
            assert!((h[at] - g[at] - expected).abs() < 1e-14, "weight {at}");
        }
        let (mut normal, mut projected) = (vec![0.0; n * n], vec![0.0; n]);
        decaying.normal_equations(&weights, &mut normal, &mut projected);
        let mut without = vec![0.0; n * n];
        plain.normal_equations(&weights, &mut without, &mut vec![0.0; n]);
        for at in 0..n {
            assert!((projected[at] * 2.0 / 20.0 - h[at]).abs() < 1e-14, "weight {at}");
            let expected = if penalised(&at) { 0.15 * 20.0 } else { 0.0 };
            let added = normal[at * n + at] - without[at * n + at];
            assert!((added - expected).abs() < 1e-12, "weight {at}: {added}");
        }
        assert!(plain.with_decay(f64::NAN).is_err());
    }

    #[test]
    fn normal_equations_agree_between_machines_and_precisions() {
        for (sizes, rows) in [(&[2, 10, 1][..], 100), (&[3, 6, 4, 3], 77), (&[14, 16, 3], 300)] {
            let mut activations = vec![Activation::Tanh; sizes.len() - 1];
            activations[sizes.len() - 2] = Activation::Linear;
            let case = case(sizes, &activations, rows, 8);
            let n = case.weights.len();
            let (mut expected, mut scale) = (Vec::new(), 0.0_f64);
            for isa in Isa::available() {
                let mut objective = case.objective::<f64>(isa);
                let (mut normal, mut projected) = (vec![0.0; n * n], vec![0.0; n]);
                objective.normal_equations(&case.weights, &mut normal, &mut projected);
                if expected.is_empty() {
                    scale = normal.iter().copied().fold(0.0, f64::max);
                    expected = normal;
                    continue;
                }
                for (a, b) in normal.iter().zip(&expected) {
                    assert!((a - b).abs() < 1e-13 * scale, "{isa}: {a} {b}");
                }
            }
            let mut single = case.objective::<f32>(Isa::detect());
            let weights: Vec<f32> = case.weights.iter().map(|&w| Real::of(w)).collect();
            let (mut normal, mut projected) = (vec![0.0; n * n], vec![0.0; n]);
            single.normal_equations(&weights, &mut normal, &mut projected);
            for (a, b) in normal.iter().zip(&expected) {
                assert!((a - b).abs() < 3e-6 * scale, "f32: {a} {b}");
            }
        }
    }
}
