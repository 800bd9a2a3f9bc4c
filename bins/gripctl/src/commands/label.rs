//! `gripctl label`: what happens in a recording, into the labels.csv beside it.

use crate::{cli::import::LabelArgs, output};
use anyhow::Context as _;
use grip_record::{Label, LabelKind, Recording, Relabel, write_label};
use grip_session::exit::{Exit, WrongArgument};
use slip_core::units::Micros;
use std::path::Path;

pub(crate) fn run(args: &LabelArgs) -> anyhow::Result<Exit> {
    let (folder, name) = place(&args.file)?;
    let kind = if args.remove {
        LabelKind::Rest
    } else {
        // A label of what cannot be read would only be found out by `score`.
        let recording = super::recording(&args.file, &args.csv)?;
        kind(args, &recording)?
    };
    let material = args.material.clone().unwrap_or_default();
    let label = Label { recording: name.clone(), kind, material };
    let relabel = match (args.remove, args.force) {
        (true, _) => Relabel::Remove,
        (_, true) => Relabel::Replace,
        _ => Relabel::Keep,
    };
    let labels = folder.join("labels.csv");
    let old = write_label(&labels, &label, relabel).context("nothing was written")?;
    let words = |label: &Label| match label.kind {
        LabelKind::Onset { at } => format!("onset at {:.6} s", at.as_seconds()),
        kind => kind.word().to_owned(),
    };
    match (relabel, old) {
        (Relabel::Keep, Some(old)) => {
            let text = format!("{name} has a label already ({}); --force replaces it", words(&old));
            return Err(WrongArgument(text).into());
        }
        (Relabel::Remove, None) => {
            return Err(
                WrongArgument(format!("{name} has no label in {}", labels.display())).into()
            );
        }
        (Relabel::Remove, Some(old)) => {
            output::line(&format!("{}: {name} was {}, removed", labels.display(), words(&old)))?;
        }
        (_, old) => {
            let was = old.map_or_else(String::new, |old| format!(", was {}", words(&old)));
            output::line(&format!("{}: {name} {}{was}", labels.display(), words(&label)))?;
        }
    }
    Ok(Exit::Done)
}

/// The folder of the recording, and its name there: `score` looks for NAME.csv, NAME.npz and NAME.mcap.
fn place(file: &Path) -> Result<(&Path, String), WrongArgument> {
    let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !["csv", "npz", "mcap"].contains(&ending) {
        let text = format!(
            "{}: a label is for a .csv, .npz or .mcap; `gripctl import` makes one",
            file.display()
        );
        return Err(WrongArgument(text));
    }
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let name = file.file_stem().and_then(|name| name.to_str());
    let name =
        name.ok_or_else(|| WrongArgument(format!("{}: its name is no text", file.display())))?;
    Ok((folder.unwrap_or(Path::new(".")), name.to_owned()))
}

fn kind(args: &LabelArgs, recording: &Recording) -> Result<LabelKind, WrongArgument> {
    let Some(onset) = args.onset else {
        return Ok(if args.steady { LabelKind::Steady } else { LabelKind::Rest });
    };
    let (Some(first), Some(last)) = (recording.samples.first(), recording.samples.last()) else {
        return Err(WrongArgument(format!("{}: has no samples", args.file.display())));
    };
    let (from, to) = (first.t.as_seconds(), last.t.as_seconds());
    if !(from..=to).contains(&onset) {
        let text = format!("--onset {onset}: the recording goes from {from:.6} s to {to:.6} s");
        return Err(WrongArgument(text));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within the recording"
    )]
    Ok(LabelKind::Onset { at: Micros((1e6 * onset).round() as u64) })
}
