//! Band signals at rest in, the noise energy of each band out.
//!
//! The floor is learned once, from the first stretch of rest, and then kept: a floor that followed the
//! signal would learn the slip it should report. The stretch is cut into blocks and the median block
//! is taken, so that one knock during learning does not raise the floor.

/// Blocks whose median is the floor.
const BLOCKS: usize = 16;

/// How the noise floor is found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct FloorConfig {
    /// Length of the stretch of rest the floor is learned from (ms), 10 to 10,000.
    pub learn_ms: f32,
    /// Smallest noise that is believed (signal unit, rms): the resolution of the sensor.
    pub min_rms: f32,
}

impl Default for FloorConfig {
    fn default() -> Self {
        Self { learn_ms: 200.0, min_rms: 2e-9 }
    }
}

/// The noise energy of `N` bands, or the measurement of it.
#[derive(Clone, Copy, Debug)]
pub struct Floor<const N: usize> {
    min_energy: f32,
    block_len: u32,
    state: State<N>,
}

#[derive(Clone, Copy, Debug)]
enum State<const N: usize> {
    Learning { sum: [f32; N], in_block: u32, blocks: [[f32; BLOCKS]; N], done: usize },
    Ready([f32; N]),
}

impl<const N: usize> Floor<N> {
    /// A floor to be learned from samples at `rate_hz`.
    #[must_use]
    pub fn learn(config: FloorConfig, rate_hz: f32) -> Self {
        let samples = config.learn_ms * 1e-3 * rate_hz / 16.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; the cast saturates"
        )]
        let block_len = samples.clamp(1.0, 1e6) as u32;
        let state =
            State::Learning { sum: [0.0; N], in_block: 0, blocks: [[0.0; BLOCKS]; N], done: 0 };
        Self { min_energy: config.min_rms * config.min_rms, block_len, state }
    }

    /// A floor that is known already: energies in signal units squared.
    #[must_use]
    pub fn known(config: FloorConfig, energy: [f32; N]) -> Self {
        let min_energy = config.min_rms * config.min_rms;
        Self { min_energy, block_len: 1, state: State::Ready(energy.map(|e| e.max(min_energy))) }
    }

    /// The floor, once it is known: energy of each band (signal unit squared).
    #[must_use]
    #[inline]
    pub fn energy(&self) -> Option<[f32; N]> {
        match self.state {
            State::Ready(energy) => Some(energy),
            State::Learning { .. } => None,
        }
    }

    /// Takes the band values of a sample at rest. Does nothing once the floor is known.
    pub fn push(&mut self, y: &[f32; N]) {
        let State::Learning { sum, in_block, blocks, done } = &mut self.state else { return };
        for (sum, y) in sum.iter_mut().zip(y) {
            *sum += y * y;
        }
        *in_block += 1;
        if *in_block < self.block_len {
            return;
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 1e6")]
        let per_sample = 1.0 / self.block_len as f32;
        for (block, sum) in blocks.iter_mut().zip(sum.iter_mut()) {
            if let Some(slot) = block.get_mut(*done) {
                *slot = *sum * per_sample;
            }
            *sum = 0.0;
        }
        *in_block = 0;
        *done += 1;
        if *done == BLOCKS {
            let energy = blocks.map(|block| median(block).max(self.min_energy));
            self.state = State::Ready(energy);
        }
    }
}

fn median(mut block: [f32; BLOCKS]) -> f32 {
    block.sort_unstable_by(f32::total_cmp);
    0.5 * (block[BLOCKS / 2 - 1] + block[BLOCKS / 2])
}

#[cfg(test)]
mod tests {
    use super::{Floor, FloorConfig};

    #[test]
    fn a_knock_does_not_raise_the_floor() {
        let config = FloorConfig { learn_ms: 160.0, min_rms: 1e-9 };
        let mut floor = Floor::<1>::learn(config, 1000.0);
        for i in 0..160_u16 {
            assert_eq!(floor.energy(), None);
            let knock = if (40..60).contains(&i) { 1e3 } else { 1.0 };
            floor.push(&[if i % 2 == 0 { knock } else { -knock }]);
        }
        let [energy] = floor.energy().unwrap();
        assert!((energy - 1.0).abs() < 1e-6, "{energy}");
        floor.push(&[1e6]);
        assert_eq!(floor.energy(), Some([energy]), "a known floor stays");
    }

    #[test]
    fn silence_has_the_sensor_resolution_as_floor() {
        let mut floor = Floor::<2>::learn(FloorConfig { learn_ms: 10.0, min_rms: 0.5 }, 2200.0);
        for _ in 0..1000 {
            floor.push(&[0.0, 0.0]);
        }
        assert_eq!(floor.energy(), Some([0.25, 0.25]));
    }
}
