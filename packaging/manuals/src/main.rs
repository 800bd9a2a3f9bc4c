//! The command lines of gripd, gripctl and gripmon and the tables of the code in; man pages, shell completions
//! and the pages of the reference, in a folder, out.
//!
//! A program of its own, so that what is installed carries neither the generators nor a hidden command.

#[path = "../../../bins/gripctl/src/cli/mod.rs"]
#[expect(dead_code, reason = "of the command line only the names are wanted here")]
mod gripctl;
#[path = "../../../bins/gripd/src/cli.rs"]
mod gripd;
#[path = "../../../bins/gripmon/src/cli.rs"]
#[expect(dead_code, unreachable_pub, reason = "of the command line only the names are wanted here")]
mod gripmon;
mod reference;
mod spec;

use anyhow::Context as _;
use clap::{Command, CommandFactory as _, Parser};
use grip_manuals::{help, write_all, write_page};
use std::{fs, path::PathBuf};

/// Writes man pages, shell completions and the pages of the reference of gripd, gripctl and gripmon.
#[derive(Debug, Parser)]
#[command(name = "grip-manuals", version)]
struct Cli {
    /// Folder that gets `man`, `bash`, `zsh` and `fish`; made where it is absent. With --spec a file.
    out: PathBuf,
    /// The pages of the reference instead, in the folder itself.
    #[arg(long)]
    reference: bool,
    /// protocol/MESSAGES.md instead: messages, fields and codes of the link.
    #[arg(long, conflicts_with = "reference")]
    spec: bool,
}

fn main() -> anyhow::Result<()> {
    let cli = Cli::parse();
    if cli.spec {
        return fs::write(&cli.out, spec::page()).with_context(|| cli.out.display().to_string());
    }
    if cli.reference {
        return pages().iter().try_for_each(|(name, text)| write_page(&cli.out, name, text));
    }
    commands().into_iter().try_for_each(|command| write_all(&cli.out, command))
}

/// How the pages of the reference are written.
const MADE: &str = "cargo run -p grip-manuals -- --reference docs/reference";

/// gripctl, which has subcommands, stands last.
fn commands() -> [Command; 3] {
    [gripd::Cli::command(), gripmon::Cli::command(), gripctl::Cli::command()]
}

/// Name and text of each page of the reference.
fn pages() -> Vec<(String, String)> {
    let programs = commands().map(|command| (command.get_name().to_owned(), help(command, MADE)));
    let tables = reference::pages().map(|(name, text)| (name.to_owned(), text));
    programs.into_iter().chain(tables).collect()
}

#[cfg(test)]
mod tests {
    use super::{MADE, commands, gripctl, pages, write_all};
    use clap::CommandFactory as _;
    use std::{fs::read_to_string, path::Path};

    #[test]
    fn the_reference_is_what_help_prints_and_the_tables_hold() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference");
        for (name, text) in pages() {
            let page = folder.join(name).with_extension("md");
            let written = read_to_string(&page).unwrap_or_default();
            assert!(written == text, "{} is of another version: {MADE}", page.display());
        }
    }

    #[test]
    fn every_flag_and_command_is_in_its_manual() {
        let folder = tempfile::tempdir().unwrap();
        for command in commands() {
            write_all(folder.path(), command).unwrap();
        }
        let read = |file: &str| read_to_string(folder.path().join(file)).unwrap();
        for command in &commands()[..2] {
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
