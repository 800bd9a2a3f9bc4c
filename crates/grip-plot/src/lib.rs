//! Charts of numbers in one style, as SVG or PNG; pages that hold them, as HTML ([`report`]).
//!
//! A [`Chart`] is a title, two axes and layers: lines, markers, bars. Everything about looks stands here, so that every
//! chart of the workspace looks alike; nothing outside knows the drawing library.
//!
//! ```
//! use grip_plot::{Axis, Chart, Layer};
//!
//! let chart = Chart::new("Height", Axis::linear("x (mm)"), Axis::linear("z (um)"))
//!     .with(Layer::line("profile", vec![(0.0, 1.0), (0.1, 3.0), (0.2, 2.0)]))
//!     .with(Layer::markers("peaks", vec![(0.1, 3.0)]));
//! assert!(chart.svg()?.starts_with("<svg"));
//! # Ok::<(), grip_plot::PlotError>(())
//! ```

mod chart;
mod draw;
pub mod report;

pub use chart::{Axis, Chart, Layer, Mark, PlotError, Scale};
