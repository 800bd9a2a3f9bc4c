//! View of all grippers: a table with a row for each, and requests of the user. Only the rows that can be seen are drawn.

mod bars;
mod row;
mod spark;

use crate::grippers::{Column, Roster};
use crate::{Table, TableAction};
use eframe::egui::{
    self, Align2, CentralPanel, FontId, Frame, Key, Margin, Modifiers, Panel, Pos2, Rect, Role,
    ScrollArea, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};
use egui_extras::{Column as Width, TableBuilder};
use gripmon::palette::Palette;
use gripmon::state::Message;

/// Height of a row (points).
const HIGH: f32 = 22.0;
/// Space between two columns (points).
const BETWEEN: f32 = 8.0;
/// Size of the sign for the order (points).
const SIGN: f32 = 4.0;
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
            ui.spacing_mut().item_spacing = vec2(BETWEEN, 0.0);
            rows(ui, seen, &mut actions);
        });
    });
    actions
}

/// Titles that order, and the rows that can be seen; a click on one opens its gripper.
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
    let scales = spark::scale(seen.roster.top_n());
    let mut table = TableBuilder::new(ui).sense(Sense::click()).auto_shrink(false);
    for column in Column::ALL {
        table = table.column(Width::exact(wide(column)).clip(true));
    }
    if let Some(place) = seen.reveal {
        table = table.animate_scrolling(false).scroll_to_row(place, None);
    }
    let table = table.header(HIGH, |mut head| {
        for column in Column::ALL {
            let (_, response) = head.col(|ui| title(ui, column, seen));
            let label = format!("Order by {}", column.title());
            response.widget_info(|| WidgetInfo::labeled(Role::Button, true, label.clone()));
            if response.on_hover_text(column.about()).clicked() {
                actions.push(TableAction::Sort(column));
            }
        }
    });
    table.body(|body| {
        body.rows(HIGH, seen.table.len(), |mut line| {
            let Some(row) = seen.table.row(seen.roster, line.index()) else { return };
            line.set_selected(seen.table.chosen.as_ref() == Some(&row.member));
            for column in Column::ALL {
                line.col(|ui| row::cell(ui, column, row, seen, &scales));
            }
            let response = line.response();
            response.widget_info(|| {
                WidgetInfo::labeled(Role::Button, true, row::label(row, seen.roster.now_s()))
            });
            if response.clicked() {
                actions.push(TableAction::Open(row.member.clone()));
            }
        });
    });
}

/// A title, with the sign for the order.
fn title(ui: &Ui, column: Column, seen: &TableSeen<'_>) {
    let sorted = seen.table.sorting.column == column;
    let colour = if sorted { seen.palette.text } else { seen.palette.weak };
    let (place, align) = edge(ui.max_rect(), column);
    let font = FontId::proportional(11.5);
    let text = ui.painter().text(place, align, column.title(), font, colour);
    if sorted {
        let side = if is_right(column) { text.left() - 6.0 } else { text.right() + 6.0 };
        let out = if seen.table.sorting.descending { SIGN / 2.0 } else { -SIGN / 2.0 };
        let at = pos2(side, text.center().y);
        let corners = vec![at + vec2(-SIGN, -out), at + vec2(SIGN, -out), at + vec2(0.0, out)];
        ui.painter().add(Shape::convex_polygon(corners, colour, Stroke::NONE));
    }
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

/// Where the text of a cell stands.
fn edge(cell: Rect, column: Column) -> (Pos2, Align2) {
    if is_right(column) {
        (cell.right_center(), Align2::RIGHT_CENTER)
    } else {
        (cell.left_center(), Align2::LEFT_CENTER)
    }
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
