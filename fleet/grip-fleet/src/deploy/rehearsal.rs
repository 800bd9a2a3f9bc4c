//! Replay of recordings of a gripper with a model, in which nothing moves: the grasps in them with what that model would have asked for.
//!
//! A recording has the model and the settings that it was made with, and every command of a client. So the replay commands what was commanded,
//! and both models are asked about the same slips, as in shadow mode. What cannot be replayed is named, and is no pass.

use crate::{
    recordings::Shelf,
    rollout::{Grasp, GraspLog, Rehearsal},
};
use grip_link::message::{DeviceState, FaultCode};
use grip_session::{
    HostEstimator,
    exit::message,
    report::{Event, EventLog},
    shadow::SlipEvidence,
    tape::{Played, Tape, TapeError, TapeOptions},
};
use slip_core::{
    Phase, PipelineState, Sample, Step,
    grip::{GripEvent, GripState},
    units::Micros,
};
use std::path::Path;

/// States of the pipeline are as far apart as gripfleet gets them.
const STATE_EVERY: Micros = Micros(200_000);

/// Recordings that are replayed, the latest ones; and their bytes together.
const MOST_RECORDINGS: usize = 8;
/// A minute at 10 kHz has some 25 MB.
const MOST_BYTES: u64 = 256 << 20;

/// Replays the latest recordings of a shelf, or states why there are none. The one that is being written is left out.
#[must_use]
pub fn rehearse(shelf: &Result<Shelf, String>, model: &HostEstimator) -> Rehearsal {
    let mut rehearsal = Rehearsal::default();
    let listed = match shelf {
        Ok(shelf) => shelf.list().map_err(|error| format!("they cannot be read: {error}")),
        Err(reason) => Err(reason.clone()),
    };
    let mut listed = match listed {
        Ok(listed) => listed,
        Err(reason) => {
            rehearsal.skipped.push(reason);
            return rehearsal;
        }
    };
    listed.retain(|recording| !recording.growing);
    listed.sort_by_key(|recording| core::cmp::Reverse(recording.modified_ns));
    let mut left = MOST_BYTES;
    let fits = listed.into_iter().take_while(|recording| {
        let fits = recording.bytes <= left;
        left = left.saturating_sub(recording.bytes);
        fits
    });
    let mut chosen: Vec<_> = fits.take(MOST_RECORDINGS).collect();
    chosen.reverse();
    if chosen.is_empty() {
        rehearsal.skipped.push("no recording has ended here that could be replayed".to_owned());
    }
    for recording in &chosen {
        let Ok(shelf) = shelf else { break };
        match replay(&shelf.path(recording), model) {
            Ok(grasps) => {
                rehearsal.recordings += 1;
                rehearsal.grasps.extend(grasps);
            }
            Err(error) => rehearsal.skipped.push(message(&error)),
        }
    }
    rehearsal
}

/// The grasps of a recording in which both models were asked; one that goes on at its end is as if it was let go then.
fn replay(file: &Path, model: &HostEstimator) -> Result<Vec<Grasp>, TapeError> {
    let (mut tape, mut replay) = (Tape::new(TapeOptions::default()), Replay::new(model));
    tape.play(file, &mut |played| match played {
        Played::Began => replay.end(),
        Played::Step { sample, step, grip } => replay.step(sample, step, grip),
        _ => {}
    })?;
    replay.end();
    Ok(replay.grasps)
}

/// The second model at the pipeline of a recording.
struct Replay<'a> {
    model: &'a HostEstimator,
    events: EventLog,
    log: GraspLog,
    due: Micros,
    last: Micros,
    grasps: Vec<Grasp>,
}

impl<'a> Replay<'a> {
    fn new(model: &'a HostEstimator) -> Self {
        let (events, log) = (EventLog::default(), GraspLog::default());
        Self { model, events, log, due: Micros(0), last: Micros(0), grasps: Vec::new() }
    }

    fn step(&mut self, sample: &Sample, step: &Step, grip: Option<GripState>) {
        self.last = step.t;
        for event in self.events.events(step).into_iter().flatten() {
            let Event::Slip(slip) = event else { continue };
            self.log.slip(&slip);
            let evidence = SlipEvidence::of(&self.events, slip.t);
            if let Some(evidence) = evidence.filter(|_| slip.phase == Phase::Ended) {
                self.log.estimates(&evidence.beside(self.model));
            }
        }
        // The gripper latches the loss, as far as the controller has noticed it.
        let lost = step.grip == Some(GripEvent::Lost);
        if step.t >= self.due || lost {
            self.due = step.t.plus(STATE_EVERY);
            let fault = if lost { FaultCode::OBJECT_LOST } else { FaultCode::NONE };
            let applied_n = sample.normal_force_n;
            self.state(&PipelineState { applied_n, fault, ..step.state(grip, None, None) });
        }
    }

    fn state(&mut self, state: &PipelineState) {
        let (host, device) = (state.t, DeviceState::Active);
        let finished = self.log.state(&PipelineState { host, device, ..*state });
        let grasp = finished.map(|finished| finished.grasp);
        self.grasps.extend(grasp.filter(|grasp| grasp.compared.is_some()));
    }

    /// The recording, or its pipeline, ends: the next one begins with open fingers.
    fn end(&mut self) {
        let (t, grip) = (self.last, GripState::Released);
        self.state(&PipelineState { t, grip, ..PipelineState::UNKNOWN });
        self.due = Micros(0);
    }
}
