//! `gripfleet back`, `pause` and `resume`: an order to each of some grippers, whatever else goes on there, and how it stands.

use super::{
    Of,
    deploy::{PATIENCE, meant},
    network, say,
};
use crate::cli::fleet::{BackArgs, SelectArgs};
use grip_fleet::{
    deploy::{ModelId, Order, Paused, Standing},
    net::standing,
};
use grip_session::exit::{Exit, message};
use serde::Serialize;

/// One line for machines.
#[derive(Debug, Serialize)]
struct Line {
    in_force: Option<ModelId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    paused: Option<Paused>,
    reason: Option<String>,
}

/// The model before.
pub(super) fn run(args: &BackArgs) -> anyhow::Result<Exit> {
    let why = Some(format!("ordered by {}", args.operator.by));
    ask(&args.select, &Order::Back { sha256: None, why })
}

/// Roll-outs pause.
pub(super) fn pause(args: &BackArgs) -> anyhow::Result<Exit> {
    ask(&args.select, &Order::Pause { by: args.operator.by.clone() })
}

/// Roll-outs go on.
pub(super) fn resume(args: &SelectArgs) -> anyhow::Result<Exit> {
    ask(args, &Order::Resume)
}

fn ask(args: &SelectArgs, order: &Order) -> anyhow::Result<Exit> {
    let session = network(&args.place.reach)?.open()?;
    let mut exit = Exit::Done;
    for member in meant(&session, &args.place, &args.to)? {
        let answer = standing(&session, &member, order, PATIENCE).map_err(|error| message(&error));
        if answer.is_err() {
            exit = Exit::Failed;
        }
        let text = match &answer {
            Ok(Standing { in_force, paused: None, .. }) => {
                format!("{member}  {in_force} is in force")
            }
            Ok(Standing { in_force, paused: Some(Paused { by, .. }), .. }) => {
                format!("{member}  {in_force} is in force; roll-outs pause, by order of {by}")
            }
            Err(reason) => reason.clone(),
        };
        let reason = answer.as_ref().err().cloned();
        let (in_force, paused) =
            answer.map_or((None, None), |standing| (Some(standing.in_force), standing.paused));
        say(args.place.json, &Of::new(&member, Line { in_force, paused, reason }), &text)?;
    }
    Ok(exit)
}
