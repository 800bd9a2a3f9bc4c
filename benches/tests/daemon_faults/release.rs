//! A client that asks for a release. Those that stall, babble and come by the thousand: `grip-daemon/tests/clients/abuse.rs`.

use super::rig::{Object, Rig};
use core::time::Duration;
use grip_daemon::{client::Client, clients::Listen};
use grip_link::message::{
    Versions,
    daemon::{Command, Operation, Subscribe, ToClient, Topics},
};
use slip_benches::time;

const WANTED: Subscribe =
    Subscribe { versions: Versions::OURS, topics: Topics::ALL, every_nth: 0, state_ms: 50 };

#[test]
fn nothing_presses_between_a_release_and_the_next_grasp() {
    let rig = Rig::new(Object::Supported);
    let daemon = rig.gripping(&["--record", "release.mcap"]);
    let patience = Duration::from_secs(20);
    let mut client = Client::connect(&Listen::Tcp(rig.address), 3, WANTED, patience).unwrap();
    let mut token = None;
    let greeted = time::until(20, || {
        let mut listen = |message: &ToClient<'_>| {
            if let ToClient::Welcome(welcome) = message {
                token = Some(welcome.token);
            }
        };
        client.wait(Duration::from_millis(100), &mut listen).unwrap();
        token.is_some()
    });
    rig.must(greeted, "no WELCOME", &daemon);
    {
        let mut bench = rig.gripper.bench();
        bench.must_hold(false);
        bench.judge.allow_open();
    }
    let release = Command { token: token.unwrap(), ..Command::new(Operation::Release) };
    client.command(&release).unwrap();
    let opened = time::until(20, || rig.gripper.bench().judge.has_opened());
    rig.must(opened, "the fingers were not opened", &daemon);
    time::wait_ms(700);
    let force_n = rig.gripper.bench().mcu.commanded_n();
    assert!(force_n <= 0.0, "{force_n} N after a release");
    rig.gripper.bench().judge.allow_close();
    client.command(&Command::new(Operation::Grasp)).unwrap();
    rig.must(rig.gripper.until_gripped(), "the fingers are not closed again", &daemon);
    rig.finish(daemon);
}
