//! The time of one item: least, median and 90 % (ns) over rounds of many, one JSON object each.

use core::time::Duration;
use serde_json::json;
use slip_benches::time::now;

/// Rounds go on for so long.
const MEASURED: Duration = Duration::from_secs(2);

/// Handles rounds of `items`: `begin` sets one up outside the time, `work` handles it. What holds none of the words of the command line is
/// left out; without `--bench`, as `cargo test --benches` runs it, one round shows that it works.
#[expect(clippy::print_stdout, reason = "the result of the program")]
pub(crate) fn by_item<S>(
    what: &str,
    items: usize,
    mut begin: impl FnMut() -> S,
    mut work: impl FnMut(&mut S),
) {
    let (flags, words): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|argument| argument.starts_with("--"));
    if !words.is_empty() && !words.iter().any(|word| what.contains(word)) {
        return;
    }
    let measured =
        if flags.iter().any(|flag| flag == "--bench") { MEASURED } else { Duration::ZERO };
    let (start, mut rounds) = (now(), Vec::new());
    while rounds.is_empty() || start.elapsed() < measured {
        let mut round = begin();
        let start = now();
        work(&mut round);
        rounds.push(1e9 * start.elapsed().as_secs_f64() / items as f64);
    }
    rounds.sort_by(f64::total_cmp);
    let at = |tenths: usize| rounds.get((rounds.len() - 1) * tenths / 10);
    println!(
        "{}",
        json!({"what": what, "rounds": rounds.len(), "least_ns": at(0), "p50_ns": at(5), "p90_ns": at(9)})
    );
}
