//! `gripctl generate`: training data for the force estimate, from the simulator's physics.

use crate::{cli::learn::GenerateArgs, output};
use anyhow::Context as _;
use grip_record::{is_npz, write_columns};
use grip_session::exit::{Exit, WrongArgument};
use grip_sim::generator::{CSV_HEADER, GeneratorConfig, Source, rows};
use ndarray::Array2;
use std::io::Write as _;

pub(crate) fn run(args: &GenerateArgs) -> anyhow::Result<Exit> {
    let out = output::path(&args.output, output::COLUMNS, &args.force, &[])?;
    let source = match args.source.as_str() {
        "stretch" => Source::Stretch,
        "trial" => Source::ClosedForm,
        "simulated" => Source::Simulated,
        other => {
            let message = format!("--source {other}: expected stretch, trial or simulated");
            return Err(WrongArgument(message).into());
        }
    };
    let config = GeneratorConfig {
        source,
        speed_noise: args.speed_noise,
        force_noise: args.force_noise,
        ..GeneratorConfig::default()
    };
    let rows =
        rows(config, args.seed, args.rows).map_err(|error| WrongArgument(error.to_string()))?;
    let rows = output::progress(usize::try_from(args.rows)?, "rows").wrap_iter(rows);
    let name = args.output.display();
    if is_npz(&args.output) {
        let columns: Vec<&str> = CSV_HEADER.split(',').collect();
        let values: Vec<f64> = rows.flat_map(|row| row.values()).collect();
        let values = Array2::from_shape_vec((values.len() / columns.len(), columns.len()), values)?;
        let mut file = out.create()?;
        write_columns(&mut file, &columns, &values)
            .with_context(|| format!("cannot write {name}"))?;
        file.finish()?;
        return reported(args);
    }
    let mut file = out.create()?;
    writeln!(file, "{CSV_HEADER}")?;
    for row in rows {
        writeln!(file, "{}", row.csv())?;
    }
    file.finish()?;
    reported(args)
}

fn reported(args: &GenerateArgs) -> anyhow::Result<Exit> {
    output::line(&format!("{} rows written to {}", args.rows, args.output.display()))?;
    Ok(Exit::Done)
}
