//! One row of the table.

use super::spark::{self, Scales};
use super::{BETWEEN, Seen, edge, is_right};
use crate::grippers::{Column, Presence, Row, Trouble};
use eframe::egui::{Color32, FontId, Painter, Rect, Stroke, Ui, vec2};
use gripmon::palette::{Palette, Tone};

/// Draws what a column shows of a row.
pub(super) fn cell(ui: &Ui, column: Column, row: &Row, seen: Seen<'_>, scales: &Scales) {
    let (painter, cell, trouble) = (ui.painter(), ui.max_rect(), row.trouble(seen.roster.now_s()));
    // The space between two columns is a half of each.
    let ground = cell.expand2(ui.spacing().item_spacing / 2.0);
    let open = painter.with_clip_rect(ground.intersect(painter.clip_rect().expand(BETWEEN)));
    if trouble == Trouble::Fault {
        open.rect_filled(ground, 0, seen.palette.wash(Tone::Red));
    }
    open.hline(ground.x_range(), ground.bottom(), seen.palette.grid_stroke());
    match column {
        Column::Trouble => lamp(painter, cell, trouble, &seen.palette),
        Column::Force => spark::force(painter, cell, row, seen, scales),
        Column::Statistic => spark::statistic(painter, cell, row, seen, scales),
        column => text(painter, cell, column, row, seen),
    }
}

/// What the row states, for those who cannot see it.
pub(super) fn label(row: &Row, now_s: f64) -> String {
    let part = |column: Column| format!("{} {}", column.title(), column.text(row, now_s));
    let reported = Column::ALL.into_iter().filter(|column| *column != Column::Trouble).map(part);
    reported.collect::<Vec<_>>().join(", ")
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

fn text(painter: &Painter, cell: Rect, column: Column, row: &Row, seen: Seen<'_>) {
    let now_s = seen.roster.now_s();
    let (place, align) = edge(cell, column);
    let font = match column {
        Column::Gripper => FontId::monospace(10.5),
        column if is_right(column) => FontId::monospace(11.5),
        _ => FontId::proportional(12.0),
    };
    let colour = colour(column, row, seen);
    painter.text(place, align, column.text(row, now_s), font, colour);
}

/// What is wrong stands out; what is not known any more, or usual, is quiet.
fn colour(column: Column, row: &Row, seen: Seen<'_>) -> Color32 {
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
