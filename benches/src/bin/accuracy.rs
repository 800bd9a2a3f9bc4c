//! Run time against error of everything that has more than one way to be computed.
//!
//! `accuracy [--json] [--plots DIR]`: a table for each question, or one JSON object a line; with `--plots` also
//! DIR/accuracy-NAME.svg.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints tables")]

use slip_benches::accuracy;
use std::{path::PathBuf, process::ExitCode, time::Instant};

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (mut json, mut plots) = (false, None);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--json" => json = true,
            "--plots" => plots = arguments.next().map(PathBuf::from),
            _ => {
                eprintln!("usage: accuracy [--json] [--plots DIR]");
                return ExitCode::from(2);
            }
        }
    }
    #[expect(clippy::disallowed_methods, reason = "a program may read a clock")]
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64() * 1e9;
    for panel in accuracy::panels(&clock) {
        if json {
            match serde_json::to_string(&panel) {
                Ok(line) => println!("{line}"),
                Err(error) => {
                    eprintln!("{}: {error}", panel.name);
                    return ExitCode::FAILURE;
                }
            }
        } else {
            println!("{panel}");
        }
        if let Some(folder) = &plots {
            let file = folder.join(format!("accuracy-{}.svg", panel.name));
            if let Err(error) = panel.chart().and_then(|chart| chart.write(&file)) {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
