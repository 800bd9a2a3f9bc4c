//! The way to the router in; a way that can be cut and goes on later out.

use super::pause;
use anyhow::Context as _;
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use std::{
    io::{self, Read as _, Write as _},
    net::{Shutdown, TcpListener, TcpStream},
    sync::Arc,
    thread,
};

/// Longest pause between two looks at whether the line is cut.
const LOOK: Duration = Duration::from_millis(20);

/// Passes every connection on. While the line is cut it takes and gives nothing, and nobody is informed: connections stay open, as they do where
/// a cable is pulled. Its threads end with their connections, and with the program.
pub(crate) struct Relay {
    /// Where it listens.
    pub(crate) address: String,
    cut: Arc<AtomicBool>,
}

impl Relay {
    /// Passes on to `router`, `tcp/ADDRESS`.
    pub(crate) fn start(router: &str) -> anyhow::Result<Self> {
        let router = router.strip_prefix("tcp/").context("no TCP address")?.to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").context("no free port")?;
        let address = format!("tcp/{}", listener.local_addr()?);
        let cut = Arc::new(AtomicBool::new(false));
        let is_cut = Arc::clone(&cut);
        thread::spawn(move || {
            for near in listener.incoming().flatten() {
                // A router that is not there ends the connection.
                let Ok(far) = TcpStream::connect(&router) else { continue };
                let ways = [
                    near.try_clone().and_then(|near| Ok((near, far.try_clone()?))),
                    Ok((far, near)),
                ];
                for (from, to) in ways.into_iter().flatten() {
                    let is_cut = Arc::clone(&is_cut);
                    thread::spawn(move || pass(from, to, &is_cut));
                }
            }
        });
        Ok(Self { address, cut })
    }

    pub(crate) fn cut(&self, cut: bool) {
        self.cut.store(cut, Ordering::Relaxed);
    }
}

/// One direction, until either side ends it.
fn pass(mut from: TcpStream, mut to: TcpStream, cut: &AtomicBool) {
    let mut bytes = [0; 16 * 1024];
    let _set = from.set_read_timeout(Some(LOOK));
    loop {
        let read = from.read(&mut bytes);
        while cut.load(Ordering::Relaxed) {
            pause(LOOK);
        }
        match read {
            Ok(count) if count > 0 => {
                if to.write_all(bytes.get(..count).unwrap_or_default()).is_err() {
                    break;
                }
            }
            Err(error) if is_pause(&error) => {}
            _ => break,
        }
    }
    // The other direction ends with it.
    let _ended = from.shutdown(Shutdown::Both);
    let _ended = to.shutdown(Shutdown::Both);
}

fn is_pause(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}
