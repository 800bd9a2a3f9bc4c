//! Random wires and device scripts: the Python peer must do byte for byte what this crate does.

use crate::dice::Dice;
use crate::python::answers;
use crate::script::Script;
use crate::targets::gripper::wire;
use crate::targets::player::Player;
use crate::targets::words::{decode, hex};
use grip_link::frame::{Direction, Header};
use grip_link::message::Kind;

const KINDS: [u8; 12] = [0x01, 0x03, 0x06, 0x10, 0x10, 0x12, 0x7e, 0x81, 0x86, 0x90, 0x91, 0xa0];

/// One to four frames, mostly in order, often damaged.
fn bytes(dice: &mut Dice) -> Vec<u8> {
    let mut all = Vec::new();
    let mut seq = dice.pick(&[0, 1, 255, 65_534]);
    for _ in 0..=dice.below(4) {
        let direction = dice.pick(&[Direction::ToDevice, Direction::ToHost]);
        let session = dice.pick(&[0xBEEF, 0xBEEF, 0xBEEF, 0, 1]);
        let header = Header::new(direction, Kind(dice.pick(&KINDS)), seq, session);
        let header = Header { version: dice.pick(&[1, 1, 1, 1, 2]), ..header };
        let longest = dice.pick(&[1, 30, 30, 300, 481]);
        let len = dice.below(longest);
        let mut payload = dice.bytes(len);
        if dice.one_in(3) {
            payload.iter_mut().for_each(|byte| *byte &= 1);
        }
        all.extend(wire(&header, &payload));
        seq = seq.wrapping_add(dice.pick(&[1, 1, 1, 0, 7, 65_281, 65_280]));
    }
    for _ in 0..dice.pick(&[0, 0, 1, 1, 3]) {
        dice.damage(&mut all);
    }
    all
}

fn same(expected: &[String], found: &[String], lines: &[String]) {
    let differ = expected.iter().zip(found).position(|(rust, python)| rust != python);
    let shown = differ.map(|at| (&expected[at], &found[at], lines.get(at)));
    assert!(differ.is_none(), "{shown:?}");
    assert_eq!(expected.len(), found.len());
}

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_decoders_give_the_same_verdicts() {
    let mut dice = Dice::new(1);
    let lines: Vec<String> = (0..4000)
        .map(|_| {
            let role = dice.pick(&["device", "host"]);
            let session = dice.pick(&["-", "beef", "beef", "beef:0", "beef:65535", "beef:300"]);
            format!("{role} {session} {}", hex(&bytes(&mut dice)))
        })
        .collect();
    let expected: Vec<String> = lines.iter().map(|line| decode(line)).collect();
    for word in "ok: too_long cobs length crc echo version stale duplicate unknown".split(' ') {
        let count = expected.iter().filter(|line| line.contains(word)).count();
        assert!(count > 5 || word == "too_long", "{word} in {count} lines");
    }
    same(&expected, &answers("decode", "decode", &lines), &lines);
}

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_devices_do_the_same() {
    for seed in 0..12 {
        let lines = Script::new(seed).lines(1500);
        let expected = Player::default().play(&lines);
        assert!(expected.len() > 500, "{}", expected.len());
        same(&expected, &answers("device", "device", &lines), &[]);
    }
}
