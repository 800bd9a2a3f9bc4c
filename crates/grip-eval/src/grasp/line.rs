//! Model of the line between gripper and host: frames in order, later than they were sent, and some of them not at all.

use super::laboratory::micros;
use crate::dice::Dice;
use slip_core::units::Micros;
use std::collections::VecDeque;

/// A line between gripper and host.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// What every frame takes, in either direction.
    pub latency: Micros,
    /// What a frame takes on top, uniform from 0 to this; frames stay in order.
    pub jitter: Micros,
    /// Frames of the gripper are handed over only at multiples of this time; 0: at once.
    pub batch: Micros,
    /// Share of the gripper's frames that are lost, 0 to 1.
    pub loss: f64,
    /// Which ones.
    pub seed: u64,
}

/// One direction of it.
#[derive(Clone, Debug)]
pub(super) struct Wire {
    latency: Micros,
    jitter: Micros,
    batch: Micros,
    loss: f64,
    dice: Dice,
    under_way: VecDeque<(Micros, Vec<u8>)>,
    /// Nothing arrives before.
    held_until: Micros,
}

impl Wire {
    pub(super) fn from_gripper(line: Line) -> Self {
        Self {
            latency: line.latency,
            jitter: line.jitter,
            batch: line.batch,
            loss: line.loss,
            dice: Dice(line.seed),
            under_way: VecDeque::new(),
            held_until: Micros(0),
        }
    }

    pub(super) fn to_gripper(line: Line) -> Self {
        Self::from_gripper(Line { loss: 0.0, batch: Micros(0), seed: !line.seed, ..line })
    }

    /// Sends a frame.
    pub(super) fn send(&mut self, now: Micros, frame: &[u8]) {
        if !(self.loss > 0.0 && self.dice.share() < self.loss) {
            let mut at = now.plus(self.latency);
            if self.jitter.0 > 0 {
                at = at.plus(micros(self.dice.between([0.0, self.jitter.as_seconds()])));
            }
            if self.batch.0 > 0 {
                at = Micros(at.0.next_multiple_of(self.batch.0));
            }
            let last = self.under_way.back().map_or(at, |(last, _)| *last);
            self.under_way.push_back((at.max(last), frame.to_vec()));
        }
    }

    /// The next frame that has arrived.
    pub(super) fn receive(&mut self, now: Micros) -> Option<Vec<u8>> {
        let held_until = self.held_until;
        let arrived = |(at, _): &mut (Micros, Vec<u8>)| (*at).max(held_until) <= now;
        self.under_way.pop_front_if(arrived).map(|(_, frame)| frame)
    }

    /// When the next frame arrives.
    pub(super) fn next(&self) -> Option<Micros> {
        self.under_way.front().map(|(at, _)| (*at).max(self.held_until))
    }

    /// Delivers nothing before `until`, and then all that was sent.
    pub(super) fn hold_until(&mut self, until: Micros) {
        self.held_until = until;
    }
}

#[cfg(test)]
mod tests {
    use super::{Line, Wire};
    use slip_core::units::Micros;

    #[test]
    fn a_line_that_stalls_loses_nothing() {
        let mut wire = Wire::from_gripper(Line { latency: Micros(500), ..Line::default() });
        wire.hold_until(Micros(10_000));
        (0..20_000).step_by(100).for_each(|i| wire.send(Micros(i), &i.to_le_bytes()));
        assert!(wire.receive(Micros(9_999)).is_none());
        assert_eq!(wire.next(), Some(Micros(10_000)));
        let came = |wire: &mut Wire, at| {
            let frames = core::iter::from_fn(|| wire.receive(Micros(at)));
            frames.map(|frame| u64::from_le_bytes(frame.try_into().unwrap())).collect::<Vec<_>>()
        };
        assert_eq!(came(&mut wire, 10_000), (0..=9_500).step_by(100).collect::<Vec<_>>());
        assert_eq!(came(&mut wire, 10_100), [9_600]);
    }

    /// Sends the number of each of 2000 frames, one each 0.1 ms; what came, and when (us).
    fn delivered(line: Line) -> Vec<(u64, u64)> {
        let mut wire = Wire::from_gripper(line);
        let mut came = Vec::new();
        for now in (0..300_000).step_by(100) {
            if now < 200_000 {
                wire.send(Micros(now), &now.to_le_bytes());
            }
            while let Some(frame) = wire.receive(Micros(now)) {
                came.push((u64::from_le_bytes(frame.try_into().unwrap()), now));
            }
        }
        came
    }

    #[test]
    fn a_line_with_batches_hands_over_at_multiples_of_their_length() {
        let came = delivered(Line { batch: Micros(16_000), ..Line::default() });
        assert_eq!(came.len(), 2000);
        for (sent, at) in came {
            assert_eq!(at, sent.div_ceil(16_000) * 16_000);
        }
    }

    #[test]
    fn a_line_with_jitter_keeps_the_order_and_the_bound() {
        let came = delivered(Line { jitter: Micros(20_000), seed: 3, ..Line::default() });
        assert_eq!(came.len(), 2000);
        assert!(came.is_sorted());
        let late: Vec<u64> = came.iter().map(|(sent, at)| at - sent).collect();
        assert!(late.iter().all(|late| *late <= 20_100));
        assert!(late.iter().any(|late| *late > 19_000), "{:?}", late.iter().max());
    }

    #[test]
    fn frames_come_in_order_after_the_latency_and_the_share_is_lost() {
        let line = Line { latency: Micros(500), loss: 0.05, seed: 7, ..Line::default() };
        let mut wire = Wire::from_gripper(line);
        let mut whole = Wire::to_gripper(line);
        let mut came = 0;
        for i in 0..10_000_u64 {
            wire.send(Micros(i), &i.to_le_bytes());
            whole.send(Micros(i), &[1]);
            assert!(wire.next().is_none_or(|at| at.0 + 500 >= i));
            while let Some(frame) = wire.receive(Micros(i)) {
                let sent = u64::from_le_bytes(frame.try_into().unwrap());
                assert_eq!(sent + 500, i);
                came += 1;
            }
        }
        assert!((8900..9200).contains(&came), "{came} of 9500");
        assert_eq!(whole.under_way.len(), 10_000);
    }
}
