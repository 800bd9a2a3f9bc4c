//! The page of the metrics that gripd makes, from a board on which everything is known.

use super::page;
use core::fmt::Write as _;
use grip_daemon::{
    Board, HotCounters, Item, LinkNote, board::About, exposition::Exposition, metrics,
};
use grip_link::message::{Firmware, Status};
use slip_core::{PipelineState, grip::GripState};

/// The page of gripd's metrics.
pub(super) fn metrics() -> String {
    let mut exposition = Exposition::default();
    metrics::write(&board().unwrap_or_default(), 1, &mut exposition);
    let mut text = page(
        "Metrics of gripd",
        "Every metric of `/metrics`, in its order ([observability](../observability.md)). Counters of the link and of the \
         pipeline begin anew with each link and each pipeline, as counters do after a restart: `rate()` and `increase()` know \
         that.",
    );
    text += "\n| metric | type | labels | means |\n|---|---|---|---|\n";
    let written = exposition.text();
    let mut lines = written.lines().filter_map(|line| line.strip_prefix("# "));
    while let (Some(help), Some(kind)) = (lines.next(), lines.next()) {
        let about = help.strip_prefix("HELP ").and_then(|help| help.split_once(' '));
        let (name, about) = about.unwrap_or_default();
        let kind = kind.rsplit(' ').next().unwrap_or("");
        let _ = writeln!(text, "| `{name}` | {kind} | {} | {about} |", labels(written, name));
    }
    text
}

/// Label and values of a metric; of a histogram the bounds of its first and its last bucket.
fn labels(written: &str, name: &str) -> String {
    let lines = written.lines().filter_map(|line| line.strip_prefix(name));
    let pairs = lines.filter_map(|line| {
        let label = line.strip_prefix('{').or_else(|| line.strip_prefix("_bucket{"))?;
        label.split_once("=\"")
    });
    let pairs: Vec<(&str, &str)> = pairs.filter(|(_, rest)| !rest.starts_with('+')).collect();
    let values: Vec<&str> = pairs.iter().filter_map(|(_, rest)| rest.split('"').next()).collect();
    match (pairs.first(), &values[..]) {
        (Some(("le", _)), [first, .., last]) => format!("`le`: {first} to {last}, in doublings"),
        (Some(("uid", _)), _) => "`uid`, `boot_id`".to_owned(),
        (Some((label, _)), [_]) => format!("`{label}`"),
        (Some((label, _)), _) => format!("`{label}`: {}", values.join(", ")),
        (None, _) => String::new(),
    }
}

/// Everything is known: zeros of messages are values.
fn board() -> Option<Board> {
    let mut board = Board::new(About { version: "0".to_owned(), ..About::default() });
    let firmware = Firmware::parse(&[0; Firmware::SIZE]).ok()?;
    let status = Status::parse(&[0; Status::SIZE]).ok()?;
    let found = LinkNote::Identified { uid: [0; 16], boot_id: 0, firmware, rebooted: false };
    for note in [found, LinkNote::Status(status)] {
        board.take(&Item::Link { host_us: 0, note: &note });
    }
    let state = PipelineState::parse(&[0; PipelineState::WHOLE]).ok()?;
    board.take(&Item::State(&PipelineState { grip: GripState::Holding, ..state }));
    for host_us in [0, 1_000_000] {
        board.count(&HotCounters { host_us, samples: host_us, ..HotCounters::default() });
    }
    Some(board)
}
