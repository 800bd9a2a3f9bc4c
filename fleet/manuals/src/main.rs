//! The command lines of gripfleet and gripmon-fleet in; man pages, shell completions and the pages of the reference, in a
//! folder, out.

#[path = "../../gripfleet/src/cli/mod.rs"]
#[expect(dead_code, reason = "of the command line only the names are wanted here")]
mod gripfleet;

use clap::{Command, CommandFactory as _, Parser};
use grip_manuals::{help, write_all, write_page};
use std::path::PathBuf;

/// Writes man pages, shell completions and the pages of the reference of gripfleet and gripmon-fleet.
#[derive(Debug, Parser)]
#[command(name = "fleet-manuals", version)]
struct Cli {
    /// Folder that gets `man`, `bash`, `zsh` and `fish`; made where it is absent.
    out: PathBuf,
    /// The pages of the reference instead, in the folder itself.
    #[arg(long)]
    reference: bool,
}

fn main() -> anyhow::Result<()> {
    let Cli { out, reference } = Cli::parse();
    for command in commands() {
        if reference {
            write_page(&out, command.get_name(), &page(command.clone()))?;
        } else {
            write_all(&out, command)?;
        }
    }
    Ok(())
}

fn commands() -> [Command; 2] {
    [gripfleet::Cli::command(), gripmon_fleet::cli::Cli::command()]
}

/// The page of the reference.
fn page(command: Command) -> String {
    help(command, "cargo run -p fleet-manuals -- --reference docs/reference")
}

#[cfg(test)]
mod tests {
    use super::{commands, page, write_all};
    use std::{fs::read_to_string, path::Path};

    #[test]
    fn the_reference_is_what_help_prints_and_every_program_has_its_manuals() {
        let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference");
        let folder = tempfile::tempdir().unwrap();
        for command in commands() {
            let name = command.get_name().to_owned();
            write_all(folder.path(), command.clone()).unwrap();
            for file in [format!("man/{name}.1"), format!("zsh/_{name}"), format!("bash/{name}")] {
                assert!(read_to_string(folder.path().join(file)).unwrap().contains("network"));
            }
            let written = read_to_string(pages.join(&name).with_extension("md")).unwrap();
            assert!(written == page(command), "{name}.md is of another version");
        }
    }
}
