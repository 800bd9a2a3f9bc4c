//! Objects that gripd remembers: the second grasp of a name begins with what the first has shown.

use crate::running::{UPDATES, client, gripd, receive, serving};
use grip_daemon::client::Client;
use grip_link::message::{
    Kind,
    daemon::{GripState, NoticeKind, Operation, ToClient},
};
use std::fs;
use stories::{Program, until};

/// A file of the memory and a name, gripd with it, and a client that may command.
fn remembering(folder: &std::path::Path) -> (Program, Client) {
    let settings = "allow_commands = true\n[memory]\nfile = \"objects.toml\"\n";
    fs::write(folder.join("gripd.toml"), settings).unwrap();
    let running = serving(folder, &[]);
    let client = client(folder, 5, UPDATES);
    (running, client)
}

/// What the controller expects of the object `name`, in words.
fn expected(client: &mut Client, name: &str) -> String {
    client.object(name).unwrap();
    let mut text = None;
    receive(client, |message| {
        if let ToClient::Notice(notice) = message
            && (notice.kind, notice.code) == (NoticeKind::Client, Operation::Expect.code())
        {
            text = Some(notice.as_str().to_owned());
        }
        text.is_some()
    });
    text.unwrap()
}

#[test]
fn a_grasp_begins_with_what_those_before_it_have_shown() {
    let folder = tempfile::tempdir().unwrap();
    let known = "[bottle]\nneeded_n = { value = 5.0, deviation = 0.1, grasps = 4 }\n";
    fs::write(folder.path().join("objects.toml"), known).unwrap();
    let (running, mut client) = remembering(folder.path());
    // Before there is a pipeline nothing is carried out.
    receive(
        &mut client,
        |message| matches!(message, ToClient::State(state) if state.grip == GripState::Holding),
    );
    // 1.2 times 5 N, and a deviation.
    assert_eq!(expected(&mut client, "bottle"), "expect an object that needs 6.30 N");
    assert_eq!(expected(&mut client, "cup"), "expect an object that needs 0.00 N");
    client.object("a\nb").unwrap();
    receive(
        &mut client,
        |message| matches!(message, ToClient::Nack(nack) if nack.kind == Kind::OBJECT),
    );
    running.interrupted().done();
}

#[test]
fn what_a_grasp_shows_stands_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let (running, mut client) = remembering(folder.path());
    client.object("brick").unwrap();
    let file = folder.path().join("objects.toml");
    let learned =
        until(|| fs::read_to_string(&file).is_ok_and(|text| text.contains("[brick.needed_n]")));
    let said = running.interrupted();
    assert!(learned, "{}", said.err);
    assert!(said.err.contains("object brick: learned"), "{}", said.err);
}

#[test]
fn a_file_that_is_no_memory_is_refused_before_anything_moves() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("objects.toml"), "[bottle]\nweight = 3\n").unwrap();
    let settings = "[memory]\nfile = \"objects.toml\"\n";
    fs::write(folder.path().join("gripd.toml"), settings).unwrap();
    gripd(folder.path(), &["--port", "sim"]).refused(2, &["objects.toml", "weight"]);
}
