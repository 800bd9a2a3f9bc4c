//! Commands of `gripfleet` at a router: who is there, and what happens to them.

mod archive;
mod back;
mod command;
mod deploy;
mod foxglove;
mod history;
mod place;
mod recordings;

use crate::{
    cli::fleet::{Command, PlaceArgs, ReachArgs, RouterArgs},
    clock, output,
};
use anyhow::{Context as _, bail};
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::client::{self, Report};
use grip_fleet::{
    About, Member, Message, Part, Selector, Since, Stamp, Uid, json,
    net::{self, Listed, Network, Reported, Watch, list},
};
use grip_link::message::daemon::ToClient;
use grip_session::{
    exit::{Exit, WrongArgument, escape},
    status::{EventReport, StateReport},
    utc,
};
use place::Place;
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::sync::Arc;

/// How long `tail` waits for a gripper that is not there.
const ABSENT: Duration = Duration::from_secs(10);
/// Longest wait between two looks at the signals.
const LOOK: Duration = Duration::from_millis(100);

pub(crate) fn run(command: &Command) -> anyhow::Result<Exit> {
    match command {
        Command::List(place) => show_list(place),
        Command::Events(args) => {
            let since = if args.all { Since::Start } else { Since::Now };
            let place = args.state.as_deref().map(Place::open).transpose()?;
            let limit = duration(args.seconds)?;
            let wanted =
                Wanted { uid: args.uid, since, telemetry: &[], limit, must_be_there: false };
            watch(&args.place, &wanted, place)
        }
        Command::Tail(args) => {
            let (uid, since, limit) = (Some(args.uid), Since::Now, duration(args.seconds)?);
            let telemetry = &[Part::State];
            let wanted = Wanted { uid, since, telemetry, limit, must_be_there: true };
            watch(&args.place, &wanted, None)
        }
        Command::Deploy(args) => deploy::run(args),
        Command::Back(args) => back::run(args),
        Command::Pause(args) => back::pause(args),
        Command::Resume(args) => back::resume(args),
        Command::History(args) => history::run(args),
        Command::Control(args) => command::run(args),
        Command::Recordings(args) => recordings::show(args),
        Command::Collect(args) => recordings::collect(args),
        Command::Archive(args) => archive::run(args),
        Command::Router(args) => router(args),
        Command::Foxglove(args) => foxglove::run(args),
    }
}

/// A number that is above 0, or 0 where that is allowed.
fn checked(flag: &str, value: f64, zero: bool) -> Result<f64, WrongArgument> {
    if value.is_finite() && (value > 0.0 || (zero && value == 0.0)) {
        return Ok(value);
    }
    let expected = if zero { "0 or more" } else { "more than 0" };
    Err(WrongArgument(format!("{flag} {value}: expected a number of {expected}")))
}

fn duration(seconds: Option<f64>) -> Result<Duration, WrongArgument> {
    let Some(seconds) = seconds else { return Ok(Duration::MAX) };
    let seconds = checked("--seconds", seconds, false)?;
    Ok(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
}

/// The network of the arguments; what can never be one is a wrong argument.
fn network(reach: &ReachArgs) -> anyhow::Result<Network> {
    let network = Network { router: reach.router.clone(), file: reach.network.clone() };
    network.check().map_err(|error| WrongArgument(error.to_string()))?;
    Ok(network)
}

/// Where a router listens that nobody has given a place.
const LISTEN: &str = "tcp/127.0.0.1:7447";

fn router(args: &RouterArgs) -> anyhow::Result<Exit> {
    let listen = args.listen.clone();
    let listen = listen.or_else(|| args.network.is_none().then(|| LISTEN.to_owned()));
    let network = Network { router: listen, file: args.network.clone() };
    let _router = net::router(&network).map_err(|error| WrongArgument(error.to_string()))?;
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    output::line(&format!("a router listens at {}", network.name()))?;
    signals.forever().next();
    Ok(Exit::Done)
}

/// Set by Ctrl-C and SIGTERM.
pub(crate) fn stopped() -> anyhow::Result<Arc<AtomicBool>> {
    let stopped = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stopped))
            .context("cannot take over Ctrl-C")?;
    }
    Ok(stopped)
}

/// What is reported of a gripper, for machines: whose it is, and the fields of the rest.
#[derive(Debug, Serialize)]
struct Of<T> {
    site: String,
    uid: String,
    #[serde(flatten)]
    what: T,
}

impl<T> Of<T> {
    fn new(member: &Member, what: T) -> Self {
        Self { site: member.site.to_string(), uid: member.uid.to_string(), what }
    }
}

/// One line, for machines or people.
fn say(json: bool, line: &impl Serialize, text: &str) -> anyhow::Result<()> {
    if json { output::json(line) } else { Ok(output::line(text)?) }
}

/// One gripper of the list.
#[derive(Debug, Serialize)]
struct Line<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    about: &'a Option<About>,
    #[serde(flatten)]
    report: Report,
}

fn show_list(place: &PlaceArgs) -> anyhow::Result<Exit> {
    let session = network(&place.reach)?.open()?;
    let selector = Selector { site: place.site.clone(), uid: None };
    let listed = list(&session, &selector)?;
    if listed.is_empty() && !place.json {
        let site = place.site.as_ref().map_or_else(String::new, |site| format!(" at {site}"));
        output::line(&format!("no gripper is there{site}"))?;
    }
    for (member, listed) in &listed {
        let (report, about) = (report(listed), &listed.about);
        let made_of = about.as_ref().map_or_else(String::new, made_of);
        let text = format!("{member}  {}{made_of}", summary(&report));
        say(place.json, &Of::new(member, Line { about, report }), &text)?;
    }
    Ok(Exit::Done)
}

fn report(listed: &Listed) -> Report {
    let mut report = Report::default();
    let gripper = listed.gripper.map(ToClient::Gripper);
    let state = listed.state.map(ToClient::State);
    let health = listed.health.map(ToClient::Health);
    for message in [gripper, state, health].iter().flatten() {
        report.take(message);
    }
    report
}

/// What a gripper is made of, behind how it does.
fn made_of(about: &About) -> String {
    let part = |name: &str, value: &Option<String>| {
        value.as_ref().map_or_else(String::new, |value| format!(", {name} {}", escape(value)))
    };
    let (firmware, model) = (part("firmware", &about.firmware), part("model", &about.model));
    format!("; {}{firmware}{model}", escape(&about.program))
}

/// How one gripper does, on one line.
fn summary(report: &Report) -> String {
    let Some(gripper) = &report.gripper else { return "does not answer".to_owned() };
    let mut text = format!("link {}, {} Hz", gripper.link, gripper.rate_hz);
    if let Some(state) = &report.state {
        text += &format!(", {}", doing(state));
    }
    if let Some(health) = &report.health {
        text += &format!(", {} slips, {} samples lost", health.slips, health.lost);
    }
    text
}

fn doing(state: &StateReport) -> String {
    let mut text = format!("{}, scene {}", state.grip, state.scene);
    if let Some(command_n) = state.command_n {
        text += &format!(", {command_n:.2} N commanded");
    }
    if let Some(applied_n) = state.applied_n {
        text += &format!(", {applied_n:.2} N measured");
    }
    let sensors = [
        ("stylus", state.stylus),
        ("travel", state.travel),
        ("pressure", state.pressure),
        ("reference", state.reference),
    ];
    for (name, health) in sensors.into_iter().filter(|(_, health)| *health != "good") {
        text += &format!(", {name} {health}");
    }
    if state.fault != 0 {
        text += &format!(", FAULT {:04x}", state.fault);
    }
    text
}

/// What is no event, for machines.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Other<'a> {
    Alive { alive: bool },
    Missing { events: u64 },
    State(&'a StateReport),
}

/// Prints what happens, for people or machines.
struct Printer {
    json: bool,
    lost: bool,
    unreadable: Unreadable,
}

/// Messages that no gripd sends: the first is named, then they are counted, with a line every ten seconds.
#[derive(Default)]
struct Unreadable {
    next: Duration,
    count: u64,
}

impl Unreadable {
    fn take(&mut self, key: &str) {
        self.count += 1;
        if clock::monotonic() >= self.next {
            let (key, count) = (escape(key), core::mem::take(&mut self.count));
            self.next = clock::monotonic() + Duration::from_secs(10);
            eprintln!("gripfleet: {key}: something came that no gripd sends ({count} messages)");
        }
    }
}

/// What is to be shown.
struct Wanted<'a> {
    uid: Option<Uid>,
    since: Since,
    telemetry: &'a [Part],
    limit: Duration,
    /// A gripper that is not there soon is not waited for.
    must_be_there: bool,
}

fn watch(args: &PlaceArgs, wanted: &Wanted<'_>, mut place: Option<Place>) -> anyhow::Result<Exit> {
    let network = network(&args.reach)?;
    let stopped = stopped()?;
    let selector = Selector { site: args.site.clone(), uid: wanted.uid };
    let mut watch = Watch::new(network.open()?, &selector, wanted.since, wanted.telemetry)?;
    if let Some(place) = &place {
        watch.resume(place.known());
    }
    let mut printer = Printer { json: args.json, lost: false, unreadable: Unreadable::default() };
    let start = clock::monotonic();
    let mut nobody = true;
    while !stopped.load(Ordering::Relaxed) {
        let gone_by = clock::monotonic().saturating_sub(start);
        let left = wanted.limit.saturating_sub(gone_by);
        if left.is_zero() {
            break;
        }
        if nobody && gone_by > if wanted.must_be_there { ABSENT } else { net::PATIENCE } {
            nobody = false;
            if wanted.must_be_there {
                bail!("no such gripper is there ('gripfleet list' shows who is)");
            }
            eprintln!(
                "gripfleet: nobody is there who is meant; waiting ('gripfleet list' shows who is)"
            );
        }
        if let Some(reported) = watch.next(left.min(LOOK))? {
            nobody = false;
            printer.reported(&reported)?;
        }
        if let Some(place) = &mut place {
            place.keep(&watch, clock::monotonic().saturating_sub(start), false)?;
        }
    }
    if let Some(place) = &mut place {
        place.keep(&watch, Duration::ZERO, true)?;
    }
    Ok(if printer.lost { Exit::DataLost } else { Exit::Done })
}

impl Printer {
    fn reported(&mut self, reported: &Reported) -> anyhow::Result<()> {
        match reported {
            Reported::Came(member) => self.life(member, true),
            Reported::Gone(member) => self.life(member, false),
            Reported::Event { member, id, at, message, missing } => {
                self.missing(member, *missing)?;
                self.event(member, Stamp { id: *id, at: *at }, message)
            }
            Reported::Telemetry { member, message, .. } => self.telemetry(member, message),
            Reported::Unreadable { key } => {
                self.unreadable.take(key);
                Ok(())
            }
        }
    }

    fn life(&self, member: &Member, alive: bool) -> anyhow::Result<()> {
        let text = if alive { "is there" } else { "is gone" };
        self.say(member, None, &Other::Alive { alive }, &format!("{member}  {text}"))
    }

    fn missing(&mut self, member: &Member, events: u64) -> anyhow::Result<()> {
        if events == 0 {
            return Ok(());
        }
        self.lost = true;
        let text = format!("{member}  {events} events are missing: they had to make room");
        self.say(member, None, &Other::Missing { events }, &text)
    }

    fn event(&self, member: &Member, stamp: Stamp, message: &Message) -> anyhow::Result<()> {
        let id = stamp.id;
        let Ok(Some(event)) = message.read().map(|message| EventReport::of(&message)) else {
            eprintln!(
                "gripfleet: {member}: event {id} is of a kind that this gripfleet does not know"
            );
            return Ok(());
        };
        let time =
            if stamp.at.ns > 0 { utc::line(stamp.at.ns / 1000) + "  " } else { String::new() };
        let text = format!("{member}  {time}{}", escape(&client::event(&event)));
        self.say(member, Some(stamp), &event, &text)
    }

    fn telemetry(&self, member: &Member, message: &Message) -> anyhow::Result<()> {
        let mut report = Report::default();
        if let Ok(message) = message.read() {
            report.take(&message);
        }
        let Some(state) = &report.state else { return Ok(()) };
        let text = format!("{:10.4} s  {}", state.t_s, doing(state));
        self.say(member, None, &Other::State(state), &text)
    }

    fn say(
        &self,
        member: &Member,
        stamp: Option<Stamp>,
        what: &impl Serialize,
        text: &str,
    ) -> anyhow::Result<()> {
        say(self.json, &json::object(member, stamp, what)?, text)
    }
}
