//! A seed in, lines for the mode `decode` of the peers out: who listens, and the bytes of a line that is often bad.

use crate::dice::Dice;
use crate::targets::gripper::{SESSION, wire};
use crate::targets::words::hex;
use grip_link::frame::{Direction, Header};
use grip_link::message::Kind;

const KINDS: [u8; 14] =
    [0x01, 0x03, 0x04, 0x06, 0x10, 0x10, 0x12, 0x7E, 0x81, 0x86, 0x90, 0x91, 0x94, 0xA0];

fn frame(dice: &mut Dice, seq: u16) -> Vec<u8> {
    let kind = dice.pick(&KINDS);
    // Now and then the other way: an echo.
    let to_host = (kind >= 0x80) ^ dice.one_in(20);
    let direction = if to_host { Direction::ToHost } else { Direction::ToDevice };
    let session = if dice.one_in(10) { dice.byte().into() } else { SESSION };
    let version = if dice.one_in(20) { dice.byte() % 16 } else { 1 };
    let longest = dice.pick(&[1, 30, 30, 300, 481]);
    let len = dice.below(longest);
    let mut payload = dice.bytes(len);
    if dice.one_in(3) {
        payload.iter_mut().for_each(|byte| *byte &= 1);
    }
    wire(&Header { version, ..Header::new(direction, Kind(kind), seq, session) }, &payload)
}

/// Up to thirteen frames, mostly in order.
fn bytes(dice: &mut Dice) -> Vec<u8> {
    let mut all = Vec::new();
    let mut seq = dice.pick(&[0, 1, 255, 65_534]);
    for _ in 0..=dice.below(13) {
        all.extend(frame(dice, seq));
        seq = seq.wrapping_add(dice.pick(&[1, 1, 1, 1, 1, 1, 1, 0, 7, 40_000, 65_281, 65_280]));
    }
    for _ in 0..dice.below(5) {
        dice.damage(&mut all);
    }
    if dice.one_in(20) {
        let long = vec![7; 480 + dice.below(30)];
        all.extend([&[0], &long[..], &[0]].concat());
    }
    all
}

/// So many lines.
pub(crate) fn lines(seed: u64, count: usize) -> Vec<String> {
    let mut dice = Dice::new(seed);
    let mut line = || {
        let role = dice.pick(&["device", "host"]);
        let session = dice.pick(&["-", "beef", "beef", "beef:0", "beef:65535", "beef:300"]);
        format!("{role} {session} {}", hex(&bytes(&mut dice)))
    };
    (0..count).map(|_| line()).collect()
}
