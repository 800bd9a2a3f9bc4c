//! Sensor sets by name: a scene whose gripper has these sensors, and the settings that go with them.

use grip_session::config::HostConfig;
use grip_sim::SceneConfig;

/// Distance of the second stylus behind the first (mm).
const SPACING_MM: f32 = 1.0;

/// What the gripper feels. The normal force is measured in every set: a gripper that controls it has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorSet {
    /// What the scene states.
    #[default]
    Scene,
    /// One stylus: how fast the object slips cannot be derived from it.
    Stylus,
    /// Stylus and moved distance.
    Travel,
    /// Two styli, 1 mm apart.
    TwoStyli,
    /// Stylus and tangential force.
    Tangential,
    /// An accelerometer in the finger instead of the stylus.
    Vibration,
}

impl SensorSet {
    /// The sets a gripper may have.
    pub const ALL: [Self; 5] =
        [Self::Stylus, Self::Travel, Self::TwoStyli, Self::Tangential, Self::Vibration];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Stylus => "stylus",
            Self::Travel => "travel",
            Self::TwoStyli => "two-styli",
            Self::Tangential => "tangential",
            Self::Vibration => "vibration",
        }
    }

    /// The set of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().chain([Self::Scene]).find(|set| set.name() == name)
    }

    /// Puts these sensors into a scene, and takes the others out; the motion reference stays as it is.
    pub(super) fn equip(self, scene: &mut SceneConfig) {
        if self == Self::Scene {
            return;
        }
        scene.channels.force = true;
        scene.channels.travel = self == Self::Travel;
        scene.channels.tangential = self == Self::Tangential;
        scene.vibration = (self == Self::Vibration).then(|| scene.vibration.unwrap_or_default());
        scene.second_stylus_mm = (self == Self::TwoStyli).then_some(f64::from(SPACING_MM));
    }

    /// The settings that know where the second stylus stands.
    pub(super) fn settings(self, config: &HostConfig) -> HostConfig {
        let mut config = config.clone();
        if self == Self::TwoStyli {
            config.velocity.spacing_m = 1e-3 * SPACING_MM;
        }
        config
    }
}

#[cfg(test)]
mod tests {
    use super::SensorSet;
    use grip_sim::scene;

    #[test]
    fn a_set_has_its_sensors_and_no_others() {
        for set in SensorSet::ALL {
            assert_eq!(SensorSet::named(set.name()), Some(set));
            let mut config = scene::load("moving").unwrap().config().clone();
            set.equip(&mut config);
            let channels = config.channels;
            let second = config.second_stylus_mm.is_some();
            let has = [channels.travel, second, channels.tangential, config.vibration.is_some()];
            assert_eq!(usize::from(set != SensorSet::Stylus), has.iter().filter(|x| **x).count());
            assert!(channels.force && channels.reference);
        }
    }
}
