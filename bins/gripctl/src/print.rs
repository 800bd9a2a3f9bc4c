//! Lines for standard output, as gripctl and gripfleet print them; and what their command lines cannot know of numbers.

use grip_session::exit::lines;
use serde::Serialize;
use std::io::{self, Write as _};

/// Writes text to standard output; what would change the terminal is escaped. Names from a file, a network or a device go through
/// [`grip_session::exit::escape`] before, so that none forges a line.
pub(crate) fn line(text: &str) -> io::Result<()> {
    writeln!(io::stdout().lock(), "{}", lines(text))
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

/// What the parser says of a number in the words of Rust, in plain words.
pub(crate) fn number(error: &clap::Error) -> Option<String> {
    let (text, words) =
        (error.to_string(), ["invalid float literal", "invalid digit found in string"]);
    let [number, whole] = words.map(|words| text.contains(words));
    (number || whole).then(|| {
        text.replace(words[0], "no number; decimals stand behind a point: 4.2")
            .replace(words[1], "no whole number")
    })
}
