//! Stress conditions by name, applied to a scene and a line.

use super::{
    laboratory::micros,
    line::Line,
    play::{Incident, IncidentKind},
};
use crate::dice::Dice;
use grip_sim::{
    Scene, SceneConfig,
    mcu::{Sensor, SensorFault},
    scene::Draw,
};
use slip_core::units::Micros;

/// What goes wrong in a grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress {
    /// Its name on the command line.
    pub name: &'static str,
    /// Every sensor shows up to this share too much or too little, each by its own, drawn anew for each grasp.
    pub gain: f64,
    /// Noise of every sensor over that of the scene.
    pub noise: f64,
    /// Bounds of the time that every frame takes in either direction (ms), drawn for each grasp.
    pub latency_ms: [f64; 2],
    /// What each frame takes on top in either direction: 0 to so many ms, drawn for each frame.
    pub jitter_ms: f64,
    /// Share of the gripper's frames, and with them of the samples, that are lost.
    pub loss: f64,
    /// The stylus dies at some time after the lift.
    pub dead_stylus: bool,
}

impl Default for Stress {
    fn default() -> Self {
        Self::NONE
    }
}

impl Stress {
    /// Nothing goes wrong.
    pub const NONE: Self = Self {
        name: "none",
        gain: 0.0,
        noise: 1.0,
        latency_ms: [0.0; 2],
        jitter_ms: 0.0,
        loss: 0.0,
        dead_stylus: false,
    };

    /// Every trouble, beginning with none.
    pub const ALL: [Self; 9] = [
        Self::NONE,
        Self { name: "gain", gain: 0.2, ..Self::NONE },
        Self { name: "noise", noise: 3.0, ..Self::NONE },
        Self { name: "latency", latency_ms: [0.0, 20.0], ..Self::NONE },
        Self { name: "jitter", jitter_ms: 20.0, ..Self::NONE },
        Self { name: "loss", loss: 0.05, ..Self::NONE },
        Self { name: "dead-stylus", dead_stylus: true, ..Self::NONE },
        Self { name: "link", noise: 3.0, latency_ms: [5.0, 5.0], ..Self::NONE },
        Self {
            name: "everything",
            gain: 0.2,
            noise: 3.0,
            latency_ms: [0.0, 20.0],
            loss: 0.05,
            ..Self::NONE
        },
    ];

    /// What it does, in a few words.
    #[must_use]
    pub fn explained(&self) -> &'static str {
        match self.name {
            "gain" => "every sensor shows up to 20 % too much or too little",
            "noise" => "three times the noise",
            "latency" => "every frame takes 0 to 20 ms in either direction",
            "jitter" => "each frame takes another 0 to 20 ms in either direction",
            "loss" => "5 % of the samples are lost",
            "dead-stylus" => "the stylus dies after the lift",
            "link" => "every frame takes 5 ms in either direction, three times the noise",
            "everything" => "gain, noise, latency and loss together",
            _ => "nothing goes wrong",
        }
    }

    /// The trouble of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|stress| stress.name == name)
    }

    /// Puts gain and noise into a scene.
    pub(super) fn trouble(&self, scene: &mut SceneConfig) {
        let noise = &mut scene.noise;
        for rms in [
            &mut noise.stylus_um,
            &mut noise.force_mn,
            &mut noise.travel_um,
            &mut noise.tangential_mn,
        ] {
            *rms *= self.noise;
        }
        if let Some(vibration) = &mut scene.vibration {
            vibration.noise_m_s2 *= self.noise;
            vibration.level = vibration.level.times(1.0 / self.noise);
        }
        if self.gain > 0.0 {
            let draw = Draw::Uniform { uniform: [1.0 - self.gain, 1.0 + self.gain] };
            let gain = &mut scene.gain;
            for sensor in
                [&mut gain.stylus, &mut gain.force, &mut gain.travel, &mut gain.tangential]
            {
                *sensor = draw;
            }
        }
    }

    /// The line of the grasp with this seed.
    #[must_use]
    pub fn line(&self, seed: u64) -> Line {
        let mut dice = Dice(seed ^ 0x006c_696e_6500);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 20,000 us"
        )]
        let latency = Micros((1e3 * dice.between(self.latency_ms)) as u64);
        let jitter = micros(1e-3 * self.jitter_ms);
        Line { latency, jitter, loss: self.loss, seed, ..Line::default() }
    }

    /// When the stylus dies: uniform between the lift and the end.
    pub(super) fn stylus_dies(&self, seed: u64, scene: &Scene, end: Micros) -> Option<Incident> {
        let config = scene.config();
        let lift_s = 1e-3 * config.drive.approach_ms + config.lift_at_s;
        let at_s = Dice(seed ^ 0x6465_6164).between([lift_s, end.as_seconds().max(lift_s)]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 660 s")]
        let at = Micros((1e6 * at_s) as u64);
        let kind = IncidentKind::Sensor(Sensor::Stylus, SensorFault::Dead);
        self.dead_stylus.then_some(Incident { at, kind })
    }
}

#[cfg(test)]
mod tests {
    use super::Stress;
    use grip_sim::scene;

    #[test]
    fn troubles_are_known_by_name_and_each_does_something() {
        let calm = scene::load("default").unwrap().config().clone();
        for stress in Stress::ALL {
            assert_eq!(Stress::named(stress.name), Some(stress));
            let mut config = calm.clone();
            stress.trouble(&mut config);
            let line = stress.line(1);
            let late = line.latency.max(line.jitter).0 > 0;
            let changed = config != calm || late || line.loss > 0.0;
            assert_eq!(changed || stress.dead_stylus, stress.name != "none", "{}", stress.name);
            assert_eq!(stress.explained().starts_with("nothing"), stress.name == "none");
        }
    }

    #[test]
    fn latencies_fill_their_range() {
        let stress = Stress::named("latency").unwrap();
        let all: Vec<u64> = (0..1000).map(|seed| stress.line(seed).latency.0).collect();
        assert!(*all.iter().min().unwrap() < 500 && *all.iter().max().unwrap() > 19_500);
        let link = Stress::named("link").unwrap();
        assert!((0..10).all(|seed| link.line(seed).latency.0 == 5000));
    }
}
