//! An address in; rows that come from there as an open line to a board, and lines of JSON back: the thread between a program that has
//! samples and the hot loop.
//!
//! The thread drives a [`RowBoard`] over one end of a socket pair, of which the hot loop holds the other, as it holds any line.

mod peer;

pub use crate::ends::{RowsAddress, RowsAddressError};

use crate::{
    clients::ListenError,
    ends::{EndFault, GripperEnds, GripperUpdate, Started},
    hot::Shared,
};
use core::{sync::atomic::Ordering, time::Duration};
use grip_link::device::Drive;
use grip_port::{Line, PortError};
use grip_robotiq::gripper::Order;
use grip_session::rows::{Actuator, BoardOptions, RowBoard, RowCounters, RowsError};
use peer::{Peer, Received};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::{
    io::{self, Read as _, Write as _},
    net::Shutdown,
    os::unix::net::{UnixDatagram, UnixStream},
    sync::{
        Arc,
        mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender},
    },
    thread::{self, JoinHandle},
};

/// Longest time without a look at the clock.
const TURN: Duration = Duration::from_millis(2);
/// The same before there is a board, and after its end.
const IDLE: Duration = Duration::from_millis(25);
/// How long lines back are still written after the end.
const FAREWELL: Duration = Duration::from_secs(1);
/// Lines back that may wait.
const LINES: usize = 256;
/// Stack of the thread (bytes).
const STACK: usize = 256 * 1024;
/// Reads before rows go on: datagrams come one by one, and few of them wait in the system.
const READS: u32 = 8;
/// Bytes read at once: more than any datagram has, so that none is cut.
const INPUT: usize = 64 * 1024;
/// The same where each row of a datagram has got its number.
const NUMBERED: usize = 2 * INPUT;
/// After this time (us) without a header a connection is reported, and gives way to another one.
const SILENT_US: u64 = 5_000_000;

/// Why rows cannot be had (any more).
#[derive(Debug, thiserror::Error)]
pub enum RowsFault {
    /// Nobody can connect.
    #[error(transparent)]
    Listen(#[from] ListenError),
    /// The rows themselves.
    #[error("rows from {place}: {source}")]
    Rows {
        /// From where.
        place: String,
        /// What is wrong.
        source: RowsError,
    },
    /// The system refuses something.
    #[error("rows from {place}: {source}")]
    System {
        /// From where.
        place: String,
        /// What.
        source: io::Error,
    },
    /// The sensor or the gripper on a line of its own.
    #[error(transparent)]
    End(#[from] EndFault),
    /// The line to the hot loop.
    #[error(transparent)]
    Line(#[from] PortError),
    /// The thread ended by a panic.
    #[error("the thread of the rows failed")]
    Thread,
}

/// The running thread.
#[derive(Debug)]
pub struct Rows {
    back: Back,
    ended: Receiver<Result<RowCounters, RowsFault>>,
    thread: JoinHandle<()>,
}

/// The way back to the program: lines of JSON, which wait for nobody.
#[derive(Clone, Debug)]
pub struct Back {
    lines: SyncSender<String>,
    wake: Arc<UnixStream>,
}

impl Back {
    /// Sends a line, without its end; `false` where it finds no room.
    #[must_use]
    pub fn line(&self, text: String) -> bool {
        let sent = self.lines.try_send(text).is_ok();
        // A full pipe wakes as well.
        let _woken = (&*self.wake).write(&[0]);
        sent
    }
}

/// Where rows come from.
#[derive(Debug)]
pub enum RowSource {
    /// Another program.
    Program(RowsAddress),
    /// A sensor on a serial line, whose thread sends them.
    Sensor {
        /// What it is called.
        name: String,
        /// Its thread.
        started: Started<UnixDatagram>,
    },
}

/// Who follows the commands.
#[derive(Debug)]
pub enum Commanded {
    /// Nobody: there is only a sensor.
    Nobody,
    /// The program that sends the rows.
    Program(Actuator),
    /// A gripper on a line of its own, and the most that it is asked for.
    Gripper(Started<GripperEnds>, Actuator),
}

/// A gripper on a line of its own, as this thread knows it.
struct OwnGripper {
    ends: GripperEnds,
    fault: Receiver<EndFault>,
    /// Whether it was ready once, and is now.
    known: bool,
    present: bool,
}

/// What the thread works with.
struct Thread<C> {
    gripper: Option<OwnGripper>,
    /// Why the thread of the sensor ended.
    sensor_fault: Option<Receiver<EndFault>>,
    clock: C,
    board: RowBoard,
    peer: Peer,
    place: String,
    shared: Arc<Shared>,
    lines: Option<Sender<Line>>,
    reports: Sender<String>,
    back: Receiver<String>,
    wake: UnixStream,
    /// This end of the line, and the other one until the board is ready.
    ours: Option<UnixStream>,
    theirs: Option<UnixStream>,
    last: LastCommand,
    ordered: Option<Order>,
    /// No more rows come.
    ended: bool,
    /// Since when (us) the program of this connection has sent no header.
    silent_us: Option<u64>,
}

impl Rows {
    /// Opens the source and starts the thread. Lines to the board come out of the receiver, sentences for people go to `reports`.
    /// `clock` gives microseconds and never goes back.
    ///
    /// # Errors
    /// Where the address cannot be opened.
    pub fn start(
        source: RowSource,
        commanded: Commanded,
        clock: impl Fn() -> u64 + Send + 'static,
        shared: Arc<Shared>,
        reports: Sender<String>,
    ) -> Result<(Self, Receiver<Line>), RowsFault> {
        let (place, peer, datagrams, sensor_fault) = match source {
            RowSource::Program(address) => {
                let datagrams = matches!(address, RowsAddress::Udp(_));
                (address.to_string(), Peer::open(&address)?, datagrams, None)
            }
            RowSource::Sensor { name, started } => {
                (name, Peer::Fed(started.end), true, Some(started.fault))
            }
        };
        let (actuator, gripper) = match commanded {
            Commanded::Nobody => (None, None),
            Commanded::Program(actuator) => (Some(actuator), None),
            Commanded::Gripper(Started { end, fault }, actuator) => {
                let gripper = OwnGripper { ends: end, fault, known: false, present: false };
                (Some(actuator), Some(gripper))
            }
        };
        let system = |source| RowsFault::System { place: place.clone(), source };
        let (ours, theirs) = line_ends().map_err(system)?;
        let (wake, waker) = UnixStream::pair().map_err(system)?;
        wake.set_nonblocking(true).map_err(system)?;
        waker.set_nonblocking(true).map_err(system)?;
        let (line_in, lines) = mpsc::channel();
        let (back_in, back) = mpsc::sync_channel(LINES);
        let (ended_in, ended) = mpsc::channel();
        let mut thread = Thread {
            gripper,
            sensor_fault,
            clock,
            board: RowBoard::new(BoardOptions { actuator, datagrams }),
            peer,
            place: place.clone(),
            shared,
            lines: Some(line_in),
            reports,
            back,
            wake,
            ours: Some(ours),
            theirs: Some(theirs),
            last: LastCommand::default(),
            ordered: None,
            ended: false,
            silent_us: None,
        };
        let run = move || {
            let ended = thread.run().map(|()| thread.board.counters());
            thread.close();
            // Nobody waits for it any more where the program ends by another fault.
            let _sent = ended_in.send(ended);
            thread.farewell();
        };
        let thread = thread::Builder::new().name("rows".to_owned()).stack_size(STACK).spawn(run);
        let thread = thread.map_err(system)?;
        let back = Back { lines: back_in, wake: Arc::new(waker) };
        Ok((Self { back, ended, thread }, lines))
    }

    /// The way back to the program.
    #[must_use]
    pub fn back(&self) -> Back {
        self.back.clone()
    }

    /// What became of the rows, once the run is over.
    ///
    /// # Errors
    /// Why there were none, or no more.
    pub fn ended(&self) -> Result<RowCounters, RowsFault> {
        self.ended.recv().unwrap_or(Err(RowsFault::Thread))
    }

    /// Waits until the last line back is written, or the program does not take it.
    pub fn finish(self) {
        let Self { back, ended, thread } = self;
        drop((back, ended));
        let _joined = thread.join();
    }
}

impl<C: Fn() -> u64> Thread<C> {
    /// Takes rows until they end, or the daemon does.
    fn run(&mut self) -> Result<(), RowsFault> {
        let mut input = vec![0; INPUT];
        while !self.shared.stop.load(Ordering::Relaxed) && !self.board.is_over() {
            self.wait().map_err(|source| self.system(source))?;
            let now_us = (self.clock)();
            if !self.has_ends(now_us)? {
                continue;
            }
            for _ in 0..READS {
                if !(self.read(&mut input)? && self.peer.is_fed()) {
                    break;
                }
            }
            self.watch_silent(now_us);
            let now_us = (self.clock)();
            self.board.turn(now_us).map_err(|source| self.rows(source))?;
            self.hand_over()?;
            self.exchange(now_us, &mut input)?;
            self.command(now_us);
            self.write_back();
            for text in self.board.take_reports() {
                let _sent = self.reports.send(text);
            }
        }
        Ok(())
    }

    fn rows(&self, source: RowsError) -> RowsFault {
        RowsFault::Rows { place: self.place.clone(), source }
    }

    fn system(&self, source: io::Error) -> RowsFault {
        RowsFault::System { place: self.place.clone(), source }
    }

    /// Waits until there is something to do.
    fn wait(&mut self) -> io::Result<()> {
        let is_ready = self.board.is_ready();
        let pause = if is_ready { self.board.pause((self.clock)(), TURN) } else { IDLE };
        let mut polled = Vec::with_capacity(3);
        polled.push(PollFd::new(&self.wake, PollFlags::IN));
        if let Some(ours) = self.ours.as_ref().filter(|_| is_ready) {
            let unsent = !self.board.unsent().is_empty();
            let flags = if unsent { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
            polled.push(PollFd::new(ours, flags));
        }
        let wanted = if self.has_room() { PollFlags::IN } else { PollFlags::empty() };
        let waiting = if self.peer.has_unsent() { PollFlags::OUT } else { PollFlags::empty() };
        if !(wanted | waiting).is_empty() {
            polled.push(PollFd::from_borrowed_fd(self.peer.fd(), wanted | waiting));
        }
        match poll(&mut polled, Some(&timespec(pause))) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Looks at the sensor and the gripper on lines of their own; `false` until the gripper was found.
    fn has_ends(&mut self, now_us: u64) -> Result<bool, RowsFault> {
        if let Some(Ok(fault)) = self.sensor_fault.as_ref().map(Receiver::try_recv) {
            return Err(fault.into());
        }
        let Some(gripper) = &mut self.gripper else { return Ok(true) };
        if let Ok(fault) = gripper.fault.try_recv() {
            return Err(fault.into());
        }
        // Also one that is back already: the board has stopped its rows, and starts them with a new line only.
        let mut lost = false;
        while let Ok(update) = gripper.ends.updates.try_recv() {
            if update.reading.is_some() && !gripper.known {
                gripper.known = true;
                self.board.set_actuator(limited(self.board.actuator(), &update));
            }
            lost |= gripper.present && update.reading.is_none();
            gripper.present = update.reading.is_some();
            self.board.set_gripper(now_us, update.reading);
            if update.let_go {
                self.board.lose_object(now_us);
            }
        }
        if lost {
            // The hot loop then does as with any gripper that is unplugged: it goes on from the force that it has sent.
            (self.ours, self.theirs) = (None, None);
            (self.last, self.ordered) = (LastCommand::default(), None);
        }
        if gripper.present && self.ours.is_none() {
            let ends = line_ends();
            let (ours, theirs) = ends.map_err(|source| self.system(source))?;
            (self.ours, self.theirs) = (Some(ours), Some(theirs));
            self.board.sent(self.board.unsent().len());
        }
        Ok(self.gripper.as_ref().is_none_or(|gripper| gripper.known))
    }

    /// Whether more comes, and a whole read has room; otherwise it stays where it is.
    fn has_room(&self) -> bool {
        self.gripper.as_ref().is_none_or(|gripper| gripper.known)
            && !self.ended
            && (self.board.room() >= NUMBERED || !self.board.is_ready())
    }

    /// Reads once; `false` where nothing came.
    fn read(&mut self, input: &mut [u8]) -> Result<bool, RowsFault> {
        // Of a stream what finds no room stays where it is; a datagram is read whole.
        let streams = !matches!(self.peer, Peer::Udp { .. } | Peer::Fed(_));
        let room = if streams { self.board.room().min(input.len()) } else { input.len() };
        let Some(input) = input.get_mut(..room).filter(|_| self.has_room()) else {
            return Ok(false);
        };
        let known = self.board.has_header();
        let received = self.peer.receive(input).map_err(|source| self.system(source))?;
        let taken = match received {
            Received::Nothing => return Ok(false),
            Received::Bytes(bytes) => self.board.push(bytes),
            Received::Datagram(bytes) => self.board.push_datagram(bytes),
            Received::End => {
                self.ended = true;
                self.board.end()
            }
            Received::Broken(error) => {
                self.ended = true;
                let text =
                    format!("the connection broke, and its last rows may be missing: {error}");
                let _sent = self.reports.send(text);
                self.board.end()
            }
        };
        if !known && self.board.has_header() {
            self.silent_us = None;
            self.peer.settle(true);
        }
        // A scan, a page or a foreign datagram is no source: without a good header the next one is waited for.
        let foreign = !self.board.has_header() && (taken.is_err() || self.ended);
        if !foreign || !self.peer.settle(false) {
            return taken.map(|()| true).map_err(|source| self.rows(source));
        }
        let why = taken.err().map_or_else(|| "nothing came".to_owned(), |error| error.to_string());
        let text = format!("{}: no header of rows, waiting for the next: {why}", self.place);
        let _sent = self.reports.send(text);
        self.board.restart();
        (self.ended, self.silent_us) = (false, None);
        Ok(true)
    }

    /// Reports a connection that sends no header, and lets another one take its place.
    fn watch_silent(&mut self, now_us: u64) {
        let waits = matches!(self.peer, Peer::Connected { .. }) && !self.board.has_header();
        let Some(since_us) = self.silent_us.filter(|_| waits) else {
            self.silent_us = waits.then_some(now_us);
            return;
        };
        if now_us.saturating_sub(since_us) < SILENT_US {
            return;
        }
        let text = format!("{}: a program has connected and sends no header", self.place);
        let _sent = self.reports.send(text);
        if self.peer.replace_silent() {
            self.board.restart();
            self.silent_us = None;
        } else {
            self.silent_us = Some(now_us);
        }
    }

    /// Gives the hot loop its end of the line, once there is a board to answer.
    fn hand_over(&mut self) -> Result<(), RowsFault> {
        if self.board.is_ready()
            && let Some((theirs, lines)) = self.theirs.take().zip(self.lines.as_ref())
        {
            let _sent = lines.send(Line::from_fd(theirs.into())?);
        }
        Ok(())
    }

    /// Bytes to and from the hot loop. Where it gave up its end of the line, it gets another one.
    fn exchange(&mut self, now_us: u64, input: &mut [u8]) -> Result<(), RowsFault> {
        let Some(ours) = self.ours.as_mut().filter(|_| self.theirs.is_none()) else {
            return Ok(());
        };
        match ours.read(input) {
            Ok(0) => {
                let (ours, theirs) = line_ends().map_err(|source| self.system(source))?;
                (self.ours, self.theirs) = (Some(ours), Some(theirs));
                // What was meant for the old line is lost with it.
                self.board.sent(self.board.unsent().len());
                return Ok(());
            }
            Ok(count) => self.board.receive(now_us, input.get(..count).unwrap_or(&[])),
            Err(_) => {}
        }
        while let Ok(count @ 1..) = ours.write(self.board.unsent()) {
            self.board.sent(count);
        }
        Ok(())
    }

    /// Gives the program what its gripper is to do, where that has changed or was written long ago.
    fn command(&mut self, now_us: u64) {
        let Some((t_us, drive)) = self.board.drive(now_us) else { return };
        if let Some(gripper) = self.gripper.as_ref().filter(|gripper| gripper.present) {
            let drive = match drive {
                Drive::Open if !self.board.opens() => Drive::Passive,
                drive => drive,
            };
            let order = if self.board.is_stopped() { Order::Stop } else { order(drive) };
            if self.ordered.replace(order) != Some(order) {
                let _sent = gripper.ends.orders.send(order);
            }
        } else if self.gripper.is_none() && self.last.is_due(drive, now_us) {
            self.peer.command(&command_line(t_us, drive));
        }
    }

    fn write_back(&mut self) {
        let _woken = self.wake.read(&mut [0; 512]);
        while let Ok(line) = self.back.try_recv() {
            self.peer.line(&line);
        }
        self.peer.write();
    }

    /// Ends the line: the hot loop reads what is left of it. This end stays open, or its next write would fail before.
    fn close(&mut self) {
        if let Some(ours) = &self.ours {
            let _gone = ours.shutdown(Shutdown::Write);
        }
        (self.theirs, self.lines) = (None, None);
    }

    /// Writes the last lines back until nobody sends any.
    fn farewell(&mut self) {
        loop {
            match self.back.recv_timeout(IDLE) {
                Ok(line) => self.peer.line(&line),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.peer.write();
        }
        let mut left = FAREWELL;
        while self.peer.has_unsent() && !left.is_zero() {
            self.peer.write();
            let _waited = poll(&mut [], Some(&timespec(TURN)));
            left = left.saturating_sub(TURN);
        }
    }
}

/// The last command written to the program, and when (us).
#[derive(Debug, Default)]
struct LastCommand(Option<(Drive, u64)>);

impl LastCommand {
    /// A command is repeated after so long (us): a datagram is lost, a board behind a bridge starts anew.
    const AGAIN: u64 = 1_000_000;

    /// Whether `drive` is to be written now, which is then taken as done.
    fn is_due(&mut self, drive: Drive, now_us: u64) -> bool {
        let due = self.0.is_none_or(|(last, at_us)| {
            last != drive || now_us.saturating_sub(at_us) >= Self::AGAIN
        });
        if due {
            self.0 = Some((drive, now_us));
        }
        due
    }
}

/// What a gripper is to do; only a host that opens it opens it.
fn order(drive: Drive) -> Order {
    match drive {
        Drive::Force(force_mn) if force_mn > 0 => {
            let force_n = 1e-3 * force_mn as f32;
            Order::Force(force_n)
        }
        Drive::Open => Order::Open,
        Drive::Force(_) | Drive::Passive => Order::Keep,
    }
}

/// What a gripper is asked for, within what it declares.
fn limited(actuator: Option<Actuator>, update: &GripperUpdate) -> Option<Actuator> {
    let [force_max_n, slew_n_s] = update.most.unwrap_or([f32::INFINITY; 2]);
    actuator.map(|actuator| Actuator {
        force_max_n: actuator.force_max_n.min(force_max_n),
        slew_n_s: actuator.slew_n_s.min(slew_n_s),
        holds_n: update.holds_n,
        ..actuator
    })
}

/// This end of a line, which never waits, and that of the hot loop.
fn line_ends() -> io::Result<(UnixStream, UnixStream)> {
    let (ours, theirs) = UnixStream::pair()?;
    ours.set_nonblocking(true)?;
    Ok((ours, theirs))
}

/// A force command as a line of JSON.
fn command_line(t_us: u64, drive: Drive) -> String {
    let (mode, force_mn) = match drive {
        Drive::Force(force_mn) => ("force", force_mn),
        Drive::Open => ("open", 0),
        Drive::Passive => ("passive", 0),
    };
    let (s, us) = (t_us / 1_000_000, t_us % 1_000_000);
    let force_n = f64::from(force_mn) / 1e3;
    format!(r#"{{"type":"command","t_s":{s}.{us:06},"mode":"{mode}","force_n":{force_n}}}"#)
}

fn timespec(time: Duration) -> Timespec {
    Timespec { tv_sec: 0, tv_nsec: i64::from(time.subsec_nanos()) }
}

#[cfg(test)]
mod tests {
    use super::{Drive, LastCommand, Rows, RowsAddress, command_line};
    use crate::hot::Shared;
    use core::{sync::atomic::Ordering, time::Duration};
    use grip_session::config::Listen;
    use std::{io::Write as _, os::unix::net::UnixStream, sync::Arc};

    #[test]
    fn a_command_is_a_line_of_json() {
        let lines = [Drive::Force(5250), Drive::Open, Drive::Passive].map(|drive| {
            let line = command_line(1_700_000_000_000_001, drive);
            serde_json::from_str::<serde_json::Value>(&line).unwrap()
        });
        assert_eq!(lines[0]["force_n"], 5.25);
        assert_eq!(lines[0]["t_s"], 1_700_000_000.000_001);
        assert_eq!((&lines[1]["mode"], &lines[2]["mode"]), (&"open".into(), &"passive".into()));
    }

    #[test]
    fn a_command_is_written_where_it_changes_and_again_every_second() {
        let mut last = LastCommand::default();
        let (held, more) = (Drive::Force(2450), Drive::Force(2460));
        let turns = [
            (Drive::Passive, 4_000_000, true),
            (Drive::Passive, 4_999_999, false),
            (Drive::Passive, 5_000_000, true),
            (held, 5_001_000, true),
            (held, 6_000_999, false),
            (held, 6_001_000, true),
            (more, 6_002_000, true),
            (more, 7_001_999, false),
            (Drive::Open, 7_002_000, true),
            (Drive::Open, 8_002_000, true),
        ];
        for (drive, now_us, due) in turns {
            assert_eq!(last.is_due(drive, now_us), due, "{drive:?} at {now_us}");
        }
    }

    #[test]
    fn a_line_that_was_given_up_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        let address = RowsAddress::Stream(Listen::Unix(path.clone()));
        let shared = Arc::new(Shared::default());
        let (source, nobody) = (super::RowSource::Program(address), super::Commanded::Nobody);
        let (reports, _texts) = std::sync::mpsc::channel();
        let (rows, lines) =
            Rows::start(source, nobody, || 0, Arc::clone(&shared), reports).unwrap();
        let mut program = UnixStream::connect(&path).unwrap();
        program.write_all(b"vibration,rate=1600\n0.5\n").unwrap();
        for _ in 0..3 {
            drop(lines.recv_timeout(Duration::from_secs(20)).unwrap());
        }
        shared.stop.store(true, Ordering::Relaxed);
        assert_eq!(rows.ended().unwrap().rows, 0, "nobody wanted them");
        rows.finish();
        assert!(lines.try_recv().is_err());
    }
}
