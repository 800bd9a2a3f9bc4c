//! What the tests of a network share: a free endpoint, the ways to a router there, and a gripper that a test plays.

use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_fleet::{
    Member, Part, Uid,
    net::{self, Announced, NetError, Network, Session},
    wire,
};
use grip_link::message::{
    Kind,
    daemon::{Notice, NoticeKind},
};
use std::{
    fs,
    net::TcpListener,
    path::Path,
    sync::Arc,
    thread::{self, JoinHandle},
};

/// Where a router can listen: a port that was free a moment ago.
pub(crate) fn endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    format!("tcp/127.0.0.1:{port}")
}

/// The way to a router.
pub(crate) fn at(endpoint: &str) -> Network {
    Network { router: Some(endpoint.to_owned()), file: None }
}

/// The same for whoever looks for it every fifth of a second, by a file `zenoh.json5` in `folder`.
pub(crate) fn patient(folder: &Path, endpoint: &str) -> Network {
    let file = folder.join("zenoh.json5");
    let retry = "{ connect: { retry: { period_init_ms: 200, period_max_ms: 200 } } }";
    fs::write(&file, retry).unwrap();
    Network { file: Some(file), ..at(endpoint) }
}

/// A router in this process.
pub(crate) fn router(endpoint: &str) -> Session {
    net::router(&at(endpoint)).unwrap()
}

/// A gripper of the hall.
pub(crate) fn member(uid: u8) -> Member {
    Member { site: "hall".parse().unwrap(), uid: Uid([uid; 16]) }
}

/// An event with a text.
pub(crate) fn notice(text: &str) -> Vec<u8> {
    let (kind, text) = (NoticeKind::Link, text.as_bytes());
    let notice = Notice { kind, code: 0, value: 0, count: 0, host_us: 1_000_000, text };
    wire(Kind::NOTICE, |out| notice.write(out).unwrap())
}

/// A gripper on the network. The router may not know yet that the one before has gone.
pub(crate) fn announced(session: &Session, member: &Member, parts: &[Part]) -> Announced {
    loop {
        match Announced::new(session, member, parts) {
            Ok(announced) => return announced,
            Err(NetError::Taken { .. }) => thread::yield_now(),
            Err(error) => panic!("{error}"),
        }
    }
}

/// A gripper on a thread of its own, until it is dropped.
pub(crate) struct Played {
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Played {
    /// It is there when this returns; `turn` comes some hundred times a second.
    pub(crate) fn new(
        session: Session,
        member: &Member,
        parts: &[Part],
        mut turn: impl FnMut(&mut Announced) + Send + 'static,
    ) -> Self {
        let mut announced = announced(&session, member, parts);
        let end = Arc::<AtomicBool>::default();
        let ended = Arc::clone(&end);
        let thread = thread::spawn(move || {
            let _open = session;
            while !ended.load(Ordering::SeqCst) {
                turn(&mut announced);
                thread::park_timeout(Duration::from_millis(2));
            }
        });
        Self { end, thread: Some(thread) }
    }
}

impl Drop for Played {
    fn drop(&mut self) {
        self.end.store(true, Ordering::SeqCst);
        // One that has failed has said so.
        self.thread.take().map(JoinHandle::join);
    }
}
