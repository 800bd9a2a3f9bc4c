//! Check of a scene configuration: the first field that is out of its range.

use super::{SceneConfig, table::Ranged as _};
use std::path::PathBuf;

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Not TOML, an unknown key or a wrong type; the text names line and column.
    #[error("scene does not parse: {0}")]
    Parse(#[source] Box<toml::de::Error>),
    /// A gripper or set of sensors with an unknown key or a value of the wrong type.
    #[error("{part}: {source}")]
    Part {
        /// Its name or file.
        part: String,
        /// What is wrong.
        source: Box<toml::de::Error>,
    },
    /// A value outside its range.
    #[error("{field} = {value} is outside {low} to {high}")]
    OutOfRange {
        /// Key, dotted where it is in a table.
        field: &'static str,
        /// The offending value.
        value: f64,
        /// Lowest value allowed.
        low: f64,
        /// Highest value allowed.
        high: f64,
    },
    /// A distribution whose bounds are the wrong way round.
    #[error("{field}: lower bound {low} lies above upper bound {high}")]
    BoundsSwapped {
        /// Key.
        field: &'static str,
        /// First bound as written.
        low: f64,
        /// Second bound as written.
        high: f64,
    },
    /// `crush_n` and `crush_ratio` both given.
    #[error("crush_n and crush_ratio exclude each other")]
    TwoCrushLimits,
    /// Neither built in nor a .toml path.
    #[error("no {what} named {name:?}; built in are {known}; a path must end in .toml")]
    Unknown {
        /// Scene, gripper or set of sensors.
        what: &'static str,
        /// Name asked for.
        name: String,
        /// Names of those that are built in.
        known: String,
    },
    /// The file could not be read.
    #[error("cannot read {what} {path}")]
    Read {
        /// Scene, gripper or set of sensors.
        what: &'static str,
        /// The path asked for.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
}

pub(super) fn check(config: &SceneConfig) -> Result<(), SceneError> {
    f64::from(config.sample_rate_hz).within("sample_rate_hz", 1000.0, 20_000.0)?;
    config.step_us.within("step_us", 1.0, 50.0)?;
    config.lift_at_s.within("lift_at_s", 0.0, 60.0)?;
    config.lift_ramp_s.within("lift_ramp_s", 0.0, 5.0)?;
    config.finger_length_mm.within("finger_length_mm", 1.0, 500.0)?;
    if let Some(spacing_mm) = config.second_stylus_mm {
        spacing_mm.within("second_stylus_mm", 0.05, 20.0)?;
    }
    check_object(config)?;
    let SceneConfig { drive, pad, shake, motion, reading, noise, gain, .. } = config;
    drive.check()?;
    drive.force_min_n.within("drive.force_min_n", 0.0, drive.force_max_n)?;
    pad.check()?;
    shake.check()?;
    motion.check()?;
    reading.check()?;
    config.vibration.map_or(Ok(()), |vibration| vibration.check())?;
    noise.check()?;
    gain.check()?;
    let SceneConfig { fill, tug, bump, arm, wet, .. } = config;
    fill.check()?;
    tug.check()?;
    bump.check()?;
    arm.check()?;
    wet.check()
}

fn check_object(config: &SceneConfig) -> Result<(), SceneError> {
    config.mass_kg.within("mass_kg", 0.005, 20.0)?;
    config.friction.within("friction", 0.02, 2.0)?;
    config.friction_ratio.within("friction_ratio", 1.0, 2.0)?;
    config.viscous_n_s_m.within("viscous_n_s_m", 0.0, 1000.0)?;
    config.roughness_ra_um.within("roughness_ra_um", 0.02, 100.0)?;
    config.waviness.check()?;
    config.friction_power.within("friction_power", 0.5, 1.0)?;
    config.tilt_deg.within("tilt_deg", 0.0, 80.0)?;
    config.form.check()?;
    match (config.crush_n, config.crush_ratio) {
        (Some(_), Some(_)) => Err(SceneError::TwoCrushLimits),
        (Some(limit), None) => limit.within("crush_n", 0.1, 10_000.0),
        (None, Some(ratio)) => ratio.within("crush_ratio", 1.0, 100.0),
        (None, None) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{Scene, SceneError};

    fn refusal(text: &str) -> String {
        let error = Scene::from_toml(text).unwrap_err();
        match &error {
            SceneError::Parse(source) => format!("{error} {source}"),
            _ => error.to_string(),
        }
    }

    #[test]
    fn unknown_keys_are_refused_by_name() {
        let text = refusal("name = \"x\"\nmas_kg = 1.0\n");
        assert!(text.contains("mas_kg") && text.contains("line 2"), "{text}");
        assert!(refusal("name = \"x\"\n[noise]\nstilus_um = 1.0\n").contains("stilus_um"));
        assert!(
            refusal("name = \"x\"\nmass_kg = { normal = [1.0, 2.0] }\n").contains("log_uniform")
        );
        assert!(refusal("seed = 1\n").contains("name"));
    }

    #[test]
    fn ranges_are_named_with_field_and_value() {
        assert_eq!(
            refusal("name = \"x\"\nsample_rate_hz = 50000\n"),
            "sample_rate_hz = 50000 is outside 1000 to 20000"
        );
        assert_eq!(refusal("name = \"x\"\nmass_kg = 0.0\n"), "mass_kg = 0 is outside 0.005 to 20");
        assert_eq!(
            refusal("name = \"x\"\nmass_kg = nan\n"),
            "mass_kg = NaN is outside 0.005 to 20"
        );
        assert_eq!(
            refusal("name = \"x\"\nfriction = { uniform = [0.2, 3.0] }\n"),
            "friction = 3 is outside 0.02 to 2"
        );
        assert_eq!(
            refusal("name = \"x\"\nfriction = { uniform = [0.5, 0.2] }\n"),
            "friction: lower bound 0.5 lies above upper bound 0.2"
        );
        assert_eq!(
            refusal("name = \"x\"\n[waviness]\namplitude_um = { uniform = [0.0, 200.0] }\n"),
            "waviness.amplitude_um = 200 is outside 0 to 100"
        );
        assert_eq!(
            refusal("name = \"x\"\n[form]\ncurvature_1_m = -2.0\n"),
            "form.curvature_1_m = -2 is outside -1 to 1"
        );
        assert_eq!(
            refusal("name = \"x\"\nviscous_n_s_m = 2000.0\n"),
            "viscous_n_s_m = 2000 is outside 0 to 1000"
        );
        assert_eq!(
            refusal("name = \"x\"\n[drive]\nlag_ms = -1.0\n"),
            "drive.lag_ms = -1 is outside 0.1 to 200"
        );
        assert_eq!(
            refusal("name = \"x\"\n[wet]\nfriction_ratio = 0.05\n"),
            "wet.friction_ratio = 0.05 is outside 0.1 to 1"
        );
        assert_eq!(
            refusal("name = \"x\"\nmass_kg = { log_normal = [0.3, 9.0], within = [0.1, 1.0] }\n"),
            "mass_kg = 9 is outside 0 to 3"
        );
        assert_eq!(
            refusal("name = \"x\"\ncrush_n = 5.0\ncrush_ratio = 2.0\n"),
            "crush_n and crush_ratio exclude each other"
        );
    }
}
