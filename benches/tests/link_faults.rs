//! Nine kinds of line faults on streams of real frames: nothing corrupt is accepted, no clean frame is lost, none comes late.
#![expect(clippy::unwrap_used, reason = "test code")]

use grip_sim::line_fault::LineFault;
use slip_benches::link_faults::{FRAMES, run};

const FRAMES_A_KIND: u64 = 100_000;

fn check(fault: LineFault) {
    let tally = run(fault, FRAMES_A_KIND, 2).unwrap();
    assert!(tally.kept(), "{fault:?}: {tally:?}");
    assert!(tally.frames >= FRAMES_A_KIND && tally.faults * 8 > tally.frames, "{tally:?}");
    let clean = tally.frames - tally.damaged;
    assert!(clean > tally.frames / 2, "{tally:?}");
    assert!(tally.damaged > tally.faults / 2 && FRAMES == 7, "{tally:?}");
    let repeating = matches!(fault, LineFault::PacketDoubled | LineFault::Swapped);
    assert!(!repeating || tally.repeats > 0, "whole frames came again: {tally:?}");
}

macro_rules! fault_kinds {
    ($($name:ident $kind:ident;)*) => {
        $(#[test] fn $name() { check(LineFault::$kind); })*
    };
}

fault_kinds! {
    one_bit_flipped BitFlip;
    one_byte_replaced ByteReplaced;
    bytes_deleted Deleted;
    bytes_inserted Inserted;
    burst_overwritten Burst;
    sixty_four_bytes_lost PacketLost;
    sixty_four_bytes_doubled PacketDoubled;
    blocks_swapped Swapped;
    stall_and_garbage StallAndGarbage;
}
