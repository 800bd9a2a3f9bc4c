//! A second model beside the one in force: asked about the same slips, without touching the force.

use crate::{
    live::replays_identically,
    running::{UPDATES, client, receive, serving},
};
use grip_daemon::client::Client;
use grip_link::message::daemon::{Estimates, Load, ToClient};
use grip_session::{HostConfig, model};
use std::{fs, path::Path};
use stories::Ended;

/// The default model with twice the range of its target: it asks for twice the force.
fn twice() -> String {
    let text = model::default_text();
    let mut doubled = text.to_owned();
    for bound in ["0.19977216", "146.0365"] {
        assert!(text.contains(bound), "another default model");
        let twice = 2.0 * bound.parse::<f64>().unwrap();
        doubled = doubled.replacen(bound, &twice.to_string(), 1);
    }
    doubled
}

/// Brings a model that estimates beside the one in force: whether it was taken.
pub(crate) fn cast(client: &mut Client, text: &str) -> bool {
    bring(client, text, |client, piece| client.shadow(piece).unwrap())
}

/// Brings a model that is put in force, for an empty text that of the configuration: whether it was.
pub(crate) fn load(client: &mut Client, text: &str) -> bool {
    bring(client, text, |client, piece| client.load(piece).unwrap())
}

fn bring(client: &mut Client, text: &str, send: impl Fn(&mut Client, &Load<'_>)) -> bool {
    let (sha256, size) = (model::digest(text.as_bytes()), u32::try_from(text.len()).unwrap());
    let pieces = text.len().div_ceil(Load::PIECE).max(1);
    for at in 0..pieces {
        let (first, end) = (at * Load::PIECE, text.len().min((at + 1) * Load::PIECE));
        let (offset, bytes) = (u32::try_from(first).unwrap(), &text.as_bytes()[first..end]);
        send(client, &Load { sha256, size, offset, bytes });
    }
    let (mut answers, mut taken) = (0, false);
    receive(client, |message| {
        match message {
            ToClient::Ack(_) => (answers, taken) = (answers + 1, true),
            ToClient::Nack(_) => (answers, taken) = (answers + 1, false),
            _ => {}
        }
        answers == pieces
    });
    taken
}

/// A grasp with a slip and a shadow: what both models made of it, and how gripd ended.
fn grasp(folder: &Path) -> Option<(Estimates, Ended)> {
    fs::remove_file(folder.join("run.csv")).unwrap_or_default();
    let running = serving(folder, &["--record", "run.csv"]);
    let mut client = client(folder, 1, UPDATES);
    assert!(cast(&mut client, &twice()));
    running.until_reported("of a client estimates beside the one in force");
    let (mut estimates, mut fallen) = (None, false);
    receive(&mut client, |message| {
        match message {
            ToClient::Estimates(made) => estimates = Some(*made),
            ToClient::State(state) => fallen = state.fault.is_fault(),
            _ => {}
        }
        estimates.is_some() || fallen
    });
    let ran = running.interrupted().done();
    estimates.map(|estimates| (estimates, ran))
}

#[test]
fn a_shadow_estimates_beside_the_model_in_force_and_changes_no_command() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("gripd.toml"), "allow_models = true\n").unwrap();
    // A machine that stops gripd for longer than the object takes to fall drops it.
    let (made, ran) = (0..5).find_map(|_| grasp(folder.path())).unwrap();
    let (in_force_n, shadow_n) = (made.in_force_n.unwrap(), made.shadow_n.unwrap());
    assert!((shadow_n / in_force_n - 2.0).abs() < 0.01, "{made:?}");
    assert!(made.slip > 0 && made.slipped_n.unwrap() > 0.0, "{made:?}");
    // The replay knows no shadow: every command in these lines is the same, bit by bit.
    let config = HostConfig { allow_models: true, ..HostConfig::default() };
    replays_identically(&folder.path().join("run.csv"), &ran, &config);
}

#[test]
fn a_file_that_is_no_model_is_no_shadow_either() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("gripd.toml"), "allow_models = true\n").unwrap();
    let running = serving(folder.path(), &[]);
    let mut client = client(folder.path(), 1, UPDATES);
    assert!(!cast(&mut client, "{}"));
    running.until_reported("the model that a client asked for is not taken as a shadow: ");
}
