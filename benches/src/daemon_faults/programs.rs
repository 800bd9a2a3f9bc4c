//! Clients that stall, babble, come by the hundred and stay silent; and one that asks for a release.

use super::{
    outcome::Outcome,
    rig::{Object, Rig, Setup},
};
use crate::time;
use anyhow::{Context as _, Result};
use core::{net::SocketAddr, time::Duration};
use grip_daemon::{client::Client, clients::Listen};
use grip_link::message::{
    Versions,
    daemon::{Command, Operation, Subscribe, ToClient, Topics},
};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use std::{
    io::{self, Write as _},
    net::TcpStream,
};

/// Clients that ask for everything and read nothing.
const STALLED: usize = 4;
/// Clients that connect and send nothing.
const SILENT: usize = 8;
/// Clients that send rubbish, and how much each of them (bytes).
const BABBLERS: usize = 8;
const RUBBISH: usize = 64 * 1024;
const PATIENCE: Duration = Duration::from_secs(20);
const EVERYTHING: Subscribe =
    Subscribe { versions: Versions::OURS, topics: Topics::ALL, every_nth: 1, state_ms: 0 };
const LITTLE: Subscribe =
    Subscribe { versions: Versions::OURS, topics: Topics::ALL, every_nth: 0, state_ms: 50 };

/// All kinds of bad clients at once, beside a good one.
pub(super) fn run(setup: &Setup<'_>, connects: u64) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let rig = Rig::new(setup, Object::Lifted)?;
    let mut daemon = rig.gripping(&["--record", "clients.mcap"])?;
    let mut good = Client::connect(&Listen::Tcp(rig.address), 1, LITTLE, PATIENCE)?;
    let stalled = (0..STALLED).map(|_| stall(rig.address)).collect::<Result<Vec<_>, _>>()?;
    let silent = (0..SILENT).map(|_| connect(rig.address)).collect::<io::Result<Vec<_>>>();
    let silent = silent.context("connect")?;
    let mut random = ChaCha8Rng::seed_from_u64(setup.seed);
    let refused = (0..BABBLERS).filter(|_| babble(rig.address, &mut random).is_err()).count();
    let states = hurry(&rig, connects, &mut good, &mut random)?;
    outcome.times = connects + (STALLED + SILENT + BABBLERS) as u64;
    outcome.require(states > 0, || "the good client received nothing meanwhile".to_owned());
    let answered = asks(&mut good)?;
    rig.missed(answered, "the good client is not answered any more", &daemon)?;
    outcome.figure(format!(
        "{STALLED} stalled, {SILENT} silent, {BABBLERS} babbling ({refused} of them cut off), {connects} connects; a good one received {states} states"
    ));
    daemon.must_run()?;
    rig.commands_again(&daemon)?;
    drop((stalled, silent));
    rig.finish(&mut daemon, &mut outcome)?;
    Ok(outcome)
}

fn connect(address: SocketAddr) -> io::Result<TcpStream> {
    let stream = TcpStream::connect_timeout(&address, PATIENCE)?;
    stream.set_write_timeout(Some(Duration::from_millis(500)))?;
    Ok(stream)
}

/// Asks for everything; nobody will ever read it.
fn stall(address: SocketAddr) -> Result<Client> {
    Ok(Client::connect(&Listen::Tcp(address), 2, EVERYTHING, PATIENCE)?)
}

/// Sends rubbish until it is all gone or the daemon has had enough, which is an error here.
fn babble(address: SocketAddr, random: &mut ChaCha8Rng) -> io::Result<()> {
    let mut stream = connect(address)?;
    let mut rubbish = vec![0; 1024];
    for _ in 0..RUBBISH / rubbish.len() {
        random.fill_bytes(&mut rubbish);
        stream.write_all(&rubbish)?;
        time::wait_ms(1);
    }
    Ok(())
}

/// Connects again and again; some send half a word first. Gives how many states the good client received meanwhile.
fn hurry(rig: &Rig<'_>, connects: u64, good: &mut Client, random: &mut ChaCha8Rng) -> Result<u64> {
    let mut states = 0;
    for _ in 0..connects {
        let mut stream = connect(rig.address).context("connect")?;
        if random.next_u32().is_multiple_of(2) {
            // Half a frame; a daemon that has closed already is right too.
            drop(stream.write_all(&[0, 9, 0x11, 0xA8, 1]));
        }
        drop(stream);
        good.wait(Duration::ZERO, &mut |message| {
            states += u64::from(matches!(message, ToClient::State(_)));
        })?;
        time::wait_ms(1);
    }
    Ok(states)
}

/// Whether a QUERY is answered.
fn asks(client: &mut Client) -> Result<bool> {
    client.query()?;
    let request = client.link().last_request();
    listen(client, |message| matches!(message, ToClient::Ack(ack) if ack.seq == request))
}

/// Listens until `done` holds of a message.
fn listen(client: &mut Client, mut done: impl FnMut(&ToClient<'_>) -> bool) -> Result<bool> {
    let end = time::now() + PATIENCE;
    let mut received = false;
    while !received && time::now() < end {
        client.wait(Duration::from_millis(100), &mut |message| received |= done(message))?;
    }
    Ok(received)
}

/// A client lets go and closes again; in between nothing may press.
pub(super) fn release(setup: &Setup<'_>) -> Result<Outcome> {
    let mut outcome = Outcome { times: 1, ..Outcome::default() };
    let rig = Rig::new(setup, Object::Supported)?;
    let mut daemon = rig.gripping(&["--record", "release.mcap"])?;
    let mut client = Client::connect(&Listen::Tcp(rig.address), 3, LITTLE, PATIENCE)?;
    let mut token = 0;
    let greeted = listen(&mut client, |message| match message {
        ToClient::Welcome(welcome) => {
            token = welcome.token;
            true
        }
        _ => false,
    })?;
    rig.missed(greeted, "no WELCOME", &daemon)?;
    {
        let mut bench = rig.gripper.bench();
        bench.must_hold(false);
        bench.judge.allow_open();
    }
    client.command(&Command { token, ..Command::new(Operation::Release) })?;
    let opened = time::until(20, || rig.gripper.bench().judge.has_opened());
    rig.missed(opened, "the fingers were not opened", &daemon)?;
    time::wait_ms(700);
    let force_n = rig.gripper.bench().mcu.commanded_n();
    outcome.require(force_n <= 0.0, || format!("{force_n} N after a release"));
    rig.gripper.bench().judge.allow_close();
    client.command(&Command::new(Operation::Grasp))?;
    let gripped = rig.gripper.until_gripped();
    rig.missed(gripped, "the fingers are not closed again", &daemon)?;
    outcome.figure("no force until a client asked for it again".to_owned());
    rig.finish(&mut daemon, &mut outcome)?;
    Ok(outcome)
}
