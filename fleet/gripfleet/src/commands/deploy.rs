//! `gripfleet deploy`: roll-out of a model to some grippers; the model on all of them, or the one of before on each, and why.

use super::{Of, PlaceArgs, checked, network, say};
use crate::{
    cli::fleet::{DeployArgs, Selection},
    clock::{self, Clock},
    output,
};
use anyhow::{Context as _, anyhow};
use core::time::Duration;
use grip_fleet::{
    Member,
    deploy::{Offer, Paused, digest, examine},
    net::{Deployer, Happening, Session, members},
    rollout::{
        Difference, Evidence, JudgeConfig, MOST_GRASPS, Progress, Rehearsal, Report, Rollout,
        RolloutConfig, Tally,
    },
};
use grip_record::files;
use grip_session::{
    exit::{Exit, WrongArgument},
    model::signature_beside,
    signature::split,
};
use serde::Serialize;
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    iterator::Signals,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    thread,
};

/// How long an answer may take: a model waits until nothing slips.
pub(super) const PATIENCE: Duration = Duration::from_secs(15);
/// A line about where it is, for people, this often (us).
const SUMMARY_US: u64 = 5_000_000;
/// Pause between two looks at the trials.
const TURN: Duration = Duration::from_millis(500);
/// How long grippers that do not answer are asked to give the model back (us).
const RETURN_US: u64 = 60_000_000;

pub(super) fn run(args: &DeployArgs) -> anyhow::Result<Exit> {
    let config = config(args)?;
    let (name, bytes) = model(&args.model, args.force)?;
    let session = network(&args.place.reach)?.open()?;
    let members = meant(&session, &args.place, &args.to)?;
    let printer = Printer::new(args.place.json, &name, &bytes, members.len());
    let signals = Signals::new([SIGINT, SIGTERM])?;
    let offer = Offer::new(name, bytes, args.lease);
    let deployer = Deployer::new(session, config, offer, members, PATIENCE)
        .with_origin(&args.operator.by, clock::utc_ns());
    drive(deployer, printer, args.plan, signals)
}

fn config(args: &DeployArgs) -> Result<RolloutConfig, WrongArgument> {
    let judge = JudgeConfig { alpha: args.error, ..JudgeConfig::default() };
    let difference = Difference { lost: args.notice_lost, force: args.notice_force };
    let grasps = args.grasps.map(usize::from);
    let possible = judge.is_sane()
        && (0.001..=1.0).contains(&difference.lost)
        && (1.2..=100.0).contains(&difference.force)
        && grasps.is_none_or(|grasps| (1..=MOST_GRASPS).contains(&grasps))
        && (5..=86_400).contains(&args.lease);
    if !possible {
        let text = "--error takes 1e-6 to 0.5, --notice-lost 0.001 to 1, --notice-force 1.2 to 100, --grasps 1 to 500, --lease 5 to 86400 s";
        return Err(WrongArgument(text.to_owned()));
    }
    if !(0.0..=1.0).contains(&args.some) {
        let text = format!("--some {}: expected a share from 0 to 1", args.some);
        return Err(WrongArgument(text));
    }
    let silence_us = micros("--patience", args.patience)?;
    let idle_us = micros("--idle", args.idle)?;
    let shadow = args.shadow.map(usize::from);
    let (some, replay) = (args.some, !args.no_replay);
    Ok(RolloutConfig { some, judge, difference, grasps, replay, shadow, silence_us, idle_us })
}

/// A time (s) in us; one that is too long stands for ever.
fn micros(name: &str, seconds: f64) -> Result<u64, WrongArgument> {
    let time = Duration::try_from_secs_f64(checked(name, seconds, false)?);
    Ok(time.map_or(u64::MAX, |time| u64::try_from(time.as_micros()).unwrap_or(u64::MAX)))
}

/// The file and the signature beside it, unless it is none for any gripper.
fn model(file: &Path, force: bool) -> anyhow::Result<(String, Vec<u8>)> {
    let mut bytes = files::read(file, files::MOST_MODEL).map_err(|error| {
        WrongArgument(format!("{}: the model cannot be read: {error}", file.display()))
    })?;
    let is_signed = core::str::from_utf8(&bytes).is_ok_and(|text| split(text).1.is_some());
    if !is_signed && let Some(signature) = signature_beside(file)? {
        bytes.extend(signature.into_bytes());
    }
    let name = file.file_name().context("a model is a file")?.to_string_lossy().into_owned();
    if !force {
        examine(&name, &digest(&bytes), &bytes).map_err(|fault| {
            WrongArgument(format!("{fault}; nothing was sent (--force sends it all the same)"))
        })?;
    }
    Ok((name, bytes))
}

/// Everybody who is meant; who is named and not there is an error.
pub(super) fn meant(
    session: &Session,
    place: &PlaceArgs,
    to: &Selection,
) -> anyhow::Result<BTreeSet<Member>> {
    let mut meant = BTreeSet::new();
    for selector in &to.0 {
        let here = |member: &Member| place.site.as_ref().is_none_or(|site| member.site == *site);
        let found: Vec<Member> =
            members(session, selector)?.into_iter().filter(|member| here(member)).collect();
        if found.is_empty() {
            let site = selector.site.as_ref().map(ToString::to_string);
            let uid = selector.uid.map(|uid| uid.to_string());
            let words: Vec<String> = site.into_iter().chain(uid).collect();
            let which = if words.is_empty() { String::new() } else { words.join("/") + ": " };
            return Err(anyhow!("{which}no such gripper is there; nothing was sent"));
        }
        meant.extend(found);
    }
    Ok(meant)
}

/// Turn by turn, to the end.
fn drive(
    mut deployer: Deployer,
    mut printer: Printer,
    only_plan: bool,
    mut signals: Signals,
) -> anyhow::Result<Exit> {
    let clock = Clock::start();
    let (mut stopped_us, mut stops) = (None, 0);
    loop {
        for _signal in signals.pending() {
            stops += 1;
            if stops == 1 {
                eprintln!(
                    "gripfleet: the model is asked back from everybody; once more leaves them to their lease"
                );
            }
            deployer.abort();
        }
        let happenings = deployer.turn(&|| clock.now_us());
        let now_us = clock.now_us();
        for happening in &happenings {
            printer.happening(happening)?;
        }
        if only_plan && deployer.rollout().grasps().is_some() {
            return Ok(Exit::Done);
        }
        let rollout = deployer.rollout();
        let progress = rollout.progress();
        printer.progress(&progress, rollout, now_us)?;
        match progress {
            Progress::Done => return printer.done(),
            Progress::Stopped(holding) => {
                let since_us = *stopped_us.get_or_insert(now_us);
                let enough = now_us.saturating_sub(since_us) > RETURN_US;
                if holding == 0 || enough || stops > 1 {
                    return printer.stopped(rollout);
                }
            }
            _ => {}
        }
        wait(TURN);
    }
}

#[expect(clippy::disallowed_methods, reason = "between two looks at the grippers")]
fn wait(pause: Duration) {
    thread::sleep(pause);
}

/// Reports what happens, for people or machines.
struct Printer {
    json: bool,
    model: String,
    all: usize,
    /// Who has it for good.
    done: BTreeSet<Member>,
    /// Grasps of those on trial.
    grasps: BTreeMap<Member, usize>,
    /// Who did not answer last time, and what came instead.
    silent: BTreeMap<Member, Option<String>>,
    summary_us: u64,
}

/// One line for machines.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Line<'a> {
    Plan {
        shadow: usize,
        grasps: usize,
    },
    Replays {
        #[serde(flatten)]
        tally: Tally,
    },
    Shadow {
        wanted: usize,
        #[serde(flatten)]
        tally: Tally,
    },
    Stage {
        stage: usize,
    },
    Evidence {
        grasps: usize,
        hold: f64,
        force: f64,
    },
    Gripper {
        #[serde(flatten)]
        of: Of<()>,
        says: &'static str,
        reason: Option<&'a str>,
        grasps: Option<usize>,
    },
    End {
        done: bool,
        reason: Option<String>,
        unreachable: Vec<String>,
    },
}

impl Printer {
    fn new(json: bool, name: &str, bytes: &[u8], all: usize) -> Self {
        let model = format!("{name} ({})", &digest(bytes).get(..12).unwrap_or_default());
        Self {
            json,
            model,
            all,
            done: BTreeSet::new(),
            grasps: BTreeMap::new(),
            silent: BTreeMap::new(),
            summary_us: 0,
        }
    }

    fn happening(&mut self, happening: &Happening) -> anyhow::Result<()> {
        match happening {
            Happening::Planned { shadow, grasps } => self.planned(*shadow, *grasps),
            Happening::Stage(stage) => {
                say(self.json, &Line::Stage { stage: *stage }, &format!("stage {stage} begins"))
            }
            Happening::Paused(member, paused) => self.paused(member, paused.as_ref()),
            Happening::Silent(member, reason) => {
                if self.silent.insert(member.clone(), reason.clone()).as_ref() == Some(reason) {
                    return Ok(());
                }
                let reason = reason.as_deref().unwrap_or("does not answer");
                self.gripper(member, "silent", &format!("{reason}; it is asked again"), None)
            }
            Happening::Reported(member, report) => {
                self.silent.remove(member);
                self.reported(member, report)
            }
        }
    }

    fn paused(&self, member: &Member, paused: Option<&Paused>) -> anyhow::Result<()> {
        let Some(Paused { by, .. }) = paused else {
            return self.gripper(member, "resumed", "lets roll-outs go on", None);
        };
        let text =
            format!("lets roll-outs pause, by order of {by}: `gripfleet resume --to {member}`");
        self.gripper(member, "paused", &text, None)
    }

    fn planned(&self, shadow: usize, grasps: usize) -> anyhow::Result<()> {
        let first = match shadow {
            0 => String::new(),
            shadow => {
                format!("beside the models in force it is asked in {shadow} grasps with a slip; ")
            }
        };
        let text =
            format!("everybody was asked and would take it; {first}a stage takes {grasps} grasps");
        say(self.json, &Line::Plan { shadow, grasps }, &text)
    }

    fn reported(&mut self, member: &Member, report: &Report) -> anyhow::Result<()> {
        match report {
            Report::Fit(before) if self.json => self.gripper(member, "fit", "", Some(before.len())),
            Report::Fit(_) | Report::Trying(_) | Report::Known | Report::Compared { .. } => Ok(()),
            Report::Replaying => Ok(()),
            Report::Replayed(rehearsal) => {
                let Rehearsal { recordings, skipped, grasps } = rehearsal;
                let mut text = match recordings {
                    0 => "could not try it on recordings".to_owned(),
                    _ => format!("tried it on {recordings} recordings"),
                };
                for reason in skipped {
                    text += &format!("; {reason}");
                }
                self.gripper(member, "replayed", &text, Some(grasps.len()))
            }
            Report::Beside => {
                let text = "lets it estimate beside the model in force; it moves nothing";
                self.gripper(member, "beside", text, None)
            }
            Report::Taken(before) => {
                self.grasps.insert(member.clone(), 0);
                let text = format!("tries it; it has made {} grasps before", before.len());
                self.gripper(member, "taken", &text, Some(before.len()))
            }
            Report::Grasps { from, grasps } => {
                let now = from + grasps.len();
                let before = self.grasps.insert(member.clone(), now);
                if !self.json || before == Some(now) {
                    return Ok(());
                }
                self.gripper(member, "grasped", "", Some(now))
            }
            Report::Kept | Report::Had => {
                self.grasps.remove(member);
                if !self.done.insert(member.clone()) {
                    return Ok(());
                }
                let had = *report == Report::Had;
                let text = if had { "has it already" } else { "keeps it" };
                self.gripper(member, if had { "had" } else { "kept" }, text, None)
            }
            Report::Refused(reason) => {
                self.gripper(member, "refused", &format!("refuses it: {reason}"), None)
            }
            Report::Left(reason) => {
                self.grasps.remove(member);
                let text = format!("has gone back to the model before: {reason}");
                self.gripper(member, "left", &text, None)
            }
            Report::Back => self.gripper(member, "back", "has given it back", None),
        }
    }

    fn gripper(
        &self,
        member: &Member,
        says: &'static str,
        text: &str,
        grasps: Option<usize>,
    ) -> anyhow::Result<()> {
        let reason = Some(text).filter(|text| !text.is_empty());
        let line = Line::Gripper { of: Of::new(member, ()), says, reason, grasps };
        say(self.json, &line, &format!("{member}  {text}"))
    }

    fn progress(
        &mut self,
        progress: &Progress,
        rollout: &Rollout,
        now_us: u64,
    ) -> anyhow::Result<()> {
        let due = match progress {
            Progress::Replay | Progress::Shadow => true,
            Progress::Stage(_) => !self.grasps.is_empty(),
            _ => false,
        };
        if !due || now_us < self.summary_us {
            return Ok(());
        }
        self.summary_us = now_us + SUMMARY_US;
        match *progress {
            Progress::Stage(stage) => {
                let Evidence { hold, force, grasps } = rollout.evidence();
                let (trying, all) = (self.grasps.len(), self.all);
                let text = format!(
                    "stage {stage}: {trying} of {all} try it; {grasps} grasps compared, evidence of a worse hold {hold:.2}, of too much force {force:.2}"
                );
                say(self.json, &Line::Evidence { grasps, hold, force }, &text)
            }
            Progress::Replay => {
                let tally = rollout.replays();
                say(self.json, &Line::Replays { tally }, &format!("recordings: {tally}"))
            }
            _ => {
                let (wanted, tally) = rollout.shadow();
                let text = format!("shadow, {wanted} grasps wanted: {tally}");
                say(self.json, &Line::Shadow { wanted, tally }, &text)
            }
        }
    }

    fn done(&self) -> anyhow::Result<Exit> {
        let who = match self.all {
            1 => "1 gripper has".to_owned(),
            all => format!("all {all} grippers have"),
        };
        let line = Line::End { done: true, reason: None, unreachable: Vec::new() };
        say(self.json, &line, &format!("{who} {}", self.model))?;
        Ok(Exit::Done)
    }

    fn stopped(&self, rollout: &Rollout) -> anyhow::Result<Exit> {
        let reason = rollout.stopped().map(ToString::to_string);
        let unreachable: Vec<String> = rollout.holding().map(ToString::to_string).collect();
        if self.json {
            output::json(&Line::End { done: false, reason, unreachable })?;
            return Ok(Exit::Failed);
        }
        let reason = reason.unwrap_or_default();
        let what = match (rollout.stage(), unreachable.len()) {
            (0, _) => "went to nobody".to_owned(),
            (_, 0) => "was stopped and rolled back".to_owned(),
            (_, 1) => "was stopped, and one gripper may still have it".to_owned(),
            (_, some) => format!("was stopped, and {some} grippers may still have it"),
        };
        output::line(&format!("{} {what}: {reason}", self.model))?;
        if !unreachable.is_empty() {
            output::line(&format!(
                "not given back by {}: each goes back when the lease ends, unless it keeps it already",
                unreachable.join(", ")
            ))?;
        }
        Ok(Exit::Failed)
    }
}
