//! The gain of a travel reading on distance, speed and load, the same for every hypothesis.

use super::math::ln;
use crate::estimate::G_M_S2;

/// Variances of distance (m^2) and speed (m^2/s^2) when a slip is noticed.
const DISTANCE: f32 = 9e-12;
const SPEED: f32 = 3.6e-5;
/// Growth of the variance of the speed in a second (m^2/s^3), and the least one of the distance in a block (m^2).
const SPEED_S: f32 = 2.4e-3;
const DISTANCE_LEAST: f32 = 1e-14;

/// Covariance of (x, v, u) under `F = [1 d 0; 0 1 g d; 0 0 1]`, since u is the load over the weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gains {
    p: [[f32; 3]; 3],
    /// Share of an innovation that goes to distance (1), speed (1/s) and load (1/m).
    pub(super) k: [f32; 3],
    /// Variance of the innovation (m^2), its reciprocal, and its logarithm (um^2).
    pub(super) s: f32,
    pub(super) per_s: f32,
    pub(super) ln_s: f32,
}

impl Gains {
    /// No gain.
    pub(super) const NONE: Self =
        Self { p: [[0.0; 3]; 3], k: [0.0; 3], s: 0.0, per_s: 0.0, ln_s: 0.0 };

    /// At an alarm, with `load` as the deviation of the load.
    pub(super) fn begin(load: f32) -> Self {
        let p = [[DISTANCE, 0.0, 0.0], [0.0, SPEED, 0.0], [0.0, 0.0, load * load]];
        Self { p, ..Self::NONE }
    }

    /// One block of `d_s` (s) in which the variance of the load grows by `load_s` a second; then a reading of variance `r` (m^2), if there is one.
    pub(super) fn step(&mut self, d_s: f32, load_s: f32, r: Option<f32>) {
        let gd = G_M_S2 * d_s;
        let [p0, p1, p2] = self.p;
        let row0: [f32; 3] = core::array::from_fn(|j| p0[j] + d_s * p1[j]);
        let row1: [f32; 3] = core::array::from_fn(|j| p1[j] + gd * p2[j]);
        let xx = row0[0] + d_s * row0[1] + DISTANCE_LEAST;
        let xv = row0[1] + gd * row0[2];
        let vv = row1[1] + gd * row1[2] + SPEED_S * d_s;
        let mut p =
            [[xx, xv, row0[2]], [xv, vv, row1[2]], [row0[2], row1[2], p2[2] + load_s * d_s]];
        if let Some(r) = r {
            let [first, ..] = p;
            self.s = first[0] + r;
            (self.per_s, self.ln_s) = (1.0 / self.s, ln(self.s * 1e12));
            self.k = first.map(|covariance| covariance * self.per_s);
            for (row, k) in p.iter_mut().zip(self.k) {
                for (place, covariance) in row.iter_mut().zip(first) {
                    *place -= k * covariance;
                }
            }
        }
        self.p = p;
    }
}
