//! Layers as texts, with names that no file has.

use super::Layers;
use crate::config::HostConfig;
use std::path::Path;

fn layers(texts: &[(&str, &str)]) -> Layers {
    let mut layers = Layers::default();
    texts.iter().for_each(|(file, text)| layers.push(Path::new(file), text));
    layers
}

fn error(texts: &[(&str, &str)]) -> String {
    layers(texts).resolve().unwrap_err().to_string()
}

#[test]
fn each_layer_replaces_single_keys() {
    let mut layers = layers(&[
        (
            "etc.toml",
            "baud = 1\nmethods = [\"stylus\", \"travel\"]\n[grip]\nf_max_n = 10.0\ntrial_force_n = 1.0\n",
        ),
        ("user.toml", "methods = [\"pressure\"]\n[grip]\nf_max_n = 8.0\n"),
        ("gripd.toml", "detector.shear.high_hz = 300.0\n"),
    ]);
    layers.set("--baud or GRIPD_BAUD", "baud", 9600);
    let config = layers.resolve().unwrap();
    assert_eq!((config.grip.f_max_n, config.grip.trial_force_n), (8.0, 1.0));
    assert_eq!(config.methods.len(), 1, "arrays are replaced");
    let default = HostConfig::default().detector.shear;
    assert_eq!(config.detector.shear.high_hz, 300.0);
    assert_eq!(config.detector.shear.low_hz, default.low_hz, "tables are merged");
    assert_eq!(config.baud, Some(9600));
    let settings = layers.settings().unwrap();
    let reported: Vec<String> = settings
        .iter()
        .map(|s| {
            format!(
                "{} = {} {} {:?}",
                s.key,
                s.value,
                s.place,
                s.replaces.iter().map(ToString::to_string).collect::<Vec<_>>()
            )
        })
        .collect();
    assert_eq!(reported[0], "baud = 9600 --baud or GRIPD_BAUD [\"etc.toml:1:1\"]");
    assert_eq!(reported[1], "detector.shear.high_hz = 300.0 gripd.toml:1:16 []");
    assert_eq!(reported[2], "grip.f_max_n = 8.0 user.toml:3:1 [\"etc.toml:4:1\"]");
}

#[test]
fn a_mistake_is_reported_in_its_own_file_even_where_it_is_hidden() {
    let reported = error(&[("etc.toml", "\nbaud = \"x\"\n"), ("gripd.toml", "baud = 5\n")]);
    assert!(
        reported.starts_with("etc.toml:2:8: invalid type: string \"x\", expected u32\n2 | "),
        "{reported}"
    );
    let reported = error(&[("etc.toml", "baud = 5\n"), ("user.toml", "[grip]\nforce = 3\n")]);
    assert!(reported.starts_with("user.toml:2:1: unknown field `force`"), "{reported}");
}

#[test]
fn a_range_names_the_place_of_the_value_in_force() {
    let etc = ("etc.toml", "[grip]\ntrial_force_n = 7.0\n");
    let reported = error(&[etc, ("gripd.toml", "[grip]\nf_max_n = 5.0\n")]);
    assert_eq!(reported, "etc.toml:2:1: grip.trial_force_n = 7 is outside 0.01 to 5");
    let reported = error(&[("gripd.toml", "[grip]\nf_max_n = 1.0\n")]);
    assert_eq!(
        reported,
        "gripd.toml:1:2: grip.trial_force_n = 1.2 is outside 0.01 to 1 (a default, which does not fit what is set)"
    );
    let mut layers = layers(&[etc]);
    layers.set("--baud or GRIPD_BAUD", "baud", 0);
    let reported = layers.resolve().unwrap_err().to_string();
    assert_eq!(reported, "--baud or GRIPD_BAUD: baud = 0 is outside 1 to 1000000000");
}

#[test]
fn a_calibration_lies_beside_the_file_that_names_it() {
    let reported = error(&[("etc/gripd.toml", "calibration = \"CAL.toml\"\n"), ("gripd.toml", "")]);
    assert!(reported.starts_with("etc/CAL.toml: "), "{reported}");
    let reported = error(&[("etc/gripd.toml", "calibration = \"/none/CAL.toml\"\n")]);
    assert!(reported.starts_with("/none/CAL.toml: "), "{reported}");
}
