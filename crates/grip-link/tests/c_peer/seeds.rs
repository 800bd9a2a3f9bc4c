//! The seeds of the fuzz targets: the C peer does with them what this crate does.

use crate::decode::judged;
use crate::device::{gripper, step};
use crate::peer::{assert_same, run, unhex};
use crate::targets::peers::{decoder_lines, device_scripts};
use grip_link::decoder::{Decoder, Role};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds")
}

/// The answer to `ROLE SESSION[:SEQ]|- HEX`.
fn answer(line: &str) -> String {
    let [role, session, hex] = line.split(' ').collect::<Vec<_>>().try_into().unwrap();
    let mut decoder = Decoder::new(if role == "device" { Role::Device } else { Role::Host });
    if session != "-" {
        let (session, seq) = session.split_once(':').map_or((session, None), |(s, q)| (s, Some(q)));
        let newest = seq.map(|seq| seq.parse().unwrap());
        decoder.open_session(u16::from_str_radix(session, 16).unwrap(), newest);
    }
    judged(decoder, &unhex(hex))
}

#[test]
fn the_decoders_agree_on_every_seed() {
    let lines = decoder_lines(&folder());
    assert!(lines.len() > 500, "{}", lines.len());
    let expected: Vec<String> = lines.iter().map(|line| answer(line)).collect();
    assert_same("decoder seeds", &expected, &run("decode", &(lines.join("\n") + "\n")));
}

#[test]
fn the_devices_agree_on_every_seed() {
    let scripts = device_scripts(&folder());
    assert!(scripts.len() > 60, "{}", scripts.len());
    let (mut input, mut expected) = (String::new(), Vec::new());
    for script in &scripts {
        let mut device = gripper();
        expected.extend(script.iter().flat_map(|line| step(&mut device, line)));
        input += &format!("new 0\n{}\n", script.join("\n"));
    }
    assert_same("device seeds", &expected, &run("device", &input));
}
