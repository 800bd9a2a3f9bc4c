//! Names of gripper and object for a row, from what a recording, its folders and its labels state of them.

use grip_record::Label;
use grip_session::recording::{ABOUT, CONFIG_NAME, OBJECT};
use std::{
    collections::BTreeMap,
    path::{Component, Path},
};

/// Where a name is not known.
pub const UNKNOWN: &str = "unknown";
/// How the name of a folder begins that states what was held.
const OBJECT_FOLDER: &str = "object=";

/// Where a recording was made, as far as it is known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Origin {
    pub(super) site: Option<String>,
    pub(super) gripper: Option<String>,
    pub(super) object: Option<String>,
}

impl Origin {
    /// What the path shows: `SITE/UID/NAME`, with 32 hexadecimal digits as UID, and a folder `object=NAME` anywhere.
    pub(super) fn of_path(file: &Path) -> Self {
        let mut origin = Self::default();
        let mut before: Option<&str> = None;
        let parent = file.parent().unwrap_or_else(|| Path::new(""));
        for component in parent.components() {
            let Component::Normal(name) = component else { continue };
            let name = name.to_str();
            if let Some(object) = name.and_then(|name| name.strip_prefix(OBJECT_FOLDER)) {
                origin.object = Some(object.to_owned()).filter(|object| !object.is_empty());
                continue;
            }
            if let Some(uid) = name.filter(|name| is_uid(name)) {
                origin.gripper = Some(uid.to_ascii_lowercase());
                origin.site = before.map(str::to_owned);
            }
            before = name;
        }
        origin
    }

    /// What the labels of its folder state: the material.
    pub(super) fn label(&mut self, file: &Path, labels: &[Label]) {
        let stem = file.file_stem().and_then(|stem| stem.to_str());
        let label = labels.iter().find(|label| Some(label.recording.as_str()) == stem);
        if let Some(label) = label.filter(|label| !label.material.is_empty()) {
            self.object = Some(label.material.clone());
        }
    }

    /// What the recording itself states goes before everything else.
    pub(super) fn metadata(&mut self, name: &str, values: &BTreeMap<String, String>) {
        let known = |key: &str| values.get(key).filter(|value| !value.is_empty()).cloned();
        match name {
            ABOUT => self.object = known(OBJECT).or(self.object.take()),
            "gripper" => self.gripper = known("uid").or(self.gripper.take()),
            _ => {}
        }
    }

    /// So does its configuration. One that cannot be read, or names no site, shows nothing.
    pub(super) fn attachment(&mut self, name: &str, data: &[u8]) {
        if name != CONFIG_NAME {
            return;
        }
        let table =
            core::str::from_utf8(data).ok().and_then(|text| text.parse::<toml::Table>().ok());
        let fleet = table.as_ref().and_then(|table| table.get("fleet"));
        if let Some(site) = fleet.and_then(|fleet| fleet.get("site")?.as_str()) {
            self.site = Some(site.to_owned());
        }
    }
}

fn is_uid(name: &str) -> bool {
    name.len() == 32 && name.bytes().all(|byte| byte.is_ascii_hexdigit())
}

#[cfg(test)]
mod tests {
    use super::Origin;
    use std::{collections::BTreeMap, path::Path};

    #[test]
    fn what_is_nearer_to_the_recording_is_believed() {
        let uid = "07070707070707070707070707070707";
        let path = format!("all/hall/{uid}/object=mug/run.mcap");
        let mut origin = Origin::of_path(Path::new(&path));
        let text = |text: &str| Some(text.to_owned());
        let of_path = Origin { site: text("hall"), gripper: text(uid), object: text("mug") };
        assert_eq!(origin, of_path);
        origin.attachment("gripd.toml", b"[fleet]\nsite = \"yard\"\n");
        origin.attachment("gripd.toml", b"no toml");
        let values = |key: &str, value: &str| BTreeMap::from([(key.to_owned(), value.to_owned())]);
        origin.metadata("recording", &values("object", "jar"));
        origin.metadata("recording", &values("object", ""));
        origin.metadata("gripper", &values("uid", "08"));
        assert_eq!(origin, Origin { site: text("yard"), gripper: text("08"), object: text("jar") });
        assert_eq!(Origin::of_path(Path::new("run.mcap")), Origin::default());
        assert_eq!(Origin::of_path(Path::new("object=/07/run.mcap")), Origin::default());
    }
}
