//! Places of a ribbon with their tops and bottoms in; the corners and triangles of a mesh out, whole or in dashes.

use super::dash;
use eframe::egui::{Color32, Mesh, Pos2, Rangef, epaint::Vertex, epaint::WHITE_UV, pos2};

/// Half the thickness of a level curve (points).
const HALF: f32 = 0.6;
/// Width over which edges fade (points).
const FADE: f32 = 0.8;

/// Draws stretches, whole or in dashes.
pub(super) struct Pen<'a> {
    mesh: &'a mut Mesh,
    colour: Color32,
    /// Where dashes are counted from.
    dashes_from: Option<f32>,
    /// The last place of dashes, its top and bottom, and whether it is in one that has begun.
    last: Option<(f32, Rangef, bool)>,
}

impl<'a> Pen<'a> {
    /// A pen for whole stretches, or for dashes that are counted from a place across.
    pub(super) const fn new(mesh: &'a mut Mesh, colour: Color32, dashes_from: Option<f32>) -> Self {
        Self { mesh, colour, dashes_from, last: None }
    }

    /// A stretch begins.
    pub(super) fn begin(&mut self, x: f32, edges: Rangef) {
        match self.dashes_from {
            Some(_) => self.last = Some((x, edges, false)),
            None => column(self.mesh, x, edges, self.colour, false),
        }
    }

    /// It goes on to here.
    pub(super) fn on(&mut self, x: f32, edges: Rangef) {
        let Some(left) = self.dashes_from else {
            return column(self.mesh, x, edges, self.colour, true);
        };
        let Some((from, before, begun)) = self.last else { return };
        let at = |place: f32| {
            let share = (place - from) / (x - from);
            Rangef::new(
                before.min + share * (edges.min - before.min),
                before.max + share * (edges.max - before.max),
            )
        };
        let mut goes_on = false;
        for dash in dash::across(left, Rangef::new(from, x)) {
            if !(begun && dash.min <= from) {
                column(self.mesh, dash.min, at(dash.min), self.colour, false);
            }
            column(self.mesh, dash.max, at(dash.max), self.colour, true);
            goes_on = dash.max >= x;
        }
        self.last = Some((x, edges, goes_on));
    }
}

/// Four corners at `x` and, where it continues, the area since the last four.
pub(super) fn column(mesh: &mut Mesh, x: f32, edges: Rangef, colour: Color32, continues: bool) {
    let Ok(base) = u32::try_from(mesh.vertices.len()) else { return };
    let clear = Color32::TRANSPARENT;
    let corners = [
        (edges.min - HALF - FADE, clear),
        (edges.min - HALF, colour),
        (edges.max + HALF, colour),
        (edges.max + HALF + FADE, clear),
    ];
    let corners = corners.map(|(y, color)| corner(pos2(x, y), color));
    if continues && lengthen(mesh, &corners) {
        return;
    }
    mesh.vertices.extend(corners);
    if !continues || base < 4 {
        return;
    }
    for row in 0..3 {
        let (a, b) = (base - 4 + row, base + row);
        mesh.indices.extend([a, a + 1, b, b, a + 1, b + 1]);
    }
}

/// Moves the last column to where the next one stands, if it, the one that it continues and the next are the same but for their place: a level
/// stretch has two columns, however long it is.
fn lengthen(mesh: &mut Mesh, next: &[Vertex; 4]) -> bool {
    let ends = u32::try_from(mesh.vertices.len())
        .is_ok_and(|len| mesh.indices.last() == Some(&(len.wrapping_sub(1))));
    let Some(two) = mesh.vertices.last_chunk_mut::<8>().filter(|_| ends) else { return false };
    let (before, last) = two.split_at_mut(4);
    let alike = |column: &[Vertex]| {
        column.iter().zip(next).all(|(a, b)| a.pos.y == b.pos.y && a.color == b.color)
    };
    if !alike(last) || !alike(before) {
        return false;
    }
    last.copy_from_slice(next);
    true
}

const fn corner(pos: Pos2, color: Color32) -> Vertex {
    Vertex { pos, uv: WHITE_UV, color }
}
