//! What a frame of the table costs without a window, as `cargo bench -p gripmon --bench frames` measures those of gripmon.

#[path = "../../../bins/gripmon/benches/frames.rs"]
#[expect(dead_code, reason = "gripmon measures more")]
mod frames;
#[path = "../tests/window/grippers.rs"]
#[expect(clippy::unwrap_used, reason = "part of a test")]
mod grippers;

use eframe::egui::Context;
use frames::{Drawn, FRAMES, heading, line, now, shown};
use gripmon::{layout::Look, scope};
use gripmon_fleet::{Hall, Lobby};
use grippers::{many, member, of, reported, state};
use std::sync::Arc;

/// The table of many grippers, each of which has shown something new before each frame.
fn main() {
    heading();
    for count in [200, 1000] {
        let ctx = Context::default();
        scope::prepare(&ctx, Look::Dark);
        let hall = Arc::new(Hall::new(many(count)));
        let mut lobby = Lobby::new(Arc::clone(&hall), Look::Dark, "a router".to_owned());
        let (mut taken, mut drawn) = (Vec::new(), Drawn::default());
        for i in 0..FRAMES + 20 {
            let force_n = 10.0 + (i as f32 * 0.1).sin();
            let of_one = |number: u16| {
                let site = if number.is_multiple_of(2) { "hall-1" } else { "hall-2" };
                of(&member(site, number), 200.0 + 0.2 * i as f64, reported(&state(force_n)))
            };
            let feeds: Vec<_> = (0..count).map(of_one).collect();
            let start = now();
            feeds.into_iter().for_each(|feed| hall.take(feed));
            taken.push(start.elapsed());
            // Other rows are seen in each frame.
            lobby.table.reveal = Some((i * 3) % usize::from(count));
            drawn.frame(&ctx, i, |ui| drop(lobby.ui(ui)));
        }
        drawn.print(&format!("table of {count} grippers, scrolled in each frame"));
        taken.sort();
        let name = "  a STATE of each into the table";
        line(&format!("{name:<46} {:>9}", shown(taken[taken.len() / 2])));
    }
}
