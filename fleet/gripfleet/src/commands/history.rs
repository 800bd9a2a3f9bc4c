//! `gripfleet history`: the roll-outs that some grippers know, with how each ended at each of them.

use super::{
    Of,
    deploy::{PATIENCE, meant},
    network, say,
};
use crate::{cli::fleet::SelectArgs, output};
use grip_fleet::{
    Member,
    deploy::{Entry, How, Order},
    net::standing,
};
use grip_session::{
    exit::{Exit, escape, message},
    utc,
};
use std::collections::BTreeMap;

/// A roll-out: when it began (ns since 1970), and the SHA-256 of its model.
type Which = (u64, String);

pub(super) fn run(args: &SelectArgs) -> anyhow::Result<Exit> {
    let session = network(&args.place.reach)?.open()?;
    let mut exit = Exit::Done;
    let mut rollouts: BTreeMap<Which, Vec<(Member, Entry)>> = BTreeMap::new();
    for member in meant(&session, &args.place, &args.to)? {
        match standing(&session, &member, &Order::History, PATIENCE) {
            Ok(standing) => {
                for entry in standing.history {
                    // What was not brought by a roll-out stands at the time of the gripper.
                    let began_ns = match entry.origin.rollout_ns {
                        0 => entry.begun_ns,
                        began_ns => began_ns,
                    };
                    let which = (began_ns, entry.model.sha256.clone());
                    rollouts.entry(which).or_default().push((member.clone(), entry));
                }
            }
            Err(error) => {
                eprintln!("gripfleet: {}", escape(&message(&error)));
                exit = Exit::Failed;
            }
        }
    }
    for ((began_ns, _), entries) in &rollouts {
        print(*began_ns, entries, args.place.json)?;
    }
    if rollouts.is_empty() && !args.place.json {
        output::line("no roll-out is known there")?;
    }
    Ok(exit)
}

fn print(began_ns: u64, entries: &[(Member, Entry)], json: bool) -> anyhow::Result<()> {
    if let Some((_, Entry { model, origin, .. })) = entries.first().filter(|_| !json) {
        let by = if origin.by.is_empty() { "nobody knows whom" } else { &origin.by };
        let signed = entries.iter().find_map(|(_, entry)| entry.signed.as_ref());
        let signed = signed.map_or_else(String::new, |signed| format!(", {signed}"));
        let text = escape(&format!("{model} by {by}{signed}"));
        output::line(&format!("{}  {text}", utc::line(began_ns / 1000)))?;
    }
    for (member, entry) in entries {
        say(json, &Of::new(member, entry), &format!("  {member}  {}", verdict(entry)))?;
    }
    Ok(())
}

/// Stage, grasps and end at one gripper.
fn verdict(entry: &Entry) -> String {
    let stage = match entry.origin.stage {
        0 => "beside the model in force".to_owned(),
        stage => format!("stage {stage}"),
    };
    let grasps = entry.grasps.map_or("not known how many".to_owned(), |grasps| grasps.to_string());
    let end = match (&entry.how, &entry.why) {
        (None, _) => "goes on".to_owned(),
        (Some(How::Ordered), Some(why)) => format!("given back: {why}"),
        (Some(How::Accepted), _) => "kept".to_owned(),
        (Some(how), _) => format!("given back: {how}"),
    };
    format!("{stage}, {grasps} grasps, {end}")
}
