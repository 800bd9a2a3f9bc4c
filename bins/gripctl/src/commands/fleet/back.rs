//! `gripctl fleet back`: some grippers in; the model before on each of them, whatever was counted with the one in force, out.

use super::{
    deploy::{PATIENCE, meant},
    network,
};
use crate::{cli::fleet::BackArgs, output};
use grip_fleet::{
    deploy::{ModelId, Order},
    net::standing,
};
use grip_session::exit::{Exit, message};
use serde::Serialize;

/// One line for machines.
#[derive(Debug, Serialize)]
struct Line {
    site: String,
    uid: String,
    in_force: Option<ModelId>,
    reason: Option<String>,
}

pub(super) fn run(args: &BackArgs) -> anyhow::Result<Exit> {
    let session = network(&args.place.reach)?.open()?;
    let mut exit = Exit::Done;
    for member in meant(&session, &args.place, &args.to)? {
        let answer = standing(&session, &member, &Order::Back { sha256: None }, PATIENCE);
        let (in_force, reason) = match answer {
            Ok(standing) => (Some(standing.in_force), None),
            Err(error) => (None, Some(message(&error))),
        };
        if in_force.is_none() {
            exit = Exit::Failed;
        }
        if args.place.json {
            let (site, uid) = (member.site.to_string(), member.uid.to_string());
            output::json(&Line { site, uid, in_force, reason })?;
        } else if let Some(model) = in_force {
            output::line(&format!("{member}  {model} is in force"))?;
        } else {
            output::line(&reason.unwrap_or_default())?;
        }
    }
    Ok(exit)
}
