//! A gripper or its sensors by name or file, and a scene that has it.
//!
//! A part states some keys of a scene, as a scene file does, without `name`. What it states takes the place of what the scene states.

use super::{Scene, SceneConfig, SceneError, builtin};
use serde::de::Error as _;
use toml::{Table, Value};

/// Name and TOML text of the grippers that need no file.
pub const GRIPPERS: [(&str, &str); 5] = [
    ("direct", include_str!("../../../../grippers/direct.toml")),
    ("industrial", include_str!("../../../../grippers/industrial.toml")),
    ("tendon", include_str!("../../../../grippers/tendon.toml")),
    ("soft", include_str!("../../../../grippers/soft.toml")),
    ("franka", include_str!("../../../../grippers/franka.toml")),
];

/// Name and TOML text of the sensors that need no file.
pub const SENSORS: [(&str, &str); 8] = [
    ("stylus_travel", include_str!("../../../../sensors/stylus_travel.toml")),
    ("stylus_alone", include_str!("../../../../sensors/stylus_alone.toml")),
    ("encoder_20um", include_str!("../../../../sensors/encoder_20um.toml")),
    ("optical_flow", include_str!("../../../../sensors/optical_flow.toml")),
    ("ft_250hz", include_str!("../../../../sensors/ft_250hz.toml")),
    ("accelerometer", include_str!("../../../../sensors/accelerometer.toml")),
    ("adc_12bit", include_str!("../../../../sensors/adc_12bit.toml")),
    ("usb_16ms", include_str!("../../../../sensors/usb_16ms.toml")),
];

/// Some keys of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name it was asked for by.
    pub name: String,
    keys: Table,
}

impl Part {
    /// The built-in gripper `name`, or the one in the file `name`.
    ///
    /// # Errors
    /// [`SceneError::Unknown`], [`SceneError::Read`] or [`SceneError::Parse`].
    pub fn gripper(name: &str) -> Result<Self, SceneError> {
        Self::of("gripper", &GRIPPERS, name)
    }

    /// The built-in sensors `name`, or those in the file `name`.
    ///
    /// # Errors
    /// As [`Part::gripper`].
    pub fn sensors(name: &str) -> Result<Self, SceneError> {
        Self::of("set of sensors", &SENSORS, name)
    }

    fn of(
        what: &'static str,
        known: &[(&str, &'static str)],
        name: &str,
    ) -> Result<Self, SceneError> {
        let text = builtin::text(what, known, name)?;
        let keys = text.parse().map_err(|source| SceneError::Parse(Box::new(source)))?;
        Ok(Self { name: name.to_owned(), keys })
    }
}

impl Scene {
    /// The same scene with what `part` states.
    ///
    /// # Errors
    /// [`SceneError::Part`] where the part has an unknown key or a value of the wrong type, and those of [`Scene::new`].
    pub fn with(&self, part: &Part) -> Result<Self, SceneError> {
        let wrong = |source| SceneError::Part { part: part.name.clone(), source: Box::new(source) };
        let seed = self.config().seed;
        // TOML has no integers above 2^63.
        let config = SceneConfig { seed: 0, ..self.config().clone() };
        let keys = Table::try_from(config);
        let mut keys = keys.map_err(|error| wrong(toml::de::Error::custom(error)))?;
        merge(&mut keys, &part.keys);
        let config: SceneConfig = keys.try_into().map_err(wrong)?;
        Self::new(SceneConfig { seed, ..config })
    }
}

/// Puts `part` over `keys`, table by table. A distribution is a table too, but replaces what stood there.
fn merge(keys: &mut Table, part: &Table) {
    for (key, value) in part {
        match (keys.get_mut(key), value) {
            (Some(Value::Table(inner)), Value::Table(more)) if !is_draw(more) => merge(inner, more),
            _ => drop(keys.insert(key.clone(), value.clone())),
        }
    }
}

fn is_draw(table: &Table) -> bool {
    ["uniform", "log_uniform", "log_normal"].iter().any(|key| table.contains_key(*key))
}

#[cfg(test)]
mod tests {
    use super::{GRIPPERS, Part, SENSORS};
    use crate::scene::{Draw, Scene, load};

    fn part(text: &str) -> Part {
        Part { name: "p".to_owned(), keys: text.parse().unwrap() }
    }

    #[test]
    fn a_part_replaces_what_it_states_and_nothing_else() {
        let scene = Scene::from_toml("name = \"x\"\nseed = 7\n[drive]\nlag_ms = 9.0\n").unwrap();
        let with = scene.with(&part("mass_kg = 0.5\n[drive]\nstep_n = 0.8\n")).unwrap();
        let mut expected = scene.config().clone();
        expected.drive.step_n = 0.8;
        expected.mass_kg = Draw::Fixed(0.5);
        assert_eq!(*with.config(), expected);
        let drawn = with.with(&part("mass_kg = { uniform = [1.0, 2.0] }\n")).unwrap();
        assert_eq!(drawn.config().mass_kg, Draw::Uniform { uniform: [1.0, 2.0] });
        let again = drawn.with(&part("mass_kg = { log_uniform = [1.0, 2.0] }\n")).unwrap();
        assert_eq!(again.config().mass_kg, Draw::LogUniform { log_uniform: [1.0, 2.0] });
    }

    #[test]
    fn a_part_with_a_mistake_is_refused_by_name() {
        let scene = load("default").unwrap();
        let error = scene.with(&part("[drive]\nstep = 0.8\n")).unwrap_err().to_string();
        assert!(error.contains("p:") && error.contains("step"), "{error}");
        let error = scene.with(&part("[drive]\nstep_n = -1.0\n")).unwrap_err().to_string();
        assert_eq!(error, "drive.step_n = -1 is outside 0 to 100");
        let error = Part::gripper("nope").unwrap_err().to_string();
        assert!(error.contains("gripper") && error.contains("industrial"), "{error}");
    }

    #[test]
    fn built_in_parts_fit_every_built_in_scene() {
        for (scene, _) in crate::scene::BUILT_IN {
            let scene = load(scene).unwrap();
            for gripper in GRIPPERS {
                for sensors in SENSORS {
                    let gripper = scene.with(&Part::gripper(gripper.0).unwrap()).unwrap();
                    gripper.with(&Part::sensors(sensors.0).unwrap()).unwrap();
                }
            }
        }
    }

    #[test]
    fn the_direct_drive_and_the_first_sensors_are_those_of_the_default_scene() {
        let scene = load("default").unwrap();
        let direct = scene.with(&Part::gripper("direct").unwrap()).unwrap();
        assert_eq!(direct.with(&Part::sensors("stylus_travel").unwrap()).unwrap(), scene);
    }
}
