//! `gripctl esc`: every reading of E_sc for a list of irregularities.

use super::checked;
use crate::{cli::EscArgs, output, table};
use grip_eval::esc::{EscLine, readings};
use grip_record::read_irregularities;
use grip_session::exit::{Exit, WrongArgument};
use serde_json::json;
use slip_core::esc::{Reading, Trial};

/// Longer ones (m) are heights and spacings in another unit.
const LONGEST_M: f64 = 0.1;

pub(crate) fn run(args: &EscArgs) -> anyhow::Result<Exit> {
    let trial = trial(args.force, args.speed, args.noise)?;
    let list = read_irregularities(&args.file)?;
    let lines = readings(list.iter().map(|i| (i.delta_m, i.spacing_m)), &trial);
    let left_out = lines.first().map_or(0, |line| line.degenerate);
    if left_out > 0 {
        eprintln!(
            "{}: {left_out} of {} irregularities left out: height and spacing must be positive and finite",
            args.file.display(),
            list.len()
        );
    }
    let longest_m = list.iter().flat_map(|i| [i.delta_m, i.spacing_m]).fold(0.0, f64::max);
    if longest_m > LONGEST_M {
        eprintln!(
            "{}: {longest_m} m is no irregularity of a surface: delta_m and s_m are in metres (20 um is 2e-5)",
            args.file.display()
        );
    }
    if args.json {
        for line in &lines {
            output::json(line)?;
        }
        return Ok(Exit::Done);
    }
    output::line(&format!(
        "{} irregularities, {} N, {} m/s, relative noise {} of each delta/s",
        list.len(),
        args.force,
        args.speed,
        args.noise
    ))?;
    table(&lines)?;
    Ok(Exit::Done)
}

/// The trial of the command line.
pub(super) fn trial(force: f64, speed: f64, noise: f64) -> Result<Trial, WrongArgument> {
    let force = checked("--force", force, false)?;
    let speed = checked("--speed", speed, false)?;
    Ok(Trial::new(force, speed).with_noise(checked("--noise", noise, true)?))
}

/// The readings as a table.
pub(super) fn table(lines: &[EscLine]) -> anyhow::Result<()> {
    let row = |(line, reading): (&EscLine, Reading)| {
        let within = match (line.value, line.lo, line.hi) {
            (Some(value), Some(lo), Some(hi)) if lo.is_finite() && hi.is_finite() => {
                format!("{:.0e}", (hi - value).max(value - lo))
            }
            (Some(_), ..) => "any".to_owned(),
            (None, ..) => "-".to_owned(),
        };
        let value = line.value.map(|value| format!("{value:.9e}"));
        json!({"line": line, "value": value, "within": within, "formula": reading.formula()})
    };
    let rows: Vec<_> = lines.iter().zip(Reading::ALL).map(row).collect();
    let value = ["reading=line.reading", "value", "unit=line.unit", "within"];
    let doubt = ["condition=line.condition", "sigma_S=line.sigma_s", "flags=line.flags", "formula"];
    table::print(&rows, &[value, doubt].concat())
}
