//! The seeds of the fuzz targets: the C peer does with them what this crate does.

use crate::peer::{assert_same, run};
use crate::targets::peers::{decoder_lines, device_scripts};
use crate::targets::player::Player;
use crate::targets::words::decode;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds")
}

#[test]
fn the_decoders_agree_on_every_seed() {
    let lines = decoder_lines(&folder());
    assert!(lines.len() > 500, "{}", lines.len());
    let expected: Vec<String> = lines.iter().map(|line| decode(line)).collect();
    assert_same("decoder seeds", &expected, &run("decode", &(lines.join("\n") + "\n")));
}

#[test]
fn the_devices_agree_on_every_seed() {
    let scripts = device_scripts(&folder());
    assert!(scripts.len() > 60, "{}", scripts.len());
    let (mut input, mut expected) = (String::new(), Vec::new());
    for script in &scripts {
        expected.extend(Player::default().play(script));
        input += &format!("new 0\n{}\n", script.join("\n"));
    }
    assert_same("device seeds", &expected, &run("device", &input));
}
