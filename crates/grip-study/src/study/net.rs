//! The nets of the study: one shape, one trainer each.

use mlp::train::{
    Algorithm, Hyper,
    trainer::{
        GradientDescentConfig, LevenbergMarquardtConfig, MomentumConfig, MomentumForm, RpropConfig,
        RpropVariant, ScgConfig,
    },
};

/// Hidden neurons of every net (tanh); the output is linear.
pub const HIDDEN: usize = 10;

/// A net and, where the source study has it, what that reports of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Net {
    /// `M1` to `M4` as in the study, or the trainer's name.
    pub name: &'static str,
    /// Name of the trainer as people write it.
    pub trainer: &'static str,
    /// Number of its error curve: Fig. 3 to 6 as in the study.
    pub figure: &'static str,
    /// Published shares of correct answers, training and test rows, 0 to 1.
    pub published: Option<[f64; 2]>,
}

/// M1 to M4 and three more.
pub const NETS: [Net; 7] = [
    Net { name: "M1", trainer: "GD", figure: "3", published: Some([0.53, 0.6397]) },
    Net { name: "M2", trainer: "GDM", figure: "4", published: Some([0.51, 0.5892]) },
    Net { name: "M3", trainer: "RPROP", figure: "5", published: Some([0.63, 0.6902]) },
    Net { name: "M4", trainer: "SCG", figure: "6", published: Some([0.56, 0.6734]) },
    Net { name: "LM", trainer: "LM", figure: "6a", published: None },
    Net { name: "LBFGS", trainer: "L-BFGS", figure: "6b", published: None },
    Net { name: "BR", trainer: "BR", figure: "6c", published: None },
];

/// M2 with the other form of momentum: the study does not state which it has.
pub const HEAVY_BALL: Net =
    Net { name: "M2b", trainer: "GDM heavy ball", figure: "4b", published: None };

impl Net {
    /// Its trainer with the usual settings (MATLAB's for M1 to M4), or those of `hyper`. RPROP is Rprop-, as the study describes
    /// it: a weight whose gradient changed its sign moves on with a shorter step, one whose product of gradients is zero keeps
    /// its step.
    #[must_use]
    pub fn algorithm(&self, hyper: &Hyper) -> Algorithm {
        let heavy = MomentumConfig { form: MomentumForm::HeavyBall, ..MomentumConfig::default() };
        let minus = RpropConfig { variant: RpropVariant::Minus, ..RpropConfig::default() };
        hyper.of(match self.trainer {
            "GD" => Algorithm::Gd(GradientDescentConfig::default()),
            "GDM" => Algorithm::Gdm(MomentumConfig::default()),
            "GDM heavy ball" => Algorithm::Gdm(heavy),
            "SCG" => Algorithm::Scg(ScgConfig::default()),
            "LM" => Algorithm::Lm(LevenbergMarquardtConfig::default()),
            "BR" => Algorithm::Br,
            "L-BFGS" => Algorithm::Lbfgs,
            _ => Algorithm::Rprop(minus),
        })
    }

    /// From how many of `repeats` starts it is trained: the evidence of a few tells the best one, of each form of the target.
    #[must_use]
    pub fn starts(&self, repeats: usize) -> usize {
        if self.trainer == "BR" { repeats.min(5) } else { repeats }
    }

    /// Name and trainer: `M3 RPROP`.
    #[must_use]
    pub fn title(&self) -> String {
        if self.published.is_some() {
            format!("{} {}", self.name, self.trainer)
        } else {
            self.trainer.to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_net_has_its_own_trainer() {
        let names: Vec<&str> =
            NETS.iter().map(|net| net.algorithm(&Hyper::default()).name()).collect();
        assert_eq!(names, ["gd", "gdm", "rprop", "scg", "lm", "lbfgs", "br"]);
    }
}
