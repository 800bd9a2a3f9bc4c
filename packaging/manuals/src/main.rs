//! The command lines of gripd, gripctl, gripfleet and gripmon in; their man pages and shell completions, in a folder, out.
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

use anyhow::Context as _;
use clap::{Command, CommandFactory as _, Parser};
use clap_complete::{
    generate_to,
    shells::{Bash, Fish, Zsh},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Writes man pages and shell completions of gripd, gripctl, gripfleet and gripmon.
#[derive(Debug, Parser)]
#[command(name = "grip-manuals", version)]
struct Cli {
    /// Folder that gets `man`, `bash`, `zsh` and `fish`; made where it is absent.
    out: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let out = Cli::parse().out;
    commands().into_iter().try_for_each(|command| write_all(&out, command))
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

#[cfg(test)]
mod tests {
    use super::{commands, gripctl, write_all};
    use clap::CommandFactory as _;
    use std::fs::read_to_string;

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
