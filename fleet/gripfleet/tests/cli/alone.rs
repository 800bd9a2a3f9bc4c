//! gripfleet without a gripd: what it cannot do anything with, a sentence and exit code 2; and what it waits for.

use crate::{fleet::running, run::run as gripfleet};
use std::fs;

#[test]
fn a_configuration_that_cannot_be_used_is_refused_with_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str, args: &[&str], words: &str| {
        fs::write(folder.path().join("gripd.toml"), text).unwrap();
        gripfleet(folder.path(), args).refused(2, &[words]);
    };
    refused("", &[], "fleet.site is not set");
    let fleet = "[fleet]\nsite = \"hall\"\n";
    let router = |router: &str| format!("{fleet}router = \"{router}\"\n");
    refused(fleet, &[], ":2:1: fleet.site is set, but neither");
    refused(&router("somewhere"), &[], ":3:1: router = somewhere: ");
    let none = format!("{fleet}network = \"none.json5\"\n");
    refused(&none, &[], "none.json5: no Zenoh configuration: ");
    let off = format!("listen = \"off\"\n{}", router("tcp/127.0.0.1:1"));
    refused(&off, &[], ":1:1: gripfleet connects to gripd, but listen is \"off\"");
    refused(&off, &["--config", "none.toml"], "none.toml");
}

#[test]
fn a_valid_configuration_is_named_so_and_a_gripd_that_is_not_there_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "listen = \"unix:gripd.sock\"\n[fleet]\nsite = \"hall\"\nrouter = \"tcp/127.0.0.1:1\"\n";
    fs::write(folder.path().join("gripd.toml"), text).unwrap();
    let ran = gripfleet(folder.path(), &["--check-config"]).done();
    assert!(ran.out.is_empty() && ran.err.contains("this gripper is published at hall"), "{ran:?}");
    running(folder.path(), &[]).until_reported("no gripd answers at unix:gripd.sock");
}
