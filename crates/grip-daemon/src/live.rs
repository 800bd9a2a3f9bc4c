//! The last seconds of a grip as points, and the messages for a page in the browser: server-sent events of JSON.

use crate::{
    board::Board,
    status::{Link, Pipeline},
};
use grip_link::message::FaultCode;
use grip_session::json_object;
use serde::Serialize;
use slip_core::{PipelineState, sample::Scene, units::Micros};
use std::collections::VecDeque;

/// Least time between two messages, and between two points (us).
pub const EVERY_US: u64 = 50_000;
/// Points that are remembered: half a minute.
const POINTS: usize = 600;
/// Events in a message.
const EVENTS: usize = 12;

#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Point {
    t_s: f64,
    scene: &'static str,
    /// Whether a slip was noticed or went on since the last point.
    slip: bool,
    /// Largest evidence since the last point; 1 is a slip.
    statistic: Option<f32>,
    /// Command, measured force; 10 % quantile, median, 90 % quantile of the needed force.
    forces_n: [Option<f32>; 5],
}

/// The last points of one device.
#[derive(Clone, Debug, Default)]
pub(crate) struct Course {
    points: VecDeque<Point>,
    /// Points since the start of the daemon.
    count: u64,
    /// Times that device time went back.
    restarts: u32,
    newest: Micros,
    /// Whether a slip was noticed since the newest point, however short it is.
    pub(crate) slipped: bool,
    statistic: Option<f32>,
}

impl Course {
    /// Takes a state; device time that goes back begins a new course. A `faulty` gripper holds nothing.
    pub(crate) fn take(&mut self, state: &PipelineState, faulty: bool) {
        if state.t < self.newest {
            self.points.clear();
            self.restarts += 1;
        }
        self.slipped |= state.scene == Scene::Slipping;
        // The larger one, or the one that is a number.
        let larger = |now: f32| self.statistic.map_or(now, |before| before.max(now));
        self.statistic = state.statistic.map(larger).or(self.statistic);
        if !self.points.is_empty() && state.t.since(self.newest).0 < EVERY_US {
            return;
        }
        if self.points.len() == POINTS {
            self.points.pop_front();
        }
        let PipelineState { command_n, applied_n, need_low_n, need_n, need_high_n, .. } = *state;
        self.points.push_back(Point {
            t_s: state.t.as_seconds(),
            scene: if faulty { "fault" } else { state.scene.name() },
            slip: core::mem::take(&mut self.slipped),
            statistic: self.statistic.take(),
            forces_n: [command_n, applied_n, need_low_n, need_n, need_high_n],
        });
        self.newest = state.t;
        self.count += 1;
    }

    /// Points behind the first `count`, as far as they are remembered.
    fn since(&self, count: u64) -> impl Iterator<Item = &Point> {
        let new = usize::try_from(self.count.saturating_sub(count)).unwrap_or(usize::MAX);
        self.points.iter().skip(self.points.len().saturating_sub(new))
    }
}

json_object! {
    #[derive(Debug, Serialize)]
    pub(crate) struct Live<'a> of (board: &'a Board, now_us: u64, count: u64) {
        version: &'a str = &board.about.version;
        /// Points with another one are of another course of time.
        run: [u32; 2] = [board.about.run_id, board.course().restarts];
        dry_run: bool = board.about.dry_run;
        healthy: bool = board.is_healthy();
        link: Link<'a> = Link::of(board);
        /// What the fault of the gripper means, where it is a listed one.
        fault: Option<&'static str> = FaultCode::TABLE.iter().find(|(code, ..)| Some(*code) == board.fault()).map(|(.., words)| *words);
        pipeline: Option<Pipeline> = board.state().map(|state| Pipeline::of(board, now_us, state));
        slips: u64 = board.counters().slips;
        /// In words, the newest first.
        events: Vec<String> = board.events().rev().take(EVENTS).map(|(_, event)| event.to_string().trim().to_owned()).collect();
        points: Vec<&'a Point> = board.course().since(count).collect();
    }
}

/// What pages have received.
#[derive(Clone, Copy, Debug, Default)]
pub struct Feed {
    due_us: u64,
    count: u64,
}

impl Feed {
    /// The next message: what `board` knows at host time `now_us` (us), with the points since the last one. None before it is due, and
    /// where nobody looks.
    pub fn next(&mut self, board: &Board, now_us: u64, viewers: usize) -> Option<String> {
        if now_us < self.due_us {
            return None;
        }
        self.due_us = now_us.saturating_add(EVERY_US);
        let count = core::mem::replace(&mut self.count, board.course().count);
        let json = (viewers > 0).then(|| serde_json::to_string(&Live::of(board, now_us, count)));
        json?.ok().map(|json| format!("retry: 2000\ndata: {json}\n\n"))
    }
}
