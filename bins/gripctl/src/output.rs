//! Results for standard output: text for people, one JSON object a line for machines.

use grip_session::exit::lines;
use indicatif::{ProgressBar, ProgressStyle};
use mlp::train::{Classified, Evaluation};
use serde::Serialize;
use std::io::{self, Write as _};

/// Writes text to standard output; what would change the terminal is escaped. Names from a file, a network or a device go through
/// [`escape`](grip_session::exit::escape) before, so that none forges a line.
pub(crate) fn line(text: &str) -> io::Result<()> {
    writeln!(io::stdout().lock(), "{}", lines(text))
}

/// The same for standard error.
pub(crate) fn note(text: &str) {
    eprintln!("{}", lines(text));
}

/// Writes a value as one line of JSON to standard output.
pub(crate) fn json(value: &impl Serialize) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    serde_json::to_writer(&mut out, value)?;
    writeln!(out)?;
    Ok(())
}

/// Whether the reader of our output has gone away (`gripctl ... | head`), which is no failure.
pub(crate) fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let io = cause.downcast_ref::<io::Error>().map(io::Error::kind);
        let json =
            cause.downcast_ref::<serde_json::Error>().and_then(serde_json::Error::io_error_kind);
        io.or(json) == Some(io::ErrorKind::BrokenPipe)
    })
}

/// A bar for so many of `what`, with the time that is left: on a terminal, on standard error; nothing elsewhere.
pub(crate) fn progress(length: usize, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length as u64);
    let template = format!("{{msg}}{{bar:30}} {{pos}}/{{len}} {what}, {{eta}} left");
    match ProgressStyle::with_template(&template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// A number in a unit that is not known: three decimals, or powers of ten where they report too little.
pub(crate) fn any_unit(value: f32) -> String {
    if (0.1..1e5).contains(&value) { format!("{value:.3}") } else { format!("{value:.2e}") }
}

/// A number with `digits` decimals, or a dash.
pub(crate) fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

/// The errors of a network on some rows, after what `of` states of them.
pub(crate) fn evaluation(of: &str, found: &Evaluation) -> io::Result<()> {
    match found.classes {
        None => errors(of, found.mse, found.scaled_mse, found.within_fraction(0.1)),
        Some(Classified { accuracy, cross_entropy }) => line(&format!(
            "{of} {:.1} % of the classes right, cross-entropy {cross_entropy:.4}, mse of the probabilities {:.6}",
            100.0 * accuracy,
            found.mse
        )),
    }
}

/// The errors of a learner on some rows, after what `of` states of them.
pub(crate) fn errors(of: &str, mse: f64, scaled: f64, within_10pct: f64) -> io::Result<()> {
    line(&format!(
        "{of} mse {mse:.6} (target unit squared), {scaled:.6} (scaled), within 10 %: {:.1} %",
        100.0 * within_10pct
    ))
}
