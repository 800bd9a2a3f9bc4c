//! All grippers in; a table with a row for each, and requests of the user, out. Only the rows that can be seen are drawn.

mod bars;
mod head;
mod row;
mod spark;

use crate::grippers::{Column, Roster};
use crate::{Table, TableAction};
use eframe::egui::{self, CentralPanel, Frame, Key, Margin, Modifiers, Panel, ScrollArea, Ui};
use gripmon::num;
use gripmon::palette::Palette;
use gripmon::state::Message;

/// Height of a row (points).
const HIGH: f32 = 22.0;
/// Space between two columns (points).
const BETWEEN: f32 = 8.0;
/// Rows that a page key moves by.
const PAGE: isize = 20;

/// What the table may look at.
#[derive(Clone, Copy, Debug)]
pub struct TableSeen<'a> {
    /// All grippers.
    pub roster: &'a Roster,
    /// What the user wants to see.
    pub table: &'a Table,
    /// The colours.
    pub palette: Palette,
    /// The row to scroll to.
    pub reveal: Option<usize>,
    /// What was done or failed last.
    pub message: Option<&'a Message>,
    /// The network, for people.
    pub place: &'a str,
}

/// Draws the whole window.
pub fn table(ui: &mut Ui, seen: &TableSeen<'_>) -> Vec<TableAction> {
    let mut actions = pressed(ui.ctx());
    let bar = |x, y| Frame::new().fill(seen.palette.panel).inner_margin(Margin::symmetric(x, y));
    Panel::top("fleet").frame(bar(8, 5)).show(ui, |ui| bars::top(ui, seen, &mut actions));
    Panel::bottom("fleet status").frame(bar(8, 3)).show(ui, |ui| bars::bottom(ui, seen));
    let middle = CentralPanel::default().frame(Frame::new().fill(seen.palette.plot));
    middle.show(ui, |ui| {
        // A narrow window shows a part of the columns.
        ScrollArea::horizontal().auto_shrink([false, false]).show(ui, |ui| {
            ui.set_min_width(width());
            ui.spacing_mut().item_spacing.y = 0.0;
            head::head(ui, seen, &mut actions);
            rows(ui, seen, &mut actions);
        });
    });
    actions
}

fn rows(ui: &mut Ui, seen: &TableSeen<'_>, actions: &mut Vec<TableAction>) {
    if seen.table.is_empty() {
        let text = if seen.roster.rows().is_empty() {
            "No gripper is there. A gripper is listed where gripfleet runs beside its gripd, with [fleet] in the configuration."
        } else {
            "No gripper has all these words: Esc takes the filter away."
        };
        gripmon::views::empty(ui, ui.available_rect_before_wrap(), text, &seen.palette);
        return;
    }
    let mut area = ScrollArea::vertical().auto_shrink([false, false]);
    if let Some(place) = seen.reveal {
        area = area.vertical_scroll_offset(offset(ui, place));
    }
    let scale = spark::scale(seen.roster.top_n());
    let shown = area.show_rows(ui, HIGH, seen.table.len(), |ui, places| {
        for place in places {
            if let Some(row) = seen.table.row(seen.roster, place) {
                actions.extend(row::row(ui, row, seen, &scale));
            }
        }
    });
    ui.data_mut(|data| {
        data.insert_temp(ui.scope_id().with("offset"), shown.state.clamped_offset().y)
    });
}

/// How far down the rows are scrolled so that this one is seen, and moved no more than that needs.
fn offset(ui: &Ui, place: usize) -> f32 {
    let now: f32 = ui.data(|data| data.get_temp(ui.scope_id().with("offset"))).unwrap_or(0.0);
    let top = HIGH * num::narrow(num::count(place));
    let lowest = top - (ui.available_height() - HIGH).max(0.0);
    now.clamp(lowest.min(top), top).max(0.0)
}

/// Width of a column (points).
const fn wide(column: Column) -> f32 {
    match column {
        Column::Trouble => 18.0,
        Column::Site => 74.0,
        Column::Gripper => 206.0,
        Column::Here => 76.0,
        Column::Link => 56.0,
        Column::Scene | Column::Grip => 56.0,
        Column::Command | Column::Applied => 52.0,
        Column::Force | Column::Statistic => 112.0,
        Column::Slips => 42.0,
        Column::Minute => 44.0,
        Column::Lost => 46.0,
        Column::Sensors => 96.0,
        Column::Fault => 36.0,
        Column::Model => 98.0,
        Column::Firmware => 54.0,
    }
}

/// Whether what it reports stands at its right edge.
const fn is_right(column: Column) -> bool {
    matches!(
        column,
        Column::Command | Column::Applied | Column::Slips | Column::Minute | Column::Lost
    )
}

/// Columns from left to right, with their left edges.
fn columns() -> impl Iterator<Item = (Column, f32)> {
    Column::ALL.into_iter().scan(BETWEEN, |left, column| {
        let here = *left;
        *left += wide(column) + BETWEEN;
        Some((column, here))
    })
}

/// Width of all columns (points).
fn width() -> f32 {
    BETWEEN + Column::ALL.into_iter().map(|column| wide(column) + BETWEEN).sum::<f32>()
}

/// The part of a row's rectangle that is a column's.
fn cell(row: egui::Rect, column: Column, left: f32) -> egui::Rect {
    let corner = row.left_top() + egui::vec2(left, 0.0);
    egui::Rect::from_min_size(corner, egui::vec2(wide(column), row.height()))
}

/// What the keys of this frame ask for.
fn pressed(ctx: &egui::Context) -> Vec<TableAction> {
    let keys = [
        (Key::ArrowDown, TableAction::Step(1)),
        (Key::ArrowUp, TableAction::Step(-1)),
        (Key::PageDown, TableAction::Step(PAGE)),
        (Key::PageUp, TableAction::Step(-PAGE)),
        (Key::End, TableAction::Last),
        (Key::Home, TableAction::First),
        (Key::Enter, TableAction::OpenChosen),
        (Key::Escape, TableAction::Clear),
        (Key::L, TableAction::ToggleTheme),
        (Key::S, TableAction::Picture),
    ];
    // While text is typed, the keys that type nothing still move through the rows.
    let typing = ctx.text_edit_focused();
    let moves = |key| {
        matches!(key, Key::ArrowDown | Key::ArrowUp | Key::PageDown | Key::PageUp | Key::Enter)
    };
    let obeyed = keys.into_iter().filter(|(key, _)| !typing || moves(*key));
    ctx.input_mut(|input| {
        obeyed
            .filter(|(key, _)| input.consume_key(Modifiers::NONE, *key))
            .map(|(_, action)| action)
            .collect()
    })
}
