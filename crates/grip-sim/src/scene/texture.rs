//! Waviness and form of an object's surface, as written in a scene and drawn.

use super::{Draw, SceneConfig, table::settings};
use crate::{random, shape::Shape};
use core::f64::consts::TAU;
use rand_chacha::ChaCha8Rng;

settings! {
    /// Long waves of the surface; see [`Shape`].
    pub struct WavinessConfig in "waviness" {
        amplitude_um: Draw = Draw::Fixed(0.0), 0.0 to 100.0 => "Amplitude of the strongest of its three waves (um; 0: none); the others are 0.6 and 1.7 times as long and half as high";
        wavelength_mm: Draw = Draw::Fixed(4.0), 0.5 to 100.0 => "Wavelength of that wave (mm)";
    }
}

settings! {
    /// Shape of the surface along the slip.
    pub struct FormConfig in "form" {
        tilt_um_mm: Draw = Draw::Fixed(0.0), -50.0 to 50.0 => "Tilt along the slip (um/mm)";
        curvature_1_m: Draw = Draw::Fixed(0.0), -1.0 to 1.0 =>
            "Curvature (1/m); positive bends away from the stylus, which leaves the surface 0.2 mm below where it landed";
    }
}

/// Draws the shape of the surface; `None` where it is flat.
pub(super) fn draw(config: &SceneConfig, rng: &mut ChaCha8Rng) -> Option<Shape> {
    let SceneConfig { waviness, form, .. } = config;
    let shape = Shape {
        amplitude_m: 1e-6 * waviness.amplitude_um.sample(rng),
        wavelength_m: 1e-3 * waviness.wavelength_mm.sample(rng),
        tilt: 1e-3 * form.tilt_um_mm.sample(rng),
        curvature_1_m: form.curvature_1_m.sample(rng),
        phases: [(); 3].map(|()| random::uniform(rng, 0.0, TAU)),
    };
    (!shape.is_flat()).then_some(shape)
}

#[cfg(test)]
mod tests {
    use crate::{
        Grasp,
        scene::{BUILT_IN, Scene, load},
        surface::Surface,
    };
    use slip_core::sample::Sample;

    const OBJECT: &str = "name = \"x\"\nmass_kg = 0.4\nfriction = 0.3\nfriction_ratio = 1.0\nroughness_ra_um = 1.6\n";
    const WAVY: &str = "[waviness]\namplitude_um = { uniform = [5.0, 10.0] }\nwavelength_mm = 2.0\n[form]\ntilt_um_mm = 1.0\n";

    #[test]
    fn the_built_in_scenes_have_the_surfaces_they_had() {
        for (name, _) in BUILT_IN {
            let scene = load(name).unwrap();
            let object = scene.object();
            let mut plain = Surface::new(object.ra_m, object.rsm_m, scene.config().seed);
            let mut surface = scene.surface();
            for i in 0..1000 {
                let x = f64::from(i) * 13e-6;
                assert_eq!(surface.height(x).to_bits(), plain.height(x).to_bits(), "{name} {x}");
            }
        }
    }

    /// Half a second under a force that lets the object slip.
    fn samples(text: &str) -> Vec<Sample> {
        let scene = Scene::from_toml(&format!("{OBJECT}lift_at_s = 0.1\n{text}")).unwrap();
        let mut grasp = Grasp::new(&scene);
        (0..5000).map(|_| grasp.step_sample(6.3)).collect()
    }

    #[test]
    fn waviness_and_form_move_the_stylus_and_nothing_else() {
        let plain = samples("");
        assert_eq!(plain, samples("[waviness]\namplitude_um = 0.0\n[form]\ntilt_um_mm = 0.0\n"));
        let wavy = samples(WAVY);
        let without = |sample: &Sample| Sample { stylus: 0.0, ..*sample };
        let travel_m = f64::from(plain[4999].travel_m.unwrap());
        assert!(travel_m > 2e-3, "it slips: {travel_m}");
        assert!(plain.iter().zip(&wavy).all(|(a, b)| without(a) == without(b)));
        let apart = |(a, b): (&Sample, &Sample)| (a.stylus - b.stylus).abs();
        let most = plain.iter().zip(&wavy).map(apart).fold(0.0, f32::max);
        assert!((5e-6..60e-6).contains(&most), "{most}");
    }

    #[test]
    fn every_seed_draws_another_waviness_on_the_same_object_as_without() {
        let wavy = Scene::from_toml(&format!("{OBJECT}{WAVY}")).unwrap();
        let plain = Scene::from_toml(OBJECT).unwrap();
        assert_eq!(wavy.object(), plain.object());
        let shape = |seed| wavy.reseeded(seed).unwrap().shape.unwrap();
        assert_eq!(shape(1), shape(1));
        let (one, two) = (shape(1), shape(2));
        assert!(one.amplitude_m != two.amplitude_m && one.phases != two.phases, "{one:?} {two:?}");
        assert!(plain.shape.is_none());
    }
}
