//! `gripfleet archive`: archive of events and HEALTH of all grippers at a router, in files by day, until it is stopped.

use super::{Unreadable, network, stopped};
use crate::cli::fleet::ArchiveArgs;
use crate::clock;
use core::{sync::atomic::Ordering, time::Duration};
use grip_fleet::{
    Part, Selector, Since, Stamp,
    archive::Archive,
    net::{Reported, Watch},
};
use grip_session::exit::Exit;

/// Longest wait between two looks at the signals.
const LOOK: Duration = Duration::from_millis(100);
/// Events, and HEALTH alone, are put on disk this often: a kill costs the HEALTH since then, and events are asked for again.
const EVENTS: Duration = Duration::from_secs(1);
const HEALTH: Duration = Duration::from_secs(10);

pub(super) fn run(args: &ArchiveArgs) -> anyhow::Result<Exit> {
    let network = network(&args.reach)?;
    let stopped = stopped()?;
    let mut archive =
        Archive::open(&args.directory, concat!("gripfleet ", env!("CARGO_PKG_VERSION")))?;
    if let Some((file, saved)) = archive.recovered() {
        let (file, messages, holes) = (file.display(), saved.messages, saved.holes.len());
        eprintln!(
            "gripfleet: {file}: finished after a kill, {messages} messages, {holes} damaged places"
        );
    }
    let selector = Selector { site: args.site.clone(), uid: args.uid };
    let mut watch = Watch::new(network.open()?, &selector, Since::Start, &[Part::Health])?;
    watch.resume(archive.received());
    let (mut committed, mut lost) = (clock::monotonic(), false);
    let mut unreadable = Unreadable::default();
    while !stopped.load(Ordering::Relaxed) {
        match watch.next(LOOK)? {
            Some(Reported::Event { member, id, at, message, missing }) => {
                if missing > 0 {
                    lost = true;
                    eprintln!(
                        "gripfleet: {member}: {missing} events are missing: they had to make room"
                    );
                }
                let stamp = Stamp { id, at };
                archive.event(clock::utc_ns(), &member, stamp, missing, &message)?;
            }
            Some(Reported::Telemetry { member, stamp, message }) => {
                archive.health(clock::utc_ns(), &member, stamp, &message)?;
            }
            Some(Reported::Unreadable { key }) => {
                unreadable.take(&key);
            }
            Some(Reported::Came(_) | Reported::Gone(_)) | None => {}
        }
        let every = if archive.has_events_open() { EVENTS } else { HEALTH };
        if clock::monotonic().saturating_sub(committed) >= every {
            archive.commit()?;
            committed = clock::monotonic();
        }
    }
    archive.close()?;
    Ok(if lost { Exit::DataLost } else { Exit::Done })
}
