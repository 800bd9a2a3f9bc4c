//! Irregularities of a surface along a path on it, and what they show.

use crate::stylus::StylusConfig;
use crate::surface::Surface;
use core::f64::consts::{FRAC_PI_2, PI};

/// What Eq. 1 can mean beside its letter, from the same irregularities, force F and speed v as
/// [`Row::esc_literal_w`](super::Row::esc_literal_w), in plain f64. `slip_core::esc::Reading` explains them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// n F v tan(sum arccot(delta_i / s_i)) (W).
    pub arc_cot_w: f64,
    /// F v sum 2 delta_i / s_i (W).
    pub slope_power_w: f64,
    /// F sum delta_i (J).
    pub lift_work_j: f64,
    /// (pi^2 / 2) c v sum delta_i^2 / s_i (J) with the damper c of the default stylus.
    pub viscous_work_j: f64,
}

/// The irregularities whose peak the stylus passed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Passed {
    pub(super) count: u32,
    /// Sum of delta_i / s_i.
    pub(super) slope_sum: f64,
    cot_sum: f64,
    arccot_sum: f64,
    height_sum_m: f64,
    /// Sum of delta_i^2 / s_i (m).
    steep_sum_m: f64,
}

impl Passed {
    pub(super) fn between(surface: &Surface, start_m: f64, end_m: f64) -> Self {
        let mut passed = Self::default();
        let mut begin = 0.0;
        for asperity in (0..).map(|index| surface.asperity(index)) {
            let peak = begin + 0.5 * asperity.spacing_m;
            begin += asperity.spacing_m;
            if peak > end_m {
                return passed;
            }
            if peak >= start_m {
                passed.add(asperity.delta_m, asperity.spacing_m);
            }
        }
        passed
    }

    fn add(&mut self, delta_m: f64, spacing_m: f64) {
        let slope = delta_m / spacing_m;
        self.count += 1;
        self.slope_sum += slope;
        self.cot_sum += 1.0 / slope.tan();
        self.arccot_sum += FRAC_PI_2 - slope.atan();
        self.height_sum_m += delta_m;
        self.steep_sum_m += slope * delta_m;
    }

    /// n F v tan(sum cot(delta_i / s_i)) (W).
    pub(super) fn literal_w(&self, force_n: f64, speed_m_s: f64) -> f64 {
        f64::from(self.count) * force_n * speed_m_s * self.cot_sum.tan()
    }

    pub(super) fn readings(&self, force_n: f64, speed_m_s: f64) -> Readings {
        let stylus = StylusConfig::default();
        let damper = 2.0 * stylus.damping_ratio * (stylus.stiffness_n_m * stylus.mass_kg).sqrt();
        Readings {
            arc_cot_w: f64::from(self.count) * force_n * speed_m_s * self.arccot_sum.tan(),
            slope_power_w: force_n * speed_m_s * 2.0 * self.slope_sum,
            lift_work_j: force_n * self.height_sum_m,
            viscous_work_j: 0.5 * PI * PI * damper * speed_m_s * self.steep_sum_m,
        }
    }
}
