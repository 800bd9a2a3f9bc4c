//! Load of an object while it is held, as written in a scene: mass, acceleration, pull and friction at any time.
//!
//! All times count from the lift. With the mass m(t), the acceleration a(t) of the hand (up is positive), the pull P(t) along the
//! fingers and the friction mu(t), each of two fingers needs
//!
//! ```text
//! F(t) = (m (g + a) + P + m' u) / (2 mu)
//! ```
//!
//! m' u is the momentum of what is poured in: it arrives with u = sqrt(2 g h) after a fall of h and comes to rest in the object. An object that
//! slides with v loses m' v more of its speed.

use super::{Draw, Object, SceneConfig, table::settings};
use crate::GRAVITY_M_S2;
use core::f64::consts::{PI, TAU};
use rand_chacha::ChaCha8Rng;

settings! {
    /// Something is poured into the object: its mass rises evenly.
    pub struct FillConfig in "fill" {
        mass_kg: Draw = Draw::Fixed(0.0), 0.0 to 20.0 => "Mass added in all (kg)";
        start_s: f64 = 0.3, 0.0 to 60.0 => "When it begins (s)";
        duration_s: f64 = 2.0, 0.01 to 60.0 => "How long it lasts (s)";
        height_mm: f64 = 100.0, 0.0 to 1000.0 => "How far it falls before it arrives (mm)";
    }
}

settings! {
    /// Somebody pulls at the object, out of the fingers: a force that rises evenly, stands, and falls evenly.
    pub struct TugConfig in "tug" {
        force_n: Draw = Draw::Fixed(0.0), 0.0 to 500.0 => "Force while it stands (N)";
        start_s: f64 = 1.0, 0.0 to 60.0 => "When it begins (s)";
        rise_ms: f64 = 50.0, 1.0 to 5000.0 => "Time of the rise, and of the fall (ms)";
        hold_ms: f64 = 300.0, 0.0 to 60_000.0 => "How long it stands (ms)";
    }
}

settings! {
    /// Something hits the hand from below: half a sine of acceleration.
    pub struct BumpConfig in "bump" {
        acceleration_m_s2: Draw = Draw::Fixed(0.0), 0.0 to 200.0 => "Its peak (m/s^2)";
        start_s: f64 = 1.0, 0.0 to 60.0 => "When it begins (s)";
        duration_ms: f64 = 20.0, 1.0 to 1000.0 => "How long it lasts (ms)";
    }
}

settings! {
    /// The arm lifts and lowers the hand in turn: each move is one period of a sine of acceleration, from rest to rest.
    pub struct ArmConfig in "arm" {
        acceleration_m_s2: Draw = Draw::Fixed(0.0), 0.0 to 50.0 => "Its peak (m/s^2)";
        start_s: f64 = 0.5, 0.0 to 60.0 => "When the first move begins (s)";
        move_s: f64 = 0.5, 0.02 to 10.0 => "Length of a move (s)";
        pause_s: f64 = 0.2, 0.0 to 10.0 => "Rest between two moves (s)";
    }
}

settings! {
    /// A liquid creeps into the contact: friction of two phases, dry before and wet after.
    pub struct WetConfig in "wet" {
        friction_ratio: Draw = Draw::Fixed(1.0), 0.1 to 1.0 => "Wet over dry friction; 1 is a contact that stays dry";
        start_s: f64 = 1.0, 0.0 to 60.0 => "When the liquid reaches the contact (s)";
        spread_s: f64 = 0.3, 0.001 to 60.0 => "Time in which the dry part of the contact falls to 1/e (s)";
    }
}

/// What acts on the object at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Acting {
    /// Mass of the object (kg).
    pub(crate) mass_kg: f64,
    /// Mass that arrives (kg/s).
    pub(crate) flow_kg_s: f64,
    /// Acceleration of the hand, upwards (m/s^2).
    pub(crate) acceleration_m_s2: f64,
    /// Pull along the fingers and impact of what is poured in (N).
    pub(crate) pull_n: f64,
    /// Friction over that of the dry object.
    pub(crate) friction_share: f64,
}

/// The drawn happenings of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Load {
    mass_kg: f64,
    shake: super::ShakeConfig,
    fill: (FillConfig, f64),
    tug: (TugConfig, f64),
    bump: (BumpConfig, f64),
    arm: (ArmConfig, f64),
    wet: (WetConfig, f64),
}

impl Load {
    /// Draws what is distributed, for an object of `mass_kg`.
    pub(super) fn draw(config: &SceneConfig, mass_kg: f64, rng: &mut ChaCha8Rng) -> Self {
        let SceneConfig { shake, fill, tug, bump, arm, wet, .. } = *config;
        Self {
            mass_kg,
            shake,
            fill: (fill, fill.mass_kg.sample(rng)),
            tug: (tug, tug.force_n.sample(rng)),
            bump: (bump, bump.acceleration_m_s2.sample(rng)),
            arm: (arm, arm.acceleration_m_s2.sample(rng)),
            wet: (wet, wet.friction_ratio.sample(rng)),
        }
    }

    /// The same happenings around another mass.
    pub(super) fn with_mass(self, mass_kg: f64) -> Self {
        Self { mass_kg, ..self }
    }

    /// Whether nothing happens: the weight is all there is.
    pub(crate) fn is_still(&self) -> bool {
        let strengths =
            [self.shake.amplitude_m_s2, self.fill.1, self.tug.1, self.bump.1, self.arm.1];
        strengths.iter().all(|strength| *strength == 0.0) && self.wet.1 == 1.0
    }

    /// What acts `t` seconds after the lift.
    pub(crate) fn at(&self, t: f64) -> Acting {
        let (fill, added_kg) = self.fill;
        let filled = ((t - fill.start_s) / fill.duration_s).clamp(0.0, 1.0);
        let pours = filled > 0.0 && filled < 1.0;
        let flow_kg_s = if pours { added_kg / fill.duration_s } else { 0.0 };
        let impact_n = flow_kg_s * (2.0 * GRAVITY_M_S2 * 1e-3 * fill.height_mm).sqrt();
        Acting {
            mass_kg: self.mass_kg + added_kg * filled,
            flow_kg_s,
            acceleration_m_s2: self.shaking(t) + self.bumping(t) + self.moving(t),
            pull_n: self.tugging(t) + impact_n,
            friction_share: self.friction_share(t),
        }
    }

    fn shaking(&self, t: f64) -> f64 {
        self.shake.amplitude_m_s2 * (TAU * self.shake.frequency_hz * t).sin()
    }

    fn bumping(&self, t: f64) -> f64 {
        let (bump, peak) = self.bump;
        let share = (t - bump.start_s) / (1e-3 * bump.duration_ms);
        if (0.0..1.0).contains(&share) { peak * (PI * share).sin() } else { 0.0 }
    }

    fn moving(&self, t: f64) -> f64 {
        let (arm, peak) = self.arm;
        let since = t - arm.start_s;
        if since < 0.0 || peak == 0.0 {
            return 0.0;
        }
        let period_s = arm.move_s + arm.pause_s;
        let (moves, into) = ((since / period_s).floor(), since % period_s);
        let sign = if moves % 2.0 == 0.0 { 1.0 } else { -1.0 };
        if into < arm.move_s { sign * peak * (TAU * into / arm.move_s).sin() } else { 0.0 }
    }

    fn tugging(&self, t: f64) -> f64 {
        let (tug, force_n) = self.tug;
        let (rise_s, hold_s) = (1e-3 * tug.rise_ms, 1e-3 * tug.hold_ms);
        let since = t - tug.start_s;
        let share = (since / rise_s).min((2.0 * rise_s + hold_s - since) / rise_s);
        force_n * share.clamp(0.0, 1.0)
    }

    fn friction_share(&self, t: f64) -> f64 {
        let (wet, ratio) = self.wet;
        let since = t - wet.start_s;
        if since <= 0.0 {
            return 1.0;
        }
        ratio + (1.0 - ratio) * (-since / wet.spread_s).exp()
    }
}

impl Acting {
    /// Force of each finger (N) that balances it where `object` is held; 0 where the object is pushed into the fingers.
    pub(crate) fn force_needed_n(&self, object: &Object) -> f64 {
        let load_n = self.mass_kg * (object.gravity_m_s2 + self.acceleration_m_s2) + self.pull_n;
        object.force_against_n(load_n, self.friction_share)
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    fn scene(text: &str) -> Scene {
        let fixed = "name = \"x\"\nmass_kg = 0.1\nfriction = 0.5\n";
        Scene::from_toml(&format!("{fixed}{text}")).unwrap()
    }

    fn load(text: &str) -> super::Load {
        scene(text).load()
    }

    #[test]
    fn without_happenings_the_weight_is_all() {
        let load = load("");
        assert!(load.is_still());
        for t in [0.0, 1.0, 100.0] {
            assert!((load.at(t).force_needed_n(&scene("").object()) - 0.980_665).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_poured_in_weighs_and_pushes() {
        let load =
            load("[fill]\nmass_kg = 0.2\nstart_s = 1.0\nduration_s = 2.0\nheight_mm = 100.0\n");
        assert!(!load.is_still());
        let acting = load.at(2.0);
        assert!((acting.mass_kg - 0.2).abs() < 1e-12 && (acting.flow_kg_s - 0.1).abs() < 1e-12);
        // 0.1 kg/s after a fall of 0.1 m: 0.1 * 1.4004 m/s.
        assert!((acting.pull_n - 0.140_05).abs() < 1e-4, "{}", acting.pull_n);
        let full = load.at(5.0);
        assert!((full.mass_kg - 0.3).abs() < 1e-12 && full.pull_n == 0.0);
        assert!((full.force_needed_n(&scene("").object()) - 0.3 * 9.80665).abs() < 1e-9);
    }

    #[test]
    fn a_tug_rises_stands_and_falls() {
        let load = load("[tug]\nforce_n = 4.0\nstart_s = 1.0\nrise_ms = 100.0\nhold_ms = 200.0\n");
        for (t, force) in [(0.9, 0.0), (1.05, 2.0), (1.1, 4.0), (1.3, 4.0), (1.35, 2.0), (1.5, 0.0)]
        {
            assert!((load.at(t).pull_n - force).abs() < 1e-9, "{t}: {}", load.at(t).pull_n);
        }
    }

    #[test]
    fn every_move_of_the_arm_ends_at_rest_and_the_next_one_goes_back() {
        let load =
            load("[arm]\nacceleration_m_s2 = 3.0\nstart_s = 0.5\nmove_s = 0.4\npause_s = 0.1\n");
        let (mut speed, mut height, mut highest) = (0.0, 0.0, 0.0_f64);
        for step in 0..150_000 {
            let t = f64::from(step) * 1e-5;
            speed += load.at(t).acceleration_m_s2 * 1e-5;
            height += speed * 1e-5;
            highest = highest.max(height);
        }
        // One period of a sine of peak A and length T moves by A T^2 / (2 pi).
        let expected = 3.0 * 0.16 / core::f64::consts::TAU;
        assert!((highest / expected - 1.0).abs() < 1e-3, "{highest} {expected}");
        assert!(speed.abs() < 1e-6 && height.abs() < 1e-3 * expected, "{speed} {height}");
    }

    #[test]
    fn a_bump_is_half_a_sine() {
        let load = load("[bump]\nacceleration_m_s2 = 10.0\nstart_s = 1.0\nduration_ms = 20.0\n");
        let gained: f64 =
            (0..200_000).map(|step| load.at(f64::from(step) * 1e-5).acceleration_m_s2 * 1e-5).sum();
        // Mean of half a sine: 2 / pi.
        let expected = 10.0 * 0.02 * 2.0 / core::f64::consts::PI;
        assert!((gained / expected - 1.0).abs() < 1e-3, "{gained} {expected}");
    }

    #[test]
    fn a_wet_contact_needs_more_force() {
        let load = load("[wet]\nfriction_ratio = 0.5\nstart_s = 1.0\nspread_s = 0.1\n");
        let dry = load.at(1.0).force_needed_n(&scene("").object());
        assert!((load.at(1.1).friction_share - (0.5 + 0.5 * (-1.0_f64).exp())).abs() < 1e-9);
        assert!((load.at(9.0).force_needed_n(&scene("").object()) / dry - 2.0).abs() < 1e-9);
    }
}
