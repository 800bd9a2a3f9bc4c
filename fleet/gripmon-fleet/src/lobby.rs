//! The table without a system's window around it: one frame from roster and requests, and what is left to be done.

use super::hall::Hall;
use super::table::Table;
use crate::grippers::{Member, Roster};
use crate::views::window;
use eframe::egui::{Theme, Ui};
use gripmon::layout::Look;
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
        let hall = Arc::clone(&self.hall);
        hall.look(|roster| {
            self.table.arrange(roster);
            window(ui, self, roster)
        })
    }

    /// Light or dark.
    pub(crate) fn toggle(&mut self) {
        self.theme = if self.theme == Look::Dark { Look::Light } else { Look::Dark };
    }

    /// The chosen gripper, to be opened.
    pub(crate) fn opened(&self, roster: &Roster) -> Option<Request> {
        let row = self.table.row(roster, self.table.chosen_place(roster)?)?;
        Some(Request::Open(row.member.clone()))
    }

    /// What was said last goes; where nothing was, nothing is chosen and filtered any more.
    pub(crate) fn clear(&mut self, roster: &Roster) {
        if self.message.take().is_none() {
            self.table.chosen = None;
            self.table.filter(roster, String::new());
        }
    }
}
