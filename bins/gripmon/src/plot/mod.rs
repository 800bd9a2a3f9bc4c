//! Drawing of curves: a rectangle, a span of time and a scale of values in; shapes out. Nothing here knows grippers.

mod dash;
mod frame;
mod line;
mod pen;
mod ribbon;
mod scale;

pub use frame::{Across, Frame, GUTTER, grid, labels, time_axis, value_axis};
pub use line::{Style, polyline};
pub use ribbon::{band, ribbon};
pub use scale::{Kind, Scale};
