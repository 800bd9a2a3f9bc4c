//! Reader and writer of checked samples and labels: recordings of gripper sensors as CSV, and everything that leaves gripd as
//! MCAP ([`mcap`]).
//!
//! A recording is a table ([`grip_table`]) whose columns are found by name; other names, units and clocks are understood as
//! [`find`](mod@find), [`time`] and [`pace`] say:
//!
//! | column | unit | goes to |
//! |---|---|---|
//! | `t_s` | s, rounded to 1 us | `Sample::t`; may be absent if a rate is given |
//! | `stylus` or `vibration` | m, or the sensor's own units | `Sample::stylus` (required) |
//! | `vibration_x`, `vibration_y`, .. | own units | up to three axes of one sensor: `Sample::stylus` and `Sample::stylus_axes` |
//! | `force_n` | N | `Sample::normal_force_n` |
//! | `tangential_n` | N | `Sample::tangential_n` |
//! | `travel_mm` or `travel_m` | mm or m | `Sample::travel_m` |
//! | `velocity_m_s` | m/s | `Sample::velocity_m_s` |
//! | `stylus2` | m | `Sample::second_stylus` |
//! | `reference`, or `reference_x`, `reference_y`, .. | own units | `Sample::reference`, `Sample::reference_axes` |
//! | `pressure` | own units | `Sample::pressure` |
//! | `motion` | 0 at rest, anything else in motion | `Sample::motion`: what arm and fingers are commanded |
//! | `pressure_0`, `pressure_1`, .. | own units | a frame of the taxel array, [`Recording::taxels`] |
//!
//! A reading may be `NaN`, `inf` or absurdly large: that is what a broken sensor sends, so it is passed on
//! unchanged and counted in [`Notes`]. A time must be a number and must never go backwards.
//!
//! With the feature `arrays` a recording is also an `.npz` of NumPy with an array for each of these columns (`read_recording`,
//! `Recording::write_npz`), and its readings are `ndarray` arrays; `Npz` reads named columns of any `.npz`.
//!
//! A labelled folder holds `labels.csv` ([`read_labels`]) beside `NAME.csv` and, where the true motion is
//! known, `NAME_pose.csv` ([`Travel`]). `phases.csv` may name what else went on in them ([`read_phases`]).
//!
//! A surface is a file too: a height profile has `x_mm` and `height_um` ([`HeightProfile`]), a list of irregularities
//! `delta_m` and `s_m` ([`read_irregularities`]).
//!
#![doc = include_str!("../README.md")]

#[cfg(feature = "arrays")]
mod arrays;
mod axes;
mod channels;
pub mod clock;
mod columns;
mod csv_read;
mod csv_write;
mod error;
pub mod files;
pub mod find;
mod irregularities;
mod labels;
mod labels_write;
mod layout;
pub mod mcap;
mod notes;
#[cfg(feature = "arrays")]
mod npy;
#[cfg(feature = "arrays")]
mod npz;
#[cfg(feature = "arrays")]
mod numbers;
pub mod outputs;
pub mod pace;
mod phases;
mod plan;
mod profile;
mod recording;
mod taxels;
pub mod time;
mod travel;
mod tsf85;
mod words;

#[cfg(feature = "arrays")]
pub use arrays::NumberSamples;
pub use axes::is_axis;
pub use channels::{COLUMN_NAMES, Channel, ChannelSet, StylusKind};
pub use columns::{Columns, Rows};
pub use csv_read::{CsvOptions, CsvSamples, parse_csv, read_csv, read_recording};
pub use csv_write::{CsvWriter, WriteError};
pub use error::{CsvError, shell};
pub use find::{Found, Signal, Use};
pub use irregularities::{Lengths, parse_irregularities, read_irregularities};
pub use labels::{Label, LabelError, LabelKind, read_labels};
pub use labels_write::{Relabel, write_label};
pub use notes::{HUGE_READING, Notes};
#[cfg(feature = "arrays")]
pub use npy::npy_table;
#[cfg(feature = "arrays")]
pub use npz::{MOST_UNPACKED, Npz, NpzError, is_npz, npz_table, write_columns};
#[cfg(feature = "arrays")]
pub use numbers::{Cell, Coding, NumberColumn, NumberTable, Packed, Strand};
pub use phases::{Phase, PhaseError, read_alarms, read_phases};
pub use profile::HeightProfile;
pub use recording::{MOST_HELD, Recording};
pub use taxels::Taxels;
pub use time::TimeUnit;
pub use travel::Travel;
