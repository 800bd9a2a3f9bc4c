//! What a user has arranged: which plots, how high, which panel, which theme; read from and written to a TOML file.

use crate::strip::StripId;
use grip_record::outputs::replace;
use grip_scope::trigger::TriggerSettings;
use serde::{Deserialize, Serialize};
use std::{
    env, fs, io,
    path::{Path, PathBuf},
};
use thiserror::Error;

slip_msg::named! {
    /// What stands at the right.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Panel {
        fn name: "What its tab says.";
    }
    Health: "Link, latency, sensors, stages.", "Health";
    Events: "What happened.", "Events";
    Cursors: "Both cursors, and what lies between.", "Cursors";
    Trigger: "When to stop and show.", "Trigger";
    Export: "Files of what is seen.", "Export";
    Command: "Commands to the gripper.", "Command";
}

/// Colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Look {
    /// Light on dark.
    #[default]
    Dark,
    /// Dark on light.
    Light,
}

/// One plot as it was arranged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StripLayout {
    /// Which.
    pub plot: StripId,
    /// Whether it is seen.
    #[serde(default = "yes")]
    pub shown: bool,
    /// Height relative to the others (0.3 to 8).
    #[serde(default = "one")]
    pub height: f32,
}

const fn yes() -> bool {
    true
}

const fn one() -> f32 {
    1.0
}

/// Everything that is remembered from one start to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Layout {
    /// Colours.
    pub theme: Look,
    /// What stands at the right; nothing where absent.
    #[serde(default)]
    pub panel: Option<Panel>,
    /// Seconds seen while the view follows the data.
    pub seconds: f64,
    /// Size of the window (points).
    pub window: [f32; 2],
    /// Width of what stands at the right (points).
    pub panel_width: f32,
    /// Whether the tour was shown.
    pub toured: bool,
    /// The plots, from top to bottom.
    pub plots: Vec<StripLayout>,
    /// The trigger.
    pub trigger: TriggerSettings,
}

/// Least and greatest width of what stands at the right (points).
pub const PANEL: (f32, f32) = (240.0, 520.0);
/// Its width at first (points).
const PANEL_WIDTH: f32 = 300.0;
/// Least and greatest height of a plot, relative to the others.
pub const HEIGHTS: (f32, f32) = (0.3, 8.0);

const fn in_range(value: f32, range: (f32, f32), usual: f32) -> f32 {
    if value.is_finite() { value.clamp(range.0, range.1) } else { usual }
}

impl Default for Layout {
    fn default() -> Self {
        use StripId::{Bands, Esc, Force, Statistic, Stylus};
        let shown = |strip| matches!(strip, Stylus | Bands | Statistic | Force | Esc);
        let plot = |plot: StripId| StripLayout { plot, shown: shown(plot), height: plot.weight() };
        Self {
            theme: Look::Dark,
            panel: Some(Panel::Health),
            seconds: 5.0,
            window: [1360.0, 860.0],
            panel_width: PANEL_WIDTH,
            toured: false,
            plots: StripId::ALL.map(plot).to_vec(),
            trigger: TriggerSettings::default(),
        }
    }
}

/// Why a layout was not read or written.
#[derive(Debug, Error)]
pub enum LayoutError {
    /// The system refuses.
    #[error("{}: {source}", path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is no layout.
    #[error("{}: {source}", path.display())]
    Text {
        /// Which file.
        path: PathBuf,
        /// Why, with the place.
        source: Box<toml::de::Error>,
    },
    /// It cannot be reported as text.
    #[error("the layout cannot be written: {0}")]
    Write(#[from] toml::ser::Error),
}

impl Layout {
    /// Reads a layout; the default where there is no such file yet.
    ///
    /// # Errors
    /// [`LayoutError`], with the line that is wrong.
    pub fn read(path: &Path) -> Result<Self, LayoutError> {
        match fs::read_to_string(path) {
            Ok(text) => Self::parse(&text)
                .map_err(|source| LayoutError::Text { path: path.to_owned(), source }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self::default()),
            Err(source) => Err(LayoutError::File { path: path.to_owned(), source }),
        }
    }

    /// A layout from its text. Plots that it does not name follow unseen, numbers out of range take the nearest that is not.
    ///
    /// # Errors
    /// What TOML states.
    pub fn parse(text: &str) -> Result<Self, Box<toml::de::Error>> {
        Ok(toml::from_str::<Self>(text).map_err(Box::new)?.within_limits())
    }

    /// The same with every plot once and every number in its range.
    #[must_use]
    pub fn within_limits(mut self) -> Self {
        let mut plots: Vec<StripLayout> = Vec::new();
        let unseen =
            StripId::ALL.map(|plot| StripLayout { plot, shown: false, height: plot.weight() });
        for strip in self.plots.into_iter().chain(unseen) {
            if plots.iter().all(|known| known.plot != strip.plot) {
                plots.push(StripLayout { height: in_range(strip.height, HEIGHTS, 1.0), ..strip });
            }
        }
        self.plots = plots;
        self.seconds = if self.seconds.is_finite() { self.seconds.clamp(1e-3, 1e5) } else { 5.0 };
        self.window = self.window.map(|side| in_range(side, (480.0, 8000.0), 860.0));
        self.panel_width = in_range(self.panel_width, PANEL, PANEL_WIDTH);
        self.trigger = self.trigger.within_limits();
        self
    }

    /// Writes it in one go: a file that is there is replaced whole or not at all. Where the path is a link, what it leads to is replaced, and
    /// not the link.
    ///
    /// # Errors
    /// [`LayoutError`].
    pub fn write(&self, path: &Path) -> Result<(), LayoutError> {
        let text = toml::to_string(self)?;
        let failed = |source| LayoutError::File { path: path.to_owned(), source };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(failed)?;
        }
        replace(path, text).map_err(failed)
    }
}

/// Where the layout stands: `gripmon/layout.toml` in the user's configuration folder; `None` where there is none.
#[must_use]
pub fn default_path() -> Option<PathBuf> {
    let named = env::var_os("XDG_CONFIG_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let home = || env::var_os("HOME").map(|home| Path::new(&home).join(".config"));
    named.or_else(home).map(|folder| folder.join("gripmon").join("layout.toml"))
}

#[cfg(test)]
mod tests {
    use super::{Layout, LayoutError, Look, Panel, StripId, TriggerSettings};
    use grip_scope::trigger::{Condition, TriggerMode};
    use grip_scope::{Channel, EventKind};

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a").join("layout.toml");
        assert_eq!(Layout::read(&path).unwrap(), Layout::default());
        let mut layout = Layout {
            theme: Look::Light,
            panel: Some(Panel::Trigger),
            panel_width: 411.0,
            ..Layout::default()
        };
        layout.plots.swap(0, 3);
        layout.plots[1].height = 2.5;
        layout.write(&path).unwrap();
        assert_eq!(Layout::read(&path).unwrap(), layout);
        layout.panel = None;
        layout.write(&path).unwrap();
        assert_eq!(Layout::read(&path).unwrap().panel, None);
    }

    #[test]
    fn every_trigger_comes_back_as_it_was_and_odd_ones_are_mended() {
        let conditions = Condition::OF_A_CHANNEL.into_iter().chain([Condition::Event]);
        let modes = [TriggerMode::Single, TriggerMode::Normal, TriggerMode::Auto];
        for (condition, mode) in conditions.flat_map(|of| modes.map(|mode| (of, mode))) {
            let (event, channel) = (EventKind::Ended, Channel::Band3);
            let (level, before_s, window_s) = (-2.5e-6, 0.25, 2.0);
            let trigger =
                TriggerSettings { condition, event, channel, level, mode, before_s, window_s };
            let text = toml::to_string(&Layout { trigger, ..Layout::default() }).unwrap();
            assert_eq!(Layout::parse(&text).unwrap().trigger, trigger, "{text}");
        }
        let reported = |text: &str| Layout::parse(text).unwrap_err().to_string();
        let event = reported("[trigger]\nevent = \"earthquake\"\n");
        assert!(event.contains("line 2") && event.contains("gross slip"), "{event}");
        let channel = reported("[trigger]\nchannel = \"height\"\n");
        assert!(channel.contains("force_n"), "{channel}");
        let older = Layout::parse("[trigger]\nchannel = \"statistic\"\n").unwrap().trigger;
        assert_eq!(older.channel, Channel::Statistic);
        let odd = "[trigger]\nlevel = nan\nbefore_s = 5.0\nwindow_s = -1.0\n";
        let form = Layout::parse(odd).unwrap().trigger;
        assert_eq!((form.level, form.before_s, form.window_s), (600.0, 5.0, 5.0));
    }

    #[test]
    fn odd_layouts_are_mended_and_wrong_ones_reported() {
        let text = "seconds = nan\nplots = [{plot = \"force\", height = 1e9}, {plot = \"force\"}]";
        let layout = Layout::parse(text).unwrap();
        assert_eq!(layout.plots.len(), StripId::ALL.len());
        assert_eq!((layout.plots[0].plot, layout.plots[0].height), (StripId::Force, 8.0));
        assert!(layout.seconds == 5.0 && !layout.plots[1].shown);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layout.toml");
        std::fs::write(&path, "theme = \"pink\"").unwrap();
        let error = Layout::read(&path).unwrap_err();
        assert!(
            matches!(error, LayoutError::Text { .. }) && error.to_string().contains("line 1"),
            "{error}"
        );
    }
}
