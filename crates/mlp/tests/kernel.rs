//! The vectorised objective against one row after the other in double precision, on every instruction set at hand.

#[cfg(test)]
mod tests {
    use mlp::train::{Isa, NetworkObjective, Objective, Real, Topology};
    use mlp::{Activation, ShapeError};
    use ndarray::{Array2, ArrayRef2, Axis, Slice};
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
        decay: f64,
    }

    impl Case {
        fn objective<T: Real>(&self, isa: Isa) -> NetworkObjective<T> {
            let Self { topology, inputs, targets, decay, .. } = self;
            let rows = NetworkObjective::with_isa(topology, inputs, targets, isa).unwrap();
            rows.with_decay(*decay).unwrap()
        }
    }

    fn case(sizes: &[usize], activations: &[Activation], rows: usize, seed: u64) -> Case {
        let topology = Topology::new(sizes, activations).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw =
            |rows, columns| Array2::from_shape_simple_fn((rows, columns), || uniform(&mut rng));
        let (inputs, targets) = (draw(rows, topology.inputs()), draw(rows, topology.outputs()));
        let weights = draw(1, topology.weights()).into_raw_vec_and_offset().0;
        Case { topology, inputs, targets, weights, decay: 0.0 }
    }

    fn slope(activation: Activation, y: f64) -> f64 {
        match activation {
            Activation::Tanh => 1.0 - y * y,
            Activation::Linear => 1.0,
            Activation::Logistic => y * (1.0 - y),
            Activation::Relu => f64::from(u8::from(y > 0.0)),
        }
    }

    /// Values of all layers for a row.
    fn values(topology: &Topology, weights: &[f64], row: Vec<f64>) -> Vec<Vec<f64>> {
        topology.layers().fold(vec![row], |mut values, layer| {
            let before = &values[values.len() - 1];
            let neuron = |j: usize| {
                let row = &weights[layer.start + j * layer.from..][..layer.from];
                let products = row.iter().zip(before).map(|(w, x)| w * x);
                layer.activation.double(weights[layer.biases() + j] + products.sum::<f64>())
            };
            values.push((0..layer.to).map(neuron).collect());
            values
        })
    }

    /// Derivatives of an output by all weights, by the textbook.
    fn derivatives(case: &Case, values: &[Vec<f64>], output: usize) -> Vec<f64> {
        let Case { topology, weights, .. } = case;
        let mut found = vec![0.0; weights.len()];
        let mut deltas = vec![0.0; topology.outputs()];
        deltas[output] = 1.0;
        for (at, layer) in topology.layers().enumerate().collect::<Vec<_>>().into_iter().rev() {
            for (delta, y) in deltas.iter_mut().zip(&values[at + 1]) {
                *delta *= slope(layer.activation, *y);
            }
            let mut before = vec![0.0; layer.from];
            for (j, delta) in deltas.iter().enumerate() {
                found[layer.biases() + j] = *delta;
                for i in 0..layer.from {
                    let weight = layer.start + j * layer.from + i;
                    found[weight] = delta * values[at][i];
                    before[i] += delta * weights[weight];
                }
            }
            deltas = before;
        }
        found
    }

    /// A sum and the sum of the sizes of its terms.
    #[derive(Debug, Clone, Copy, Default)]
    struct Sum {
        value: f64,
        size: f64,
    }

    impl Sum {
        fn add(&mut self, term: f64) {
            self.value += term;
            self.size += term.abs();
        }

        /// The rounding of the terms themselves, which does not shrink with their number, and of some scale.
        fn check(&self, got: f64, unit: f64, n: f64, name: &str) {
            let error = (got - self.value).abs();
            assert!(error <= 30.0 * unit * (self.size + 0.05 * n), "{name}: {error:e} {self:?}");
        }
    }

    /// Sum of squares, `J'e` and `J'J`, with the penalty on all weights but the biases.
    type Sums = (f64, Vec<Sum>, Vec<Sum>);

    fn plain(case: &Case) -> Sums {
        let n = case.weights.len();
        let (mut squares, mut projected) = (0.0, vec![Sum::default(); n]);
        let mut normal = vec![Sum::default(); n * n];
        for (row, target) in case.inputs.rows().into_iter().zip(case.targets.rows()) {
            let values = values(&case.topology, &case.weights, row.to_vec());
            for (output, target) in target.iter().enumerate() {
                let e = values[values.len() - 1][output] - target;
                squares += e * e;
                let d = derivatives(case, &values, output);
                for (at, &a) in d.iter().enumerate() {
                    projected[at].add(a * e);
                    d[..=at].iter().zip(&mut normal[at * n..]).for_each(|(b, sum)| sum.add(a * b));
                }
            }
        }
        let half = 0.5 * case.decay * case.targets.len() as f64;
        for at in case.topology.layers().flat_map(|layer| layer.start..layer.biases()) {
            squares += half * case.weights[at].powi(2);
            projected[at].add(half * case.weights[at]);
            normal[at * n + at].add(half);
        }
        (squares, projected, normal)
    }

    /// Compares error, gradient and normal equations; `unit` is the rounding of one operation.
    fn compare<T: Real>(case: &Case, isa: Isa, unit: f64, plain: &Sums) {
        let mut objective = case.objective::<T>(isa);
        let weights: Vec<T> = case.weights.iter().map(|&w| T::of(w)).collect();
        let (n, residuals) = (weights.len(), case.targets.len() as f64);
        let mut gradient = vec![T::default(); n];
        let mse = objective.gradient(&weights, &mut gradient);
        let (squares, projected, normal) = plain;
        let name = format!("{:?} {} {isa}", case.topology.sizes(), T::NAME);
        // Residuals are differences of numbers near 1: each is off by some units, whatever its size.
        let expected = squares / residuals;
        let bound = 20.0 * unit * (expected + expected.sqrt());
        assert!((mse - expected).abs() < bound, "{name}: {mse} {expected}");
        assert_eq!(mse.to_bits(), objective.mse(&weights).to_bits(), "{name}");
        let (mut j_j, mut j_e) = (vec![0.0; n * n], vec![0.0; n]);
        let again = objective.normal_equations(&weights, &mut j_j, &mut j_e);
        assert!((again - expected).abs() < bound, "{name}: {again} {expected}");
        for ((sum, g), p) in projected.iter().zip(&gradient).zip(j_e) {
            sum.check(0.5 * residuals * g.double(), unit, residuals, &name);
            sum.check(p, unit, residuals, &name);
        }
        // The textbook adds one after the other, which in double precision is the larger error.
        let unit = unit.max(4e-16);
        normal.iter().zip(j_j).for_each(|(sum, got)| sum.check(got, unit, residuals, &name));
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
                    let mut case = case(sizes, &activations, rows, seed as u64);
                    case.decay = [0.0, 0.3][rows % 2];
                    let plain = plain(&case);
                    for isa in Isa::available() {
                        // A relu of a sum near zero may fall on either side in single precision.
                        if hidden != Activation::Relu {
                            compare::<f32>(&case, isa, 6e-8, &plain);
                        }
                        compare::<f64>(&case, isa, 1.2e-16, &plain);
                    }
                }
            }
        }
    }

    /// 40,000 rows: sums in single precision alone would lose three more digits. 291 weights: the Jacobian does not fit at once.
    #[test]
    fn sums_stay_accurate_over_many_rows_and_weights() {
        let activations = [Activation::Tanh, Activation::Linear];
        let [rows, weights] = [([2, 4, 1], 40_000), ([14, 16, 3], 300)]
            .map(|(sizes, rows)| case(&sizes, &activations, rows, 99));
        let of_rows = plain(&rows);
        let of_weights = plain(&weights);
        for isa in Isa::available() {
            compare::<f32>(&rows, isa, 6e-8, &of_rows);
            compare::<f32>(&weights, isa, 6e-8, &of_weights);
            compare::<f64>(&weights, isa, 1.2e-16, &of_weights);
        }
    }

    #[test]
    fn rows_that_do_not_fit_are_refused() {
        let topology = Topology::regression(2, &[3], 1).unwrap();
        let build = |inputs: (usize, usize), targets: (usize, usize)| {
            let (inputs, targets) = (Array2::zeros(inputs), Array2::zeros(targets));
            NetworkObjective::<f64>::new(&topology, &inputs, &targets).unwrap_err()
        };
        assert_eq!(build((0, 2), (0, 1)), ShapeError::Rows { inputs: 0, outputs: 0 });
        assert_eq!(build((5, 3), (5, 1)), ShapeError::Inputs { needed: 2, given: 3 });
        assert_eq!(build((4, 2), (4, 0)), ShapeError::Outputs { needed: 1, given: 0 });
        assert_eq!(build((4, 2), (3, 1)), ShapeError::Rows { inputs: 4, outputs: 3 });
        let one = Array2::zeros((1, 2));
        let rows = NetworkObjective::<f64>::new(&topology, &one, &Array2::zeros((1, 1))).unwrap();
        assert!(rows.with_decay(f64::NAN).is_err());
    }

    /// Columns side by side in memory, rows backwards, every second row: the same bits as rows copied one by one.
    #[test]
    fn any_memory_layout_gives_the_same_bits() {
        let Case { topology, inputs, weights, .. } = case(&[2, 2], &[Activation::Tanh], 60, 3);
        let columns = inputs.t().as_standard_layout().reversed_axes().into_owned();
        let every = |axis, step| columns.slice_axis(axis, Slice::from(..).step_by(step));
        for view in [columns.view(), every(Axis(0), -1), every(Axis(0), 2), every(Axis(1), -1)] {
            assert!(!view.is_standard_layout());
            let gradient = |x: &ArrayRef2<f64>| {
                let mut gradient = vec![0.0; weights.len()];
                let mut rows = NetworkObjective::new(&topology, x, x).unwrap();
                rows.gradient(&weights, &mut gradient);
                gradient
            };
            let copy = Array2::from_shape_fn(view.dim(), |at| view[at]);
            assert_eq!(gradient(&view), gradient(&copy));
        }
    }

    /// Cross-entropy by hand, row by row, and its gradient by differences; 37 rows leave lanes of the last vector empty.
    #[test]
    fn cross_entropy_and_its_gradient_are_those_of_softmax() {
        let activations = [Activation::Tanh, Activation::Linear];
        let mut case = case(&[3, 4, 5], &activations, 37, 3);
        case.targets = Array2::from_shape_fn((37, 5), |(row, class)| {
            f64::from(u8::from(row * 7 % 5 == class))
        });
        let weights = &case.weights;
        let mut by_hand = 0.0;
        for (row, target) in case.inputs.rows().into_iter().zip(case.targets.rows()) {
            let scores = &values(&case.topology, weights, row.to_vec())[2];
            let sum: f64 = scores.iter().map(|score| score.exp()).sum();
            by_hand -=
                scores.iter().zip(target).map(|(s, t)| t * (s - sum.ln())).sum::<f64>() / 37.0;
        }
        for isa in Isa::available() {
            let mut objective = case.objective::<f64>(isa).with_softmax();
            let mut gradient = vec![0.0; weights.len()];
            let error = objective.gradient(weights, &mut gradient);
            assert!((error - by_hand).abs() < 1e-12, "{isa}: {error} {by_hand}");
            assert_eq!(error.to_bits(), objective.mse(weights).to_bits(), "{isa}");
            for at in 0..weights.len() {
                let [up, down] = [1e-5, -1e-5].map(|by| {
                    let mut weights = weights.clone();
                    weights[at] += by;
                    objective.mse(&weights)
                });
                let slope = (up - down) / 2e-5;
                assert!((slope - gradient[at]).abs() < 1e-8, "{isa} {at}: {slope} {gradient:?}");
            }
        }
    }
}
