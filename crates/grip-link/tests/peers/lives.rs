//! A seed in, lines for the mode `device` of the peers out: lives as the fuzz target `device` reads them from bytes, on a
//! line that damages and cuts, with reports of motion.

use crate::dice::Dice;
use crate::targets::script::{Step, TURNS, steps};
use crate::targets::words::{hex, unhex};

/// What happens, as often as it stands here.
const OFTEN: &str = "micros micros micros millis millis drive drive drive send send send grip grip grip grip grip \
                     row row floats short short config clear clear measured frame noise ready hello start alive log \
                     link fault estop";

/// From the power on to samples, with all answers.
const LINK: [&str; 9] =
    ["ready", "hello", "send", "config", "send", "start", "send", "grip", "drive"];

/// A turn with its arguments; those that another length would suit make other turns of the bytes that follow.
fn turn(dice: &mut Dice, name: &str, bytes: &mut Vec<u8>) {
    let place = TURNS.iter().position(|turn| *turn == name).unwrap();
    bytes.push(u8::try_from(place).unwrap());
    let any = |dice: &mut Dice, most: usize| {
        let len = dice.below(most);
        [&[u8::try_from(len).unwrap()], &dice.bytes(len)[..]].concat()
    };
    match name {
        "micros" => bytes.extend(dice.pick(&[1_u16, 137, 200, 1000, 5000, 20_000]).to_le_bytes()),
        "millis" => bytes.extend(dice.pick(&[4_u16, 10, 60, 90, 400, 1200]).to_le_bytes()),
        "noise" => bytes.extend(any(dice, 40)),
        "frame" => {
            // Mostly for the device, of this session and version.
            let [kind, oddity] = [dice.byte(), dice.byte()];
            let kind = dice.pick(&[0x01, 0x06, 0x10, 0x12, 0x7E, 0x81, kind]);
            bytes.extend([kind, dice.pick(&[0x40, 0x41, 0x42, 0x0C, 0x70, oddity])]);
            bytes.extend(any(dice, 30));
        }
        "config" => {
            let style = dice.pick(&[0, 0, 0, 2, 3]);
            bytes.push(style);
            match style {
                // Life, time until the loss action, that action.
                2 => bytes.extend([dice.byte() % 120, 0, dice.byte(), 1, dice.byte()]),
                3 => bytes.extend(dice.bytes(22)),
                _ => {}
            }
        }
        "grip" => {
            let style = dice.byte() & 0x7F;
            bytes.push(dice.pick(&[0, 0, 0, 0, style]));
            bytes.extend(dice.pick(&[0_u16, 700, 5000, 9000, 30_000]).to_le_bytes());
        }
        "row" | "floats" => bytes.extend([0, dice.byte(), dice.byte()]),
        "measured" => bytes.extend(dice.bytes(4)),
        "log" => bytes.extend([&[dice.byte()], &any(dice, 256)[..]].concat()),
        "short" => bytes.extend([&[dice.byte() & 1], &dice.bytes(4)[..]].concat()),
        "hello" | "send" | "fault" | "clear" => bytes.push(dice.byte()),
        _ => {}
    }
}

/// What one gripper lives through.
pub(crate) fn life(seed: u64) -> Vec<String> {
    let mut dice = Dice::new(seed);
    let mut bytes = vec![dice.byte()];
    let often: Vec<&str> = OFTEN.split_whitespace().collect();
    if dice.one_in(4) {
        turn(&mut dice, "drive", &mut bytes);
    }
    LINK.iter().for_each(|name| turn(&mut dice, name, &mut bytes));
    while bytes.len() < 1000 {
        match dice.pick(&often) {
            "link" => LINK.iter().for_each(|name| turn(&mut dice, name, &mut bytes)),
            name => turn(&mut dice, name, &mut bytes),
        }
    }
    let first = if seed % 3 == 1 { "new 0 passive" } else { "new 0" };
    let mut lines = vec![first.to_owned()];
    for step in steps(&bytes) {
        lines.extend(arrives(&mut dice, &step));
        if dice.one_in(40) {
            lines.push(format!("motion {} {}", step.tick, dice.below(2)));
        }
    }
    lines
}

/// The line of a step; bytes may be damaged, or arrive in two pieces.
fn arrives(dice: &mut Dice, step: &Step) -> Vec<String> {
    let line = step.line();
    let Some((head, text)) = line.strip_prefix("rx ").and_then(|rest| rest.split_once(' ')) else {
        return vec![line];
    };
    let mut bytes = unhex(text);
    if dice.one_in(50) {
        dice.damage(&mut bytes);
    }
    let cut = if dice.one_in(25) { dice.below(bytes.len() + 1) } else { bytes.len() };
    let pieces = [&bytes[..cut], &bytes[cut..]].into_iter().filter(|piece| !piece.is_empty());
    pieces.map(|piece| format!("rx {head} {}", hex(piece))).collect()
}
