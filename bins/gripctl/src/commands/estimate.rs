//! `gripctl estimate`: models of the adequate force against generated objects that no training saw.

use crate::{cli::learn::EstimateArgs, output};
use grip_eval::accuracy::{Accuracy, Objects, TRAINING_SEED, accuracy};
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
        table(&rows)?;
    }
    Ok(Exit::Done)
}

fn table(rows: &[Accuracy]) -> anyhow::Result<()> {
    let width = rows.iter().map(|row| row.model.chars().count()).max().unwrap_or(0).max(5);
    output::line(&format!(
        "{:width$}  {:8} {:>8} {:>9} {:>13} {:>14} {:>14} {:>9} {:>9}",
        "model",
        "slips",
        "objects",
        "in range",
        "within 10 %",
        "of in range",
        "error p50/p95",
        "1/2 sigma",
        "trusted"
    ))?;
    for row in rows {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let error =
            |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{:.1}", 100.0 * v));
        let [one, two] = row.within_sigmas.map(|share| format!("{:.0}", 100.0 * share));
        output::line(&format!(
            "{:width$}  {:8} {:>8} {:>9} {:>13} {:>14} {:>14} {:>9} {:>9}",
            row.model,
            row.source,
            row.rows,
            row.inside,
            percent(row.within_10pct),
            percent(row.within_10pct_inside),
            format!("{}/{} %", error(row.error.p50), error(row.error.p95)),
            format!("{one}/{two} %"),
            row.trusted,
        ))?;
    }
    Ok(())
}
