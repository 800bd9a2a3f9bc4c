//! Models that have to be signed: those of clients, and that of the configuration; and the way back, which no signature closes.

use crate::{
    running::{UPDATES, client, gripd, serving},
    shadow::{cast, load},
};
use grip_session::model::default_text;
use rustix::process::Signal;
use std::fs;
use stories::Ended;

/// A key, a model with its signature by that key, and two of its signatures that are not taken.
const KEY: &str = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ";
const MODEL: &str = include_str!("../../../../crates/grip-session/tests/signed/model.json");
const SIGNATURE: &str =
    include_str!("../../../../crates/grip-session/tests/signed/model.json.minisig");
const BY_OTHER: &str =
    include_str!("../../../../crates/grip-session/tests/signed/other-key.minisig");
const LEGACY: &str = include_str!("../../../../crates/grip-session/tests/signed/legacy.minisig");
/// Who has signed it.
const SIGNER: &str = "(signed with key AF8131513DC1E017: trained in hall-2, card sha256:0f1e)";

fn keys() -> String {
    format!("model_keys = [\"{KEY}\"]\n")
}

fn signed() -> String {
    MODEL.to_owned() + SIGNATURE
}

/// The default model, with another SHA-256.
fn unsigned() -> String {
    default_text().to_owned() + " "
}

#[test]
fn a_client_brings_signed_models_only_where_a_key_is_set() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("gripd.toml"), "allow_models = true\n".to_owned() + &keys())
        .unwrap();
    let running = serving(folder.path(), &[]);
    let mut client = client(folder.path(), 1, UPDATES);
    let by = |signature: &str| MODEL.to_owned() + signature;
    for (text, why) in [
        (
            unsigned(),
            "it is not signed, and model_keys takes signed models only; sign it: `minisign",
        ),
        (by(BY_OTHER), "it is signed with key A1645C1206F7CE7B, which is not in model_keys"),
        (by(LEGACY), "its signature is of the old form of minisign"),
        (signed().replacen("4.36", "4.37", 1), "its signature is not of this model"),
        (signed().replacen("hall-2", "hall-3", 1), "its signature is not of this model"),
        (signed()[..signed().len() - 30].to_owned(), "its signature cannot be read, or is cut off"),
        (
            by(&SIGNATURE.replace('\n', &"x".repeat(2000))),
            "its signature has 8278 bytes; more than",
        ),
    ] {
        // Neither in force nor beside.
        assert!(!load(&mut client, &text) && !cast(&mut client, &text), "{why}");
        running.until_reported(&format!("is not put in force: {why}"));
        running.until_reported(&format!("is not taken as a shadow: {why}"));
    }
    assert!(!running.reported().contains(" of a client "), "{}", running.reported());
    assert!(cast(&mut client, &signed()));
    running.until_reported(&format!("estimates beside the one in force {SIGNER}"));
    assert!(load(&mut client, &signed()));
    running.until_reported(&format!(" of a client is in force {SIGNER}"));
    drop(client);
    running.interrupted().done();
}

/// The folder has gripd.toml with keys, and force.json.
fn check(folder: &std::path::Path) -> Ended {
    gripd(folder, &["--check-config"])
}

#[test]
fn the_model_of_the_configuration_is_signed_too_where_a_key_is_set() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let beside = place("force.json.minisig");
    fs::write(place("gripd.toml"), keys() + "model = \"force.json\"\n").unwrap();
    fs::write(place("force.json"), MODEL).unwrap();
    check(folder.path())
        .refused(2, &["force.json: it is not signed", "sign it: `minisign -Sm ", "force.json`"]);
    for (signature, why) in [
        (BY_OTHER, "it is signed with key A1645C1206F7CE7B, which is not in model_keys"),
        (LEGACY, "its signature is of the old form of minisign"),
        ("", "its signature cannot be read, or is cut off"),
        ("{}\n", "its signature cannot be read, or is cut off"),
        (&"x".repeat(4097), "the signature of the model cannot be read: it has 4097 bytes"),
    ] {
        fs::write(&beside, signature).unwrap();
        check(folder.path()).refused(2, &["force.json", why]);
    }
    fs::write(&beside, SIGNATURE).unwrap();
    assert!(check(folder.path()).done().err.contains(&format!("force.json {SIGNER}\n")));
    fs::write(place("force.json"), MODEL.replacen("4.36", "4.37", 1)).unwrap();
    check(folder.path()).refused(2, &["force.json: its signature is not of this model"]);
    // The signature may stand in the file too.
    fs::remove_file(&beside).unwrap();
    fs::write(place("force.json"), signed()).unwrap();
    check(folder.path()).done();
    // A built-in model is a part of the program; and unsigned models may be allowed.
    fs::write(place("gripd.toml"), keys()).unwrap();
    check(folder.path()).done();
    fs::write(place("force.json"), MODEL).unwrap();
    fs::write(
        place("gripd.toml"),
        keys() + "allow_unsigned_models = true\nmodel = \"force.json\"\n",
    )
    .unwrap();
    check(folder.path()).done();
}

#[test]
fn a_reload_asks_for_signatures_and_leaves_what_is_in_force() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let config = "allow_models = true\nmodel = \"force.json\"\n";
    fs::write(place("force.json"), MODEL).unwrap();
    fs::write(place("gripd.toml"), config).unwrap();
    let running = serving(folder.path(), &[]);
    let mut client = client(folder.path(), 1, UPDATES);
    assert!(load(&mut client, &unsigned()));
    fs::write(place("gripd.toml"), config.to_owned() + &keys()).unwrap();
    running.signal(Signal::HUP);
    running.until_reported("the settings in force stay: ");
    running.until_reported("force.json: it is not signed");
    assert!(load(&mut client, &(unsigned() + " ")), "no key is in force yet");
    fs::write(place("force.json.minisig"), SIGNATURE).unwrap();
    running.signal(Signal::HUP);
    running.until_reported("the new settings are in force: model_keys: ");
    assert!(!load(&mut client, &(unsigned() + "  ")));
    // What was in force comes back, also the model of the configuration of which the file is gone.
    assert!(load(&mut client, &unsigned()));
    fs::remove_file(place("force.json")).unwrap();
    assert!(load(&mut client, ""));
    running.until_reported("force.json is in force");
    drop(client);
    running.interrupted().done();
}

#[test]
fn a_model_of_before_the_keys_comes_back_after_a_start() {
    let folder = tempfile::tempdir().unwrap();
    let config = "allow_models = true\ndump_dir = \"state\"\n";
    fs::write(folder.path().join("gripd.toml"), config).unwrap();
    let running = serving(folder.path(), &[]);
    let mut viewer = client(folder.path(), 1, UPDATES);
    assert!(load(&mut viewer, &unsigned()));
    // To be asked is not to be in force.
    assert!(cast(&mut viewer, &(unsigned() + " ")));
    drop(viewer);
    running.interrupted().done();
    fs::write(folder.path().join("gripd.toml"), config.to_owned() + &keys()).unwrap();
    let running = serving(folder.path(), &[]);
    let mut viewer = client(folder.path(), 1, UPDATES);
    assert!(!load(&mut viewer, &(unsigned() + " ")));
    assert!(load(&mut viewer, &unsigned()));
    drop(viewer);
    running.interrupted().done();
    // Whoever deletes the file closes that way.
    fs::remove_file(folder.path().join("state/accepted-models")).unwrap();
    let running = serving(folder.path(), &[]);
    let mut viewer = client(folder.path(), 1, UPDATES);
    assert!(!load(&mut viewer, &unsigned()));
    drop(viewer);
    running.interrupted().done();
}
