//! The object in hand: whether there is one, and how much less force may be tried.

use super::GripConfig;

// Detector of an object between the fingers, from touch.

slip_msg::named! {
    /// What became of the object in hand.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum GripEvent {
        fn name: "The name used in output lines.";
    }
    Empty: "The fingers are commanded to press with the least force and touch nothing: there is no object.", "empty";
    Lost: "Touch is gone while the fingers are commanded to press: the object is lost.", "lost";
    Regrasped: "Touch is back after the object was lost.", "regrasped";
    Persistent:
        "The slip has not ended within two seconds: the sensors may show what is none, or the force is not enough.",
        "persistent";
    Found:
        "The force that the object is held with is what its slips have shown to be needed, or the least there is: no less is tried.",
        "found";
    Limited:
        "The object is held with the largest force that may be commanded. What it needs is not known: it may be less, or more.",
        "limited";
}

/// Fingers need this long to reach an object (s): without touch until then there is none.
const EMPTY_S: f32 = 3.0;

/// Memory of the touch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Touch {
    /// Time without touch (s).
    absent_s: f32,
    /// Whether the object was touched before it was held; a sensor that saw nothing then may not measure at all.
    touched: bool,
    /// The touch of the last step.
    touching: bool,
    lost: bool,
    event: Option<GripEvent>,
}

impl Touch {
    #[inline]
    pub(super) fn event(&self) -> Option<GripEvent> {
        self.event
    }

    /// A step begins.
    #[inline]
    pub(super) fn begin(&mut self, touching: bool) {
        self.event = None;
        self.touching = touching;
    }

    pub(super) fn is_lost(&self) -> bool {
        self.lost
    }

    /// Whether fingers that close were found to close on nothing, and still do.
    pub(super) fn is_empty(&self) -> bool {
        self.absent_s >= EMPTY_S && !self.touching
    }

    /// Whether only a change of touch has anything to report: no time runs.
    #[inline]
    pub(super) fn is_settled(&self) -> bool {
        self.lost || !self.touched || self.touching
    }

    /// Fingers that have held an object before this program came.
    pub(super) fn carried() -> Self {
        Self { touched: true, ..Self::default() }
    }

    /// Fingers that settle.
    pub(super) fn settle(&mut self) {
        self.touched |= self.touching;
    }

    /// Fingers that close; `pressing`: whether they are commanded to press.
    pub(super) fn close(&mut self, pressing: bool, dt_s: f32) {
        self.settle();
        let before_s = self.absent_s;
        self.absent_s = if pressing && !self.touching { before_s + dt_s } else { 0.0 };
        if before_s < EMPTY_S && self.absent_s >= EMPTY_S {
            self.event = Some(GripEvent::Empty);
        }
    }

    /// Fingers that hold; the object is lost after `lost_s` (s) without touch.
    pub(super) fn hold(&mut self, lost_s: f32, dt_s: f32) -> Option<GripEvent> {
        if self.lost {
            if self.touching {
                self.lost = false;
                self.absent_s = 0.0;
                self.event = Some(GripEvent::Regrasped);
            }
            return self.event;
        }
        let absent = self.touched && !self.touching;
        self.absent_s = if absent { self.absent_s + dt_s } else { 0.0 };
        if self.absent_s >= lost_s {
            self.lost = true;
            self.event = Some(GripEvent::Lost);
        }
        self.event
    }
}

// Search for a smaller force: how much less may be tried out after slips and alarms of an object.
//
// An object that does not slip shows nothing of the force it needs. So what holds it falls slowly until it just slips: static friction gives way
// at the force that is needed over the ratio of static and kinetic friction, whatever the object is. One that slips while its weight is put on is searched for a second time, since the
// estimate of such a slip is of the load that was there.

/// Over the rate of an object that has not slipped.
const SLOWLY: f32 = 0.5;
/// Whether less is to be tried.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Mode {
    /// It is known what the object needs.
    #[default]
    Found,
    /// Nothing has slipped: nothing is known but that the force is not too little.
    Untried,
    /// It is held with what it is known to need; it should slip with less.
    Known,
    /// It slipped while its weight was put on, so its need is known roughly: not below this force (N).
    Above(f32),
}

/// The search for the smallest force that is enough.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Search {
    mode: Mode,
    /// Force below which no touch is felt (N).
    touch_n: f32,
}

impl Search {
    /// An object of which nothing is known.
    pub(super) fn begin() -> Self {
        Self { mode: Mode::Untried, touch_n: 0.0 }
    }

    /// An object that is held with what it is known to need: its load counts as there.
    pub(super) fn known() -> Self {
        Self { mode: Mode::Known, touch_n: 0.0 }
    }

    /// What counts as touch now (N): with less the object would seem lost.
    pub(super) fn feel(&mut self, touch_n: f32) {
        self.touch_n = touch_n;
    }

    /// What counts as touch (N), as of the last sample.
    pub(super) fn touch_n(&self) -> f32 {
        self.touch_n
    }

    /// The least force that is to be tried (N), and the share by which the force falls in a second.
    fn fall(&self, config: &GripConfig) -> (f32, f32) {
        let floor_n = config.least_force_n.max(self.touch_n);
        match self.mode {
            Mode::Found => (f32::INFINITY, 0.0),
            Mode::Untried | Mode::Known => (floor_n, config.relax_per_s),
            Mode::Above(least_n) => (least_n.max(floor_n), SLOWLY * config.relax_per_s),
        }
    }

    /// Whether less than `hold_n` (N) is to be tried.
    pub(super) fn goes_on(&self, config: &GripConfig, hold_n: f32) -> bool {
        let (least_n, per_s) = self.fall(config);
        per_s > 0.0 && hold_n > least_n
    }

    /// What to hold with instead of `hold_n` (N) after `dt_s`.
    pub(super) fn step(&self, config: &GripConfig, hold_n: f32, dt_s: f32) -> f32 {
        let (least_n, per_s) = self.fall(config);
        (hold_n * (1.0 - (per_s * dt_s).min(1.0))).max(least_n).min(hold_n)
    }

    /// Whether a slip in which nothing was seen to move is believed all the same: where less and less is held it is what the search waits for.
    pub(super) fn believes(&self, config: &GripConfig) -> bool {
        self.fall(config).1 > 0.0
    }

    /// Whether the object has slid before or is known, so that its load is there and nothing but the falling force makes it slip.
    pub(super) fn is_loaded(&self) -> bool {
        matches!(self.mode, Mode::Above(_) | Mode::Known)
    }

    /// A slip that was believed has shown what is needed; where it did roughly only, `least_n` (N) is the least that may do.
    pub(super) fn found(&mut self, least_n: Option<f32>) {
        self.mode = least_n.map_or(Mode::Found, Mode::Above);
    }
}
