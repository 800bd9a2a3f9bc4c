//! Touch in; whether there is an object between the fingers out.

/// What became of the object in hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GripEvent {
    /// The fingers are told to press with the least force and touch nothing: there is no object.
    Empty,
    /// Touch is gone while the fingers are told to press: the object is lost.
    Lost,
    /// Touch is back after the object was lost.
    Regrasped,
    /// The slip has not ended within two seconds: the sensors may show what is none, or the force is not enough.
    Persistent,
    /// The force that the object is held with is what its slips have shown to be needed, or the least there is: no less is tried.
    Found,
}

impl GripEvent {
    /// The name used in output lines.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Empty => "empty",
            Self::Lost => "lost",
            Self::Regrasped => "regrasped",
            Self::Persistent => "persistent",
            Self::Found => "found",
        }
    }
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
    /// What the last step was told.
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

    /// Whether only a change of touch has anything to tell: no time runs.
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

    /// Fingers that close; `pressing` says whether they are told to press.
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
