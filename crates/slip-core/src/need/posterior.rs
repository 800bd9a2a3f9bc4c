//! The power of a block in; the distribution of the needed force after it, and its quantiles, out.

use super::{AHEAD_S, FORCES, FORGET_S, Felt, Need, RAMPS, SLOPE_BLOCKS, STEP, candidate::Surface};

impl Need {
    /// What a block says whose power is `square` with that of the noise, `noise`, and that weighs `w`: the candidates go on under `force_n` (N).
    pub(super) fn believe(&mut self, (square, noise): (f32, f32), w: f32, force_n: f32) {
        let d_s = self.block_s;
        let law = self.law;
        let keep = libm::expf(-d_s / FORGET_S);
        self.power = self.power * keep + w * (square - noise);
        self.weight = self.weight * keep + w;
        let [least, most] = law.slope;
        let prior = SLOPE_BLOCKS * least * most;
        let surface = Surface::after(self.swings.turns);
        let mut best = f32::NEG_INFINITY;
        for (forces, (ramp_s, ramp_ln)) in self.candidates.chunks_exact_mut(FORCES).zip(RAMPS) {
            for candidate in forces {
                candidate.go(force_n, ramp_s, d_s);
                let way_m = candidate.way_m(d_s);
                candidate.squares = candidate.squares * keep + w * way_m * way_m;
                let slope2 = (self.power + 1e-3 * noise).max(0.05 * noise * w) / candidate.squares;
                let variance = way_m * way_m + noise / slope2;
                candidate.logs = candidate.logs * keep + w * libm::logf(variance);
                candidate.misfit = candidate.misfit * keep + w * square / variance;
                let k2 = (candidate.misfit + prior) / (self.weight + SLOPE_BLOCKS);
                let k2 = k2.max(least * least).min(most * most);
                let amplitude =
                    candidate.logs + self.weight * libm::logf(k2) + candidate.misfit / k2;
                candidate.p = ramp_ln - 0.5 * amplitude;
                if law.turns {
                    candidate.p += candidate.turning(&surface);
                }
                best = best.max(candidate.p);
            }
        }
        self.conclude(best);
    }

    /// From the logarithms of the likelihoods, of which `best` is the largest, to probabilities and quantiles.
    fn conclude(&mut self, best: f32) {
        const BINS: usize = 64;
        /// Width of a bin in the logarithm of the needed force over that at the alarm.
        #[expect(clippy::cast_precision_loss, reason = "small numbers")]
        const BIN: f32 = STEP * (FORCES as f32 + 1.0) / BINS as f32;
        let mut bins = [0.0_f32; BINS];
        let mut all = 0.0;
        for candidate in &mut self.candidates {
            candidate.p = libm::expf(candidate.p - best);
            all += candidate.p;
        }
        let mut speed_m_s = 0.0;
        for (forces, (ramp_s, _)) in self.candidates.chunks_exact_mut(FORCES).zip(RAMPS) {
            let mut ln = 0.5 * STEP;
            for candidate in forces {
                candidate.p /= all;
                speed_m_s += candidate.p * candidate.speed_m_s;
                let mut now = ln;
                if ramp_s > 0.0 && candidate.load < 1.0 {
                    now += libm::logf((candidate.load + AHEAD_S / ramp_s).min(1.0));
                }
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "from 0, and beyond the last there is none"
                )]
                let bin = (now / BIN).max(0.0) as usize;
                if let Some(bin) = bins.get_mut(bin.min(BINS - 1)) {
                    *bin += candidate.p;
                }
                ln += STEP;
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
