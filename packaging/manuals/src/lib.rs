//! Man pages, shell completions and page of the reference of a program, made from its command line.

use anyhow::Context as _;
use clap::Command;
use clap_complete::{
    generate_to,
    shells::{Bash, Fish, Zsh},
};
use core::fmt::Write as _;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Writes man pages and completions of a program into `man`, `bash`, `zsh` and `fish` of a folder.
///
/// # Errors
/// Where the folder takes none.
pub fn write_all(out: &Path, mut command: Command) -> anyhow::Result<()> {
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

/// Writes a page of the reference into a folder.
///
/// # Errors
/// Where the folder takes none.
pub fn write_page(out: &Path, name: &str, text: &str) -> anyhow::Result<()> {
    let page = out.join(name).with_extension("md");
    fs::create_dir_all(out)
        .and_then(|()| fs::write(&page, text))
        .context(page.display().to_string())
}

/// The page of a program: what `--help` prints of it and of each of its commands.
///
/// `made` is the command that writes the page.
#[must_use]
pub fn help(command: Command, made: &str) -> String {
    let name = command.get_name();
    let mut page = format!("# {name}\n\nWhat `--help` prints. `{made}` writes this page.\n");
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
