//! Lives of a gripper that chance hardly finds, for the mode `device` of the peers, and what must come of each.

use super::gripper::{CONFIG, SESSION, hello, press, wire, written};
use super::words::hex;
use grip_link::frame::{Direction, Header};
use grip_link::message::{ClearFault, FaultCode, Grip, Kind, Ping, Versions};

/// A script and, in their order, words that its answers must hold; the answers may hold others between them.
#[derive(Debug)]
pub struct Life {
    /// What it shows.
    pub name: &'static str,
    /// The lines.
    pub script: Vec<String>,
    /// Types of the frames written, but for STATUS, EVENT and STATS, and lines that are no frames.
    pub wanted: Vec<&'static str>,
}

struct Author {
    script: Vec<String>,
    seq: u16,
}

impl Author {
    fn new(first: &str) -> Self {
        Self { script: vec![first.to_owned(), "ready 0".to_owned()], seq: 0 }
    }

    fn line(&mut self, line: &str) -> &mut Self {
        self.script.push(line.to_owned());
        self
    }

    fn send(&mut self, tick: u64, kind: Kind, payload: &[u8]) -> &mut Self {
        let header = Header::new(Direction::ToDevice, kind, self.seq, SESSION);
        self.seq += 1;
        let bytes = wire(&Header { ack_req: true, ..header }, payload);
        self.line(&format!("rx {tick} {}", hex(&bytes)))
    }

    fn clear(&mut self, tick: u64, fault: u16) -> &mut Self {
        let payload = written(|p| ClearFault { fault: FaultCode(fault) }.write(p));
        self.send(tick, Kind::CLEAR_FAULT, &payload).line(&format!("tx {tick} 20"))
    }

    fn ping(&mut self, tick: u64) -> &mut Self {
        let payload = written(|p| Ping { t1_us: tick }.write(p));
        self.send(tick, Kind::PING, &payload).line(&format!("tx {tick} 20"))
    }

    /// HELLO, CONFIG and 5 N until the force has come.
    fn press(&mut self) -> &mut Self {
        let payload = written(|p| Grip { ttl_ms: 100, ..press(1, 1000) }.write(p));
        self.send(0, Kind::HELLO, &hello(Versions::OURS, 0));
        self.send(0, Kind::CONFIG, &CONFIG.to_bytes());
        self.send(0, Kind::GRIP, &payload).line("tx 0 20").line("drive 9000")
    }
}

/// Every 100 ms a gripper without a session states who it is, if somebody speaks to it.
fn announcements() -> Life {
    let mut author = Author::new("new 0");
    author
        .ping(0)
        .ping(1)
        .ping(50_000)
        .ping(99_999)
        .ping(100_000)
        .ping(100_001)
        .ping(199_999)
        .ping(200_000);
    let wanted = vec!["frame 81", "frame 81", "frame 81"];
    Life { name: "announcements", script: author.script, wanted }
}

/// CLEAR_FAULT of a fault that is gone is agreed to once more, but not after another fault or stop was latched.
fn cleared_before(name: &'static str, latch: &str) -> Life {
    let mut author = Author::new("new 0");
    author.send(0, Kind::HELLO, &hello(Versions::OURS, 0)).line("tx 0 20").line("fault 1000 0101");
    author.clear(2000, 0x0101).clear(3000, 0x0101).line(latch).clear(5000, 0x0101);
    let wanted =
        vec!["linked beef", "frame 81", "cleared 0101", "frame 8e", "frame 8e", "frame 8f"];
    Life { name, script: author.script, wanted }
}

/// ESTOP with the torque off, if the gripper is made so, or with the force held.
fn stopped(name: &'static str, first: &str, drive: &'static str) -> Life {
    let mut author = Author::new(first);
    author.press().send(10_000, Kind::ESTOP, &[]).line("drive 10000").line("tx 10000 20");
    author.line("drive 20000");
    let mut wanted = vec!["linked beef", "configured", "command 1", "frame 81", "frame 83"];
    wanted.extend(["drive force 1000 state 4", "estop", drive, "frame 8e", drive]);
    Life { name, script: author.script, wanted }
}

/// All of them.
pub fn lives() -> Vec<Life> {
    vec![
        announcements(),
        cleared_before("cleared before another fault", "fault 4000 0102"),
        cleared_before("cleared before a stop", "estop 4000"),
        stopped("stop that holds", "new 0", "drive force 1000 state 8 fault 0001"),
        stopped("stop that releases", "new 0 passive", "drive passive 0 state 8 fault 0001"),
    ]
}

/// Compares what came with what was wanted.
pub fn judge(life: &Life, answers: &[String]) {
    let reported: Vec<String> = answers.iter().filter_map(|line| reported(line)).collect();
    let fits = reported.len() == life.wanted.len()
        && reported.iter().zip(&life.wanted).all(|(reported, wanted)| reported.starts_with(wanted));
    assert!(fits, "{}: {reported:#?} instead of {:#?}", life.name, life.wanted);
}

/// A line in short; `None` for STATUS, EVENT and STATS.
fn reported(line: &str) -> Option<String> {
    let Some(frame) = line.strip_prefix("frame ") else { return Some(line.to_owned()) };
    // 00, COBS code, version and flags, type: none of the types is 0 and the first byte is not either.
    let kind = &frame[6..8];
    (!["91", "92", "93"].contains(&kind)).then(|| format!("frame {kind}"))
}
