//! What the pipeline costs on a Cortex-M4: instructions per sample in each scene and per inference, RAM and stack.
//!
//! Runs in QEMU with `-icount shift=0`, where one instruction takes one nanosecond and a tick of the 25 MHz SysTick is
//! exactly 40 instructions. Instructions are not cycles: a real core needs some more of them.
#![no_std]
#![no_main]

mod board;
#[cfg(feature = "network")]
mod model;
#[cfg(feature = "network")]
mod network;
#[cfg(feature = "pipeline")]
mod scenes;
#[cfg(feature = "pipeline")]
mod signal;
#[cfg(feature = "network")]
mod stack;

use board::{Board, print};
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    let board = Board::start();
    board.check();
    #[cfg(feature = "network")]
    network::measure(&board);
    #[cfg(feature = "pipeline")]
    scenes::measure(&board);
    print(&["done\n"], &[]);
    board::stop()
}
