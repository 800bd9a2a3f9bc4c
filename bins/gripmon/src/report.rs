//! A page about a recording, without a window.

use crate::cli::SourceError;
use anyhow::{Context as _, bail};
use grip_scope::{Model, SourceSpec, SourceStatus, export, report, source};
use std::path::Path;

/// Reads the recording and writes the page.
///
/// # Errors
/// Where the source is no recording or cannot be read, or the page cannot be written.
pub fn run(spec: SourceSpec, memory_bytes: usize, file: &Path) -> anyhow::Result<()> {
    let SourceSpec::Recording(recording) = &spec else {
        return Err(SourceError::Report(spec).into());
    };
    let name =
        recording.file_name().unwrap_or(recording.as_os_str()).to_string_lossy().into_owned();
    let model = source::load(recording, Model::new(memory_bytes));
    if let SourceStatus::Failed { sentence } = model.status() {
        bail!("{sentence}");
    }
    let span = model.span().with_context(|| format!("{name}: has no samples"))?;
    let written = export::html(report::grasp(&model, span, &name).as_ref(), file);
    written.map(|_| ()).map_err(|error| anyhow::Error::msg(error.about(file)))
}

#[cfg(test)]
mod tests {
    use super::run;
    use grip_scope::SourceSpec;
    use std::fs;

    const MEMORY: usize = 16_000_000;

    #[test]
    fn a_recording_becomes_a_page_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let (table, page) = (folder.path().join("run.csv"), folder.path().join("run.html"));
        let rows: String =
            (0..500).map(|i| format!("{},{}\n", f64::from(i) * 1e-3, i % 7)).collect();
        fs::write(&table, format!("t_s,stylus\n{rows}")).unwrap();
        run(SourceSpec::Recording(table.clone()), MEMORY, &page).unwrap();
        let text = fs::read_to_string(&page).unwrap();
        assert!(text.contains("<h1>Grasp: run.csv</h1>") && text.contains(">500<"), "{text}");
        let error = |spec| run(spec, MEMORY, &page).unwrap_err().to_string();
        let there = error(SourceSpec::Recording(table));
        assert!(there.contains("is there already"), "{there}");
        assert_eq!(fs::read_to_string(&page).unwrap(), text);
        let missing = error(SourceSpec::Recording(folder.path().join("none.csv")));
        assert!(missing.contains("none.csv"), "{missing}");
        let live = error(SourceSpec::parse("demo").unwrap());
        assert!(live.starts_with("--report is for a recording"), "{live}");
    }
}
