//! The titles of the columns: a click orders the rows.

use super::{HIGH, TableSeen, cell, columns, is_right, width};
use crate::TableAction;
use crate::grippers::Column;
use eframe::egui::{Align2, FontId, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};

/// Size of the sign for the order (points).
const SIGN: f32 = 4.0;

pub(super) fn head(ui: &mut Ui, seen: &TableSeen<'_>, actions: &mut Vec<TableAction>) {
    let wide = width().max(ui.available_width());
    let (line, _) = ui.allocate_exact_size(vec2(wide, HIGH + 2.0), Sense::hover());
    ui.painter().rect_filled(line, 0, seen.palette.panel);
    for (column, left) in columns() {
        if title(ui, cell(line, column, left), column, seen) {
            actions.push(TableAction::Sort(column));
        }
    }
    ui.painter().hline(line.x_range(), line.bottom(), Stroke::new(1.0, seen.palette.edge));
}

/// Draws a title; whether it was clicked.
fn title(ui: &Ui, rect: Rect, column: Column, seen: &TableSeen<'_>) -> bool {
    let response = ui.interact(rect, ui.scope_id().with(("title", column)), Sense::click());
    let label = || WidgetInfo::labeled(Role::Button, true, format!("Order by {}", column.title()));
    response.widget_info(label);
    let sorted = seen.table.sorting.column == column;
    let colour = if sorted || response.hovered() { seen.palette.text } else { seen.palette.weak };
    let (place, align) = if is_right(column) {
        (rect.right_center(), Align2::RIGHT_CENTER)
    } else {
        (rect.left_center(), Align2::LEFT_CENTER)
    };
    let font = FontId::proportional(11.5);
    let text = ui.painter().text(place, align, column.title(), font, colour);
    if sorted {
        let side = if is_right(column) { text.left() - 6.0 } else { text.right() + 6.0 };
        let out = if seen.table.sorting.descending { SIGN / 2.0 } else { -SIGN / 2.0 };
        let at = pos2(side, rect.center().y);
        let corners = vec![at + vec2(-SIGN, -out), at + vec2(SIGN, -out), at + vec2(0.0, out)];
        ui.painter().add(Shape::convex_polygon(corners, colour, Stroke::NONE));
    }
    response.on_hover_text(column.about()).clicked()
}
