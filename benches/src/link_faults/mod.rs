//! A count of frames in; what nine kinds of line faults do to the link, in numbers, out.
//!
//! Streams of real frames go through one fault each. Which frames came through whole is known from the place of the fault
//! ([`grip_sim::line_fault::Faulty::place_of`]) and what they must read from the list of frames sent: the
//! decoder under test has no state in either. The promises are:
//! - *undetected* = 0: a frame handed out is one that was sent, word for word, and handed out once, in order;
//! - *clean frames lost* = 0: a frame none of whose wire bytes (delimiters included) was hit is handed out;
//! - *delay* = 0: and with its own last byte, wherever the fault has moved it.

mod traffic;

pub use traffic::{Sent, Stream, Traffic};

use anyhow::Result;
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::Direction;
use grip_sim::line_fault::{Faulty, LineFault};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// Frames of a stream.
pub const FRAMES: usize = 7;
/// Faults put into a stream, one at a time, before another is made.
const FAULTS_A_STREAM: u64 = 4;
/// Longest piece that a port delivers at once (bytes).
const LONGEST_READ: usize = 200;

/// What became of all frames of one kind of fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Faults injected: one a stream.
    pub faults: u64,
    /// Frames sent.
    pub frames: u64,
    /// Frames that a fault hit, or fell into.
    pub damaged: u64,
    /// Blocks that were good frames but came again or out of order, and were refused for it.
    pub repeats: u64,
    /// Frames handed out that were not sent like this, or were handed out before.
    pub undetected: u64,
    /// Frames that were not hit and not handed out.
    pub clean_lost: u64,
    /// Most bytes that a clean frame needed beyond its own last one.
    pub delay_bytes: usize,
}

impl Tally {
    /// Whether every promise was kept.
    #[must_use]
    pub const fn kept(&self) -> bool {
        self.undetected == 0 && self.clean_lost == 0 && self.delay_bytes == 0
    }
}

/// Sends at least `frames` frames through faults of one kind. The same seed gives the same numbers.
///
/// # Errors
/// Never: every frame fits.
pub fn run(fault: LineFault, frames: u64, seed: u64) -> Result<Tally> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut traffic = Traffic::new(rng.next_u64());
    let mut tally = Tally::default();
    while tally.frames < frames {
        let direction =
            if rng.next_u64() % 4 == 0 { Direction::ToDevice } else { Direction::ToHost };
        let stream = traffic.stream(direction, FRAMES)?;
        for _ in 0..FAULTS_A_STREAM {
            let faulty = fault.inject(&stream.bytes, &mut rng);
            tally.judge(&stream, &faulty, &receive(&stream, &faulty, &mut rng));
        }
    }
    Ok(tally)
}

/// What a decoder made of a stream.
#[derive(Debug, Default)]
struct Received {
    /// Frames in the order in which they were handed out: which one it is, and the position behind the byte that
    /// completed it. `None` where no such frame was sent.
    frames: Vec<(Option<usize>, usize)>,
    repeats: u64,
}

/// Feeds the bytes in pieces of random length, as a port does.
fn receive(stream: &Stream, faulty: &Faulty, rng: &mut impl Rng) -> Received {
    let role = if stream.direction == Direction::ToHost { Role::Host } else { Role::Device };
    let mut decoder = Decoder::new(role);
    decoder.open_session(stream.session, Some(stream.first_seq.wrapping_sub(1)));
    let mut received = Received::default();
    let mut rest = faulty.bytes.as_slice();
    while !rest.is_empty() {
        let len = usize::try_from(rng.next_u64()).unwrap_or(0) % LONGEST_READ + 1;
        let (piece, after) = rest.split_at(len.min(rest.len()));
        let mut input = piece;
        while let Some(verdict) = decoder.next(&mut input) {
            if let Verdict::Frame(frame) = verdict {
                let completed = faulty.bytes.len() - after.len() - input.len();
                received.frames.push((stream.find(&frame), completed));
            }
        }
        rest = after;
    }
    received.repeats = u64::from(decoder.counters().duplicate);
    received
}

impl Tally {
    fn judge(&mut self, stream: &Stream, faulty: &Faulty, received: &Received) {
        self.faults += 1;
        self.repeats += received.repeats;
        let mut next = 0;
        for (frame, _) in &received.frames {
            match *frame {
                Some(index) if index >= next => next = index + 1,
                _ => self.undetected += 1,
            }
        }
        for (index, sent) in stream.frames.iter().enumerate() {
            self.frames += 1;
            let Some(place) = faulty.place_of(&sent.span) else {
                self.damaged += 1;
                continue;
            };
            let found = received.frames.iter().find(|(frame, _)| *frame == Some(index));
            match found {
                Some((_, completed)) => {
                    self.delay_bytes = self.delay_bytes.max(completed.saturating_sub(place.end));
                }
                None => self.clean_lost += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The judge itself: a decoder that invents, repeats, swaps, loses or delays frames is found out.
    #[test]
    fn broken_promises_are_seen() {
        let stream = Traffic::new(1).stream(Direction::ToHost, 3).unwrap();
        let clean = Faulty { bytes: stream.bytes.clone(), touched: 0..0, put: 0 };
        let ends: Vec<usize> = stream.frames.iter().map(|sent| sent.span.end).collect();
        let judged = |frames: &[(Option<usize>, usize)]| {
            let mut tally = Tally::default();
            let received = Received { frames: frames.to_vec(), ..Received::default() };
            tally.judge(&stream, &clean, &received);
            (tally.undetected, tally.clean_lost, tally.delay_bytes)
        };
        let all = [(Some(0), ends[0]), (Some(1), ends[1]), (Some(2), ends[2])];
        assert_eq!(judged(&all), (0, 0, 0));
        assert_eq!(judged(&all[1..]), (0, 1, 0), "lost");
        assert_eq!(judged(&[all[0], (None, 9), all[1], all[2]]), (1, 0, 0), "invented");
        assert_eq!(judged(&[all[0], all[0], all[1], all[2]]), (1, 0, 0), "repeated");
        assert_eq!(judged(&[all[1], all[0], all[2]]), (1, 0, 0), "swapped");
        assert_eq!(judged(&[all[0], all[1], (Some(2), ends[2] + 5)]), (0, 0, 5), "late");
    }

    #[test]
    fn a_hit_frame_is_not_missed() {
        let stream = Traffic::new(2).stream(Direction::ToHost, 3).unwrap();
        let hit = stream.frames[1].span.start + 2;
        let faulty = Faulty { bytes: Vec::new(), touched: hit..hit + 1, put: 0 };
        let mut tally = Tally::default();
        tally.judge(&stream, &faulty, &Received::default());
        assert_eq!((tally.damaged, tally.clean_lost), (1, 2));
    }
}
