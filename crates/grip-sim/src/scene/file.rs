//! Reader of a scene by its name or that of its file: the scene, or what is wrong with it and where.

use super::{Scene, SceneError, load};
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
    /// There is no such scene, or its file cannot be read.
    #[error(transparent)]
    Absent(SceneError),
    /// Not TOML, an unknown key, or a value of the wrong type.
    #[error("{name}: {source}")]
    Parse {
        /// The file.
        name: String,
        /// Line, column, and what is wrong there.
        source: SceneError,
    },
    /// A value that cannot be.
    #[error("{name}:{line}:{column}: {source}")]
    Value {
        /// The file.
        name: String,
        /// Line of the value, from 1; 0 where it does not stand in the file.
        line: usize,
        /// Column of the value, from 1; 0 where it does not stand in the file.
        column: usize,
        /// The value and its range.
        source: SceneError,
    },
}

/// The built-in scene `name`, or the one in the file `name` where it ends in `.toml`.
///
/// # Errors
/// Where there is no such scene, or its file does not describe one.
pub fn open(name: &str) -> Result<Scene, SceneFileError> {
    load(name).map_err(|source| {
        let field = match &source {
            SceneError::OutOfRange { field, .. } | SceneError::BoundsSwapped { field, .. } => field,
            SceneError::TwoCrushLimits => "crush_ratio",
            SceneError::Parse(_) => return SceneFileError::Parse { name: name.to_owned(), source },
            SceneError::Unknown { .. } | SceneError::Read { .. } | SceneError::Part { .. } => {
                return SceneFileError::Absent(source);
            }
        };
        // The file has been read a moment ago; where it has gone since, the value is named without its place.
        let text = std::fs::read_to_string(Path::new(name)).unwrap_or_default();
        let (line, column) = place(&text, field).unwrap_or((0, 0));
        SceneFileError::Value { name: name.to_owned(), line, column, source }
    })
}

/// Line and column, from 1, of the key `path` in `text`, or of the last table on the way to it.
fn place(text: &str, path: &str) -> Option<(usize, usize)> {
    let root = DeTable::parse(text).ok()?;
    let mut table = root.get_ref();
    let mut at = None;
    for name in path.split('.') {
        let found = table.iter().find(|(key, _)| key.get_ref().as_ref() == name);
        let Some((key, value)) = found else { break };
        at = Some(key.span().start);
        let DeValue::Table(inner) = value.get_ref() else { break };
        table = inner;
    }
    let before = text.get(..at?)?;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    Some((before.matches('\n').count() + 1, column))
}

#[cfg(test)]
mod tests {
    use super::open;

    fn refusal(text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.toml");
        std::fs::write(&file, text).unwrap();
        let name = file.display().to_string();
        open(&name).unwrap_err().to_string().replace(&name, "s.toml")
    }

    #[test]
    fn a_value_out_of_range_is_found_in_the_file() {
        assert_eq!(
            refusal("name = \"x\"\n\n[drive]\nlag_ms = -1.0\n"),
            "s.toml:4:1: drive.lag_ms = -1 is outside 0.1 to 200"
        );
        let text = refusal("name = \"x\"\nfriction = { uniform = [0.5, 0.2] }\n");
        assert!(text.starts_with("s.toml:2:1: friction: lower bound 0.5"), "{text}");
        let text = refusal("name = \"x\"\ncrush_n = 5.0\ncrush_ratio = 2.0\n");
        assert!(text.starts_with("s.toml:3:1: crush_n and crush_ratio"), "{text}");
    }

    #[test]
    fn an_unknown_key_is_named_once() {
        let text = refusal("name = \"x\"\nmas = 1\n");
        assert!(
            text.starts_with("s.toml: scene does not parse: TOML parse error at line 2"),
            "{text}"
        );
        assert_eq!(text.matches("line 2").count(), 1, "{text}");
        assert!(open("default").is_ok());
        assert!(open("nope").unwrap_err().to_string().contains("built in are default"));
    }
}
