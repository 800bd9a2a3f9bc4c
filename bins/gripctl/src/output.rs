//! Results for standard output: text for people, one JSON object a line for machines.

pub(crate) use crate::print::{is_closed_pipe, json, line, number};

use crate::cli::ForceArgs;
use core::{fmt::Display, sync::atomic::AtomicBool};
use grip_plot::Chart;
use grip_record::outputs::{OutputError, OutputKind, OutputPath};
use grip_session::exit::{escape, lines};
use indicatif::{ProgressBar, ProgressStyle};
use mlp::train::{Classified, Evaluation};
use std::{io, path::Path, sync::Arc};

/// A recording, or rows of data, as columns.
pub(crate) const COLUMNS: OutputKind = OutputKind::data(&["csv", "npz"]);
/// A recording in a file of its own.
pub(crate) const TABLE: OutputKind = OutputKind::data(&["csv"]);
/// A chart.
pub(crate) const PICTURE: OutputKind =
    OutputKind { endings: &["svg", "png"], strict: true, is_ours: is_picture };
/// What a training has found.
pub(crate) const MODEL: OutputKind = OutputKind {
    endings: &["json"],
    strict: false,
    is_ours: |head| {
        ["mlp-model", "ensemble-model", "svr-model", "gp-model", "poly-model"]
            .iter()
            .any(|format| is_format(head, format))
    },
};
/// How a model came about.
pub(crate) const CARD: OutputKind = OutputKind {
    endings: &["json"],
    strict: false,
    is_ours: |head| is_format(head, "mlp-model-card"),
};

/// Looks at the name of an output, before any work is done for it; `inputs` is all that the command reads.
pub(crate) fn path(
    file: &Path,
    kind: OutputKind,
    force: &ForceArgs,
    inputs: &[Option<&Path>],
) -> Result<OutputPath, OutputError> {
    OutputPath::new(file, kind, inputs.iter().copied().flatten(), Some(force.force))
}

/// Draws a chart into its file.
pub(crate) fn draw(chart: &Chart, out: &OutputPath) -> anyhow::Result<()> {
    Ok(out.write(chart.bytes(out.file())?)?)
}

pub(crate) fn is_picture(head: &[u8]) -> bool {
    head.starts_with(b"<svg") || head.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// Whether this is the beginning of our JSON that states its format.
fn is_format(head: &[u8], format: &str) -> bool {
    head.starts_with(format!("{{\n  \"format\": \"{format}\",").as_bytes())
}

/// Whether `text` stands in the beginning of a file.
pub(crate) fn has(head: &[u8], text: &str) -> bool {
    head.windows(text.len()).any(|part| part == text.as_bytes())
}

/// The same for standard error.
pub(crate) fn note(text: &str) {
    eprintln!("{}", lines(text));
}

/// One line for standard error on a file or a name.
pub(crate) fn remark(of: impl Display, text: impl Display) {
    note(&escape(&format!("{of}: {text}")));
}

/// Whether the user has stopped the program (Ctrl-C, SIGTERM), from now on.
pub(crate) fn stopped() -> io::Result<Arc<AtomicBool>> {
    let stopped = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stopped))?;
    }
    Ok(stopped)
}

/// What an optional output is called, looked at as by [`path`].
pub(crate) fn optional(
    file: Option<&Path>,
    kind: OutputKind,
    force: &ForceArgs,
    inputs: &[Option<&Path>],
) -> Result<Option<OutputPath>, OutputError> {
    file.map(|file| path(file, kind, force, inputs)).transpose()
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
        None => errors(of, [found.mse, found.scaled_mse], found.within_fraction(0.1), found.r2),
        Some(Classified { accuracy, cross_entropy }) => line(&format!(
            "{of} {:.1} % of the classes right, cross-entropy {cross_entropy:.4}, mse of the probabilities {:.6}",
            100.0 * accuracy,
            found.mse
        )),
    }
}

/// The errors of a learner on some rows, after what `of` states of them.
pub(crate) fn errors(
    of: &str,
    [mse, scaled]: [f64; 2],
    within_10pct: f64,
    r2: Option<f64>,
) -> io::Result<()> {
    line(&format!(
        "{of} mse {mse:.6} (target unit squared), {scaled:.6} (scaled), {}",
        share(within_10pct, r2)
    ))
}

/// How many answers are near, and how much better than the mean they are; nothing of a target that is always the same.
pub(crate) fn share(within_10pct: f64, r2: Option<f64>) -> String {
    r2.map_or("the target does not vary".to_owned(), |r2| {
        format!("within 10 %: {:.1} %, R2 {r2:.4}", 100.0 * within_10pct)
    })
}
