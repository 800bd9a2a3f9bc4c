//! A scene configuration in, the first field that is out of its range out.

use super::{Draw, SceneConfig};
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
    within("sample_rate_hz", f64::from(config.sample_rate_hz), 1000.0, 20_000.0)?;
    within("step_us", config.step_us, 1.0, 50.0)?;
    within("lift_at_s", config.lift_at_s, 0.0, 60.0)?;
    within("lift_ramp_s", config.lift_ramp_s, 0.0, 5.0)?;
    within("finger_length_mm", config.finger_length_mm, 1.0, 500.0)?;
    if let Some(spacing_mm) = config.second_stylus_mm {
        within("second_stylus_mm", spacing_mm, 0.05, 20.0)?;
    }
    check_object(config)?;
    check_gripper(config)?;
    check_sensors(config)?;
    check_load(config)
}

fn check_object(config: &SceneConfig) -> Result<(), SceneError> {
    drawn("mass_kg", config.mass_kg, 0.005, 20.0)?;
    drawn("friction", config.friction, 0.02, 2.0)?;
    drawn("friction_ratio", config.friction_ratio, 1.0, 2.0)?;
    within("viscous_n_s_m", config.viscous_n_s_m, 0.0, 1000.0)?;
    drawn("roughness_ra_um", config.roughness_ra_um, 0.02, 100.0)?;
    drawn("waviness.amplitude_um", config.waviness.amplitude_um, 0.0, 100.0)?;
    drawn("waviness.wavelength_mm", config.waviness.wavelength_mm, 0.5, 100.0)?;
    within("friction_power", config.friction_power, 0.5, 1.0)?;
    within("tilt_deg", config.tilt_deg, 0.0, 80.0)?;
    drawn("form.tilt_um_mm", config.form.tilt_um_mm, -50.0, 50.0)?;
    drawn("form.curvature_1_m", config.form.curvature_1_m, -1.0, 1.0)?;
    match (config.crush_n, config.crush_ratio) {
        (Some(_), Some(_)) => Err(SceneError::TwoCrushLimits),
        (Some(limit), None) => drawn("crush_n", limit, 0.1, 10_000.0),
        (None, Some(ratio)) => drawn("crush_ratio", ratio, 1.0, 100.0),
        (None, None) => Ok(()),
    }
}

fn check_gripper(config: &SceneConfig) -> Result<(), SceneError> {
    let SceneConfig { drive, pad, shake, motion, .. } = config;
    within("drive.force_max_n", drive.force_max_n, 0.5, 1000.0)?;
    within("drive.slew_max_n_s", drive.slew_max_n_s, 1.0, 100_000.0)?;
    within("drive.lag_ms", drive.lag_ms, 0.1, 200.0)?;
    within("drive.approach_ms", drive.approach_ms, 1.0, 5000.0)?;
    within("drive.force_min_n", drive.force_min_n, 0.0, drive.force_max_n)?;
    within("drive.step_n", drive.step_n, 0.0, 100.0)?;
    within("drive.command_hz", drive.command_hz, 0.0, 1000.0)?;
    within("drive.delay_ms", drive.delay_ms, 0.0, 500.0)?;
    within("drive.dead_band_n", drive.dead_band_n, 0.0, 100.0)?;
    within("drive.hysteresis", drive.hysteresis, 0.0, 0.9)?;
    within("pad.shear_n_mm", pad.shear_n_mm, 1.0, 10_000.0)?;
    within("pad.damping_n_s_m", pad.damping_n_s_m, 0.0, 500.0)?;
    within("pad.stribeck_mm_s", pad.stribeck_mm_s, 0.1, 100.0)?;
    within("pad.elastic_share", pad.elastic_share, 0.0, 0.99)?;
    within("pad.sink_um_n", pad.sink_um_n, 0.0, 100.0)?;
    within("shake.amplitude_m_s2", shake.amplitude_m_s2, 0.0, 50.0)?;
    within("shake.frequency_hz", shake.frequency_hz, 0.0, 200.0)?;
    within("motion.level", motion.level, 0.0, 10.0)?;
    within("motion.taps_per_s", motion.taps_per_s, 0.0, 20.0)
}

fn check_sensors(config: &SceneConfig) -> Result<(), SceneError> {
    let SceneConfig { noise, gain, reading, .. } = config;
    within("reading.travel_hz", reading.travel_hz, 0.0, 20_000.0)?;
    within("reading.travel_delay_ms", reading.travel_delay_ms, 0.0, 1000.0)?;
    within("reading.force_hz", reading.force_hz, 0.0, 20_000.0)?;
    within("reading.force_drift_mn_s", reading.force_drift_mn_s, -1000.0, 1000.0)?;
    within("reading.adc_bits", f64::from(reading.adc_bits), 0.0, 24.0)?;
    within("reading.batch_ms", reading.batch_ms, 0.0, 100.0)?;
    if let Some(vibration) = config.vibration {
        drawn("vibration.level", vibration.level, 0.1, 10_000.0)?;
        drawn("vibration.exponent", vibration.exponent, 0.1, 3.0)?;
        within("vibration.noise_m_s2", vibration.noise_m_s2, 0.0, 1000.0)?;
    }
    within("noise.stylus_um", noise.stylus_um, 0.0, 1000.0)?;
    within("noise.force_mn", noise.force_mn, 0.0, 1000.0)?;
    within("noise.travel_um", noise.travel_um, 0.0, 1000.0)?;
    within("noise.travel_step_um", noise.travel_step_um, 0.001, 1000.0)?;
    within("noise.tangential_mn", noise.tangential_mn, 0.0, 1000.0)?;
    drawn("gain.stylus", gain.stylus, 0.1, 10.0)?;
    drawn("gain.force", gain.force, 0.1, 10.0)?;
    drawn("gain.travel", gain.travel, 0.1, 10.0)?;
    drawn("gain.tangential", gain.tangential, 0.1, 10.0)
}

fn check_load(config: &SceneConfig) -> Result<(), SceneError> {
    let SceneConfig { fill, tug, bump, arm, wet, .. } = config;
    drawn("fill.mass_kg", fill.mass_kg, 0.0, 20.0)?;
    within("fill.start_s", fill.start_s, 0.0, 60.0)?;
    within("fill.duration_s", fill.duration_s, 0.01, 60.0)?;
    within("fill.height_mm", fill.height_mm, 0.0, 1000.0)?;
    drawn("tug.force_n", tug.force_n, 0.0, 500.0)?;
    within("tug.start_s", tug.start_s, 0.0, 60.0)?;
    within("tug.rise_ms", tug.rise_ms, 1.0, 5000.0)?;
    within("tug.hold_ms", tug.hold_ms, 0.0, 60_000.0)?;
    drawn("bump.acceleration_m_s2", bump.acceleration_m_s2, 0.0, 200.0)?;
    within("bump.start_s", bump.start_s, 0.0, 60.0)?;
    within("bump.duration_ms", bump.duration_ms, 1.0, 1000.0)?;
    drawn("arm.acceleration_m_s2", arm.acceleration_m_s2, 0.0, 50.0)?;
    within("arm.start_s", arm.start_s, 0.0, 60.0)?;
    within("arm.move_s", arm.move_s, 0.02, 10.0)?;
    within("arm.pause_s", arm.pause_s, 0.0, 10.0)?;
    drawn("wet.friction_ratio", wet.friction_ratio, 0.1, 1.0)?;
    within("wet.start_s", wet.start_s, 0.0, 60.0)?;
    within("wet.spread_s", wet.spread_s, 0.001, 60.0)
}

fn within(field: &'static str, value: f64, low: f64, high: f64) -> Result<(), SceneError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(SceneError::OutOfRange { field, value, low, high })
    }
}

fn drawn(field: &'static str, draw: Draw, low: f64, high: f64) -> Result<(), SceneError> {
    let [first, second] = draw.bounds();
    within(field, first, low, high)?;
    within(field, second, low, high)?;
    if first > second {
        return Err(SceneError::BoundsSwapped { field, low: first, high: second });
    }
    match draw {
        // A logarithm of 0 is none.
        Draw::LogUniform { .. } => within(field, first, low.max(f64::MIN_POSITIVE), high),
        Draw::LogNormal { log_normal: [median, spread], .. } => {
            within(field, median, low.max(f64::MIN_POSITIVE), high)?;
            within(field, spread, 0.0, 3.0)
        }
        Draw::Fixed(_) | Draw::Uniform { .. } => Ok(()),
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
