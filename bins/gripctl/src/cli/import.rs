//! Arguments of `gripctl import` and `gripctl label`.

use super::CsvArgs;
use clap::{ArgGroup, Args};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// What to import: .wav, .npy, .csv (with commas, semicolons or tabs; Robotiq TSF-85 too), .mcap of any program,
    /// rosbag2 .db3, or the folder of a bag.
    pub(crate) file: PathBuf,
    /// Where to write the recording: .csv, .npz or .mcap. Without it what would be taken for what is printed.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Replace the file that --output names, where there is one already.
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
    /// Read only this topic; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) topic: Vec<String>,
    /// Which finger of a TSF-85 recording, by the number in its columns.
    #[arg(long, value_name = "N")]
    pub(crate) finger: Option<u32>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("kind").required(true).args(["onset", "steady", "rest", "remove"])))]
pub(crate) struct LabelArgs {
    /// The recording (.csv, .npz or .mcap). Its label goes into labels.csv of the same folder.
    pub(crate) file: PathBuf,
    /// It starts at rest and begins to slip at this time of its clock (s).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) onset: Option<f64>,
    /// It slips all the time.
    #[arg(long)]
    pub(crate) steady: bool,
    /// It never slips: every alarm is false.
    #[arg(long)]
    pub(crate) rest: bool,
    /// Take its label away.
    #[arg(long)]
    pub(crate) remove: bool,
    /// The material touched, in your own words; recordings of one material are kept apart from the floor they are scored with.
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// Replace the label that the recording has already.
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
}
