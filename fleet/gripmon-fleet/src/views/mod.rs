//! View of all grippers: a table with a row for each, and requests of the user. Only the rows that can be seen are drawn.

mod bars;
mod row;
mod spark;

use crate::grippers::{Column, Roster, Sorting};
use crate::{Lobby, Request, Table};
use eframe::egui::{
    self, Align2, CentralPanel, FontId, Frame, Key, Margin, Modifiers, Panel, Pos2, Rect, Role,
    ScrollArea, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};
use egui_extras::{Column as Width, TableBuilder};
use gripmon::palette::Palette;

/// Height of a row (points).
const HIGH: f32 = 22.0;
/// Space between two columns (points).
const BETWEEN: f32 = 8.0;
/// Size of the sign for the order (points).
const SIGN: f32 = 4.0;
/// Rows that a page key moves by.
const PAGE: isize = 20;

/// What the rows are drawn from.
#[derive(Clone, Copy)]
struct Seen<'a> {
    roster: &'a Roster,
    palette: Palette,
    /// The column that orders, and whether the largest stand on top.
    sorting: Sorting,
}

/// Draws the whole window, and does what the user asks for; what is left to be done.
pub(crate) fn window(ui: &mut Ui, lobby: &mut Lobby, roster: &Roster) -> Vec<Request> {
    let mut requests = pressed(ui.ctx(), lobby, roster);
    let palette = Palette::now(ui.ctx());
    let seen = Seen { roster, palette, sorting: lobby.table.sorting };
    let bar = |x, y| Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(x, y));
    let top = Panel::top("fleet").frame(bar(8, 5));
    requests.extend(top.show(ui, |ui| bars::top(ui, lobby, seen)).inner);
    Panel::bottom("fleet status").frame(bar(8, 3)).show(ui, |ui| bars::bottom(ui, lobby, seen));
    let middle = CentralPanel::default().frame(Frame::new().fill(palette.plot));
    middle.show(ui, |ui| {
        // A narrow window shows a part of the columns.
        ScrollArea::horizontal().auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(BETWEEN, 0.0);
            requests.extend(rows(ui, &mut lobby.table, seen));
        });
    });
    requests
}

/// Titles that order, and the rows that can be seen; a click on one opens its gripper.
fn rows(ui: &mut Ui, shown: &mut Table, seen: Seen<'_>) -> Option<Request> {
    let roster = seen.roster;
    if shown.len() == 0 {
        let text = if roster.rows().is_empty() {
            "No gripper is there. A gripper is listed where gripfleet runs beside its gripd, with [fleet] in the configuration."
        } else {
            "No gripper has all these words: Esc takes the filter away."
        };
        gripmon::views::empty(ui, ui.available_rect_before_wrap(), text, &seen.palette);
        return None;
    }
    let scales = spark::scale(roster.top_n());
    let mut table = TableBuilder::new(ui).sense(Sense::click()).auto_shrink(false);
    for column in Column::ALL {
        table = table.column(Width::exact(wide(column)).clip(true));
    }
    if let Some(place) = shown.reveal.take() {
        table = table.animate_scrolling(false).scroll_to_row(place, None);
    }
    let (mut sorted, mut opened) = (None, None);
    let table = table.header(HIGH, |mut head| {
        for column in Column::ALL {
            let (_, response) = head.col(|ui| title(ui, column, seen));
            let label = format!("Order by {}", column.title());
            response.widget_info(|| WidgetInfo::labeled(Role::Button, true, label.clone()));
            if response.on_hover_text(column.about()).clicked() {
                sorted = Some(column);
            }
        }
    });
    table.body(|body| {
        body.rows(HIGH, shown.len(), |mut line| {
            let Some(row) = shown.row(roster, line.index()) else { return };
            line.set_selected(shown.chosen.as_ref() == Some(&row.member));
            for column in Column::ALL {
                line.col(|ui| row::cell(ui, column, row, seen, &scales));
            }
            let response = line.response();
            response.widget_info(|| {
                WidgetInfo::labeled(Role::Button, true, row::label(row, roster.now_s()))
            });
            if response.clicked() {
                opened = Some(row.member.clone());
            }
        });
    });
    if let Some(column) = sorted {
        shown.sort(roster, column);
    }
    if opened.is_some() {
        shown.chosen.clone_from(&opened);
    }
    opened.map(Request::Open)
}

/// A title, with the sign for the order.
fn title(ui: &Ui, column: Column, seen: Seen<'_>) {
    let sorted = seen.sorting.column == column;
    let colour = if sorted { seen.palette.text } else { seen.palette.weak };
    let (place, align) = edge(ui.max_rect(), column);
    let font = FontId::proportional(11.5);
    let text = ui.painter().text(place, align, column.title(), font, colour);
    if sorted {
        let side = if is_right(column) { text.left() - 6.0 } else { text.right() + 6.0 };
        let out = if seen.sorting.descending { SIGN / 2.0 } else { -SIGN / 2.0 };
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

/// Does what the keys of this frame ask for.
fn pressed(ctx: &egui::Context, lobby: &mut Lobby, roster: &Roster) -> Vec<Request> {
    // While text is typed, the keys that type nothing still move through the rows.
    let typing = ctx.text_edit_focused();
    let moves = |key| ctx.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    let is = |key| !typing && moves(key);
    for (key, by) in
        [(Key::ArrowDown, 1), (Key::ArrowUp, -1), (Key::PageDown, PAGE), (Key::PageUp, -PAGE)]
    {
        if moves(key) {
            lobby.table.step(roster, by);
        }
    }
    for (key, place) in [(Key::Home, 0), (Key::End, usize::MAX)] {
        if is(key) {
            lobby.table.choose(roster, place);
        }
    }
    if is(Key::Escape) {
        lobby.clear(roster);
    }
    if is(Key::L) {
        lobby.toggle();
    }
    let opened = if moves(Key::Enter) { lobby.opened(roster) } else { None };
    opened.into_iter().chain(is(Key::S).then_some(Request::Picture)).collect()
}
