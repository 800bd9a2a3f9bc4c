//! Settings of training rules, from their options.

use crate::cli::learn::HyperArgs;
use grip_session::exit::WrongArgument;
use mlp::train::{Algorithm, Hyper, trainer::MomentumForm};

/// The settings that the options name.
pub(super) fn of(args: &HyperArgs) -> Result<Hyper, WrongArgument> {
    let form = match args.momentum.as_deref() {
        None => None,
        Some("averaged") => Some(MomentumForm::Averaged),
        Some("heavy-ball") => Some(MomentumForm::HeavyBall),
        Some(other) => {
            let message = format!("--momentum {other}: expected averaged or heavy-ball");
            return Err(WrongArgument(message));
        }
    };
    let variant = |text: &String| {
        text.parse().map_err(|error| WrongArgument(format!("--rprop {text}: {error}")))
    };
    let [initial, increase, decrease, max] =
        args.rprop_steps.map_or([None; 4], |steps| steps.map(Some));
    Ok(Hyper {
        rate: args.rate,
        momentum: args.momentum_share,
        form,
        variant: args.rprop.as_ref().map(variant).transpose()?,
        initial,
        increase,
        decrease,
        max,
        sigma: args.sigma,
        lambda: args.lambda,
        mu: args.mu,
    })
}

/// Refuses options of other rules than `algorithm`.
pub(super) fn refuse_others(args: &HyperArgs, algorithm: Algorithm) -> Result<(), WrongArgument> {
    for (option, given, rules) in [
        ("--rate", args.rate.is_some(), &["gd", "gdm", "gdx"][..]),
        ("--momentum", args.momentum.is_some(), &["gdm"]),
        ("--momentum-share", args.momentum_share.is_some(), &["gdm", "gdx"]),
        ("--rprop", args.rprop.is_some(), &["rprop"]),
        ("--rprop-steps", args.rprop_steps.is_some(), &["rprop"]),
        ("--sigma", args.sigma.is_some(), &["scg"]),
        ("--lambda", args.lambda.is_some(), &["scg"]),
        ("--mu", args.mu.is_some(), &["lm"]),
    ] {
        if given && !rules.contains(&algorithm.name()) {
            let rules = rules.join(", ");
            return Err(WrongArgument(format!("{option} goes with --algorithm {rules} only")));
        }
    }
    Ok(())
}
