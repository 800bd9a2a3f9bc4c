//! Path at which cargo has built a program, by the program's name.
//!
//! Cargo shows only a package's own tests where its program stands. What lies beside this test may be older than its sources: `cargo test -p stories`
//! does not build it, and a build that failed leaves the last one there. So cargo is asked, once for each story file: it looks at every source,
//! builds what is not of today, and states where the programs are. Under `cargo test --workspace` nothing is left to build.

use serde_json::Value;
use std::{
    collections::BTreeMap,
    env,
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
};

/// Which packages and features the programs are built with, where not those of `cargo test --workspace`: another choice compiles most of the
/// workspace again.
const SELECTION: &str = "STORIES_BUILD";

/// A call of cargo that builds programs.
#[derive(Debug)]
pub struct Build {
    /// Where cargo runs.
    pub folder: PathBuf,
    /// What it is given.
    pub arguments: Vec<String>,
}

impl Build {
    /// The programs that belong to these tests, as the whole workspace is tested, in the target folder and the profile of this test.
    #[must_use]
    pub fn beside_tests(names: &[&str]) -> Self {
        let selection = env::var(SELECTION).unwrap_or_else(|_| "--workspace".to_owned());
        let test = env::current_exe().unwrap();
        let built = test.parent().and_then(Path::parent).unwrap();
        let profile = built.file_name().unwrap().to_str().unwrap();
        let mut arguments = ["test", "--no-run", "--locked"].map(str::to_owned).to_vec();
        arguments.extend(names.iter().flat_map(|name| ["--test".to_owned(), (*name).to_owned()]));
        arguments.extend(selection.split_whitespace().map(str::to_owned));
        arguments
            .extend(["--target-dir".to_owned(), built.parent().unwrap().display().to_string()]);
        if profile != "debug" {
            arguments.extend(["--profile".to_owned(), profile.to_owned()]);
        }
        Self { folder: env!("CARGO_MANIFEST_DIR").into(), arguments }
    }

    /// Builds, and states where each program is.
    ///
    /// # Errors
    /// What cargo said against it. A program of an earlier build may still be there, and nobody runs it.
    pub fn programs(&self) -> Result<BTreeMap<String, PathBuf>, String> {
        let cargo = env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into());
        let mut command = Command::new(cargo);
        command.args(&self.arguments).args(["--quiet", "--message-format=json-render-diagnostics"]);
        forget_this_package(&mut command);
        let output = command.current_dir(&self.folder).output();
        let output = output.map_err(|error| format!("cargo does not start: {error}"))?;
        if !output.status.success() {
            let stated = String::from_utf8_lossy(&output.stderr);
            return Err(format!("`cargo {}` failed: {stated}", self.arguments.join(" ")));
        }
        Ok(programs(&String::from_utf8_lossy(&output.stdout)))
    }
}

/// Takes away what cargo has set for this test about its own package: build scripts that look at such variables would run again, and with them
/// all that depends on them.
fn forget_this_package(command: &mut Command) {
    let reported = ["CARGO_PKG_", "CARGO_MANIFEST_", "CARGO_CRATE_", "CARGO_BIN_", "OUT_DIR"];
    for (name, _) in env::vars_os() {
        if reported.iter().any(|start| name.to_string_lossy().starts_with(start)) {
            command.env_remove(name);
        }
    }
}

/// The programs in cargo's messages.
fn programs(messages: &str) -> BTreeMap<String, PathBuf> {
    let messages = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    messages
        .filter(|message| message["reason"] == "compiler-artifact")
        .filter(|message| message["target"]["kind"] == Value::from(vec!["bin"]))
        .filter_map(|message| {
            let name = message["target"]["name"].as_str()?;
            Some((name.to_owned(), message["executable"].as_str()?.into()))
        })
        .collect()
}

/// The programs, and the tests of their packages with which cargo builds them.
const PROGRAMS: [(&str, &str); 2] = [("gripd", "daemon"), ("gripctl", "cli")];

/// Where the program of that name is, built from the sources as they are.
///
/// # Panics
/// Where it cannot be built.
pub(crate) fn program(name: &str) -> &'static Path {
    static BUILT: [OnceLock<Result<BTreeMap<String, PathBuf>, String>>; 2] =
        [const { OnceLock::new() }; 2];
    let known = PROGRAMS.iter().zip(&BUILT).find(|((known, _), _)| *known == name);
    let ((_, test), built) = known.unwrap_or_else(|| panic!("{name} is no program of ours"));
    let programs = built.get_or_init(|| Build::beside_tests(&[test]).programs());
    let programs = programs.as_ref().unwrap_or_else(|why| panic!("{why}"));
    programs.get(name).unwrap_or_else(|| panic!("cargo has built {programs:?}, but no {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// What the program prints that cargo gives.
    fn stated(build: &Build) -> Result<String, String> {
        let programs = build.programs()?;
        let output = Command::new(&programs["told"]).output().unwrap();
        Ok(String::from_utf8(output.stdout).unwrap())
    }

    #[test]
    fn a_stale_program_is_built_anew_or_an_error() {
        let folder = tempfile::tempdir().unwrap();
        // A path that a list of files would have to escape.
        let package = folder.path().join("a package");
        let source = package.join("src/main.rs");
        fs::create_dir_all(source.parent().unwrap()).unwrap();
        let manifest = "[package]\nname = \"told\"\nedition = \"2024\"\n[workspace]\n";
        fs::write(package.join("Cargo.toml"), manifest).unwrap();
        let arguments =
            ["build", "--offline", "--target-dir", "target"].map(str::to_owned).to_vec();
        let build = Build { folder: package.clone(), arguments };
        for text in ["one", "two"] {
            fs::write(&source, format!("fn main() {{ print!({text:?}) }}")).unwrap();
            assert_eq!(stated(&build).as_deref(), Ok(text));
        }
        fs::write(&source, "fn main() { no_such_function() }").unwrap();
        let why = stated(&build).unwrap_err();
        assert!(why.contains("`cargo build") && why.contains("no_such_function"), "{why}");
        assert!(package.join("target/debug/told").exists(), "the old one is there");
        fs::remove_file(&source).unwrap();
        assert!(stated(&build).is_err());
    }

    #[test]
    fn only_programs_are_taken_from_what_cargo_states() {
        let messages = [
            r#"{"reason":"compiler-artifact","target":{"kind":["lib"],"name":"a"},"executable":null}"#,
            r#"{"reason":"compiler-artifact","target":{"kind":["test"],"name":"b"},"executable":"/x y/b"}"#,
            r#"{"reason":"compiler-artifact","target":{"kind":["bin"],"name":"c"},"executable":"/x y/c"}"#,
            r#"{"reason":"build-finished","success":true}"#,
            "no message",
        ];
        let found = programs(&messages.join("\n"));
        assert_eq!(found.into_iter().collect::<Vec<_>>(), [("c".to_owned(), "/x y/c".into())]);
    }
}
