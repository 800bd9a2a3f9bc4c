//! A board as a busy hour leaves it in; what metrics, status and dumps cost out, for docs/results.md.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

#[path = "../tests/service/made.rs"]
#[expect(dead_code, reason = "shared with the tests, which use the rest")]
mod made;

use core::time::Duration;
use grip_daemon::{
    Board, HotCounters, Item,
    dump::{Cause, FlightRecorder},
    exposition::Exposition,
    log::Clocks,
    metrics,
    status::Status,
};
use std::time::Instant;

/// The least time of 200 runs.
#[expect(clippy::disallowed_methods, reason = "this is what is measured")]
fn least(mut run: impl FnMut()) -> Duration {
    let times = (0..200).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed()
    });
    times.min().unwrap_or_default()
}

fn main() -> Result<(), serde_json::Error> {
    let board = made::board();
    let mut page = Exposition::default();
    let text = least(|| metrics::write(&board, 1, &mut page));
    println!("| a page of metrics, {} bytes | {text:?} |", page.text().len());
    let json = Status::of(&board, 1).json()?.len();
    let status = least(|| drop(Status::of(&board, 1).json()));
    println!("| the status, {json} bytes | {status:?} |");
    let mut recorder = FlightRecorder::new(None);
    let mut bytes = [0x55; 320];
    bytes[319] = 0;
    let frame = least(|| {
        for host_us in 0..1000 {
            recorder.take(&Item::Wire { host_us, to_device: false, bytes: &bytes });
        }
    });
    println!("| a frame of 320 bytes remembered for a dump | {:?} |", frame / 1000);
    let now = Clocks { host_us: 0, wall_us: 0 };
    let dump = least(|| drop(recorder.text(&Cause::Asked, &board, now)));
    let size = recorder.text(&Cause::Asked, &board, now).len();
    println!("| the text of a dump, {size} bytes | {dump:?} |");
    let mut board = Board::default();
    let state = least(|| {
        for _ in 0..1000 {
            board.take(&Item::State(&made::STATE));
        }
    });
    println!("| a state taken by the board | {:?} |", state / 1000);
    println!("| a copy of the counters | {} bytes |", size_of::<HotCounters>());
    let mut hot = HotCounters::default();
    let record =
        least(|| (0..1000).for_each(|ns| hot.latency.record(core::hint::black_box(20 * ns))));
    println!("| a latency recorded | {:?} |", record / 1000);
    Ok(())
}
