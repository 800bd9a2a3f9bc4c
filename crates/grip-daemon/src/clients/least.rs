//! Least forces that clients ask for, each with its client: the one that stands, and its turn to be passed on.
//!
//! The largest stands. One ends when its client takes it back, and never by the end of a connection: a program that crashes lets
//! nothing fall. What such a client has left stands until a client that has asked for nothing before asks, any asks for 0, or the object
//! is let go.

/// Least time from one to the next (us): the newest one waits for it, and replaces what has waited before.
const EVERY_US: u64 = 10_000;

/// The least forces (N) of all clients.
#[derive(Debug, Default)]
pub(super) struct Least {
    here: Vec<(u64, f32)>,
    left_n: f32,
    waits: bool,
    next_us: u64,
}

impl Least {
    /// A client asks for so much; 0 takes its own back.
    pub(super) fn ask(&mut self, client: u64, force_n: f32) {
        let known = self.here.iter_mut().find(|(id, _)| *id == client);
        if known.is_none() || force_n == 0.0 {
            self.left_n = 0.0;
        }
        match known {
            Some((_, least_n)) => *least_n = force_n,
            None => self.here.push((client, force_n)),
        }
        self.waits = true;
    }

    /// A client has gone, and what it asked for stands.
    pub(super) fn leave(&mut self, client: u64) {
        let gone = self.here.extract_if(.., |(id, _)| *id == client);
        self.left_n = gone.fold(self.left_n, |most, (_, least_n)| most.max(least_n));
    }

    /// The object is let go: what clients have left ends.
    pub(super) fn let_go(&mut self) {
        self.waits |= self.left_n > 0.0;
        self.left_n = 0.0;
    }

    /// The least force from now on, where somebody has asked since the last time and its turn has come.
    pub(super) fn due(&mut self, now_us: u64) -> Option<f32> {
        if !self.waits || now_us < self.next_us {
            return None;
        }
        (self.waits, self.next_us) = (false, now_us.saturating_add(EVERY_US));
        Some(self.here.iter().fold(self.left_n, |most, (_, least_n)| most.max(*least_n)))
    }
}

#[cfg(test)]
mod tests {
    use super::{EVERY_US, Least};

    #[test]
    fn the_largest_stands_and_only_its_own_client_takes_it_back() {
        let (mut least, mut now_us) = (Least::default(), 0);
        let mut ask = |least: &mut Least, client, force_n| {
            least.ask(client, force_n);
            now_us += EVERY_US;
            least.due(now_us).unwrap()
        };
        assert_eq!(ask(&mut least, 1, 45.0), 45.0);
        assert_eq!(ask(&mut least, 2, 0.0), 45.0);
        assert_eq!(ask(&mut least, 2, 5.0), 45.0);
        least.leave(1);
        assert_eq!(ask(&mut least, 2, 6.0), 45.0, "a crash lets nothing fall");
        least.leave(2);
        assert_eq!(ask(&mut least, 3, 10.0), 10.0, "a newcomer decides anew");
        least.leave(3);
        assert_eq!(ask(&mut least, 4, 0.0), 0.0);
    }

    #[test]
    fn the_newest_of_a_flood_comes_in_its_turn() {
        let mut least = Least::default();
        let came: Vec<f32> = (0..100_u16)
            .filter_map(|n| {
                least.ask(1, n.into());
                least.due(u64::from(n) * 1_000)
            })
            .collect();
        assert_eq!(came, [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0]);
        assert_eq!(
            (least.due(99_000), least.due(100_000), least.due(200_000)),
            (None, Some(99.0), None)
        );
    }

    #[test]
    fn what_was_left_ends_with_the_object() {
        let mut least = Least::default();
        least.ask(1, 30.0);
        assert_eq!(least.due(0), Some(30.0));
        least.let_go();
        assert_eq!(least.due(EVERY_US), None, "its client is here");
        least.leave(1);
        least.let_go();
        assert_eq!(least.due(EVERY_US), Some(0.0));
    }
}
