//! One row of the table.

use super::spark::{self, Scales};
use super::{HIGH, TableSeen, cell, columns, is_right, width};
use crate::TableAction;
use crate::grippers::{Column, Presence, Row, Trouble};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Rect, Role, Sense, Stroke, Ui, WidgetInfo, vec2,
};
use gripmon::palette::{Palette, Tone};

/// Draws a row; a click opens its gripper.
pub(super) fn row(
    ui: &mut Ui,
    row: &Row,
    seen: &TableSeen<'_>,
    scales: &Scales,
) -> Option<TableAction> {
    let wide = width().max(ui.available_width());
    let (rect, response) = ui.allocate_exact_size(vec2(wide, HIGH), Sense::click());
    let now_s = seen.roster.now_s();
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, label(row, now_s)));
    let trouble = row.trouble(now_s);
    ground(ui.painter(), rect, row, trouble, response.hovered(), seen);
    for (column, left) in columns() {
        let cell = cell(rect, column, left);
        match column {
            Column::Trouble => lamp(ui.painter(), cell, trouble, &seen.palette),
            Column::Force => spark::force(ui.painter(), cell, row, seen, scales),
            Column::Statistic => spark::statistic(ui.painter(), cell, row, seen, scales),
            column => text(ui.painter(), cell, column, row, seen),
        }
    }
    response.clicked().then(|| TableAction::Open(row.member.clone()))
}

/// What the row states, for those who cannot see it.
fn label(row: &Row, now_s: f64) -> String {
    let part = |column: Column| format!("{} {}", column.title(), column.text(row, now_s));
    let reported = Column::ALL.into_iter().filter(|column| *column != Column::Trouble).map(part);
    reported.collect::<Vec<_>>().join(", ")
}

fn ground(
    painter: &Painter,
    rect: Rect,
    row: &Row,
    trouble: Trouble,
    hovered: bool,
    seen: &TableSeen<'_>,
) {
    let palette = &seen.palette;
    if trouble == Trouble::Fault {
        painter.rect_filled(rect, 0, palette.wash(Tone::Red));
    }
    if seen.table.chosen.as_ref() == Some(&row.member) {
        painter.rect_filled(rect, 0, palette.tone(Tone::Blue).gamma_multiply(0.3));
    } else if hovered {
        painter.rect_filled(rect, 0, palette.grid);
    }
    painter.hline(rect.x_range(), rect.bottom(), palette.grid_stroke());
}

/// What the trouble of a row is drawn in.
const fn tone(trouble: Trouble) -> Tone {
    match trouble {
        Trouble::None => Tone::Green,
        Trouble::Slipping => Tone::Blue,
        Trouble::Sensor | Trouble::Link | Trouble::Silent | Trouble::Gone => Tone::Orange,
        Trouble::Fault => Tone::Red,
    }
}

/// A lamp whose form shows as much as its colour: a square has stopped, a ring is gone or silent.
fn lamp(painter: &Painter, cell: Rect, trouble: Trouble, palette: &Palette) {
    let (at, colour) = (cell.center(), palette.tone(tone(trouble)));
    match trouble {
        Trouble::Fault => {
            painter.rect_filled(Rect::from_center_size(at, vec2(10.0, 10.0)), 0, colour);
        }
        Trouble::Gone | Trouble::Silent => {
            painter.circle_stroke(at, 4.0, Stroke::new(1.5, colour));
        }
        Trouble::None => {
            painter.circle_filled(at, 3.0, colour);
        }
        Trouble::Link | Trouble::Sensor | Trouble::Slipping => {
            painter.circle_filled(at, 4.5, colour);
        }
    }
}

fn text(painter: &Painter, cell: Rect, column: Column, row: &Row, seen: &TableSeen<'_>) {
    let now_s = seen.roster.now_s();
    let (place, align) = if is_right(column) {
        (cell.right_center(), Align2::RIGHT_CENTER)
    } else {
        (cell.left_center(), Align2::LEFT_CENTER)
    };
    let font = match column {
        Column::Gripper => FontId::monospace(10.5),
        column if is_right(column) => FontId::monospace(11.5),
        _ => FontId::proportional(12.0),
    };
    let colour = colour(column, row, seen);
    // A long name ends at the next column.
    let clipped = painter.with_clip_rect(cell.intersect(painter.clip_rect()));
    clipped.text(place, align, column.text(row, now_s), font, colour);
}

/// What is wrong stands out; what is not known any more, or usual, is quiet.
fn colour(column: Column, row: &Row, seen: &TableSeen<'_>) -> Color32 {
    let (palette, now_s) = (&seen.palette, seen.roster.now_s());
    let presence = row.presence(now_s);
    let is_here = presence == Presence::Here;
    match column {
        Column::Fault if row.fault().is_some() => palette.tone(Tone::Red),
        Column::Here if !is_here => palette.tone(Tone::Orange),
        Column::Site | Column::Gripper if !matches!(presence, Presence::Gone(_)) => palette.text,
        _ if !is_here => palette.tone(Tone::Quiet),
        Column::Link if !row.streams() => palette.tone(Tone::Orange),
        Column::Sensors if row.worst_sensor().is_some() => palette.tone(Tone::Orange),
        Column::Lost if row.lost().is_some_and(|lost| lost > 0) => palette.tone(Tone::Orange),
        Column::Scene | Column::Grip if column.text(row, now_s) == "slipping" => {
            palette.tone(Tone::Blue)
        }
        Column::Minute if row.slips_last_minute(now_s) == 0 => palette.weak,
        Column::Here | Column::Link | Column::Sensors | Column::Fault => palette.weak,
        Column::Model | Column::Firmware => palette.weak,
        _ => palette.text,
    }
}
