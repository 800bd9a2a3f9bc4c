//! The grip force in, whether it stands out: fingers that close or open change the pattern of an array without a slip.

use crate::units::Micros;

/// A force that stays within this share of itself stands.
const SHARE: f32 = 0.1;

/// Whether the grip force stands.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standing {
    /// The force (N) that the others are held against, and when it was measured.
    from: Option<(f32, Micros)>,
}

impl Standing {
    /// From contact, and from each change of the grip force by more than a tenth, on: how long nothing is told of the pattern.
    pub const WAIT: Micros = Micros(500_000);

    /// Takes the measured normal force (N); whether it has stood for [`Standing::WAIT`]. Without a force sensor it does.
    pub fn step(&mut self, t: Micros, normal_force_n: Option<f32>) -> bool {
        let Some(force_n) = normal_force_n else { return true };
        let (from_n, since) = *self.from.get_or_insert((force_n, t));
        if (force_n - from_n).abs() > SHARE * from_n.abs() {
            self.from = Some((force_n, t));
            return false;
        }
        t.since(since) >= Self::WAIT
    }

    /// Another object: nothing is known.
    pub fn prime(&mut self) {
        self.from = None;
    }
}

#[cfg(test)]
mod tests {
    use super::Standing;
    use crate::units::Micros;

    #[test]
    fn a_force_stands_half_a_second_after_its_last_change() {
        let mut standing = Standing::default();
        let mut stands = |ms: u64, n: f32| standing.step(Micros(1000 * ms), Some(n));
        assert!(!stands(0, 1.0) && !stands(400, 1.08) && stands(500, 0.95));
        assert!(!stands(510, 1.5) && !stands(1000, 1.4) && stands(1010, 1.4));
        assert!(Standing::default().step(Micros(0), None), "nobody measures it");
    }
}
