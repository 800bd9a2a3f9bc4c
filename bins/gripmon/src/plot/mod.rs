//! Plots over time by [`egui_plot`]: where values stand, axes with units, curves and areas. Nothing here knows grippers.

mod curve;
mod frame;
mod scale;

pub use curve::{DASHED, area, line, runs};
pub use frame::{Frame, GUTTER, show, time_labels};
pub use scale::{Kind, Scale};
