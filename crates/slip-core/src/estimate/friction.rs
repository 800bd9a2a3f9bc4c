//! Tangential and normal force of a slip in, the force that is adequate out.
//!
//! The tangential force of a finger is `F_t = mu F` while the object slides, and half of the load once it stands, whatever F is. So
//!
//! ```text
//! f = kappa F_t / mu,    mu = the largest F_t / F of this slip
//! ```
//!
//! is kappa times the force there is while the object slides, which is not yet enough, and kappa times what the load needs once it stands. The
//! largest ratio is friction itself where the object slid, and less than that where it never did: then more force follows, never less. A wrong
//! scale of the tangential sensor cancels. [`KAPPA`] is that of the networks.
//!
//! Friction at break-away is above that of sliding (by a fifth at most in the scenes), and a contact may get wet. So the largest ratio fades
//! towards the present one with `FADE_BLOCKS`, while a stylus feels the slip and F_t does not show that the object stands: where it does, F grows and
//! F_t takes no part in it.
//!
//! Forces are means over blocks of a millisecond, taken over four of them: the estimate is 2 ms old.

use super::{ForceEstimate, KAPPA};

/// Blocks that are averaged, and compared, the first with the last.
const BLOCKS: usize = 4;
/// Blocks in which a ratio that is too large fades to 1/e of what it is too large by: where the present one may be that of sliding, and where it is
/// below [`SLIDING`] of it.
const FADE_BLOCKS: [f32; 2] = [10.0, 60.0];
/// Friction of sliding over that at break-away is hardly below this.
const SLIDING: f32 = 0.8;
/// Growth of the normal force over the blocks (relative) from which it says whether the object stands: the tangential force then grows by less than
/// the stated share of that.
const GROWTH: f32 = 0.03;
const STANDS: f32 = 0.35;
/// Deviation of mu (relative): where between static and kinetic friction the largest ratio lies.
const MU_SIGMA: f32 = 0.1;
/// Forces below this (N) say nothing.
const LEAST_N: f32 = 0.05;

/// Means over a block.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    normal_n: f32,
    tangential_n: f32,
}

/// Friction and load of one slip; O(1) state and cost.
#[derive(Clone, Copy, Debug)]
pub struct FrictionMeter {
    per_block: u32,
    sum: Block,
    count: u32,
    /// The last blocks, oldest first.
    blocks: [Block; BLOCKS],
    filled: usize,
    /// Means over the blocks; none where they say nothing.
    mean: Option<Block>,
    /// 0 before there is any.
    mu: f32,
    /// That of the slips before, of the same object.
    known: f32,
}

impl FrictionMeter {
    /// A meter for samples at `rate_hz`.
    #[must_use]
    pub fn new(rate_hz: f32) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; the cast saturates"
        )]
        let per_block = (1e-3 * rate_hz).clamp(1.0, 1e6) as u32;
        Self {
            per_block,
            sum: Block::default(),
            count: 0,
            blocks: [Block::default(); BLOCKS],
            filled: 0,
            mean: None,
            mu: 0.0,
            known: 0.0,
        }
    }

    /// A slip begins with the next sample.
    pub fn begin(&mut self) {
        let (per_block, known) = (self.per_block, if self.mu > 0.0 { self.mu } else { self.known });
        *self = Self { per_block, known, ..Self::new(0.0) };
    }

    /// Another object is taken: nothing is known of its friction.
    pub fn prime(&mut self) {
        self.begin();
        self.known = 0.0;
    }

    /// Takes the forces of the next sample (N, finite) without a slip sensor: the load is followed, the friction stays.
    #[inline]
    pub fn watch(&mut self, normal_n: f32, tangential_n: f32) {
        self.add(normal_n, tangential_n);
        if self.count >= self.per_block {
            self.close_block();
        }
    }

    /// The force that is adequate for the load that was watched, by the friction of the last slips of this object; `None` where no slip has shown it.
    #[must_use]
    pub fn loaded_n(&self) -> Option<f32> {
        let mu = if self.mu > 0.0 { self.mu } else { self.known };
        let force_n = KAPPA * self.mean?.tangential_n / mu;
        (mu > 0.0 && force_n.is_finite()).then_some(force_n)
    }

    /// Takes the forces of the next sample of the slip (N, finite), and whether the slip is felt right now. The sign of the tangential force depends
    /// on how its sensor is mounted.
    #[inline]
    pub fn push(&mut self, normal_n: f32, tangential_n: f32, felt: bool) {
        self.add(normal_n, tangential_n);
        if self.count >= self.per_block {
            self.close_block();
            if let Some(mean) = self.mean {
                self.learn(mean.tangential_n / mean.normal_n, felt);
            }
        }
    }

    #[inline]
    fn add(&mut self, normal_n: f32, tangential_n: f32) {
        self.sum.normal_n += normal_n;
        self.sum.tangential_n += tangential_n;
        self.count += 1;
    }

    fn close_block(&mut self) {
        #[expect(clippy::cast_precision_loss, reason = "at most 1e6")]
        let share = 1.0 / self.count as f32;
        let block = Block {
            normal_n: share * self.sum.normal_n,
            tangential_n: (share * self.sum.tangential_n).abs(),
        };
        (self.sum, self.count) = (Block::default(), 0);
        self.blocks.rotate_left(1);
        self.blocks[BLOCKS - 1] = block;
        self.filled = (self.filled + 1).min(BLOCKS);
        self.mean = self.usable_mean();
    }

    /// Takes the ratio of the last blocks.
    fn learn(&mut self, ratio: f32, felt: bool) {
        if ratio > self.mu {
            self.mu = ratio;
        } else if felt && !self.stands() {
            let [near, far] = FADE_BLOCKS;
            let blocks = if ratio > SLIDING * self.mu { near } else { far };
            self.mu += (ratio - self.mu) / blocks;
        }
    }

    /// Not of a sensor that shows the same for all of them: nothing that is alive does.
    fn usable_mean(&self) -> Option<Block> {
        let sum = |part: fn(&Block) -> f32| self.blocks.iter().map(part).sum::<f32>();
        let mean = Block {
            normal_n: 0.25 * sum(|block| block.normal_n),
            tangential_n: 0.25 * sum(|block| block.tangential_n),
        };
        let enough = mean.normal_n >= LEAST_N && mean.tangential_n >= LEAST_N;
        let [first, others @ ..] = self.blocks;
        let alive = others.iter().any(|block| block.tangential_n != first.tangential_n);
        (self.filled == BLOCKS && enough && alive).then_some(mean)
    }

    /// Whether the normal force has just grown alone.
    fn stands(&self) -> bool {
        let [first, .., last] = self.blocks;
        let grown = last.normal_n - first.normal_n;
        let followed = last.tangential_n - first.tangential_n;
        grown > GROWTH * first.normal_n
            && followed * first.normal_n < STANDS * grown * first.tangential_n
    }

    /// What is known of the friction of this slip; `None` before there is anything.
    #[must_use]
    pub fn friction(&self) -> Option<f32> {
        (self.mu > 0.0).then_some(self.mu)
    }

    /// The adequate force for the load so far; `None` before the forces say anything.
    #[must_use]
    pub fn estimate(&self) -> Option<ForceEstimate> {
        let force_n = KAPPA * self.mean?.tangential_n / self.friction()?;
        let sigma_n = MU_SIGMA * force_n;
        force_n.is_finite().then_some(ForceEstimate { force_n, sigma_n, extrapolated: false })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{FrictionMeter, KAPPA};
    use crate::estimate::ForceEstimate;
    use std::vec::Vec;

    /// A slip of 0.1 s at 10 kHz under a force that grows by e each 20 ms from 2 N to 8 N.
    #[derive(Clone, Copy)]
    struct Slip {
        /// Friction of sliding and its excess at break-away, which fades in 2 ms.
        mu: f32,
        excess: f32,
        /// Half of the load (N); the object slides until the force is 1.2 times what that needs.
        load_n: f32,
        scale: f32,
        felt: bool,
    }

    impl Slip {
        const HELD: Self = Self { mu: 0.3, excess: 0.2, load_n: 1.5, scale: 1.0, felt: true };

        fn needed_n(self) -> f32 {
            self.load_n / self.mu
        }

        /// The estimates of each millisecond, with the force there is and whether the object slides.
        fn run(self) -> Vec<(Option<ForceEstimate>, f32, bool)> {
            let mut meter = FrictionMeter::new(10_000.0);
            meter.begin();
            let mut noise = 1_u32;
            let mut draw = || {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                0.017 * (f32::from(u16::try_from(noise >> 16).unwrap()) / 65_536.0 - 0.5)
            };
            let mut out = Vec::new();
            for i in 0..1000_u16 {
                let t_s = 1e-4 * f32::from(i);
                let normal_n = (2.0 * libm::expf(t_s / 0.02)).min(8.0);
                let slides = normal_n < 1.2 * self.needed_n();
                let mu = self.mu * (1.0 + self.excess * libm::expf(-t_s / 2e-3));
                let shown_n = if slides { mu * normal_n } else { self.load_n };
                let felt = self.felt && slides;
                meter.push(normal_n + draw(), self.scale * (shown_n + draw()), felt);
                if i % 10 == 9 {
                    out.push((meter.estimate(), normal_n, slides));
                }
            }
            out
        }
    }

    #[test]
    fn the_adequate_force_follows_from_the_load_at_rest_whatever_the_scale() {
        for scale in [1.0, 0.8, -1.2] {
            let slip = Slip { scale, ..Slip::HELD };
            let estimate = slip.run().last().unwrap().0.unwrap();
            let ratio = estimate.force_n / (KAPPA * slip.needed_n());
            assert!((0.9..1.05).contains(&ratio), "{ratio} at scale {scale}");
            assert!(estimate.is_trusted() && !estimate.extrapolated, "{estimate:?}");
        }
    }

    /// So the force goes on growing until the object stands.
    #[test]
    fn an_object_that_slides_needs_more_than_the_force_there_is() {
        let steps = Slip::HELD.run();
        let mean_n = |last: &[(Option<ForceEstimate>, f32, bool)]| {
            last.iter().map(|step| step.1).sum::<f32>() / 4.0
        };
        let ratio = |last: &[(Option<ForceEstimate>, f32, bool)]| {
            last[3].2.then(|| last[3].0.unwrap().force_n / mean_n(last))
        };
        let ratios: Vec<f32> = steps.windows(4).filter_map(ratio).collect();
        assert!(ratios.len() > 15, "{ratios:?}");
        assert!(ratios.iter().all(|ratio| (1.0..1.25).contains(ratio)), "{ratios:?}");
        assert!(ratios.last().is_some_and(|ratio| *ratio > 1.15), "{ratios:?}");
    }

    /// Much less friction than at break-away, as on a wet contact: the ratio of before fades.
    #[test]
    fn friction_that_has_fallen_is_believed_after_a_while() {
        let wet = Slip { excess: 0.8, load_n: 1e3, ..Slip::HELD };
        let (estimate, normal_n, _) = *wet.run().last().unwrap();
        assert!(estimate.unwrap().force_n > 1.1 * normal_n, "{estimate:?} at {normal_n} N");
        let unfelt = Slip { felt: false, ..wet };
        let (estimate, normal_n, _) = *unfelt.run().last().unwrap();
        assert!(estimate.unwrap().force_n < 0.9 * normal_n, "nothing slips: {estimate:?}");
    }

    #[test]
    fn forces_that_say_nothing_give_no_estimate() {
        for slip in [Slip { scale: 0.0, ..Slip::HELD }, Slip { scale: 0.01, ..Slip::HELD }] {
            assert!(slip.run().iter().all(|(estimate, ..)| estimate.is_none()));
        }
        let after = |samples: u16, stuck: bool| {
            let mut meter = FrictionMeter::new(10_000.0);
            for i in 0..samples {
                let noise_n = if stuck { 0.0 } else { 1e-3 * f32::from(i % 7) };
                meter.push(2.0 + 0.1 * f32::from(i), 0.6 + noise_n, true);
            }
            (meter.estimate(), meter.friction())
        };
        assert_eq!(after(39, false), (None, None), "four blocks are needed");
        assert!(after(40, false).0.is_some());
        assert_eq!(after(400, true), (None, None), "a sensor that is stuck");
    }
}
