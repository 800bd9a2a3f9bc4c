//! Send queue of one client, payloads as whole frames: bounded, and what finds no room is counted.

use grip_link::frame::{self, Header, MAX_WIRE};
use grip_link::message::daemon::DroppedClass;

/// How much a frame is worth keeping; the first are dropped first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Samples.
    Rows,
    /// State of the pipeline, figures.
    States,
    /// Slips, grippers, notices.
    News,
    /// Answers to the client.
    Answers,
}

/// The classes whose losses are reported.
pub(super) const REPORTED: [(Class, DroppedClass); 3] = [
    (Class::Rows, DroppedClass::Rows),
    (Class::States, DroppedClass::States),
    (Class::News, DroppedClass::News),
];

/// Frames that wait for a client.
#[derive(Debug)]
pub(super) struct Outbox {
    bytes: Vec<u8>,
    from: usize,
    limit: usize,
    /// Frames dropped since they were reported, by class.
    dropped: [u32; 4],
}

impl Outbox {
    /// Never holds more than `limit` bytes; at least eight frames fit.
    pub(super) fn new(limit: usize) -> Self {
        Self { bytes: Vec::new(), from: 0, limit: limit.max(8 * MAX_WIRE), dropped: [0; 4] }
    }

    /// Bytes that a class may fill: what matters more always finds room that samples may not take.
    const fn share(&self, class: Class) -> usize {
        match class {
            Class::Rows => self.limit / 2,
            Class::States => self.limit / 8 * 5,
            Class::News => self.limit / 4 * 3,
            Class::Answers => self.limit,
        }
    }

    /// Puts a frame behind the others; `false`, and counted, where it finds no room.
    pub(super) fn push(&mut self, class: Class, header: &Header, payload: &[u8]) -> bool {
        if self.waiting().len() + MAX_WIRE > self.share(class) {
            self.count(class);
            return false;
        }
        if self.bytes.len() + MAX_WIRE > self.limit {
            self.bytes.drain(..self.from);
            self.from = 0;
        }
        let end = self.bytes.len();
        self.bytes.resize(end + MAX_WIRE, 0);
        let room = self.bytes.get_mut(end..).unwrap_or_default();
        let written = frame::encode(header, payload, room);
        self.bytes.truncate(end + written.unwrap_or(0));
        if written.is_err() {
            self.count(class);
        }
        written.is_ok()
    }

    fn count(&mut self, class: Class) {
        let Some(count) = self.dropped.get_mut(class as usize) else { return };
        *count = count.saturating_add(1);
    }

    /// Frames of a class dropped since [`Outbox::reported`].
    pub(super) fn dropped(&self, class: Class) -> u32 {
        self.dropped.get(class as usize).copied().unwrap_or(0)
    }

    /// The client knows of `count` frames of a class.
    pub(super) fn reported(&mut self, class: Class, count: u32) {
        let Some(left) = self.dropped.get_mut(class as usize) else { return };
        *left = left.saturating_sub(count);
    }

    /// Bytes to be written, oldest first.
    pub(super) fn waiting(&self) -> &[u8] {
        self.bytes.get(self.from..).unwrap_or_default()
    }

    /// Whether a client that was too slow has caught up.
    pub(super) fn is_calm(&self) -> bool {
        self.waiting().len() <= self.limit / 4
    }

    /// The first `count` waiting bytes are written.
    pub(super) fn taken(&mut self, count: usize) {
        self.from = self.from.saturating_add(count).min(self.bytes.len());
        if self.from == self.bytes.len() {
            self.bytes.clear();
            self.from = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Class, Outbox};
    use grip_link::decoder::{Decoder, Role, Verdict};
    use grip_link::frame::{Direction, Header, MAX_WIRE};
    use grip_link::message::Kind;

    fn header(seq: u16) -> Header {
        Header::new(Direction::ToHost, Kind::ROWS, seq, 7)
    }

    #[test]
    fn only_whole_frames_stand_in_it_and_the_bound_holds() {
        let mut outbox = Outbox::new(10_000);
        let mut decoder = Decoder::new(Role::Client);
        decoder.open_session(7, None);
        let (mut sent, mut seen) = (0_u16, 0_u32);
        for turn in 0_usize..5_000 {
            sent += u16::from(outbox.push(Class::Rows, &header(sent), &[3; 300]));
            assert!(outbox.waiting().len() <= 5_000 && outbox.bytes.capacity() <= 20_000);
            let part = outbox.waiting();
            let part = part[..part.len().min(turn % 517)].to_vec();
            outbox.taken(part.len());
            let mut input = part.as_slice();
            while let Some(verdict) = decoder.next(&mut input) {
                assert!(matches!(verdict, Verdict::Frame(_)));
                seen += 1;
            }
        }
        assert!(seen > 1_000 && decoder.counters().gap == 0, "{seen}");
        assert_eq!(u32::from(sent) + outbox.dropped(Class::Rows), 5_000);
    }

    #[test]
    fn samples_leave_room_for_what_matters_more() {
        let mut outbox = Outbox::new(40 * MAX_WIRE);
        while outbox.push(Class::Rows, &header(0), &[0; 400]) {}
        assert!(outbox.push(Class::States, &header(0), &[0; 400]));
        while outbox.push(Class::States, &header(0), &[0; 400]) {}
        assert!(outbox.push(Class::News, &header(0), &[0; 400]));
        while outbox.push(Class::News, &header(0), &[0; 400]) {}
        assert!(outbox.push(Class::Answers, &header(0), &[0; 400]));
        let dropped = [Class::Rows, Class::States, Class::News].map(|class| outbox.dropped(class));
        assert_eq!(dropped, [1, 1, 1]);
        outbox.reported(Class::Rows, 1);
        assert_eq!(outbox.dropped(Class::Rows), 0);
    }
}
