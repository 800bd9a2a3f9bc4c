//! `gripctl fleet deploy`: a model and some grippers in; the model on all of them, or the one of before on each, and why, out.

use super::{PlaceArgs, network};
use crate::{
    cli::fleet::{DeployArgs, Selection},
    commands::{checked, clock::Clock},
    output,
};
use anyhow::{Context as _, anyhow};
use core::time::Duration;
use grip_fleet::{
    Member,
    deploy::{digest, examine},
    net::{Deployer, Happening, Session, members},
    rollout::{Counts, JudgeConfig, Progress, Report, RolloutConfig},
};
use grip_record::files;
use grip_session::exit::{Exit, WrongArgument};
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
/// How long grippers that do not answer are asked to give the model back (us).
const RETURN_US: u64 = 60_000_000;

pub(super) fn run(args: &DeployArgs) -> anyhow::Result<Exit> {
    let config = config(args)?;
    let (name, bytes) = model(&args.model, args.force)?;
    let session = network(&args.place.reach)?.open()?;
    let members = meant(&session, &args.place, &args.to)?;
    let printer = Printer::new(args.place.json, &name, &bytes, members.len());
    let signals = Signals::new([SIGINT, SIGTERM])?;
    let deployer = Deployer::new(session, config, (name, bytes), members, PATIENCE);
    drive(deployer, printer, config.judge, signals)
}

fn config(args: &DeployArgs) -> Result<RolloutConfig, WrongArgument> {
    let watch_s = checked("--watch", args.watch, false)?;
    let judge = JudgeConfig { factor: args.factor, watch_s, ..JudgeConfig::default() };
    if !judge.is_sane() {
        let text = "--watch takes 1 to 2592000 s, --factor 1 to 100";
        return Err(WrongArgument(text.to_owned()));
    }
    if !(0.0..=1.0).contains(&args.some) {
        let text = format!("--some {}: expected a share from 0 to 1", args.some);
        return Err(WrongArgument(text));
    }
    let silence_us = micros("--patience", args.patience)?;
    let idle_us = micros("--idle", args.idle)?;
    Ok(RolloutConfig { some: args.some, judge, silence_us, idle_us })
}

/// A time (s) in us; one that is too long stands for ever.
fn micros(name: &str, seconds: f64) -> Result<u64, WrongArgument> {
    let time = Duration::try_from_secs_f64(checked(name, seconds, false)?);
    Ok(time.map_or(u64::MAX, |time| u64::try_from(time.as_micros()).unwrap_or(u64::MAX)))
}

/// The file, unless it is none for any gripper.
fn model(file: &Path, force: bool) -> anyhow::Result<(String, Vec<u8>)> {
    let bytes = files::read(file, files::MOST_MODEL).map_err(|error| {
        WrongArgument(format!("{}: the model cannot be read: {error}", file.display()))
    })?;
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
    judge: JudgeConfig,
    mut signals: Signals,
) -> anyhow::Result<Exit> {
    let clock = Clock::start();
    let pause = Duration::from_secs_f64((judge.watch_s / 20.0).clamp(0.2, 2.0));
    let (mut stopped_us, mut stops) = (None, 0);
    loop {
        for _signal in signals.pending() {
            stops += 1;
            if stops == 1 {
                printer.stopping();
            }
            deployer.abort();
        }
        let happenings = deployer.turn(&|| clock.now_us());
        let now_us = clock.now_us();
        for happening in &happenings {
            printer.happening(happening, &judge)?;
        }
        let progress = deployer.progress();
        printer.progress(&progress, now_us)?;
        match progress {
            Progress::Done => return printer.done(),
            Progress::Checking | Progress::Stage(_) => {}
            Progress::Stopped(holding) => {
                let since_us = *stopped_us.get_or_insert(now_us);
                let enough = now_us.saturating_sub(since_us) > RETURN_US;
                if holding == 0 || enough || stops > 1 {
                    return printer.stopped(&deployer);
                }
            }
        }
        wait(pause);
    }
}

#[expect(clippy::disallowed_methods, reason = "between two looks at the grippers")]
fn wait(pause: Duration) {
    thread::sleep(pause);
}

/// Says what happens, for people or machines.
struct Printer {
    json: bool,
    model: String,
    all: usize,
    /// Who has it for good.
    done: BTreeSet<Member>,
    /// Time that those on trial were watched (s).
    watched: BTreeMap<Member, f64>,
    /// Who did not answer last time, and what came instead.
    silent: BTreeMap<Member, Option<String>>,
    summary_us: u64,
}

/// One line for machines.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Line<'a> {
    Stage {
        stage: usize,
    },
    Gripper {
        site: String,
        uid: String,
        says: &'static str,
        reason: Option<&'a str>,
        counts: Option<Counts>,
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
            watched: BTreeMap::new(),
            silent: BTreeMap::new(),
            summary_us: 0,
        }
    }

    fn happening(&mut self, happening: &Happening, judge: &JudgeConfig) -> anyhow::Result<()> {
        match happening {
            Happening::Stage(stage) => self.begin(*stage),
            Happening::Silent(member, reason) => {
                if self.silent.insert(member.clone(), reason.clone()).as_ref() == Some(reason) {
                    return Ok(());
                }
                let reason = reason.as_deref().unwrap_or("does not answer");
                self.gripper(member, "silent", &format!("{reason}; it is asked again"), None)
            }
            Happening::Reported(member, report) => {
                self.silent.remove(member);
                self.reported(member, report, judge)
            }
        }
    }

    fn begin(&self, stage: usize) -> anyhow::Result<()> {
        if self.json {
            return output::json(&Line::Stage { stage });
        }
        if stage == 1 {
            output::line("everybody was asked and would take it")?;
        }
        Ok(())
    }

    fn reported(
        &mut self,
        member: &Member,
        report: &Report,
        judge: &JudgeConfig,
    ) -> anyhow::Result<()> {
        match report {
            Report::Fit if self.json => self.gripper(member, "fit", "", None),
            Report::Fit => Ok(()),
            Report::Taken(before) => {
                self.watched.insert(member.clone(), 0.0);
                self.gripper(member, "taken", &taken(before, judge), Some(*before))
            }
            Report::Counted(now) => {
                self.watched.insert(member.clone(), now.seconds);
                if !self.json {
                    return Ok(());
                }
                self.gripper(member, "counted", "", Some(*now))
            }
            Report::Kept | Report::Had => {
                self.watched.remove(member);
                if !self.done.insert(member.clone()) {
                    return Ok(());
                }
                let had = *report == Report::Had;
                let text = if had { "has it already" } else { "keeps it: it is no worse" };
                self.gripper(member, if had { "had" } else { "kept" }, text, None)
            }
            Report::Refused(reason) => {
                self.gripper(member, "refused", &format!("refuses it: {reason}"), None)
            }
            Report::FellBack(_) | Report::Left(_) => {
                self.watched.remove(member);
                let text = match report {
                    Report::Left(reason) => format!("has gone back to the model before: {reason}"),
                    _ => "is worse with it, and has gone back to the model before".to_owned(),
                };
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
        counts: Option<Counts>,
    ) -> anyhow::Result<()> {
        if self.json {
            let (site, uid) = (member.site.to_string(), member.uid.to_string());
            let reason = Some(text).filter(|text| !text.is_empty());
            return output::json(&Line::Gripper { site, uid, says, reason, counts });
        }
        Ok(output::line(&format!("{member}  {text}"))?)
    }

    fn progress(&mut self, progress: &Progress, now_us: u64) -> anyhow::Result<()> {
        let Progress::Stage(stage) = *progress else { return Ok(()) };
        if !self.json && now_us >= self.summary_us && !self.watched.is_empty() {
            self.summary_us = now_us + SUMMARY_US;
            let least_s = self.watched.values().fold(f64::INFINITY, |a, b| a.min(*b));
            let (done, all, trying) = (self.done.len(), self.all, self.watched.len());
            output::line(&format!(
                "stage {stage}: {done} of {all} have it, {trying} try it, for {least_s:.0} s at least"
            ))?;
        }
        Ok(())
    }

    #[expect(clippy::unused_self, reason = "says what happens, like the others")]
    fn stopping(&self) {
        eprintln!(
            "gripctl: the model is asked back from everybody; once more leaves them as they are"
        );
    }

    fn done(&self) -> anyhow::Result<Exit> {
        if self.json {
            output::json(&Line::End { done: true, reason: None, unreachable: Vec::new() })?;
        } else {
            let who = match self.all {
                1 => "1 gripper has".to_owned(),
                all => format!("all {all} grippers have"),
            };
            output::line(&format!("{who} {}", self.model))?;
        }
        Ok(Exit::Done)
    }

    fn stopped(&self, deployer: &Deployer) -> anyhow::Result<Exit> {
        let reason = deployer.stopped().map(ToString::to_string);
        let unreachable: Vec<String> = deployer.holding().map(ToString::to_string).collect();
        if self.json {
            output::json(&Line::End { done: false, reason, unreachable })?;
            return Ok(Exit::Failed);
        }
        let reason = reason.unwrap_or_default();
        let what = match (deployer.stage(), unreachable.len()) {
            (0, _) => "went to nobody".to_owned(),
            (_, 0) => "was stopped and rolled back".to_owned(),
            (_, 1) => "was stopped, and one gripper may still have it".to_owned(),
            (_, some) => format!("was stopped, and {some} grippers may still have it"),
        };
        output::line(&format!("{} {what}: {reason}", self.model))?;
        if !unreachable.is_empty() {
            output::line(&format!(
                "not given back by {}: each keeps it unless it finds it worse by itself",
                unreachable.join(", ")
            ))?;
        }
        Ok(Exit::Failed)
    }
}

/// What a gripper has to compare with, and what can be told by that.
fn taken(before: &Counts, judge: &JudgeConfig) -> String {
    let Counts { seconds, slips, .. } = before;
    #[expect(clippy::cast_precision_loss, reason = "a count of slips")]
    let rate = *slips as f64 / seconds.max(1.0);
    let judged = match judge.noticed(rate.clamp(1.0 / seconds.max(1.0), 1.0)) {
        Some(ratio) => format!("{ratio:.1} times as many slips are noticed nine times in ten"),
        None => "no number of slips can be told from that: watch for longer".to_owned(),
    };
    format!("tries it; before it {before}, so {judged}")
}
