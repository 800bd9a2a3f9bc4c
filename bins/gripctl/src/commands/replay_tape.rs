//! `gripctl replay` of MCAP: the pipeline that was recorded, its events printed or compared with the recorded ones.

use super::replay_plot::Picture;
use crate::{cli::ReplayArgs, output};
use grip_record::mcap::McapError;
use grip_record::outputs::OutputPath;
use grip_session::{
    exit::{Exit, WrongArgument},
    model, replay,
    report::Event,
    tape::{Played, Tape, TapeError, TapeOptions, TapeSummary},
};
use serde::Serialize;
use serde_json::{Map, Value};
use std::{collections::VecDeque, path::Path};

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct Summary {
    samples: u64,
    lost: u64,
    slips: u64,
    duration_s: f64,
    unusable: u64,
    isolated: u64,
    floor_lowered: u64,
    steady_alarms: u64,
    pipelines: u64,
    unrecorded: u64,
    /// Whether the noise floor was still being learned at the end: a stylus shows no slip before.
    learning: bool,
    /// Events that are the recorded ones; only with `--check`.
    #[serde(skip_serializing_if = "Option::is_none")]
    checked: Option<u64>,
}

/// The events differ from the recorded ones.
#[derive(Debug, thiserror::Error)]
enum Differs {
    #[error("event {number} differs:\n  recorded: {recorded}\n  replayed: {replayed}")]
    Lines { number: u64, recorded: String, replayed: String },
    #[error("event {number} was recorded, but is not replayed: {line}")]
    Missing { number: u64, line: String },
    #[error("event {number} is replayed, but was not recorded: {line}")]
    New { number: u64, line: String },
}

pub(super) fn run(args: &ReplayArgs, plot: Option<&OutputPath>) -> anyhow::Result<Exit> {
    refuse_csv_options(args)?;
    let estimator = args.model.as_deref().map(model::read_estimator).transpose()?;
    let (no_skip, observe, esc) = (args.no_skip, args.observe, args.esc);
    let mut tape = Tape::new(TapeOptions { estimator, no_skip, observe, esc });
    let mut listener = Listener {
        json: args.json,
        check: args.check.then(Check::default),
        picture: args.plot.as_ref().map(|_| Picture::default()),
        failure: None,
    };
    let mut cut = false;
    for file in &args.files {
        match tape.play(file, &mut |played| listener.receive(file, played)) {
            Err(TapeError::Mcap(
                error @ (McapError::Truncated { .. } | McapError::Damaged { .. }),
            )) if tape.summary().samples > 0 => {
                cut = true;
                output::remark("gripctl", error);
            }
            other => other?,
        }
        listener.failure.take().map_or(Ok(()), Err)?;
        if cut {
            break;
        }
    }
    let summary = tape.summary();
    if let Some((picture, plot)) = listener.picture.take().zip(plot) {
        let name = args.files.first().and_then(|file| file.file_stem()).unwrap_or_default();
        output::draw(
            &picture.chart(&name.to_string_lossy(), Some("stylus (m) or vibration")),
            plot,
        )?;
    }
    if summary.learning {
        let last = args.files.last().map(|file| file.display().to_string()).unwrap_or_default();
        output::remark(last, replay::LEARNING);
    }
    let checked = listener.check.map(|check| check.finish(cut)).transpose()?;
    print(args.json, summary, checked)?;
    let lossy = cut || summary.lost > 0 || summary.unrecorded > 0 || summary.mid_run;
    Ok(if lossy { Exit::DataLost } else { Exit::Done })
}

/// The recording has its settings inside.
fn refuse_csv_options(args: &ReplayArgs) -> Result<(), WrongArgument> {
    let given = [
        ("--rate", args.csv.rate.is_some()),
        ("--map", !args.csv.map.is_empty()),
        ("--calibration", args.calibration.is_some()),
        ("--config", args.config.is_some()),
    ];
    if let Some((flag, _)) = given.into_iter().find(|(_, given)| *given) {
        return Err(WrongArgument(format!(
            "{flag}: an .mcap recording has its own settings inside; export it with `gripctl csv` to try others"
        )));
    }
    let changed = [
        ("--model", args.model.is_some()),
        ("--esc", args.esc.is_some()),
        ("--observe", args.observe),
    ];
    match changed.into_iter().find(|(_, given)| args.check && *given) {
        Some((flag, _)) => Err(WrongArgument(format!(
            "--check with {flag}: the events can only be the recorded ones with the recorded model and settings"
        ))),
        None => Ok(()),
    }
}

fn print(json: bool, summary: TapeSummary, checked: Option<u64>) -> anyhow::Result<()> {
    let TapeSummary { samples, lost, slips, duration_s, unusable, floor_lowered, .. } = summary;
    let TapeSummary { steady_alarms, pipelines, unrecorded, isolated, learning, .. } = summary;
    if json {
        return output::json(&Summary {
            samples,
            lost,
            slips,
            duration_s,
            unusable,
            isolated,
            floor_lowered,
            steady_alarms,
            pipelines,
            unrecorded,
            learning,
            checked,
        });
    }
    if let Some(events) = checked {
        output::line(&format!("{events} events, byte by byte the recorded ones"))?;
    }
    output::line(&format!(
        "{samples} samples in {duration_s:.3} s through {pipelines} pipelines, {lost} rows lost, {unrecorded} items not recorded, \
         {unusable} unusable readings, {isolated} isolated, {slips} slips, floor lowered {floor_lowered} times"
    ))?;
    Ok(())
}

/// Prints or compares what is played.
struct Listener {
    json: bool,
    check: Option<Check>,
    picture: Option<Picture>,
    failure: Option<anyhow::Error>,
}

impl Listener {
    fn receive(&mut self, file: &Path, played: Played<'_>) {
        if self.failure.is_some() {
            return;
        }
        if let (Played::Step { sample, step, .. }, Some(picture)) = (&played, &mut self.picture) {
            picture.take(sample, step);
        }
        let received = match (played, &mut self.check) {
            (Played::Note(text), _) => {
                output::remark(file.display(), text);
                Ok(())
            }
            (Played::Line(line), Some(check)) => serde_json::to_string(line)
                .map_err(Into::into)
                .and_then(|line| Ok(check.replayed(line)?)),
            (Played::Recorded(line), Some(check)) => {
                check.recorded(line.to_owned()).map_err(Into::into)
            }
            (Played::Line(line), None) => self.show(line),
            (Played::Recorded(_), None)
            | (
                Played::Began
                | Played::Step { .. }
                | Played::Metadata { .. }
                | Played::Attached { .. },
                _,
            ) => Ok(()),
        };
        self.failure = received.err();
    }

    fn show(&self, line: &Event) -> anyhow::Result<()> {
        if self.json { output::json(line) } else { Ok(output::line(&line.to_string())?) }
    }
}

/// Lines of either side that wait for their counterpart; one of the two is always empty.
#[derive(Default)]
struct Check {
    recorded: VecDeque<String>,
    replayed: VecDeque<String>,
    equal: u64,
}

impl Check {
    fn recorded(&mut self, line: String) -> Result<(), Differs> {
        self.recorded.push_back(line);
        self.compare()
    }

    fn replayed(&mut self, line: String) -> Result<(), Differs> {
        self.replayed.push_back(line);
        self.compare()
    }

    fn compare(&mut self) -> Result<(), Differs> {
        if self.recorded.is_empty() || self.replayed.is_empty() {
            return Ok(());
        }
        let pair = self.recorded.pop_front().zip(self.replayed.pop_front());
        match pair {
            Some((recorded, replayed)) if !agree(&recorded, &replayed) => {
                Err(Differs::Lines { number: self.equal + 1, recorded, replayed })
            }
            _ => {
                self.equal += 1;
                Ok(())
            }
        }
    }

    /// How many were equal. At the end of a file that was cut off a line may lack its counterpart.
    fn finish(mut self, cut: bool) -> Result<u64, Differs> {
        let number = self.equal + 1;
        match (self.recorded.pop_front(), self.replayed.pop_front()) {
            (Some(line), _) if !cut => Err(Differs::Missing { number, line }),
            (_, Some(line)) if !cut => Err(Differs::New { number, line }),
            _ => Ok(self.equal),
        }
    }
}

/// Fields that lines have since recordings were first made.
const ADDED: [&str; 4] = ["certified", "certified_interval_s", "ruled_out", "possible"];

/// Whether the lines are equal, but for fields that have been added since the recording.
fn agree(recorded: &str, replayed: &str) -> bool {
    let fields = |line: &str| serde_json::from_str::<Map<String, Value>>(line);
    recorded == replayed
        || fields(recorded).is_ok_and(|recorded| {
            fields(replayed).is_ok_and(|mut replayed| {
                replayed.retain(|name, _| {
                    recorded.contains_key(name) || !ADDED.contains(&name.as_str())
                });
                recorded == replayed
            })
        })
}

#[cfg(test)]
mod tests {
    use super::agree;

    #[test]
    fn a_field_that_was_added_since_is_no_difference_and_any_other_is() {
        let old = r#"{"type":"slip","t_s":0.5,"statistic":3.25}"#;
        let new = r#"{"type":"slip","t_s":0.5,"statistic":3.25,"certified":false}"#;
        assert!(agree(old, new) && agree(old, old));
        assert!(!agree(new, old), "a field that is missing now");
        assert!(!agree(r#"{"type":"slip"}"#, new), "fields that were always there");
        assert!(!agree(old, &new.replace("3.25", "3.5")));
        assert!(!agree("cut {", new));
    }
}
