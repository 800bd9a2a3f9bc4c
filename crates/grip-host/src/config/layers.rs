//! Files and flags from the lowest to the highest in; one configuration, and where each of its values stands, out.
//!
//! Flags win over the environment, that over `./gripd.toml`, the user's and `/etc/gripd/gripd.toml`; each layer replaces single
//! keys of the ones below it. Tables are merged, everything else (arrays too) is replaced as a whole. Each file is read and checked
//! for unknown keys and types by itself, so a mistake is told in the file where it stands, also where a higher layer hides it.

use super::{
    HostConfig,
    error::{HostConfigError, Place, ValueError, line_and_column},
};
use serde::Deserialize as _;
use std::{
    io,
    path::{Path, PathBuf},
};
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// The system's file.
const SYSTEM: &str = "/etc/gripd/gripd.toml";

/// What is said from one place.
#[derive(Clone, Debug)]
struct Layer {
    source: Source,
    text: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Source {
    File(PathBuf),
    /// A flag or a variable of the environment, by name.
    Given(String),
}

/// Everything that has a say, the lowest first.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    layers: Vec<Layer>,
}

/// A value that is set somewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Its name, dotted.
    pub key: String,
    /// As TOML.
    pub value: String,
    /// Where the value in force stands.
    pub place: Place,
    /// Where values stand that it replaces, the highest first.
    pub replaces: Vec<Place>,
}

impl Layers {
    /// What `/etc/gripd/gripd.toml`, `gripd/gripd.toml` in `user_directory` and `./gripd.toml` say, as far as they exist.
    ///
    /// # Errors
    /// Where one exists and cannot be read.
    pub fn search(user_directory: Option<&Path>) -> Result<Self, HostConfigError> {
        let user = user_directory.map(|directory| directory.join("gripd/gripd.toml"));
        let files = [Some(PathBuf::from(SYSTEM)), user, Some(PathBuf::from("gripd.toml"))];
        let mut layers = Self::default();
        for file in files.into_iter().flatten() {
            match layers.read(&file) {
                Err(HostConfigError::Read { source, .. }) if is_absent(&source) => {}
                read => read?,
            }
        }
        Ok(layers)
    }

    /// Only what `file` says.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn file(file: &Path) -> Result<Self, HostConfigError> {
        let mut layers = Self::default();
        layers.read(file)?;
        Ok(layers)
    }

    /// Puts what `file` says on top.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn read(&mut self, file: &Path) -> Result<(), HostConfigError> {
        let text = read(file, "configuration")?;
        self.push(file, &text);
        Ok(())
    }

    /// Puts the text of a file on top.
    pub fn push(&mut self, file: &Path, text: &str) {
        self.layers.push(Layer { source: Source::File(file.to_owned()), text: text.to_owned() });
    }

    /// Puts one value on top: `key` is dotted, `from` names the flag or the variable that gave it.
    pub fn set(&mut self, from: &str, key: &str, value: impl Into<toml::Value>) {
        let mut names = key.rsplit('.');
        let mut table = toml::Table::new();
        if let Some(last) = names.next() {
            table.insert(last.to_owned(), value.into());
        }
        for name in names {
            table = toml::Table::from_iter([(name.to_owned(), toml::Value::Table(table))]);
        }
        self.layers.push(Layer { source: Source::Given(from.to_owned()), text: table.to_string() });
    }

    /// The files that were read, the lowest first.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.layers.iter().filter_map(|layer| match &layer.source {
            Source::File(file) => Some(file.as_path()),
            Source::Given(_) => None,
        })
    }

    /// One configuration of all layers, checked, with its calibration.
    ///
    /// # Errors
    /// [`HostConfigError`] with the place of the mistake.
    pub fn resolve(&self) -> Result<HostConfig, HostConfigError> {
        let mut config = self.merged()?;
        config.model = config.model.map(|file| self.beside("model", file));
        config.calibration = config.calibration.map(|file| self.beside("calibration", file));
        config.check().map_err(|(key, source)| self.blame(key, source))?;
        match config.calibration.clone() {
            Some(file) => config.with_calibration(&file),
            None => Ok(config),
        }
    }

    /// Every value that is set, in the order of its name.
    ///
    /// # Errors
    /// As [`Layers::resolve`].
    pub fn settings(&self) -> Result<Vec<Setting>, HostConfigError> {
        let mut settings: Vec<Setting> = Vec::new();
        for layer in &self.layers {
            let table = layer.parse()?;
            for (key, byte, value) in leaves(&table) {
                let place = layer.place(Some(byte));
                match settings.iter_mut().find(|setting| setting.key == key) {
                    Some(setting) => {
                        let below = core::mem::replace(&mut setting.place, place);
                        setting.replaces.insert(0, below);
                        setting.value = value;
                    }
                    None => settings.push(Setting { key, value, place, replaces: Vec::new() }),
                }
            }
        }
        settings.sort_by(|a, b| a.key.cmp(&b.key));
        Ok(settings)
    }

    fn merged(&self) -> Result<HostConfig, HostConfigError> {
        let defaults = toml::Table::try_from(HostConfig::default())
            .map(|table| table.to_string())
            .unwrap_or_default();
        let base = Layer { source: Source::Given("the defaults".to_owned()), text: defaults };
        let base = base.parse()?;
        let mut all = base.clone();
        for layer in &self.layers {
            let table = layer.parse()?;
            // By itself first: what a higher layer hides must be right too.
            let mut alone = base.clone();
            merge(alone.get_mut(), table.get_ref());
            layer.read_as_config(alone)?;
            merge(all.get_mut(), table.get_ref());
        }
        match self.layers.last() {
            Some(top) => top.read_as_config(all),
            None => Ok(HostConfig::default()),
        }
    }

    /// A relative path is meant from the folder of the file that says it.
    fn beside(&self, key: &str, path: PathBuf) -> PathBuf {
        let says = self.layers.iter().rev().find(|layer| layer.depth(key).0 == 1);
        match says.map(|layer| &layer.source) {
            Some(Source::File(file)) => file.with_file_name(path),
            _ => path,
        }
    }

    /// The place of the value in force; of its innermost table that is set, where the value itself is a default.
    fn blame(&self, key: &str, source: ValueError) -> HostConfigError {
        let wanted = key.split('.').count();
        let mut found: Option<(usize, Place)> = None;
        for layer in self.layers.iter().rev() {
            let (depth, byte) = layer.depth(key);
            if depth > found.as_ref().map_or(0, |(deepest, _)| *deepest) {
                found = Some((depth, layer.place(byte)));
            }
        }
        let nowhere = || (0, Place { source: "configuration".to_owned(), at: None });
        let (depth, place) = found.unwrap_or_else(nowhere);
        HostConfigError::Value { place, inherited: depth < wanted, source }
    }
}

impl Layer {
    fn parse(&self) -> Result<Spanned<DeTable<'_>>, HostConfigError> {
        DeTable::parse(&self.text).map_err(|error| self.fault(&error))
    }

    fn fault(&self, error: &toml::de::Error) -> HostConfigError {
        match &self.source {
            Source::File(file) => {
                HostConfigError::of_toml(&file.display().to_string(), &self.text, error)
            }
            Source::Given(name) => HostConfigError::Parse {
                place: Place { source: name.clone(), at: None },
                message: error.message().to_owned(),
                excerpt: String::new(),
            },
        }
    }

    fn read_as_config(&self, table: Spanned<DeTable<'_>>) -> Result<HostConfig, HostConfigError> {
        HostConfig::deserialize(toml::Deserializer::from(table)).map_err(|error| self.fault(&error))
    }

    fn place(&self, byte: Option<usize>) -> Place {
        match &self.source {
            Source::File(file) => Place {
                source: file.display().to_string(),
                at: byte.map(|byte| line_and_column(&self.text, byte)),
            },
            Source::Given(name) => Place { source: name.clone(), at: None },
        }
    }

    /// How many names of a dotted key are set here, and where the last of them stands. What lies in an array counts as set.
    fn depth(&self, key: &str) -> (usize, Option<usize>) {
        let Ok(root) = DeTable::parse(&self.text) else { return (0, None) };
        let names: Vec<&str> = key.split('.').collect();
        let mut table = root.get_ref();
        let mut at = None;
        for (depth, name) in names.iter().enumerate() {
            let Some((key, value)) = find(table, name) else { return (depth, at) };
            at = Some(key);
            let DeValue::Table(inner) = value else { return (names.len(), at) };
            table = inner;
        }
        (names.len(), at)
    }
}

/// The text of a file; `what` it is, for the message.
pub(super) fn read(file: &Path, what: &'static str) -> Result<String, HostConfigError> {
    std::fs::read_to_string(file).map_err(|source| HostConfigError::Read {
        file: file.to_owned(),
        what,
        source,
    })
}

fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

fn find<'a, 'i>(table: &'a DeTable<'i>, name: &str) -> Option<(usize, &'a DeValue<'i>)> {
    table
        .iter()
        .find(|(key, _)| key.get_ref().as_ref() == name)
        .map(|(key, value)| (key.span().start, value.get_ref()))
}

/// Puts `top` over `below`: tables key by key, everything else as a whole.
fn merge<'i>(below: &mut DeTable<'i>, top: &DeTable<'i>) {
    for (key, value) in top {
        let lower = below.get_mut(key);
        if let (DeValue::Table(top), Some(lower)) = (value.get_ref(), lower)
            && let DeValue::Table(lower) = lower.get_mut()
        {
            merge(lower, top);
            continue;
        }
        // The old key goes too: it bears the place of the layer below.
        below.remove(key);
        below.insert(key.clone(), value.clone());
    }
}

/// Each value that is no table: its dotted name, the byte of its key, and itself as TOML.
fn leaves(table: &Spanned<DeTable<'_>>) -> Vec<(String, usize, String)> {
    let mut leaves = Vec::new();
    let mut open = vec![(String::new(), table.get_ref())];
    while let Some((path, table)) = open.pop() {
        for (key, value) in table {
            let name = format!("{path}{}", key.get_ref());
            match value.get_ref() {
                DeValue::Table(inner) => open.push((format!("{name}."), inner)),
                value => leaves.push((name, key.span().start, shown(value))),
            }
        }
    }
    leaves
}

/// A value on one line.
fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(time) => time.to_string(),
        DeValue::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| shown(item.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        DeValue::Table(table) => {
            let items =
                table.iter().map(|(k, v)| format!("{} = {}", k.get_ref(), shown(v.get_ref())));
            format!("{{ {} }}", items.collect::<Vec<_>>().join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Layers;
    use std::path::Path;

    fn layers(texts: &[(&str, &str)]) -> Layers {
        let mut layers = Layers::default();
        texts.iter().for_each(|(file, text)| layers.push(Path::new(file), text));
        layers
    }

    fn error(texts: &[(&str, &str)]) -> String {
        layers(texts).resolve().unwrap_err().to_string()
    }

    #[test]
    fn each_layer_replaces_single_keys() {
        let mut layers = layers(&[
            (
                "etc.toml",
                "baud = 1\nmethods = [\"stylus\", \"travel\"]\n[grip]\nf_max_n = 10.0\ntrial_force_n = 1.0\n",
            ),
            ("user.toml", "methods = [\"pressure\"]\n[grip]\nf_max_n = 8.0\n"),
            ("gripd.toml", "detector.shear.threshold = 30.0\n"),
        ]);
        layers.set("--baud or GRIPD_BAUD", "baud", 9600);
        let config = layers.resolve().unwrap();
        assert_eq!((config.grip.f_max_n, config.grip.trial_force_n), (8.0, 1.0));
        assert_eq!(config.methods.len(), 1, "arrays are replaced");
        let default = super::HostConfig::default().detector.shear;
        assert_eq!(config.detector.shear.threshold, 30.0);
        assert_eq!(config.detector.shear.low_hz, default.low_hz, "tables are merged");
        assert_eq!(config.baud, Some(9600));
        let settings = layers.settings().unwrap();
        let told: Vec<String> = settings
            .iter()
            .map(|s| {
                format!(
                    "{} = {} {} {:?}",
                    s.key,
                    s.value,
                    s.place,
                    s.replaces.iter().map(ToString::to_string).collect::<Vec<_>>()
                )
            })
            .collect();
        assert_eq!(told[0], "baud = 9600 --baud or GRIPD_BAUD [\"etc.toml:1:1\"]");
        assert_eq!(told[1], "detector.shear.threshold = 30.0 gripd.toml:1:16 []");
        assert_eq!(told[2], "grip.f_max_n = 8.0 user.toml:3:1 [\"etc.toml:4:1\"]");
    }

    #[test]
    fn a_mistake_is_told_in_its_own_file_even_where_it_is_hidden() {
        let told = error(&[("etc.toml", "\nbaud = \"x\"\n"), ("gripd.toml", "baud = 5\n")]);
        assert!(
            told.starts_with("etc.toml:2:8: invalid type: string \"x\", expected u32\n2 | "),
            "{told}"
        );
        let told = error(&[("etc.toml", "baud = 5\n"), ("user.toml", "[grip]\nforce = 3\n")]);
        assert!(told.starts_with("user.toml:2:1: unknown field `force`"), "{told}");
    }

    #[test]
    fn a_range_names_the_place_of_the_value_in_force() {
        let etc = ("etc.toml", "[grip]\ntrial_force_n = 7.0\n");
        let told = error(&[etc, ("gripd.toml", "[grip]\nf_max_n = 5.0\n")]);
        assert_eq!(told, "etc.toml:2:1: grip.trial_force_n = 7 is outside 0.01 to 5");
        let told = error(&[("gripd.toml", "[grip]\nf_max_n = 1.0\n")]);
        assert_eq!(
            told,
            "gripd.toml:1:2: grip.trial_force_n = 2 is outside 0.01 to 1 (a default, which does not fit what is set)"
        );
        let mut layers = layers(&[etc]);
        layers.set("--baud or GRIPD_BAUD", "baud", 0);
        let told = layers.resolve().unwrap_err().to_string();
        assert_eq!(told, "--baud or GRIPD_BAUD: baud = 0 is outside 1 to 1000000000");
    }

    #[test]
    fn a_calibration_lies_beside_the_file_that_names_it() {
        let told = error(&[("etc/gripd.toml", "calibration = \"CAL.toml\"\n"), ("gripd.toml", "")]);
        assert!(told.starts_with("etc/CAL.toml: "), "{told}");
        let told = error(&[("etc/gripd.toml", "calibration = \"/none/CAL.toml\"\n")]);
        assert!(told.starts_with("/none/CAL.toml: "), "{told}");
    }
}
