//! Genome of a net: a list of small numbers for its shape and training.

use core::fmt;

use mlp::Activation;
use mlp::train::{Algorithm, FitConfig};

/// Widths of the first hidden layer.
const FIRST: [usize; 11] = [2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32];
/// Widths of the second one; without a width there is none. Half of the places, so that simple nets are drawn as often.
const SECOND: [Option<usize>; 8] = [None, None, None, None, Some(3), Some(6), Some(10), Some(16)];
const ACTIVATIONS: [Activation; 3] = [Activation::Tanh, Activation::Logistic, Activation::Relu];
const TRAINERS: [&str; 6] = ["rprop", "scg", "lbfgs", "lm", "gdx", "gdm"];
const DECAYS: [f64; 5] = [0.0, 1e-6, 1e-5, 1e-4, 1e-3];

/// What a search varies.
#[derive(Debug, Clone, PartialEq)]
pub struct Genome {
    /// Neurons of each hidden layer.
    pub hidden: Vec<usize>,
    /// Their function.
    pub activation: Activation,
    /// Training rule with its usual settings.
    pub algorithm: Algorithm,
    /// Penalty on the weights, as [`FitConfig::decay`].
    pub decay: f64,
}

impl Genome {
    /// The possible values of each gene: 0 up to, but without, this number.
    pub const ALLELES: [usize; 5] =
        [FIRST.len(), SECOND.len(), ACTIVATIONS.len(), TRAINERS.len(), DECAYS.len()];

    /// What the genes stand for; none where there are too few or one is too large.
    #[must_use]
    pub fn from_genes(genes: &[usize]) -> Option<Self> {
        let &[first, second, activation, trainer, decay] = genes else { return None };
        let widths = [Some(*FIRST.get(first)?), *SECOND.get(second)?];
        Some(Self {
            hidden: widths.into_iter().flatten().collect(),
            activation: *ACTIVATIONS.get(activation)?,
            algorithm: TRAINERS.get(trainer)?.parse().ok()?,
            decay: *DECAYS.get(decay)?,
        })
    }

    /// The genes with the first of those that stand for the same thing, so that equal genomes have equal genes.
    #[must_use]
    pub fn canonical(genes: &[usize]) -> Vec<usize> {
        let mut genes = genes.to_vec();
        if let Some(second) = genes.get_mut(1) {
            let width = SECOND.get(*second);
            *second = SECOND.iter().position(|known| Some(known) == width).unwrap_or(*second);
        }
        genes
    }

    /// `base` with the shape, rule and decay of this genome.
    #[must_use]
    pub fn config(&self, base: &FitConfig) -> FitConfig {
        FitConfig {
            hidden: self.hidden.clone(),
            activation: self.activation,
            algorithm: self.algorithm,
            decay: self.decay,
            ..base.clone()
        }
    }
}

impl fmt::Display for Genome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths: Vec<String> = self.hidden.iter().map(ToString::to_string).collect();
        let name = self.algorithm.name();
        write!(f, "{} {} {name} decay {}", widths.join("-"), self.activation, self.decay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_gene_stands_for_something_and_differs() {
        for (at, &alleles) in Genome::ALLELES.iter().enumerate() {
            let texts: BTreeSet<String> = (0..alleles)
                .map(|allele| {
                    let mut genes = [0; 5];
                    genes[at] = allele;
                    Genome::from_genes(&genes).unwrap().to_string()
                })
                .collect();
            let repeated = if at == 1 { 3 } else { 0 };
            assert_eq!(texts.len(), alleles - repeated, "gene {at}: {texts:?}");
            let mut genes = [0; 5];
            genes[at] = alleles;
            assert_eq!(Genome::from_genes(&genes), None);
        }
        assert_eq!(Genome::from_genes(&[0; 4]), None);
    }

    #[test]
    fn equal_genomes_have_equal_canonical_genes() {
        let genes = [[5, 0, 1, 3, 2], [5, 3, 1, 3, 2], [5, 4, 1, 3, 2]];
        let canonical = genes.map(|genes| Genome::canonical(&genes));
        assert_eq!(canonical, [[5, 0, 1, 3, 2], [5, 0, 1, 3, 2], [5, 4, 1, 3, 2]]);
        assert_eq!(Genome::from_genes(&genes[1]), Genome::from_genes(&canonical[1]));
    }

    #[test]
    fn the_config_takes_over_what_the_genome_states() {
        let genome = Genome::from_genes(&[5, 5, 1, 3, 2]).unwrap();
        assert_eq!(genome.to_string(), "10-6 logistic lm decay 0.00001");
        let config = genome.config(&FitConfig { seed: 7, ..FitConfig::default() });
        assert_eq!((config.hidden, config.seed), (vec![10, 6], 7));
        assert_eq!((config.activation, config.algorithm.name()), (Activation::Logistic, "lm"));
    }
}
