//! The table without a system's window around it: one frame from roster and requests, and what is left to be done.

use super::hall::Hall;
use super::table::{Table, TableAction};
use crate::grippers::Member;
use crate::views::{TableSeen, table};
use eframe::egui::{Theme, Ui};
use gripmon::layout::Look;
use gripmon::palette::Palette;
use gripmon::state::Message;
use std::sync::Arc;

/// What the table leaves to the window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Open this gripper.
    Open(Member),
    /// Make a picture of the window.
    Picture,
}

/// The table.
#[derive(Debug)]
pub struct Lobby {
    /// All grippers.
    pub hall: Arc<Hall>,
    /// What the user wants to see of them.
    pub table: Table,
    /// Colours.
    pub theme: Look,
    /// What was done or failed last.
    pub message: Option<Message>,
    /// The network, for people.
    pub place: String,
}

impl Lobby {
    /// A table of these grippers.
    #[must_use]
    pub fn new(hall: Arc<Hall>, theme: Look, place: String) -> Self {
        Self { hall, table: Table::default(), theme, message: None, place }
    }

    /// Draws a frame and fulfils what the user asks for in it; what is left to be done.
    pub fn ui(&mut self, ui: &mut Ui) -> Vec<Request> {
        let theme = if self.theme == Look::Dark { Theme::Dark } else { Theme::Light };
        if ui.ctx().theme() != theme {
            ui.ctx().set_theme(theme);
            ui.ctx().request_repaint();
        }
        let (hall, palette) = (Arc::clone(&self.hall), Palette::of(theme));
        hall.look(|roster| {
            self.table.arrange(roster);
            let reveal = self.table.reveal.take();
            let (message, place) = (self.message.as_ref(), self.place.as_str());
            let seen = TableSeen { roster, table: &self.table, palette, reveal, message, place };
            let actions = table(ui, &seen);
            actions.into_iter().filter_map(|action| self.apply(roster, action)).collect()
        })
    }

    fn apply(&mut self, roster: &crate::grippers::Roster, action: TableAction) -> Option<Request> {
        match action {
            TableAction::ToggleTheme => {
                self.theme = if self.theme == Look::Dark { Look::Light } else { Look::Dark };
                None
            }
            TableAction::Picture => Some(Request::Picture),
            TableAction::Clear if self.message.is_some() => {
                self.message = None;
                None
            }
            other => self.table.apply(roster, other).map(Request::Open),
        }
    }
}
