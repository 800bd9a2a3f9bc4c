//! The command lines of gripd, gripctl, gripfleet and gripmon and the tables of the code in; man pages, shell completions
//! and the pages of the reference, in a folder, out.
//!
//! A program of its own, so that what is installed carries neither the generators nor a hidden command.

#[path = "../../../bins/gripctl/src/cli/mod.rs"]
#[expect(dead_code, reason = "of the command line only the names are wanted here")]
mod gripctl;
#[path = "../../../bins/gripd/src/cli.rs"]
mod gripd;
#[path = "../../../bins/gripfleet/src/cli.rs"]
mod gripfleet;
#[path = "../../../bins/gripmon/src/cli.rs"]
#[expect(dead_code, unreachable_pub, reason = "of the command line only the names are wanted here")]
mod gripmon;
mod reference;
mod spec;

use anyhow::Context as _;
use clap::{Command, CommandFactory as _, Parser};
use clap_complete::{
    generate_to,
    shells::{Bash, Fish, Zsh},
};
use core::fmt::Write as _;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Writes man pages, shell completions and the pages of the reference of gripd, gripctl, gripfleet and gripmon.
#[derive(Debug, Parser)]
#[command(name = "grip-manuals", version)]
struct Cli {
    /// Folder that gets `man`, `bash`, `zsh` and `fish`; made where it is absent. With --spec a file.
    out: PathBuf,
    /// The pages of the reference instead, in the folder itself.
    #[arg(long)]
    reference: bool,
    /// A copy of protocol/SPEC.md instead, with the tables of the code.
    #[arg(long, conflicts_with = "reference")]
    spec: bool,
}

fn main() -> anyhow::Result<()> {
    let cli = Cli::parse();
    if cli.spec {
        return fs::write(&cli.out, spec::spec()).with_context(|| cli.out.display().to_string());
    }
    if cli.reference {
        fs::create_dir_all(&cli.out).with_context(|| cli.out.display().to_string())?;
        return pages().into_iter().try_for_each(|(name, text)| {
            let page = cli.out.join(name).with_extension("md");
            fs::write(&page, text).with_context(|| page.display().to_string())
        });
    }
    commands().into_iter().try_for_each(|command| write_all(&cli.out, command))
}

/// gripctl, which has subcommands, stands last.
fn commands() -> [Command; 4] {
    let (gripd, gripfleet) = (gripd::Cli::command(), gripfleet::Cli::command());
    [gripd, gripfleet, gripmon::Cli::command(), gripctl::Cli::command()]
}

fn write_all(out: &Path, mut command: Command) -> anyhow::Result<()> {
    let folder = |name: &str| -> anyhow::Result<PathBuf> {
        let folder = out.join(name);
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        Ok(folder)
    };
    let name = command.get_name().to_owned();
    clap_mangen::generate_to(command.clone(), folder("man")?).context("man pages")?;
    generate_to(Bash, &mut command, &name, folder("bash")?).context("bash")?;
    generate_to(Zsh, &mut command, &name, folder("zsh")?).context("zsh")?;
    generate_to(Fish, &mut command, &name, folder("fish")?).context("fish")?;
    // The name under which bash looks for it.
    let bash = folder("bash")?;
    fs::rename(bash.join(format!("{name}.bash")), bash.join(&name)).context("bash")
}

/// Name and text of each page of the reference.
fn pages() -> Vec<(String, String)> {
    let programs = commands().map(|command| (command.get_name().to_owned(), help(command)));
    let tables = reference::pages().map(|(name, text)| (name.to_owned(), text));
    programs.into_iter().chain(tables).collect()
}

/// The page of a program: what `--help` prints of it and of each of its commands.
fn help(command: Command) -> String {
    let name = command.get_name();
    let mut page = format!(
        "# {name}\n\nWhat `--help` prints, with all features. `cargo run -p grip-manuals -- --reference docs/reference` writes this page.\n"
    );
    // What fits a page beside the contents, and no terminal decides it.
    let mut command = command.term_width(100).disable_help_subcommand(true);
    command.build();
    sections(command, &mut page);
    page
}

fn sections(command: Command, page: &mut String) {
    // Not what a variable is set to where the page is written.
    let mut command = command.mut_args(|argument| argument.hide_env_values(true));
    let help = command.render_long_help().to_string();
    let name = command.get_bin_name().unwrap_or_else(|| command.get_name());
    let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
    // Writing to a String cannot fail.
    let _ = write!(page, "\n## {name}\n\n```text\n{}\n```\n", lines.join("\n"));
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        sections(below.clone(), page);
    }
}

#[cfg(test)]
mod tests {
    use super::{commands, gripctl, pages, write_all};
    use clap::CommandFactory as _;
    use std::{fs::read_to_string, path::Path};

    #[test]
    fn the_reference_is_what_help_prints_and_the_tables_hold() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference");
        for (name, text) in pages() {
            let page = folder.join(name).with_extension("md");
            let written = read_to_string(&page).unwrap_or_default();
            assert!(
                written == text,
                "{} is of another version: cargo run -p grip-manuals -- --reference docs/reference",
                page.display()
            );
        }
    }

    #[test]
    fn every_flag_and_command_is_in_its_manual() {
        let folder = tempfile::tempdir().unwrap();
        for command in commands() {
            write_all(folder.path(), command).unwrap();
        }
        let read = |file: &str| read_to_string(folder.path().join(file)).unwrap();
        for command in &commands()[..3] {
            let name = command.get_name();
            let (manual, bash) = (read(&format!("man/{name}.1")), read(&format!("bash/{name}")));
            for argument in command.get_arguments() {
                let Some(long) = argument.get_long() else { continue };
                let there = manual.contains(&long.replace('-', "\\-"));
                assert!(there, "--{long} is not in the manual of {name}");
                assert!(bash.contains(&format!("--{long}")), "--{long} of {name} is not completed");
            }
        }
        for command in gripctl::Cli::command().get_subcommands() {
            let name = command.get_name();
            let page = read(&format!("man/gripctl-{name}.1"));
            assert!(page.contains(".SH SYNOPSIS"), "{name}");
            assert!(
                read("zsh/_gripctl").contains(name) && read("fish/gripctl.fish").contains(name)
            );
        }
    }
}
