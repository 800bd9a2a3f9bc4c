//! Trainers against `scripts/trainer-reference.py` of 06a8dbdc, weight by weight after 100 epochs, in both precisions.

#[cfg(test)]
mod tests {
    use mlp::train::trainer::{
        GradientDescentConfig, MomentumConfig, MomentumForm, RpropConfig, RpropVariant,
    };
    use mlp::train::{Algorithm, Isa, NetworkObjective, Real, Topology};

    use ndarray::{Array2, Axis};

    const REFERENCE: &str = include_str!("reference.csv");

    fn lines(name: &str) -> impl Iterator<Item = Vec<f64>> {
        let lines = REFERENCE.lines().map(|line| line.split_once(',').unwrap());
        lines
            .filter(move |(label, _)| *label == name)
            .map(|(_, fields)| fields.split(',').map(|field| field.parse().unwrap()).collect())
    }

    fn objective<T: Real>(isa: Isa) -> NetworkObjective<T> {
        let rows: Vec<f64> = lines("row").flatten().collect();
        let rows = Array2::from_shape_vec((rows.len() / 3, 3), rows).unwrap();
        let topology = Topology::regression(2, &[5], 1).unwrap();
        let (inputs, targets) = rows.view().split_at(Axis(1), 2);
        NetworkObjective::with_isa(&topology, &inputs, &targets, isa).unwrap()
    }

    fn rules() -> Vec<(&'static str, Algorithm)> {
        let momentum = |form| Algorithm::Gdm(MomentumConfig { rate: 0.05, momentum: 0.9, form });
        let mut rules = vec![
            ("gd", Algorithm::Gd(GradientDescentConfig { rate: 0.05 })),
            ("averaged", momentum(MomentumForm::Averaged)),
            ("heavy-ball", momentum(MomentumForm::HeavyBall)),
        ];
        for variant in RpropVariant::ALL {
            let config = RpropConfig { variant, ..RpropConfig::default() };
            rules.push((variant.name(), Algorithm::Rprop(config)));
        }
        rules
    }

    /// Largest difference of a weight, relative to it or to 0.001 where it is smaller.
    fn difference<T: Real>(isa: Isa, name: &str, algorithm: Algorithm) -> f64 {
        let mut objective = objective::<T>(isa);
        let start = lines("start").next().unwrap();
        let mut weights: Vec<T> = start.into_iter().map(T::of).collect();
        let mut trainer = algorithm.trainer(weights.len());
        for _ in 0..100 {
            trainer.step(&mut objective, &mut weights);
        }
        let expected = lines(name).next().unwrap();
        assert_eq!(expected.len(), weights.len());
        let pairs = weights.iter().zip(expected);
        pairs.map(|(w, e)| (w.double() - e).abs() / e.abs().max(1e-3)).fold(0.0, f64::max)
    }

    /// In single precision rules that follow the size of the gradient stay near; those that follow its sign may part for good where
    /// rounding decides a sign, so they are only reported.
    #[test]
    fn every_weight_agrees_to_five_digits_and_stays_near_in_single_precision() {
        for isa in Isa::available() {
            for (name, algorithm) in rules() {
                let double = difference::<f64>(isa, name, algorithm);
                let single = difference::<f32>(isa, name, algorithm);
                eprintln!("{name} {isa}: f64 {double:.1e}, f32 {single:.1e}");
                assert!(double < 5e-6, "{name} {isa}: {double:e}");
                assert!(single < 1e-3 || name.contains("rprop"), "{name} {isa}: {single:e}");
            }
        }
    }
}
