//! Built-in scenes and scene files, by name or path.

use super::{Scene, SceneError};
use std::{borrow::Cow, path::Path};

/// Name and TOML text of the scenes that need no file.
pub const BUILT_IN: [(&str, &str); 18] = [
    ("default", include_str!("../../../../scenes/default.toml")),
    ("heavy_smooth", include_str!("../../../../scenes/heavy_smooth.toml")),
    ("light_rough", include_str!("../../../../scenes/light_rough.toml")),
    ("moving", include_str!("../../../../scenes/moving.toml")),
    ("shaken", include_str!("../../../../scenes/shaken.toml")),
    ("raw_egg", include_str!("../../../../scenes/raw_egg.toml")),
    ("light_bulb", include_str!("../../../../scenes/light_bulb.toml")),
    ("glass_bottle_full", include_str!("../../../../scenes/glass_bottle_full.toml")),
    ("glass_bottle_empty", include_str!("../../../../scenes/glass_bottle_empty.toml")),
    ("paper_cup", include_str!("../../../../scenes/paper_cup.toml")),
    ("oily_steel", include_str!("../../../../scenes/oily_steel.toml")),
    ("brick", include_str!("../../../../scenes/brick.toml")),
    ("foam", include_str!("../../../../scenes/foam.toml")),
    ("moving_arm", include_str!("../../../../scenes/moving_arm.toml")),
    ("bump", include_str!("../../../../scenes/bump.toml")),
    ("tug", include_str!("../../../../scenes/tug.toml")),
    ("wet", include_str!("../../../../scenes/wet.toml")),
    ("heavy_tail", include_str!("../../../../scenes/heavy_tail.toml")),
];

/// The built-in scene `name`, or the one in the file `name` where it ends in `.toml`.
///
/// # Errors
/// [`SceneError::Unknown`] or [`SceneError::Read`] where there is none, and those of [`Scene::from_toml`].
pub fn load(name: &str) -> Result<Scene, SceneError> {
    Scene::from_toml(&text("scene", &BUILT_IN, name)?)
}

/// The text of the `what` that is called `name` among the `known` ones, or stands in the file `name`.
pub(super) fn text(
    what: &'static str,
    known: &[(&str, &'static str)],
    name: &str,
) -> Result<Cow<'static, str>, SceneError> {
    if let Some((_, text)) = known.iter().find(|(known, _)| *known == name) {
        return Ok(Cow::Borrowed(text));
    }
    let path = Path::new(name);
    if path.extension().is_none_or(|extension| extension != "toml") {
        let known = known.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", ");
        return Err(SceneError::Unknown { what, name: name.to_owned(), known });
    }
    let text =
        read(path).map_err(|source| SceneError::Read { what, path: path.to_owned(), source });
    text.map(Cow::Owned)
}

/// Most bytes of a scene file.
const MOST_BYTES: u64 = 1 << 20;

fn read(path: &Path) -> std::io::Result<String> {
    // Asked before opening: to open a FIFO waits for its writer, and a device never ends.
    let about = std::fs::metadata(path)?;
    if !about.is_file() || about.len() > MOST_BYTES {
        let text = format!("it is no regular file of at most {MOST_BYTES} bytes");
        return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, text));
    }
    std::fs::read_to_string(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneConfig;

    #[test]
    fn built_in_scenes_are_valid_and_named_as_their_key() {
        for (name, _) in BUILT_IN {
            assert_eq!(load(name).unwrap().config().name, name);
        }
    }

    #[test]
    fn the_default_file_states_what_the_defaults_are() {
        let bare = SceneConfig::from_toml("name = \"default\"\n").unwrap();
        let mut file = load("default").unwrap().config().clone();
        assert_eq!(file.crush_ratio, Some(crate::scene::Draw::Fixed(2.5)));
        file.crush_ratio = None;
        assert_eq!(file, bare);
    }

    #[test]
    fn default_objects_can_be_held_without_crushing() {
        let scene = load("default").unwrap();
        let mut largest: f64 = 0.0;
        for seed in 0..500 {
            let object = scene.reseeded(seed).unwrap().object();
            largest = largest.max(object.force_needed_n());
            assert!(object.crush_n >= 2.0 * object.force_needed_n());
        }
        assert!((15.0..25.0).contains(&largest), "{largest}");
    }

    #[test]
    fn what_an_object_needs_over_its_hold_is_mostly_well_below_what_crushes_it() {
        for (name, _) in BUILT_IN {
            let scene = load(name).unwrap();
            let (mut needed, mut crush, mut roomy) = (Vec::new(), Vec::new(), 0);
            for seed in 0..400 {
                let scene = scene.reseeded(seed).unwrap();
                let (needed_n, object) = (scene.force_needed_n(2.5), scene.object());
                assert!(needed_n >= object.force_needed_n(), "{name} {needed_n}");
                roomy += i32::from(
                    needed_n <= 0.7 * object.crush_n
                        && 1.2 * needed_n <= scene.config().drive.force_max_n,
                );
                needed.push(needed_n);
                crush.push(object.crush_n);
            }
            needed.sort_by(f64::total_cmp);
            crush.sort_by(f64::total_cmp);
            println!(
                "| {name} | {:.2} - {:.2} | {:.1} - {:.1} | {:.1} % |",
                needed[20],
                needed[380],
                crush[20],
                crush[380],
                f64::from(roomy) / 4.0
            );
            assert!(roomy >= 380, "{name}: {roomy} of 400");
        }
    }

    #[test]
    fn every_built_in_scene_stands_in_the_page_about_scenes() {
        let page = include_str!("../../../../docs/scenes.md");
        for (name, _) in BUILT_IN {
            assert!(page.contains(&format!("| `{name}` |")), "{name} is missing");
        }
    }

    #[test]
    fn missing_scenes_say_what_there_is() {
        assert!(load("defualt").unwrap_err().to_string().contains("heavy_smooth"));
        assert!(matches!(load("no/such/file.toml"), Err(SceneError::Read { .. })));
    }
}
