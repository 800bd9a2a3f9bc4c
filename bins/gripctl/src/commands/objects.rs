//! `gripctl objects`: a table of a memory of objects. `gripctl object`: a name for the next object, and the answer of gripd.

use super::command::{FORBIDDEN, PATIENCE, first, silent};
use crate::{
    cli::{ObjectArgs, ObjectsArgs},
    output, table,
};
use anyhow::bail;
use grip_daemon::client::Client;
use grip_link::message::{
    Kind, NackReason, Versions,
    daemon::{NoticeKind, Subscribe, ToClient, Topics},
};
use grip_port::nonce;
use grip_session::{
    exit::{Exit, WrongArgument},
    memory::{Figure, Memory, Object},
};
use serde::Serialize;
use serde_json::json;

#[derive(Serialize)]
struct Line<'a> {
    #[serde(rename = "type")]
    kind: &'static str,
    name: &'a str,
    expected_n: f32,
    #[serde(flatten)]
    object: &'a Object,
}

pub(crate) fn list(args: &ObjectsArgs) -> anyhow::Result<Exit> {
    if !args.file.exists() {
        bail!(WrongArgument(format!("{}: no such file", args.file.display())));
    }
    let memory = Memory::read(&args.file).map_err(|error| WrongArgument(error.to_string()))?;
    let lines: Vec<Line<'_>> = memory
        .objects()
        .iter()
        .map(|(name, object)| Line {
            kind: "object",
            name,
            expected_n: object.expected_n(),
            object,
        })
        .collect();
    if args.json {
        lines.iter().try_for_each(output::json)?;
        return Ok(Exit::Done);
    }
    let row = |line: &Line<'_>| {
        let Object { needed_n, friction_ratio, spacing_um, height_um, .. } = line.object;
        let figures = [needed_n, friction_ratio, spacing_um, height_um].map(|of| figure(*of));
        json!({"line": line, "of": figures})
    };
    let first = ["object=line.name", "needs N=of.0", "grasped with N=line.expected_n"];
    let surface = ["static/kinetic=of.1", "spacing um=of.2", "height um=of.3"];
    let last = ["grasps=line.needed_n.grasps", "forgotten=line.forgotten"];
    let rows: Vec<_> = lines.iter().map(row).collect();
    table::print(&rows, &[&first[..], &surface, &last].concat())?;
    Ok(Exit::Done)
}

/// A value with what its mean may be off by.
fn figure(figure: Figure) -> String {
    if figure.is_unknown() {
        return "-".to_owned();
    }
    format!("{:.2} +-{:.0} %", figure.value, 100.0 * figure.uncertainty())
}

pub(crate) fn name(args: &ObjectArgs) -> anyhow::Result<Exit> {
    let wanted =
        Subscribe { versions: Versions::OURS, topics: Topics::NEWS, every_nth: 0, state_ms: 0 };
    let mut client = Client::connect(&args.address, nonce(), wanted, PATIENCE)?;
    client.object(&args.name)?;
    let mut accepted = false;
    let answer = first(&mut client, PATIENCE, |message| match message {
        ToClient::Ack(ack) => {
            accepted |= ack.kind == Kind::OBJECT;
            None
        }
        ToClient::Nack(nack) if nack.kind == Kind::OBJECT => Some(Err(nack.reason)),
        ToClient::Notice(notice) if accepted && notice.kind == NoticeKind::Object => {
            Some(Ok(notice.as_str().to_owned()))
        }
        _ => None,
    })?;
    match answer {
        None => bail!(silent(&args.address)),
        Some(Ok(known)) => output::line(&known)?,
        Some(Err(NackReason::Forbidden)) => bail!(FORBIDDEN),
        Some(Err(NackReason::WrongState)) => {
            bail!("gripd has no memory: set file in the table [memory] of gripd.toml")
        }
        Some(Err(NackReason::Malformed)) => bail!(WrongArgument(
            "the name of an object has at most 64 bytes and no control characters".to_owned()
        )),
        Some(Err(reason)) => bail!("gripd refused the name: {}", reason.name()),
    }
    Ok(Exit::Done)
}
