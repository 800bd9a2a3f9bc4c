//! Arbitrary bytes to a session: no panic, no command that is not allowed, bounded memory, only good frames out.

use grip_daemon::client::ClientLink;
use grip_daemon::clients::{Asked, ClientSession, Terms};
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Header, MAX_WIRE, encode};
use grip_link::message::daemon::{
    Command, Goodbye, Operation, RealTime, ToClient, Topics, Welcome, WelcomeFlags,
};
use grip_link::message::{Kind, NackReason, Versions};
use proptest::prelude::*;
use slip_core::ClientCommand;

const TOKEN: u32 = 0x1234_5678;

fn terms(allow_commands: bool) -> Terms<'static> {
    let welcome = Welcome {
        versions: Versions::OURS,
        max_rx: 480,
        flags: WelcomeFlags::default(),
        token: 0,
        run_id: 1,
        host_us: 0,
        real_time: RealTime::NotAsked,
        text: b"test",
    };
    let (allow_models, force_max_n) = (allow_commands, Some(60.0));
    Terms {
        welcome,
        allow_commands,
        allow_models,
        token: TOKEN,
        room: 64,
        immovable: None,
        force_max_n,
    }
}

fn wire(kind: u8, seq: u16, session: u16, payload: &[u8]) -> Vec<u8> {
    let header = Header::new(Direction::ToDevice, Kind(kind), seq, session);
    let mut out = [0; MAX_WIRE];
    let len = encode(&Header { ack_req: true, ..header }, payload, &mut out).unwrap();
    out[..len].to_vec()
}

/// Bytes of a client that knows the framing but not the manners, or only rubbish.
fn words() -> impl Strategy<Value = Vec<u8>> {
    let session = prop_oneof![Just(7_u16), any::<u16>()];
    let kind = prop_oneof![4 => 0xA8..=0xAB_u8, 1 => any::<u8>()];
    let payload = proptest::collection::vec(prop_oneof![Just(1_u8), any::<u8>()], 0..24);
    prop_oneof![
        4 => (kind, any::<u16>(), session, payload).prop_map(|(k, n, s, p)| wire(k, n, s, &p)),
        1 => proptest::collection::vec(any::<u8>(), 0..600),
    ]
}

fn run(bytes: &[u8], piece: usize, allow_commands: bool) -> (Vec<Asked>, ClientSession) {
    let mut session = ClientSession::new(0, 8_192);
    let mut asked = Vec::new();
    let greeting = ClientLink::new(7).subscribe(&crate::rig::wanted(Topics::ALL, 1));
    for (now_us, part) in (0..).zip(greeting.chunks(piece).chain(bytes.chunks(piece))) {
        session.receive(now_us, part, &terms(allow_commands), &mut |request| asked.push(request));
        session.tick(now_us, 1_000_000);
        assert!(session.outgoing().len() <= 8_192);
    }
    (asked, session)
}

proptest! {
    #[test]
    fn no_bytes_make_a_command_where_none_are_allowed(
        words in proptest::collection::vec(words(), 0..40), piece in 1_usize..700,
    ) {
        let (asked, session) = run(&words.concat(), piece, false);
        let is_taken = |request: &Asked| {
            matches!(request, Asked::Command(_) | Asked::Load { model: Some(_), .. })
        };
        prop_assert!(!asked.iter().any(is_taken));
        let mut decoder = Decoder::new(Role::Tap);
        let mut input = session.outgoing();
        while let Some(verdict) = decoder.next(&mut input) {
            prop_assert!(matches!(verdict, Verdict::Frame(_)));
        }
        prop_assert_eq!(decoder.counters().gap, 0);
    }

    #[test]
    fn commands_that_are_allowed_have_possible_forces_and_need_the_token(
        words in proptest::collection::vec(words(), 0..40), piece in 1_usize..700,
    ) {
        let (asked, _) = run(&words.concat(), piece, true);
        for request in asked {
            match request {
                Asked::Command(ClientCommand::AtLeast(n)) => prop_assert!(n.is_finite() && n >= 0.0),
                Asked::Command(ClientCommand::Release) => prop_assert!(false, "without the token"),
                _ => {}
            }
        }
    }

    #[test]
    fn pieces_make_no_difference(
        words in proptest::collection::vec(words(), 0..20), piece in 1_usize..300,
    ) {
        let bytes = words.concat();
        let (whole, first) = run(&bytes, usize::MAX, true);
        let (parts, second) = run(&bytes, piece, true);
        prop_assert_eq!(whole, parts);
        prop_assert_eq!(first.counters(), second.counters());
        prop_assert_eq!(first.malformed(), second.malformed());
    }
}

#[test]
fn a_client_of_another_version_gets_a_welcome_and_a_goodbye() {
    let mut session = ClientSession::new(0, 8_192);
    let bytes = wire(0xA8, 0, 7, &[2, 3, 0, 0, 1, 0, 0, 0]);
    session.receive(1, &bytes, &terms(true), &mut |request| panic!("{request:?}"));
    assert!(session.goodbye().is_some() && !session.is_subscribed());
    let mut decoder = Decoder::new(Role::Client);
    decoder.open_session(7, None);
    let mut input = session.outgoing();
    while decoder.next(&mut input).is_some() {}
    assert_eq!(decoder.counters().ok, 2);
}

/// A page in a browser can send any bytes behind the head of a request, and a call of WebRTC any behind its own head.
#[test]
fn a_connection_begins_with_subscribe_or_ends() {
    let mut link = ClientLink::new(7);
    let frames = [
        link.subscribe(&crate::rig::wanted(Topics::ALL, 1)),
        link.command(&Command { force_mn: 25_000, ..Command::new(Operation::AtLeast) }),
        link.command(&Command::new(Operation::Stop)),
    ];
    let [_, command, _] = &frames;
    let malformed = wire(0xA8, 0, 7, &[1]);
    let without_nonce = wire(0xA8, 0, 0, &[1, 1, 0, 0, 1, 0, 0, 0]);
    let mut heads: Vec<Vec<u8>> =
        ["GET", "POST", "PUT", "HEAD", "OPTIONS", "BREW", "\r\nPOST", "\0\0GET"]
            .map(|method| {
                format!("{method} / HTTP/1.1\r\nHost: 127.0.0.1:7747\r\n\r\n").into_bytes()
            })
            .into();
    heads.push(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec());
    heads.push(b"\0\x03\0\x08\x21\x12\xa4\x42turn".to_vec());
    heads.extend([command.clone(), malformed, without_nonce, b"\x01\0".to_vec()]);
    for head in heads {
        for piece in [1, 7, usize::MAX] {
            let mut session = ClientSession::new(0, 8_192);
            let bytes = [head.clone(), frames.concat()].concat();
            for part in bytes.chunks(piece.min(bytes.len())) {
                session
                    .receive(1, part, &terms(true), &mut |request| panic!("{request:?}: {head:?}"));
            }
            assert_eq!(session.goodbye(), Some(Goodbye::Garbage), "{head:?}");
            assert!(session.is_stranger());
        }
        let mut session = ClientSession::new(0, 8_192);
        if head.first().is_some_and(|byte| *byte >= b' ') {
            session.receive(1, &head[..1], &terms(true), &mut |request| panic!("{request:?}"));
            assert!(session.is_stranger(), "at once");
        }
    }
    let (asked, session) = run(&frames[1..].concat(), 1, true);
    assert_eq!((asked.len(), session.goodbye()), (3, None));
}

#[test]
fn a_force_above_the_largest_one_is_refused() {
    let mut link = ClientLink::new(7);
    let mut bytes = link.subscribe(&crate::rig::wanted(Topics::ALL, 1));
    for operation in [Operation::AtLeast, Operation::Expect] {
        for force_mn in [60_000, 60_002, i32::MAX] {
            bytes.extend(link.command(&Command { force_mn, ..Command::new(operation) }));
        }
    }
    let (mut session, mut asked, mut refused) = (ClientSession::new(0, 8_192), vec![], 0);
    session.receive(1, &bytes, &terms(true), &mut |request| asked.push(request));
    let taken = [ClientCommand::AtLeast(60.0), ClientCommand::Expect(60.0)].map(Asked::Command);
    assert_eq!(asked[1..], taken);
    link.receive(session.outgoing(), &mut |message| {
        let ToClient::Nack(nack) = message else { return };
        assert_eq!(nack.reason, NackReason::Malformed);
        refused += 1;
    });
    assert_eq!(refused, 4);
}

#[test]
fn a_request_of_the_serial_line_is_refused_as_unknown() {
    let mut session = ClientSession::new(0, 8_192);
    let greeting = ClientLink::new(7).subscribe(&crate::rig::wanted(Topics::ALL, 1));
    let grip = wire(Kind::GRIP.0, 1, 7, &[0; 20]);
    session.receive(1, &[greeting, grip].concat(), &terms(true), &mut |request| {
        assert_eq!(request, Asked::Subscribed);
    });
    let mut refused = 0;
    let mut link = ClientLink::new(7);
    link.receive(session.outgoing(), &mut |message| {
        let ToClient::Nack(nack) = message else { return };
        assert_eq!((nack.kind, nack.reason, nack.seq), (Kind::GRIP, NackReason::UnknownType, 1));
        refused += 1;
    });
    assert_eq!((refused, session.counters().unknown), (1, 1));
}
