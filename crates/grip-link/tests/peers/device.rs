//! Decoders and devices: the seeds of the fuzz targets, and lives that chance hardly finds.

use crate::peer::Peer;
use crate::targets::directed::{judge, lives};
use crate::targets::peers::{decoder_lines, device_scripts};
use crate::targets::player::Player;
use crate::targets::words::decode;
use std::path::Path;

/// Every test asks both peers; Python need not be there.
macro_rules! asked {
    ($($test:ident)*) => {
        mod c {
            $(#[test] fn $test() { super::$test(super::Peer::C); })*
        }
        mod python {
            $(#[test]
            #[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
            fn $test() { super::$test(super::Peer::Python); })*
        }
    };
}

asked! {
    the_decoders_agree_on_every_seed
    the_devices_agree_on_every_seed
    the_devices_do_what_is_wanted
}

fn seeds() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds")
}

/// Words that stand in no line.
fn absent(words: impl Iterator<Item = String>, lines: &[String]) -> Vec<String> {
    words.filter(|word| !lines.iter().any(|line| line.contains(word))).collect()
}

fn the_decoders_agree_on_every_seed(peer: Peer) {
    let lines = decoder_lines(&seeds());
    assert!(lines.len() > 500, "{}", lines.len());
    let expected: Vec<String> = lines.iter().map(|line| decode(line)).collect();
    let words = "ok: too_long cobs length crc echo version stale duplicate unknown".split(' ');
    assert_eq!(absent(words.map(str::to_owned), &expected), [""; 0]);
    peer.must_say("decode", &lines, &expected);
}

fn the_devices_agree_on_every_seed(peer: Peer) {
    let scripts = device_scripts(&seeds());
    assert!(scripts.len() > 400, "{}", scripts.len());
    let anew = |script| [vec!["new 0".to_owned()], script].concat();
    let lines: Vec<String> = scripts.into_iter().flat_map(anew).collect();
    let expected = Player::default().play(&lines);
    let events =
        "linked configured started stopped command rejected heartbeat estop cleared log".split(' ');
    let states = (0..=8).map(|state| format!(" state {state}"));
    assert_eq!(absent(events.map(str::to_owned).chain(states), &expected), [""; 0]);
    peer.must_say("device", &lines, &expected);
}

fn the_devices_do_what_is_wanted(peer: Peer) {
    for life in lives() {
        let rust = Player::default().play(&life.script);
        judge(&life, &rust);
        peer.must_say("device", &life.script, &rust);
    }
}

#[test]
fn gl_init_refuses_what_cannot_be() {
    let stated = Peer::C.answers("init", &[]);
    assert!(stated.len() >= 25, "{stated:#?}");
    for reason in ["ok", "tick rate", "limits", "no stylus", "row"] {
        assert!(stated.iter().any(|line| line.ends_with(&format!(": {reason}"))), "no {reason}");
    }
}
