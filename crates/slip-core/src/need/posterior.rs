//! The power of a block in; the distribution of the needed force after it, and its quantiles, out.

use super::{
    AHEAD_S, FORCES, FORGET_S, Felt, Need, RAMPS, SLOPE_BLOCKS, STEP,
    candidate::{Block, Surface, at_least},
    logarithm::{exp, ln},
};

/// The logarithm of a likelihood over the best one from which on it adds nothing to the sums, not even in their last bit; the exponential
/// of less is slow where it is no normal number.
const NEGLIGIBLE: f32 = -80.0;

impl Need {
    /// What a block says whose power is `square` with that of the noise, `noise`, and that weighs `w`: the candidates go on under `force_n` (N).
    pub(super) fn believe(&mut self, (square, noise): (f32, f32), w: f32, force_n: f32) {
        let d_s = self.block_s;
        let keep = libm::expf(-d_s / FORGET_S);
        self.power = self.power * keep + w * (square - noise);
        self.weight = self.weight * keep + w;
        let [least, most] = self.law.slope;
        let block = Block {
            keep,
            w,
            square,
            noise: noise / self.signal(noise, w),
            weight: self.weight,
            believed: SLOPE_BLOCKS,
            prior: SLOPE_BLOCKS * least * most,
            least2: least * least,
            most2: most * most,
        };
        let surface = Surface::after(self.swings.turns);
        let extreme_s = self.extreme_s.take();
        let mut best = f32::NEG_INFINITY;
        for (row, (ramp_s, ramp_ln)) in self.rows.iter_mut().zip(RAMPS) {
            if let Some(extreme_s) = extreme_s {
                row.extreme(extreme_s);
            }
            row.go(force_n, ramp_s, d_s);
            row.weigh(&block);
            if self.law.turns {
                row.weigh_turns(&surface);
            }
            for p in &mut row.p {
                *p += ramp_ln;
                best = at_least(best, *p);
            }
        }
        self.conclude(best);
    }

    /// Weighted squares of the readings without noise, of which some are left where the noise is `noise` and the last block weighs `w`.
    pub(super) fn signal(&self, noise: f32, w: f32) -> f32 {
        (self.power + 1e-3 * noise).max(0.05 * noise * w)
    }

    /// From the logarithms of the likelihoods, of which `best` is the largest, to probabilities and quantiles.
    fn conclude(&mut self, best: f32) {
        const BINS: usize = 64;
        /// Width of a bin in the logarithm of the needed force over that at the alarm.
        #[expect(clippy::cast_precision_loss, reason = "small numbers")]
        const BIN: f32 = STEP * (FORCES as f32 + 1.0) / BINS as f32;
        let mut bins = [0.0_f32; BINS];
        let mut all = 0.0;
        for row in &mut self.rows {
            for p in &mut row.p {
                let ln = *p - best;
                *p = if ln < NEGLIGIBLE { 0.0 } else { exp(ln) };
            }
            all += row.p.iter().sum::<f32>();
        }
        let mut speed_m_s = 0.0;
        for (row, (ramp_s, _)) in self.rows.iter_mut().zip(RAMPS) {
            let mut need_ln = -0.5 * STEP;
            for ((p, speed), load) in row.p.iter_mut().zip(&row.speed_m_s).zip(&row.load) {
                need_ln += STEP;
                if *p <= 0.0 {
                    continue;
                }
                *p /= all;
                speed_m_s += *p * speed;
                let mut now = need_ln;
                if ramp_s > 0.0 && *load < 1.0 {
                    now += ln((load + AHEAD_S / ramp_s).min(1.0));
                }
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "from 0, and beyond the last there is none"
                )]
                let bin = (now / BIN).max(0.0) as usize;
                if let Some(bin) = bins.get_mut(bin.min(BINS - 1)) {
                    *bin += *p;
                }
            }
        }
        self.speed_m_s = speed_m_s;
        let from_n = self.felt.from_n;
        let quantile = |share: f32| {
            let (mut sum, mut ln) = (0.0, 0.0);
            for p in bins {
                if sum + p >= share {
                    ln += BIN * (share - sum) / p;
                    break;
                }
                sum += p;
                ln += BIN;
            }
            from_n * libm::expf(ln)
        };
        self.felt = Felt { low_n: quantile(0.1), median_n: quantile(0.5), ..self.felt };
    }
}
