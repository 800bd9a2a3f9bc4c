//! Roster of all grippers that are or were there in this session, from what the network reports.

use super::row::{Presence, Row, Trouble};
use super::spark::{COLUMN_S, COLUMNS};
use super::{FleetFeed, Member, Received};
use grip_scope::feed::SourceStatus;
use std::collections::HashMap;

/// Most grippers that are kept: names come from a network, and each takes some 2 kB.
pub const MOST: usize = 20_000;
/// Largest force that scales the curves (N): beyond it is no force of a gripper.
const LARGEST_N: f32 = 10_000.0;

/// How many are how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// All.
    pub all: usize,
    /// There, and telling.
    pub here: usize,
    /// There, and silent.
    pub silent: usize,
    /// Gone.
    pub gone: usize,
    /// With a fault.
    pub faults: usize,
    /// There, with no samples from the gripper.
    pub links: usize,
    /// With a sensor that is not good, and no fault.
    pub sensors: usize,
    /// Slipping.
    pub slipping: usize,
}

/// All grippers of a network.
#[derive(Debug, Default)]
pub struct Roster {
    rows: Vec<Row>,
    places: HashMap<Member, usize>,
    status: SourceStatus,
    now_s: f64,
    /// When something of a gripper came last (s).
    reported_s: f64,
    revision: u64,
    unreadable: u64,
    refused: u64,
}

impl Roster {
    /// Takes one item.
    pub fn take(&mut self, feed: FleetFeed) {
        match feed {
            FleetFeed::Status(status) => {
                self.revision += u64::from(status != self.status);
                self.status = status;
            }
            FleetFeed::Of { member, at_s, what } => self.receive(member, at_s, &what),
            FleetFeed::Now(now_s) => self.pass(now_s),
            FleetFeed::Unreadable => {
                self.unreadable += 1;
                self.revision += 1;
            }
        }
    }

    fn receive(&mut self, member: Member, at_s: f64, what: &Received) {
        self.revision += 1;
        let place = match self.places.get(&member) {
            Some(place) => *place,
            None if self.rows.len() >= MOST => {
                self.refused += 1;
                return;
            }
            // Who was never here is not shown as gone, and who has answered may be gone again.
            None if matches!(what, Received::Gone | Received::About(_)) => return,
            None => {
                self.rows.push(Row::new(member.clone(), at_s));
                self.places.insert(member, self.rows.len() - 1);
                self.rows.len() - 1
            }
        };
        (self.now_s, self.reported_s) = (self.now_s.max(at_s), self.reported_s.max(at_s));
        let read = self.rows.get_mut(place).is_none_or(|row| row.take(at_s, what));
        self.unreadable += u64::from(!read);
    }

    /// Time goes on: whether that can be seen.
    fn pass(&mut self, now_s: f64) {
        let before_s = self.now_s;
        self.now_s = before_s.max(now_s);
        let passes = |step_s: f64| (before_s / step_s).floor() < (self.now_s / step_s).floor();
        // Curves slide until they are empty, and what is gone is gone for some minutes more.
        let slides = self.now_s < self.reported_s + COLUMN_S * (COLUMNS as f64 + 1.0);
        let seen =
            self.rows.iter().any(Row::is_alive) || slides && passes(COLUMN_S) || passes(60.0);
        self.revision += u64::from(seen && !self.rows.is_empty());
    }

    /// All rows, in the order in which they came; a row keeps its place.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// How the way to the router is.
    #[must_use]
    pub const fn status(&self) -> &SourceStatus {
        &self.status
    }

    /// The time that the table is of (s).
    #[must_use]
    pub const fn now_s(&self) -> f64 {
        self.now_s
    }

    /// Another one whenever something that can be seen is new.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// What came that no gripd sends.
    #[must_use]
    pub const fn unreadable(&self) -> u64 {
        self.unreadable
    }

    /// What came of grippers beyond [`MOST`].
    #[must_use]
    pub const fn refused(&self) -> u64 {
        self.refused
    }

    /// Events of all grippers that nobody has any more.
    #[must_use]
    pub fn missing(&self) -> u64 {
        self.rows.iter().map(|row| row.missing).sum()
    }

    /// The largest force of the last minutes (N): the scale of all curves of force.
    #[must_use]
    pub fn top_n(&self) -> f32 {
        let highest = self.rows.iter().filter_map(|row| row.force.highest(self.now_s));
        highest.filter(|force_n| *force_n <= LARGEST_N).fold(0.0, f32::max)
    }

    /// How many are how.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let mut summary = Summary { all: self.rows.len(), ..Summary::default() };
        for row in &self.rows {
            match row.presence(self.now_s) {
                Presence::Here => summary.here += 1,
                Presence::Silent(_) => summary.silent += 1,
                Presence::Gone(_) => summary.gone += 1,
            }
            match row.trouble(self.now_s) {
                Trouble::Fault => summary.faults += 1,
                Trouble::Link => summary.links += 1,
                Trouble::Sensor => summary.sensors += 1,
                Trouble::Slipping => summary.slipping += 1,
                Trouble::None | Trouble::Silent | Trouble::Gone => {}
            }
        }
        summary
    }
}
