//! `gripfleet recordings` and `collect`: a router in; what grippers have recorded listed, and copied here.

use super::{Of, checked, network, say};
use crate::{
    cli::fleet::{CollectArgs, RecordingsArgs},
    clock,
};
use anyhow::{Context as _, bail};
use core::{cell::Cell, time::Duration};
use grip_fleet::{
    Member, Part, Selector,
    net::{Ask, NetError, PATIENCE, Session, ask, members},
    recordings::{FetchError, Fetched, PIECE, Recording, fetch},
};
use grip_session::{
    exit::{Exit, escape, message},
    utc,
};
use serde::Serialize;
use std::{
    collections::BTreeSet,
    fs,
    path::Path,
    thread,
    time::{SystemTime, UNIX_EPOCH},
};

/// The least that is asked for at once (bytes): the least that a line must carry while an answer is waited for.
const LEAST: u64 = 16 * 1024;
/// So many answers may fail to come in time before patience ends.
const ATTEMPTS: u32 = 4;
/// An answer that comes within this part of the time that it may take leaves room for a longer one.
const QUICK: u32 = 8;
/// Pause between two attempts.
const RETRY: Duration = Duration::from_millis(500);

/// One recording, or what became of it.
#[derive(Serialize)]
struct Line<'a> {
    #[serde(flatten)]
    recording: &'a Recording,
    #[serde(skip_serializing_if = "Option::is_none")]
    done: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    resumed: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

const fn line(recording: &Recording) -> Line<'_> {
    Line { recording, done: None, resumed: None, reason: None }
}

#[derive(Default, Serialize)]
#[serde(tag = "type", rename = "summary")]
struct Summary {
    grippers: u64,
    /// Those that give nothing away, or did not state what they have.
    without: u64,
    copied: u64,
    bytes: u64,
    there: u64,
    growing: u64,
    failed: u64,
}

pub(super) fn show(args: &RecordingsArgs) -> anyhow::Result<Exit> {
    let session = network(&args.place.reach)?.open()?;
    let selector = Selector { site: args.place.site.clone(), uid: args.uid };
    let mut lost = false;
    for member in everybody(&session, &selector)? {
        let Some(all) = listed(&session, &member, &mut lost) else { continue };
        for recording in &all {
            let text = format!("{member}  {}", escape(&text(recording)));
            say(args.place.json, &Of::new(&member, line(recording)), &text)?;
        }
    }
    Ok(if lost { Exit::DataLost } else { Exit::Done })
}

fn text(recording: &Recording) -> String {
    let Recording { name, bytes, modified_ns, growing, .. } = recording;
    let state = if *growing { ", being written" } else { "" };
    format!("{name}  {bytes} bytes, {}{state}", utc::line(modified_ns / 1000))
}

fn everybody(session: &Session, selector: &Selector) -> anyhow::Result<BTreeSet<Member>> {
    let everybody = members(session, selector)?;
    if everybody.is_empty() {
        bail!("no gripper is there that was asked for");
    }
    Ok(everybody)
}

/// A sentence that names the gripper once.
fn named(member: &Member, text: &str) -> String {
    let member = member.to_string();
    if text.contains(&member) { text.to_owned() } else { format!("{member}: {text}") }
}

/// Whether the gripper has said that it does not do it.
fn is_refused(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(NetError::Declined { .. }))
}

/// What a gripper gives away; none where it does not, or does not answer, which is a loss.
fn listed(session: &Session, member: &Member, lost: &mut bool) -> Option<Vec<Recording>> {
    let all = list(session, member).inspect_err(|error| {
        eprintln!("gripfleet: {}", named(member, &escape(&message(error.as_ref()))));
        *lost |= !is_refused(error);
    });
    all.ok()
}

fn list(session: &Session, member: &Member) -> anyhow::Result<Vec<Recording>> {
    let question =
        Ask { member, part: Part::Recordings, parameters: &[], payload: &[], patience: PATIENCE };
    let mut all = Vec::new();
    for part in ask(session, &question)? {
        let some: Vec<Recording> =
            serde_json::from_slice(&part).context("the answer is no list of recordings")?;
        all.extend(some);
    }
    all.sort_by(|one, other| one.name.cmp(&other.name));
    Ok(all)
}

pub(super) fn collect(args: &CollectArgs) -> anyhow::Result<Exit> {
    let since_ns = since(args.since)?;
    let patience = Duration::try_from_secs_f64(checked("--patience", args.patience, true)?)?;
    let session = network(&args.place.reach)?.open()?;
    let selector = Selector { site: args.place.site.clone(), uid: args.uid };
    let mut summary = Summary::default();
    let mut lost = false;
    for member in everybody(&session, &selector)? {
        summary.grippers += 1;
        let Some(all) = listed(&session, &member, &mut lost) else {
            summary.without += 1;
            continue;
        };
        let folder = args.directory.join(member.site.to_string()).join(member.uid.to_string());
        let copying = Copying::new(&session, &member, &folder, patience);
        for recording in all.iter().filter(|recording| recording.modified_ns >= since_ns) {
            copying.copy(recording, args.place.json, &mut summary)?;
        }
    }
    report(args.place.json, &summary)?;
    Ok(if lost || summary.failed > 0 { Exit::DataLost } else { Exit::Done })
}

/// What was written before that (ns since 1970) is not wanted.
#[expect(clippy::disallowed_methods, reason = "the times of files are those of the wall clock")]
fn since(hours: Option<f64>) -> anyhow::Result<u64> {
    let Some(hours) = hours else { return Ok(0) };
    let span = Duration::try_from_secs_f64(3600.0 * checked("--since", hours, false)?)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH)?;
    Ok(u64::try_from(now.saturating_sub(span).as_nanos())?)
}

/// From one gripper into its folder.
struct Copying<'a> {
    session: &'a Session,
    member: &'a Member,
    folder: &'a Path,
    patience: Duration,
    /// So many bytes are asked for at once.
    most: Cell<u64>,
    /// It has not answered for as long as patience lasts.
    gone: Cell<bool>,
}

impl<'a> Copying<'a> {
    const fn new(
        session: &'a Session,
        member: &'a Member,
        folder: &'a Path,
        patience: Duration,
    ) -> Self {
        let (most, gone) = (Cell::new(PIECE as u64), Cell::new(false));
        Self { session, member, folder, patience, most, gone }
    }

    fn copy(&self, recording: &Recording, json: bool, summary: &mut Summary) -> anyhow::Result<()> {
        let mut line = line(recording);
        if self.gone.get() {
            let reason = format!("{}: not asked for: the gripper does not answer", recording.name);
            (line.done, line.reason) = (Some("failed"), Some(reason));
            summary.failed += 1;
            return reported(self.member, line, json);
        }
        // A name that leads elsewhere is refused by `fetch`, before anything is written.
        fs::create_dir_all(self.folder)
            .with_context(|| format!("cannot make the folder {}", self.folder.display()))?;
        let mut ask = |from, bytes| self.ask(recording, from, bytes);
        match fetch(recording, self.folder, &mut ask) {
            Ok(Fetched::Copied { bytes, resumed }) => {
                (line.done, line.resumed) = (Some("copied"), Some(resumed));
                summary.copied += 1;
                summary.bytes += bytes;
            }
            Ok(Fetched::There) => {
                line.done = Some("there");
                summary.there += 1;
            }
            Err(FetchError::Growing(_)) => {
                line.done = Some("growing");
                summary.growing += 1;
            }
            Err(error) => {
                (line.done, line.reason) = (Some("failed"), Some(message(&error)));
                summary.failed += 1;
            }
        }
        reported(self.member, line, json)
    }

    /// Asks until an answer comes, or patience ends; a reason against it is an answer. One piece at a time, so that everything else that the
    /// gripper reports waits for no more than that; less, where the line is too slow for one, and more again where an answer comes much sooner than it must.
    fn ask(&self, recording: &Recording, from: u64, bytes: u64) -> Result<Vec<Vec<u8>>, NetError> {
        let start = clock::monotonic();
        loop {
            let (most, asked) = (self.most.get(), clock::monotonic());
            let error = match self.once(recording, from, bytes.min(most)) {
                Err(error @ (NetError::Silent { .. } | NetError::Refused { .. })) => error,
                done => {
                    let took = clock::monotonic().saturating_sub(asked);
                    if bytes >= most && took < self.answer() / QUICK {
                        self.most.set((2 * most).min(PIECE as u64));
                    }
                    return done;
                }
            };
            let now = clock::monotonic();
            // What nobody has received ends sooner, and was not too long.
            let is_slow = now.saturating_sub(asked) >= self.answer();
            if is_slow {
                self.most.set((most / 4).max(LEAST));
            }
            if now.saturating_sub(start) >= self.patience {
                self.gone.set(!is_slow || most == LEAST);
                return Err(error);
            }
            thread::park_timeout(RETRY);
        }
    }

    /// How long one answer may take.
    fn answer(&self) -> Duration {
        PATIENCE.max(self.patience / ATTEMPTS)
    }

    fn once(&self, recording: &Recording, from: u64, bytes: u64) -> Result<Vec<Vec<u8>>, NetError> {
        let parameters = recording.question(from, bytes);
        let (member, patience) = (self.member, self.answer());
        let part = Part::Recordings;
        ask(self.session, &Ask { member, part, parameters: &parameters, payload: &[], patience })
    }
}

fn reported(member: &Member, line: Line<'_>, json: bool) -> anyhow::Result<()> {
    let Recording { name, bytes, .. } = line.recording;
    if let Some(reason) = line.reason.as_ref().filter(|_| !json) {
        eprintln!("gripfleet: {}", named(member, &escape(reason)));
        return Ok(());
    }
    let what = match (line.done, line.resumed) {
        (_, Some(resumed)) if resumed > 0 => {
            format!("{bytes} bytes copied, {resumed} of them before")
        }
        (Some("copied"), _) => format!("{bytes} bytes copied"),
        (Some("there"), _) => "is here already".to_owned(),
        _ => "is being written; not copied".to_owned(),
    };
    let text = format!("{member}  {}  {what}", escape(name));
    say(json, &Of::new(member, line), &text)
}

fn report(json: bool, summary: &Summary) -> anyhow::Result<()> {
    let Summary { grippers, without, copied, bytes, there, growing, failed } = summary;
    let text = format!(
        "{grippers} grippers ({without} without recordings to give): {copied} recordings copied ({bytes} bytes), {there} here already, \
         {growing} being written, {failed} failed"
    );
    say(json, summary, &text)
}
