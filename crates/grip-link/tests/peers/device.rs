//! Decoders and devices: random lines and lives, the seeds of the fuzz targets, and lives that chance hardly finds.

use crate::lives::life;
use crate::peer::Peer;
use crate::streams;
use crate::targets::directed::{judge, lives};
use crate::targets::peers::{decoder_lines, device_scripts};
use crate::targets::player::Player;
use crate::targets::words::decode;
use std::collections::HashSet;
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
    the_decoders_give_the_same_verdicts
    the_decoders_agree_on_every_seed
    the_devices_do_the_same
    the_devices_agree_on_every_seed
    the_devices_do_what_is_wanted
}

fn decodes(peer: Peer, lines: &[String]) -> Vec<String> {
    let expected: Vec<String> = lines.iter().map(|line| decode(line)).collect();
    peer.must_say("decode", lines, &expected);
    expected
}

fn the_decoders_give_the_same_verdicts(peer: Peer) {
    let expected = decodes(peer, &streams::lines(1, 6000));
    for word in "ok: too_long cobs length crc echo version stale duplicate unknown".split(' ') {
        let count = expected.iter().filter(|line| line.contains(word)).count();
        assert!(count > 5, "{word} in {count} lines");
    }
}

fn the_decoders_agree_on_every_seed(peer: Peer) {
    let lines = decoder_lines(&seeds());
    assert!(lines.len() > 500, "{}", lines.len());
    decodes(peer, &lines);
}

fn seeds() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds")
}

fn the_devices_do_the_same(peer: Peer) {
    let count = if peer == Peer::C { 600 } else { 100 };
    let lines: Vec<String> = (0..count).flat_map(life).collect();
    let expected = Player::default().play(&lines);
    peer.must_say("device", &lines, &expected);
    let mut seen = HashSet::new();
    for line in &expected {
        seen.insert(line.split(' ').next().unwrap().to_owned());
        if let Some((_, state)) = line.split_once("state ") {
            seen.insert(format!("state {}", state.split(' ').next().unwrap()));
        }
    }
    let events =
        "linked configured started stopped command rejected heartbeat estop cleared log".split(' ');
    let states = (0..=8).map(|state| format!("state {state}"));
    for wanted in events.map(str::to_owned).chain(states) {
        assert!(seen.contains(&wanted), "no {wanted} in any life");
    }
}

fn the_devices_agree_on_every_seed(peer: Peer) {
    let scripts = device_scripts(&seeds());
    assert!(scripts.len() > 60, "{}", scripts.len());
    let anew = |script| [vec!["new 0".to_owned()], script].concat();
    let lines: Vec<String> = scripts.into_iter().flat_map(anew).collect();
    peer.must_say("device", &lines, &Player::default().play(&lines));
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
