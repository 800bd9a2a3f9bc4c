//! Row of the training file: a slip and where it was recorded.

use super::watch::MeasuredSlip;
use slip_core::estimate::{Feature, KAPPA};

/// Names of the columns in the order of [`Row::csv`]: where it was, both forces, what models use, and the target with its bounds.
pub const COLUMNS: [&str; 18] = [
    "site",
    "gripper",
    "object",
    "recording",
    "t_s",
    "slipped_n",
    "stayed_n",
    "slip_speed_m_s",
    "contact_time_s",
    "slip_acceleration_m_s2",
    "micro_displacement_m",
    "trial_force_n",
    "irregularities",
    "mean_slope",
    "esc_literal_w",
    "adequate_low_n",
    "adequate_high_n",
    "adequate_force_n",
];

/// One slip of one object in one gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Where the gripper stands.
    pub site: String,
    /// Which gripper.
    pub gripper: String,
    /// What was held.
    pub object: String,
    /// The file.
    pub recording: String,
    /// What happened.
    pub slip: MeasuredSlip,
}

impl Row {
    /// The adequate force of one finger is at least, and at most, this (N).
    #[must_use]
    pub fn bounds_n(&self) -> [f32; 2] {
        [KAPPA * self.slip.slipped_n, KAPPA * self.slip.stayed_n]
    }

    /// The target (N): the middle of its bounds as a ratio.
    #[must_use]
    pub fn adequate_n(&self) -> f32 {
        KAPPA * (self.slip.slipped_n * self.slip.stayed_n).sqrt()
    }

    /// A line of CSV without its end; the cell of a feature that the slip did not show is empty.
    #[must_use]
    pub fn csv(&self) -> String {
        let [low_n, high_n] = self.bounds_n();
        let texts = [&self.site, &self.gripper, &self.object, &self.recording].map(|s| quoted(s));
        let mut cells = Vec::from(texts);
        cells.push(self.slip.t.as_seconds().to_string());
        cells.extend([self.slip.slipped_n, self.slip.stayed_n].map(|force| force.to_string()));
        cells.extend(Feature::ALL.map(|feature| {
            feature.value(&self.slip.features).map_or_else(String::new, |value| value.to_string())
        }));
        cells.extend([low_n, high_n, self.adequate_n()].map(|force| force.to_string()));
        cells.join(",")
    }
}

/// A text as RFC 4180 has it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.to_owned()
}

#[cfg(test)]
pub(super) mod tests {
    use super::{COLUMNS, Row};
    use crate::collect::MeasuredSlip;
    use slip_core::{
        estimate::{Feature, Features},
        units::Micros,
    };

    /// A slip of half a metre a second, 4 ms long.
    pub(in crate::collect) fn features(trial_force_n: f32) -> Features {
        Features {
            slip_speed_m_s: 0.5,
            contact_time_s: 0.004,
            slip_acceleration_m_s2: -1.5,
            slip_acceleration_sigma_m_s2: None,
            micro_displacement_m: 1e-4,
            trial_force_n,
            irregularities: 0,
            mean_slope: None,
            esc: None,
            esc_chosen: None,
        }
    }

    #[test]
    fn a_row_has_a_cell_for_each_column_and_the_middle_of_its_bounds() {
        let features = features(4.5);
        let slip = MeasuredSlip { t: Micros(1_500_000), features, slipped_n: 4.0, stayed_n: 9.0 };
        let text = |text: &str| text.to_owned();
        let (site, gripper) = (text("hall"), text("07"));
        let row =
            Row { site, gripper, object: text("a \"b\", c"), recording: text("r.mcap"), slip };
        let line = row.csv();
        let wanted = "hall,07,\"a \"\"b\"\", c\",r.mcap,1.5,4,9,0.5,0.004,-1.5,0.0001,4.5,0,,,";
        assert_eq!(line, format!("{wanted}4.8,10.8,{}", 1.2_f32 * 6.0));
        assert_eq!(line.replace("\", c", "").split(',').count(), COLUMNS.len());
        assert_eq!(COLUMNS[7..15], Feature::ALL.map(Feature::name));
    }
}
