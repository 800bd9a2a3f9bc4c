//! The seeds of the fuzz targets: the Python peer does with them what this crate does.

use crate::python::answers;
use crate::targets::peers::{decoder_lines, device_scripts};
use crate::targets::player::Player;
use crate::targets::words::decode;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds")
}

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_decoders_agree_on_every_seed() {
    let lines = decoder_lines(&folder());
    let expected: Vec<String> = lines.iter().map(|line| decode(line)).collect();
    let found = answers("decode-seeds", "decode", &lines);
    for (line, (rust, python)) in lines.iter().zip(expected.iter().zip(&found)) {
        assert_eq!(rust, python, "{line}");
    }
    assert!(lines.len() > 500 && expected.len() == found.len(), "{}", lines.len());
}

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_devices_agree_on_every_seed() {
    let scripts = device_scripts(&folder());
    assert!(scripts.len() > 60, "{}", scripts.len());
    let expected: Vec<String> =
        scripts.iter().flat_map(|script| Player::default().play(script)).collect();
    let lines: Vec<String> = scripts
        .into_iter()
        .flat_map(|script| [vec!["new 0".to_owned()], script].concat())
        .collect();
    let found = answers("device-seeds", "device", &lines);
    for (number, (rust, python)) in expected.iter().zip(&found).enumerate() {
        let before = &expected[number.saturating_sub(5)..number];
        assert_eq!(rust, python, "answer {number}, after {before:#?}");
    }
    assert_eq!(expected.len(), found.len());
}
