//! The file of `gripfleet events --state`: what was shown of each gripper, and so where to go on after a start.

use anyhow::Context as _;
use core::time::Duration;
use grip_fleet::{EventId, Member, net::Watch};
use grip_record::outputs::replace;
use grip_session::exit::WrongArgument;
use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
};

/// The file is written this often at most: what was shown since then is shown again after a kill.
const EVERY: Duration = Duration::from_secs(1);

/// The file: the last events of each gripper.
#[derive(Debug)]
pub(super) struct Place {
    file: PathBuf,
    known: BTreeMap<Member, Vec<EventId>>,
    kept: Duration,
}

impl Place {
    /// Opens it; one that is not there yet is empty.
    pub(super) fn open(file: &Path) -> anyhow::Result<Self> {
        let known = match fs::read(file) {
            Ok(bytes) => serde_json::from_slice(&bytes)
                .map_err(|error| wrong(file, &format!("no file of --state: {error}")))?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => BTreeMap::new(),
            Err(error) => return Err(wrong(file, &error.to_string()).into()),
        };
        Ok(Self { file: file.to_owned(), known, kept: Duration::ZERO })
    }

    /// What was shown.
    pub(super) fn known(&self) -> impl Iterator<Item = (Member, Vec<EventId>)> {
        self.known.clone().into_iter()
    }

    /// Writes what was received until now, where it is time for that or the end.
    pub(super) fn keep(&mut self, watch: &Watch, now: Duration, last: bool) -> anyhow::Result<()> {
        if !last && now.saturating_sub(self.kept) < EVERY {
            return Ok(());
        }
        self.kept = now;
        let mut all = self.known.clone();
        all.extend(watch.received().map(|(member, ids)| (member.clone(), ids)));
        if all == self.known {
            return Ok(());
        }
        self.known = all;
        replace(&self.file, serde_json::to_vec(&self.known)?)
            .with_context(|| format!("{}: cannot be written", self.file.display()))
    }
}

fn wrong(file: &Path, why: &str) -> WrongArgument {
    WrongArgument(format!("--state {}: {why}", file.display()))
}
