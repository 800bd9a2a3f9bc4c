//! Merge of files and flags from the lowest to the highest: one configuration, and where each of its values stands.
//!
//! Flags win over the environment, that over `./gripd.toml`, the user's and `/etc/gripd/gripd.toml`; each layer replaces single
//! keys of the ones below it. Tables are merged, everything else (arrays too) is replaced as a whole. Each file is read and checked
//! for unknown keys and types by itself, so a mistake is reported in the file where it stands, also where a higher layer hides it.

mod tree;

#[cfg(test)]
mod tests;

use super::{
    HostConfig,
    error::{HostConfigError, Place, ValueError, line_and_column},
};
use crate::model::built_in;
use grip_record::files;
use serde::Deserialize as _;
use std::{
    io,
    path::{Path, PathBuf},
};
use toml::{Spanned, de::DeTable};
use tree::{leaves, merge};

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

/// Everything that has a part, the lowest first.
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
    /// What `/etc/gripd/gripd.toml`, `gripd/gripd.toml` in `user_directory` and `./gripd.toml` state, as far as they exist.
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

    /// Only what `file` states; without one, what [`Layers::search`] finds for the user of this program.
    ///
    /// # Errors
    /// As these.
    pub fn of_user(file: Option<&Path>) -> Result<Self, HostConfigError> {
        let folder = |name| std::env::var_os(name).filter(|folder| !folder.is_empty());
        let user = folder("XDG_CONFIG_HOME").map(PathBuf::from);
        let user = user.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".config")));
        file.map_or_else(|| Self::search(user.as_deref()), Self::file)
    }

    /// Only what `file` states.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn file(file: &Path) -> Result<Self, HostConfigError> {
        let mut layers = Self::default();
        layers.read(file)?;
        Ok(layers)
    }

    /// Puts what `file` states on top.
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
        config.model = config.model.map(|file| match built_in(&file) {
            Some(_) => file,
            None => self.beside("model", file),
        });
        config.calibration = config.calibration.map(|file| self.beside("calibration", file));
        let fleet = &mut config.fleet;
        fleet.network = fleet.network.take().map(|file| self.beside("fleet.network", file));
        fleet.spool = fleet.spool.take().map(|folder| self.beside("fleet.spool", folder));
        fleet.models = fleet.models.take().map(|folder| self.beside("fleet.models", folder));
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

    /// A relative path is meant from the folder of the file that states it.
    fn beside(&self, key: &str, path: PathBuf) -> PathBuf {
        let names = key.split('.').count();
        let states = self.layers.iter().rev().find(|layer| layer.depth(key).0 == names);
        match states.map(|layer| &layer.source) {
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

    /// How many names of a dotted key are set here, and where the last of them stands.
    fn depth(&self, key: &str) -> (usize, Option<usize>) {
        DeTable::parse(&self.text).map_or((0, None), |root| tree::depth(root.get_ref(), key))
    }
}

/// The text of a file; `what` it is, for the message.
pub(super) fn read(file: &Path, what: &'static str) -> Result<String, HostConfigError> {
    let calibration = what == "calibration";
    let most = if calibration { files::MOST_CALIBRATION } else { files::MOST_CONFIG };
    files::read_text(file, most).map_err(|source| HostConfigError::Read {
        file: file.to_owned(),
        what,
        source,
    })
}

fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}
