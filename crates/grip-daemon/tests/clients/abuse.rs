//! Clients that stall, flood, send rubbish, send nothing, or come in crowds.

use crate::rig::{PATIENCE, Rig, tcp, wanted};
use grip_daemon::client::ClientLink;
use grip_daemon::clients::{ClientsConfig, Listen};
use grip_link::message::daemon::{Goodbye, ToClient, Topics};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;

fn raw(rig: &Rig) -> TcpStream {
    let Listen::Tcp(address) = rig.place() else { panic!("not at a port") };
    let stream = TcpStream::connect(address).unwrap();
    stream.set_nonblocking(true).unwrap();
    stream
}

#[test]
fn a_stalled_client_loses_samples_is_reported_how_many_and_disturbs_nobody() {
    let config = ClientsConfig { buffer_bytes: 64 * 1024, ..tcp() };
    let mut rig = Rig::new(config);
    let mut stalled = rig.viewer(1, wanted(Topics::NEWS, 1));
    let mut healthy = rig.viewer(2, wanted(Topics::NEWS, 1));
    while rig.clients.counters().dropped < 1_000 {
        rig.samples(400);
        rig.turn();
        healthy.look();
        assert!(rig.index < 50_000_000, "nothing was ever dropped");
    }
    rig.updates();
    let samples = rig.index as usize;
    rig.until(&mut healthy, |seen| seen.rows.len() == samples && seen.grippers == 1);
    assert_eq!((healthy.seen.dropped, rig.clients.count()), (0, 2));
    let dropped = u32::try_from(rig.clients.counters().dropped).unwrap();
    rig.until(&mut stalled, |seen| seen.dropped == dropped && seen.grippers == 1);
    assert!(stalled.seen.rows.len() < samples);
    assert_eq!(stalled.seen.row_frames + dropped, healthy.seen.row_frames);
    assert_eq!(stalled.client.link().counters().gap, 0, "only whole frames, none lost on the way");
    assert_eq!(stalled.client.link().counters().bad_blocks(), 0);
}

#[test]
fn a_client_that_takes_nothing_is_sent_away_and_the_others_stay() {
    let mut rig = Rig::new(ClientsConfig { stall_us: 500_000, most: 2, ..tcp() });
    let stalled = rig.viewer(1, wanted(Topics::default(), 1));
    let mut healthy = rig.viewer(2, wanted(Topics::default(), 1000));
    for _ in 0..PATIENCE {
        if rig.clients.count() == 1 {
            break;
        }
        rig.samples(400);
        rig.turn();
        healthy.look();
    }
    for _ in 0..1000 {
        rig.samples(400);
        rig.turn();
        healthy.look();
    }
    assert_eq!((rig.clients.count(), rig.clients.counters().sent_away), (1, 1));
    assert_eq!(rig.clients.subscribed(), 1);
    assert!(!healthy.seen.closed && rig.clients.counters().dropped > 0);
    drop(stalled);
}

#[test]
fn garbage_is_counted_and_then_refused() {
    let mut rig = Rig::new(tcp());
    let mut healthy = rig.viewer(1, wanted(Topics::default(), 1));
    let mut stream = raw(&rig);
    stream.write_all(&ClientLink::new(4).subscribe(&wanted(Topics::default(), 0))).unwrap();
    let rubbish: Vec<u8> = (0..4096_u32).map(|i| (i * 7 % 61) as u8).collect();
    for _ in 0..PATIENCE {
        let _maybe_full = stream.write(&rubbish);
        rig.turn();
        if rig.clients.counters().sent_away == 1 {
            break;
        }
    }
    assert_eq!((rig.clients.counters().sent_away, rig.clients.count()), (1, 1));
    assert_eq!(rig.clients.take_strangers(), 0, "it has begun well");
    rig.samples(10);
    rig.until(&mut healthy, |seen| seen.rows.len() == 10);
}

#[test]
fn who_states_nothing_or_no_subscribe_is_sent_away_in_a_session_that_every_client_receives() {
    let cases =
        [(&b"\0\x04"[..], Goodbye::Silent, 0), (b"GET / HTTP/1.1\r\n\r\n", Goodbye::Garbage, 1)];
    for (sent, wanted, strangers) in cases {
        let mut rig = Rig::new(tcp());
        let mut stream = raw(&rig);
        stream.write_all(sent).unwrap();
        let mut link = ClientLink::new(5);
        let (mut bytes, mut reason) = ([0; 1000], None);
        for _ in 0..PATIENCE {
            rig.turn();
            match stream.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => link.receive(&bytes[..count], &mut |message| {
                    let ToClient::Notice(notice) = message else { panic!("{message:?}") };
                    reason = Some(Goodbye::from_code(notice.code));
                }),
                Err(_) => {}
            }
        }
        assert_eq!((reason, rig.clients.count()), (Some(wanted), 0));
        assert_eq!((rig.clients.take_strangers(), rig.clients.take_strangers()), (strangers, 0));
    }
}

#[test]
fn one_client_too_many_is_reported_so() {
    let mut rig = Rig::new(ClientsConfig { most: 2, ..tcp() });
    let _first = rig.viewer(1, wanted(Topics::default(), 0));
    let _second = rig.viewer(2, wanted(Topics::default(), 0));
    let mut third = rig.connect(3, wanted(Topics::default(), 0));
    rig.until(&mut third, |seen| seen.closed || seen.goodbye.is_some());
    assert_eq!((rig.clients.count(), rig.clients.counters().refused), (2, 1));
    assert_eq!(third.seen.goodbye.unwrap_or(Goodbye::Full), Goodbye::Full);
}

#[test]
fn a_thousand_connects_leave_nothing_behind() {
    let mut rig = Rig::new(tcp());
    let mut healthy = rig.viewer(9, wanted(Topics::default(), 1));
    for turn in 0..1_000_u32 {
        let mut stream = raw(&rig);
        if turn % 3 == 0 {
            stream.write_all(&ClientLink::new(4).subscribe(&wanted(Topics::ALL, 1))).unwrap();
        }
        drop(stream);
        rig.samples(1);
        rig.turn();
    }
    for _ in 0..PATIENCE {
        if rig.clients.count() == 1 {
            break;
        }
        rig.turn();
    }
    let counters = rig.clients.counters();
    assert_eq!((rig.clients.count(), counters.accept_errors), (1, 0));
    assert_eq!(counters.accepted + counters.refused, 1_001);
    rig.until(&mut healthy, |seen| seen.rows.len() == 1_000);
}

#[test]
fn a_client_that_closes_its_half_or_resets_is_forgotten() {
    let mut rig = Rig::new(tcp());
    let stream = raw(&rig);
    let unread = rig.viewer(3, wanted(Topics::default(), 1));
    rig.turn();
    assert_eq!(rig.clients.count(), 2);
    stream.shutdown(std::net::Shutdown::Write).unwrap();
    rig.samples(5_000);
    rig.turn();
    drop(unread);
    for _ in 0..PATIENCE {
        if rig.clients.count() == 0 {
            return;
        }
        rig.samples(100);
        rig.turn();
    }
    panic!("{} clients are left", rig.clients.count());
}
