//! Recorder of items of the hot thread in files: the thread that may wait for a disk.

use crate::{
    clock::Clock,
    settings::{PROGRAM, Settings},
};
use anyhow::{Context as _, anyhow};
use core::time::Duration;
use grip_daemon::{
    recorder::{About, Recorder, RecorderCounters, RecorderUpdate, RecordingOptions},
    rings::{Inbox, Outbox, Sizes, rings},
};
use grip_record::mcap::Attached;
use grip_session::exit::message;
use std::{
    path::PathBuf,
    sync::mpsc::{self, Receiver, Sender},
    thread::{self, JoinHandle},
};

/// Pause between two looks into the ring.
const PAUSE: Duration = Duration::from_millis(50);
/// Stack of the thread (bytes).
const STACK: usize = 512 * 1024;

/// What the recorder reports to the service thread.
#[derive(Debug)]
pub(crate) enum Reported {
    /// A file was begun.
    Began(PathBuf),
    /// The recording has stopped, and why.
    Stopped(String),
    /// The oldest file of the run made room.
    Deleted(PathBuf),
    /// It was to make room and could not be deleted.
    Kept(PathBuf, String),
    /// Counts and bytes as of now.
    Counters(RecorderCounters),
}

/// The recorder's thread, as seen from outside.
#[derive(Debug)]
pub(crate) struct Recording {
    thread: JoinHandle<anyhow::Result<RecorderCounters>>,
}

/// How the service thread talks with it.
#[derive(Debug)]
pub(crate) struct Recorded {
    /// What it reports.
    pub(crate) reported: Receiver<Reported>,
    /// Another configuration, model or calibration.
    pub(crate) attach: Sender<Attached>,
}

/// What the thread runs on.
#[derive(Debug)]
struct Thread {
    recorder: Recorder,
    inbox: Inbox,
    clock: Clock,
    reported: Sender<Reported>,
    attach: Receiver<Attached>,
    dropped: u64,
}

impl Recording {
    /// Begins the recording that the settings ask for, if they do: the end of the ring for the hot thread, the thread and its reports.
    pub(crate) fn start(
        settings: &Settings,
        clock: Clock,
    ) -> anyhow::Result<Option<(Outbox, Self, Recorded)>> {
        let Some(file) = settings.record(clock.wall_s()) else { return Ok(None) };
        let about = About {
            program: PROGRAM.to_owned(),
            run: format!("{:x}", clock.wall_ns()),
            wall_ns: clock.wall_ns(),
            host_us: clock.now_us(),
            attached: settings.attachments()?,
            ..About::default()
        };
        let recorder = Recorder::create(&file, options(settings), about)?;
        let (outbox, inbox) = rings(Sizes::RECORDER);
        let (reported_in, reported) = mpsc::channel();
        let (attach, attach_out) = mpsc::channel();
        let thread = Thread {
            recorder,
            inbox,
            clock,
            reported: reported_in,
            attach: attach_out,
            dropped: 0,
        };
        let thread = thread::Builder::new()
            .name("recorder".to_owned())
            .stack_size(STACK)
            .spawn(move || thread.run())
            .context("cannot start the recorder")?;
        Ok(Some((outbox, Self { thread }, Recorded { reported, attach })))
    }

    /// Waits for the last file to be whole.
    pub(crate) fn finish(self) -> anyhow::Result<RecorderCounters> {
        self.thread.join().map_err(|_| anyhow!("the recorder failed"))?
    }
}

fn options(settings: &Settings) -> RecordingOptions {
    let recording = &settings.config.recording;
    RecordingOptions {
        rotate_bytes: Some(u64::from(recording.max_mib) << 20),
        rotate_us: Some(u64::from(recording.max_age_s) * 1_000_000),
        keep_bytes: recording.keep_mib.map(|mib| u64::from(mib) << 20),
        flush_us: u64::from(recording.flush_ms) * 1000,
        wire: true,
    }
}

impl Thread {
    /// Records until the hot thread has let go of the ring and it is empty.
    fn run(mut self) -> anyhow::Result<RecorderCounters> {
        loop {
            let last = self.inbox.is_finished();
            let now_us = self.clock.now_us();
            while let Ok(file) = self.attach.try_recv() {
                self.recorder.attach(&file, now_us);
            }
            let recorder = &mut self.recorder;
            self.inbox.drain(&mut |item| recorder.take(&item, now_us));
            self.count_drops(now_us);
            self.recorder.tick(now_us);
            self.report();
            if last {
                break;
            }
            pause();
        }
        Ok(self.recorder.finish()?)
    }

    fn count_drops(&mut self, now_us: u64) {
        let dropped = self.inbox.drops().now().total();
        if dropped > self.dropped {
            self.recorder.dropped(dropped - self.dropped, now_us);
            self.dropped = dropped;
        }
    }

    /// Nobody who listens any more is no reason not to record.
    fn report(&mut self) {
        while let Some(updates) = self.recorder.updates() {
            let _reported = self.reported.send(match updates {
                RecorderUpdate::Began(file) => Reported::Began(file),
                RecorderUpdate::Stopped(error) => Reported::Stopped(message(&error)),
                RecorderUpdate::Deleted(file) => Reported::Deleted(file),
                RecorderUpdate::Kept(file, error) => Reported::Kept(file, error.to_string()),
            });
        }
        let _reported = self.reported.send(Reported::Counters(self.recorder.counters()));
    }
}

#[expect(clippy::disallowed_methods, reason = "the driver may wait; only this thread does")]
fn pause() {
    thread::sleep(PAUSE);
}
