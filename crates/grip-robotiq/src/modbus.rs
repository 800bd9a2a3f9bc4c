//! Requests and their answers on a Modbus RTU line, one request at a time.
//!
//! Frames, checksums and function codes are those of the crate rmodbus. An answer has a known length, so that it is taken with its last
//! byte; between two frames the line is silent for [`SILENCE_US`]. An adapter with echo returns the request itself, and a line without
//! bias gives stray bytes before an answer: both are skipped and counted.
//!
//! An answer does not name its request. Behind a forwarder one may come after it was given up, and would then count as that of the next
//! request, and so on for ever. So the first request after a time-out, and on every new line, is a probe, which reads one register or
//! two: its answer is shorter than that of a look, and what was owed before has come by then, because a line keeps the order. One and two
//! take turns, so that the probes of a time-out are none of the one after it.

use rmodbus::{ErrorKind, ModbusProto, client::ModbusRequest};

/// First command register, and first status register.
const COMMAND: u16 = 0x03E8;
const STATUS: u16 = 0x07D0;
/// Registers of each.
const REGISTERS: usize = 3;
/// Least time between two frames (us): 3.5 characters, and never less than 1.75 ms above 19200 baud.
const SILENCE_US: u64 = 1750;
/// An answer that takes longer than this (us) does not come.
const TIMEOUT_US: u64 = 60_000;
/// After a broken answer, silence for this long (us) begins the next one.
const RESYNC_US: u64 = 10_000;
/// Bytes of an answer: written registers, status, and an exception.
const WRITTEN: usize = 8;
const READ: usize = 5 + 2 * REGISTERS;
const EXCEPTION: usize = 5;
/// Bytes that are looked at for one answer: its request twice, and as much again.
const LONGEST: usize = 64;

/// What became of the requests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusCounters {
    /// Answers as they should be.
    pub answers: u64,
    /// Requests without an answer in time.
    pub timeouts: u64,
    /// Answers with a wrong checksum, or from another device.
    pub broken: u64,
    /// Requests that the device refused.
    pub refused: u64,
    /// Own requests that came back before the answer.
    pub echoes: u64,
    /// Stray bytes before answers.
    pub stray: u64,
}

impl BusCounters {
    /// What is odd about a line that works.
    #[must_use]
    pub fn note(&self) -> Option<&'static str> {
        if self.echoes > 0 {
            Some("the line echoes the requests (an RS-485 adapter with echo): they are skipped")
        } else if self.stray > 0 {
            Some("stray bytes before answers are skipped: check termination and bias of RS-485")
        } else {
            None
        }
    }
}

/// A request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Request {
    /// Write the command registers (function 16).
    Write([u16; REGISTERS]),
    /// Read the status registers (function 04).
    Read,
    /// Read the first of them only, or the first two.
    Probe(u16),
}

/// What came of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// The registers are written.
    Written([u16; REGISTERS]),
    /// The status registers.
    Status([u16; REGISTERS]),
    /// Answers are those of their requests from now on.
    Probed,
    /// Nothing usable came.
    Failed,
}

/// The line.
#[derive(Debug)]
pub(crate) struct Bus {
    unit: u8,
    /// What waits for its answer, until when (us).
    pending: Option<(Request, ModbusRequest, u64)>,
    /// The request as it was sent, and whether it has come back.
    sent: Vec<u8>,
    echoed: bool,
    input: Vec<u8>,
    /// From when on (us) the next request may go out.
    free_us: u64,
    /// Whether an answer might be that of an earlier request; how many requests were given up whose answer may still come.
    unsure: bool,
    owed: u32,
    /// Registers that a probe reads.
    probed: u16,
    counters: BusCounters,
}

impl Bus {
    pub(crate) fn new(unit: u8) -> Self {
        Self {
            unit,
            pending: None,
            sent: Vec::with_capacity(64),
            echoed: false,
            input: Vec::with_capacity(64),
            free_us: 0,
            unsure: true,
            owed: 0,
            probed: 1,
            counters: BusCounters::default(),
        }
    }

    pub(crate) fn counters(&self) -> BusCounters {
        self.counters
    }

    /// The line was opened anew.
    pub(crate) fn reset(&mut self, now_us: u64) {
        self.owed += u32::from(self.pending.take().is_some());
        self.doubt();
        self.input.clear();
        self.free_us = now_us + RESYNC_US;
    }

    /// Whether a request may go out now.
    pub(crate) fn is_free(&self, now_us: u64) -> bool {
        self.pending.is_none() && now_us >= self.free_us
    }

    /// The next request that reads: the status, or a probe, which must come before any other.
    pub(crate) fn look(&self) -> Request {
        if self.unsure { Request::Probe(self.probed) } else { Request::Read }
    }

    /// An answer may come that is none of the next request.
    fn doubt(&mut self) {
        if !core::mem::replace(&mut self.unsure, true) {
            self.probed = 3 - self.probed;
        }
    }

    /// Writes a request into `out`; `false` where that is not possible.
    pub(crate) fn send(&mut self, now_us: u64, request: Request, out: &mut Vec<u8>) -> bool {
        let mut frame = ModbusRequest::new(self.unit, ModbusProto::Rtu);
        let count = u16::try_from(REGISTERS).unwrap_or(u16::MAX);
        let made = match request {
            Request::Write(values) => frame.generate_set_holdings_bulk(COMMAND, &values, out),
            Request::Read => frame.generate_get_inputs(STATUS, count, out),
            Request::Probe(count) => frame.generate_get_inputs(STATUS, count, out),
        };
        self.input.clear();
        self.sent.clone_from(out);
        self.echoed = false;
        if made.is_ok() {
            self.pending = Some((request, frame, now_us + TIMEOUT_US));
        }
        made.is_ok()
    }

    /// Time goes on: a request may have waited too long.
    pub(crate) fn expire(&mut self, now_us: u64) -> Option<Answer> {
        let (_, _, until_us) = self.pending.as_ref()?;
        if now_us < *until_us {
            return None;
        }
        // An echo was taken off: what is left was to be an answer.
        let count = if self.input.is_empty() {
            &mut self.counters.timeouts
        } else {
            &mut self.counters.broken
        };
        *count += 1;
        self.doubt();
        self.owed = self.owed.saturating_add(1);
        self.fail(now_us)
    }

    /// Takes bytes. What comes without a request belongs to an answer that was given up.
    pub(crate) fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Option<Answer> {
        let Some((request, frame, _)) = &self.pending else {
            self.free_us = self.free_us.max(now_us + RESYNC_US);
            return None;
        };
        self.input.extend(bytes.iter().take(LONGEST));
        let sent = self.sent.len().max(1);
        let echo = self.input.windows(sent).position(|bytes| bytes == self.sent);
        if let Some(at) = echo.filter(|_| !self.echoed) {
            self.input.drain(..at + sent);
            self.echoed = true;
            self.counters.echoes += 1;
            self.counters.stray += at as u64;
        }
        let may_echo = |at| self.sent.starts_with(self.input.get(at..).unwrap_or(&[]));
        let (answer, at) = match find(*request, frame, self.unit, &self.input) {
            Found::Answer(answer, at) => (answer, at),
            // An echo comes in pieces, too.
            Found::None if !self.echoed && (0..self.input.len()).any(may_echo) => return None,
            Found::None if self.input.len() < answer_length(*request, false) => return None,
            // What is owed may stand before it.
            Found::None if self.owed > 0 && self.input.len() < LONGEST => return None,
            Found::Begins if self.input.len() < LONGEST => return None,
            Found::None | Found::Begins => (Err(ErrorKind::FrameBroken), 0),
        };
        match answer {
            Ok(answer) => {
                self.counters.answers += 1;
                if self.owed == 0 {
                    self.counters.stray += at as u64;
                }
                let request = *request;
                self.settle(request);
                self.pending = None;
                self.free_us = now_us + SILENCE_US;
                Some(answer)
            }
            Err(error) if error.is_modbus_error() => {
                self.counters.refused += 1;
                let request = *request;
                self.settle(request);
                self.fail(now_us)
            }
            Err(_) => {
                self.counters.broken += 1;
                // The answer itself may still come, behind what was no answer.
                self.doubt();
                self.owed = self.owed.saturating_add(1);
                self.fail(now_us)
            }
        }
    }

    /// Something was answered, or refused.
    fn settle(&mut self, request: Request) {
        match request {
            Request::Probe(_) => self.unsure = false,
            // Whatever was owed came before it.
            Request::Read | Request::Write(_) => self.owed = 0,
        }
    }

    fn fail(&mut self, now_us: u64) -> Option<Answer> {
        self.pending = None;
        self.free_us = now_us + RESYNC_US;
        Some(Answer::Failed)
    }
}

/// What bytes hold of an answer.
enum Found {
    /// Nothing.
    None,
    /// A part that may be the beginning of one.
    Begins,
    /// One, or a refusal, behind so many stray bytes.
    Answer(Result<Answer, ErrorKind>, usize),
}

/// Bytes of an answer to `request`.
const fn answer_length(request: Request, refused: bool) -> usize {
    match request {
        _ if refused => EXCEPTION,
        Request::Write(_) => WRITTEN,
        Request::Read => READ,
        Request::Probe(1) => READ - 4,
        Request::Probe(_) => READ - 2,
    }
}

/// The first answer of `unit` with a right checksum, wherever it begins.
fn find(request: Request, frame: &ModbusRequest, unit: u8, input: &[u8]) -> Found {
    let mut found = Found::None;
    for at in 0..input.len() {
        let rest = input.get(at..).unwrap_or(&[]);
        let function = match request {
            Request::Write(_) => 0x10,
            Request::Read | Request::Probe(_) => 0x04,
        };
        let refused = match rest {
            [first, ..] if *first != unit => continue,
            [_, second, ..] if second & 0x7F != function => continue,
            [_, second, ..] => second & 0x80 != 0,
            _ => false,
        };
        let Some(whole) = rest.get(..answer_length(request, refused)) else {
            found = Found::Begins;
            continue;
        };
        match read(request, frame, whole) {
            Err(error) if !error.is_modbus_error() => {}
            answer => return Found::Answer(answer, at),
        }
    }
    found
}

/// The meaning of a whole answer.
fn read(request: Request, frame: &ModbusRequest, bytes: &[u8]) -> Result<Answer, ErrorKind> {
    match request {
        Request::Write(values) => {
            frame.parse_ok(bytes)?;
            // What was written is repeated: the first register and how many.
            let [first, last] = COMMAND.to_be_bytes();
            let echo = [first, last, 0, 3];
            let matches = bytes.get(2..6) == Some(&echo);
            matches.then_some(Answer::Written(values)).ok_or(ErrorKind::FrameBroken)
        }
        Request::Read => {
            let mut values = Vec::with_capacity(REGISTERS);
            frame.parse_u16(bytes, &mut values)?;
            let values = values.try_into().map_err(|_| ErrorKind::FrameBroken)?;
            Ok(Answer::Status(values))
        }
        Request::Probe(count) => {
            let mut values = Vec::with_capacity(REGISTERS);
            frame.parse_u16(bytes, &mut values)?;
            if values.len() == usize::from(count) {
                Ok(Answer::Probed)
            } else {
                Err(ErrorKind::FrameBroken)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Answer, Bus, Request};

    /// Frames of Robotiq's manual for the 2F-85 and 2F-140, steps 7 and 8 of its example over Modbus RTU.
    const OPEN: &[u8] = &[9, 0x10, 3, 0xE8, 0, 3, 6, 9, 0, 0, 0, 0xFF, 0xFF, 0x72, 0x19];
    const OPENED: &[u8] = &[9, 0x10, 3, 0xE8, 0, 3, 1, 0x30];
    const STATUS: &[u8] = &[9, 4, 6, 0xF9, 0, 0, 0, 0x0D, 0, 0x17, 0xAA];

    #[test]
    fn the_frames_of_the_manual() {
        let (mut bus, mut out) = (Bus::new(9), Vec::new());
        assert!(bus.send(0, Request::Write([0x0900, 0, 0xFFFF]), &mut out));
        assert_eq!(out, OPEN);
        assert!(!bus.is_free(1000));
        assert_eq!(bus.receive(4000, &OPENED[..5]), None);
        assert_eq!(bus.receive(4200, &OPENED[5..]), Some(Answer::Written([0x0900, 0, 0xFFFF])));
        assert!(!bus.is_free(5000) && bus.is_free(6000));
        assert!(bus.send(6000, Request::Read, &mut out));
        assert_eq!(out[..6], [9, 4, 7, 0xD0, 0, 3]);
        assert_eq!(bus.receive(9000, STATUS), Some(Answer::Status([0xF900, 0, 0x0D00])));
        assert_eq!(bus.counters().answers, 2);
    }

    /// Whatever pieces they come in.
    #[test]
    fn an_echo_and_stray_bytes_before_an_answer_are_skipped() {
        let write = Request::Write([0x0900, 0, 0xFFFF]);
        for (request, answer) in [(write, OPENED), (Request::Read, STATUS)] {
            for (before, after, echoes) in [
                (&[][..], &[][..], true),
                (&[0], &[], false),
                (&[], &[0, 0xFF], true),
                (&[0], &[0], true),
                (&[9, 0xFF, 9], &[], false),
            ] {
                for piece in 1..=40 {
                    let (mut bus, mut out) = (Bus::new(9), Vec::new());
                    assert!(bus.send(0, request, &mut out));
                    let echo = if echoes { &out[..] } else { &[] };
                    let came = [before, echo, after, answer].concat();
                    let answers: Vec<_> =
                        came.chunks(piece).filter_map(|bytes| bus.receive(4000, bytes)).collect();
                    let [answer] = answers.as_slice() else { panic!("{answers:?} of {came:02x?}") };
                    assert_ne!(*answer, Answer::Failed, "{came:02x?} by {piece}");
                    let counters = bus.counters();
                    assert_eq!((counters.answers, counters.broken), (1, 0));
                    assert_eq!(counters.echoes, u64::from(echoes));
                    assert_eq!(counters.stray, (before.len() + after.len()) as u64);
                    assert!(counters.note().is_some());
                }
            }
        }
    }

    #[test]
    fn what_is_broken_late_or_refused_is_counted_and_asked_again() {
        let (mut bus, mut out) = (Bus::new(9), Vec::new());
        bus.send(0, Request::Read, &mut out);
        let mut wrong = STATUS.to_vec();
        wrong[4] ^= 1;
        assert_eq!(bus.receive(3000, &wrong), Some(Answer::Failed));
        bus.send(20_000, Request::Read, &mut out);
        assert_eq!(bus.expire(70_000), None);
        assert_eq!(bus.expire(80_000), Some(Answer::Failed));
        assert_eq!(bus.receive(81_000, STATUS), None, "an answer that was given up");
        assert!(!bus.is_free(85_000) && bus.is_free(92_000));
        bus.send(92_000, Request::Read, &mut out);
        assert_eq!(bus.receive(93_000, &[9, 0x84, 2, 0x43, 0x03]), Some(Answer::Failed));
        // Another device, and the echo of another register.
        bus.send(120_000, Request::Write([0; 3]), &mut out);
        let other = [8, 0x10, 3, 0xE8, 0, 3, 0, 0xE1];
        assert_eq!(bus.receive(121_000, &other), Some(Answer::Failed));
        let counters = bus.counters();
        assert_eq!((counters.answers, counters.timeouts), (0, 1));
        assert_eq!((counters.broken, counters.refused), (2, 1));
    }
}
