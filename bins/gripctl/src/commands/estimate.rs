//! `gripctl estimate`: models of the adequate force against generated objects that no training saw.

use crate::{cli::learn::EstimateArgs, output, table};
use grip_eval::accuracy::{Objects, TRAINING_SEED, accuracy};
use grip_session::{
    exit::{Exit, WrongArgument},
    model,
};
use grip_sim::generator::Source;

pub(crate) fn run(args: &EstimateArgs) -> anyhow::Result<Exit> {
    if args.seed == TRAINING_SEED {
        let message =
            format!("--seed {TRAINING_SEED}: the built-in models were trained on these objects");
        return Err(WrongArgument(message).into());
    }
    let mut rows = Vec::new();
    for file in &args.model {
        let estimator = model::read_estimator(file)?;
        for source in [Source::Stretch, Source::ClosedForm] {
            let objects = Objects {
                source,
                count: args.rows,
                seed: args.seed,
                speed_noise: args.speed_noise,
                force_noise: args.force_noise,
            };
            let judged = accuracy(&file.display().to_string(), &estimator, &objects)
                .map_err(|error| WrongArgument(error.to_string()))?;
            rows.push(judged);
        }
    }
    if args.json {
        rows.iter().try_for_each(output::json)?;
    } else {
        let objects = ["model", "slips=source", "objects=rows", "in range=inside"];
        let within = ["within 10 %=within_10pct%", "of in range=within_10pct_inside%"];
        let errors = ["error % p50/p95=error%", "1/2 sigma %=within_sigmas%", "trusted"];
        table::print(&rows, &[&objects[..], &within, &errors].concat())?;
    }
    Ok(Exit::Done)
}
