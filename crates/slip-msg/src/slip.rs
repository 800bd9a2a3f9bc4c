//! What is known of a slip when it is noticed, becomes gross, is certified, or ends.

use crate::{
    EXTRAPOLATED, INFORMATIVE, Method, Phase, Reading, SpeedSource, message, units::Micros,
};

message! {
    /// What is known of a slip; SLIP (A1), daemon to client.
    SlipReport {
        0 number: u32, "1..", "+1 for every report since the daemon's start; 0 before the daemon has numbered it.";
        4 t: Micros, "us", "Device time.";
        12 host: Micros, "us", "Host time since the daemon's start.";
        20 phase: Phase, "", "How far it has come.";
        21 method: Method, "", "Which method noticed it.";
        22 speed_source: SpeedSource, "", "Where the speed comes from.";
        23 esc_kind: Reading, "", "Which reading `esc` is.";
        24 statistic: Option<f32>, "", "Slip statistic over its threshold.";
        28 confidence: Option<f32>, "0..1", "Probability that noise alone would not reach the statistic within the stated false-alarm interval.";
        32 speed_m_s: Option<f32>, "m/s", "Slip speed.";
        36 speed_sigma_m_s: Option<f32>, "m/s", "Its standard deviation.";
        40 moved_m: Option<f32>, "m", "Distance moved since the slip was noticed.";
        44 irregularities: Option<u32>, "", "Irregularities the stylus passed.";
        48 esc_w: Option<f64>, "W", "E_sc as printed.";
        52 esc: Option<f64>, "W or J", "The reading of E_sc that was asked for.";
        56 esc_flags: u8, "", "What is wrong with E_sc as printed: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.";
        57 notes: u8, "", "b0 E_sc depends on the surface, b1 the estimate is extrapolated and not used.";
        58 ruled_out: u8, "", "Causes other than a slip that were ruled out: b0 knock, b1 motion, b2 grip change, b3 closing, b4 arm stop.";
        59 possible: u8, "", "Causes that were not ruled out; one in neither could not be judged.";
        60 estimate_n: Option<f32>, "N", "Estimate of the adequate force.";
        64 command_n: Option<f32>, "N", "Commanded force.";
        68 duration_s: Option<f64>, "s", "From the first notice to the end.";
    }
    appended {
        72 certified_s: Option<f32>, "s", "The interval that the slip is certified with: false alarms of that kind are at least so far apart on average.";
    }
    local {
        estimate_sigma_n: Option<f32>, "N", "Standard deviation of the estimate.";
        mean_slope: Option<f32>, "", "Mean height over distance of the irregularities the stylus passed.";
        first: bool, "", "Whether this is the first notice of the slip: not its turn to gross, its certificate or its end.";
    }
}

impl SlipReport {
    /// Whether E_sc as printed depends on the surface at the assumed noise.
    #[must_use]
    pub const fn is_informative(&self) -> bool {
        self.notes & INFORMATIVE != 0
    }

    /// Whether the estimate lies outside what the network was trained on.
    #[must_use]
    pub const fn is_extrapolated(&self) -> bool {
        self.notes & EXTRAPOLATED != 0
    }
}
