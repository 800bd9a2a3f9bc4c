//! Memory of objects from events of grasps: what is known of them, and the force to grasp the next one with.
//!
//! An object has a name, which a client gives. With each grasp whose needed force was found ([`GripEvent::Found`]) its figures are
//! learned: needed force, ratio of static and kinetic friction, and what the stylus feels of its surface. The next grasp of that name begins with what is known
//! ([`Memory::expected_n`]). A grasp that contradicts what is known by more than three deviations is of another object: what was known is forgotten.
//! A grasp without a name counts for the one object whose figures it has, its grip signature.
//!
//! The file is a TOML table of objects. Nothing here runs on the hot thread.

mod figure;
mod file;

pub use figure::Figure;
pub use file::MemoryError;

use crate::report::Event;
use serde::{Deserialize, Serialize};
use slip_core::{Phase, SlipReport, estimate::KAPPA, grip::GripEvent};
use std::collections::BTreeMap;

/// A name has at most so many bytes.
pub const LONGEST_NAME: usize = 64;
/// Objects that are remembered; another one is refused.
pub const MOST_OBJECTS: usize = 10_000;
/// Irregularities that the stylus has passed, and distance (m), in a slip of which it knows the surface.
const SURFACE_OF: u32 = 10;
const SURFACE_M: f32 = 5e-4;
/// Deviations by which another object differs.
const DIFFERS: f64 = 3.0;
/// Deviations up to which an object without a name is the one of the same figures, as a mean over them.
const SAME: f64 = 1.5;

/// What is known of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Normal force of one finger that it needs (N), without margin.
    pub needed_n: Figure,
    /// Static over kinetic friction, where it has just slipped under its load.
    #[serde(default, skip_serializing_if = "Figure::is_unknown")]
    pub friction_ratio: Figure,
    /// Mean distance of its irregularities (um).
    #[serde(default, skip_serializing_if = "Figure::is_unknown")]
    pub spacing_um: Figure,
    /// Mean height of its irregularities (um).
    #[serde(default, skip_serializing_if = "Figure::is_unknown")]
    pub height_um: Figure,
    /// Times that what was known was contradicted, and forgotten.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub forgotten: u32,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(count: &u32) -> bool {
    *count == 0
}

/// What one grasp has shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Seen {
    needed_n: Option<f64>,
    friction_ratio: Option<f64>,
    surface_um: Option<(f64, f64)>,
}

impl Object {
    /// The figures, each with what `seen` states of it.
    fn figures(self, seen: &Seen) -> [(Figure, Option<f64>); 4] {
        let (spacing, height) = seen.surface_um.unzip();
        [
            (self.needed_n, seen.needed_n),
            (self.friction_ratio, seen.friction_ratio),
            (self.spacing_um, spacing),
            (self.height_um, height),
        ]
    }

    fn learn(&mut self, seen: &Seen) {
        let [needed_n, friction_ratio, spacing_um, height_um] =
            self.figures(seen).map(|(known, seen)| seen.map_or(known, |value| known.with(value)));
        *self = Self { needed_n, friction_ratio, spacing_um, height_um, ..*self };
    }

    /// Deviations between what is known and what was seen, where both are: of the needed force, and of the surface.
    fn differs(self, seen: &Seen) -> impl Iterator<Item = f64> {
        let [needed, _, spacing, height] = self.figures(seen);
        [needed, spacing, height].into_iter().filter_map(|(known, seen)| known.deviations(seen?))
    }

    /// The force to grasp it with (N): the margin of the estimate over what it needs, and a deviation more; 0 where nothing is known.
    #[must_use]
    pub fn expected_n(&self) -> f32 {
        let needed_n = self.needed_n.value * f64::from(KAPPA) * (1.0 + self.needed_n.uncertainty());
        #[expect(clippy::cast_possible_truncation, reason = "a force of some newtons")]
        let expected_n = needed_n as f32;
        if self.needed_n.is_unknown() { 0.0 } else { expected_n }
    }
}

/// What a grasp has done to the memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Remembered {
    /// The object of this name is known better.
    Learned(String),
    /// A grasp without a name was of this object.
    Recognised(String),
    /// What was held under this name is another object: what was known is forgotten.
    Contradicted {
        /// The name.
        name: String,
        /// Needed force that was known (N).
        before_n: f64,
        /// What it needs now (N).
        needed_n: f64,
    },
}

impl core::fmt::Display for Remembered {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Learned(name) => write!(f, "object {name}: learned"),
            Self::Recognised(name) => write!(f, "object {name}: recognised by its grip signature"),
            Self::Contradicted { name, before_n, needed_n } => write!(
                f,
                "object {name}: another one than before (needs {needed_n:.2} N instead of {before_n:.2} N, or has another surface); forgotten"
            ),
        }
    }
}

/// The objects, and the grasp that goes on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    objects: BTreeMap<String, Object>,
    /// Name of the next object; empty where it has none.
    name: String,
    grasp: Grasp,
}

/// The grasp that goes on.
#[derive(Clone, Debug, Default, PartialEq)]
struct Grasp {
    /// Name of the object in hand, from its first command on; empty where it has none.
    name: Option<String>,
    /// Force that it was expected to be held with (N).
    expected_n: f32,
    /// Whether it has shown what it needs: it counts once.
    counted: bool,
    seen: Seen,
    /// Command while nothing slipped (N), and under which it slipped last.
    command_n: Option<f32>,
    slipped_n: Option<f32>,
    /// Whether it slips, and whether it has slipped before: then its load is there.
    slips: bool,
    loaded: bool,
}

impl Memory {
    /// Names the next object; an empty name is none. Gives the force to grasp it with (N), 0 where nothing is known of it.
    ///
    /// # Errors
    /// A name that is longer than [`LONGEST_NAME`] or has control characters.
    pub fn select(&mut self, name: &str) -> Result<f32, MemoryError> {
        if !is_name(name) {
            return Err(MemoryError::Name);
        }
        name.clone_into(&mut self.name);
        Ok(self.expected_n())
    }

    /// Name of the next object; empty where it has none.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The objects by name.
    #[must_use]
    pub fn objects(&self) -> &BTreeMap<String, Object> {
        &self.objects
    }

    /// The force to grasp the next object with (N); 0 where nothing is known of it.
    #[must_use]
    pub fn expected_n(&self) -> f32 {
        self.objects.get(&self.name).map_or(0.0, Object::expected_n)
    }

    /// Another grasp begins: the fingers are open, or close.
    pub fn begin(&mut self) {
        self.grasp = Grasp::default();
    }

    /// What the controller holds with now (N).
    pub fn watch(&mut self, command_n: Option<f32>) {
        if self.grasp.name.is_none() {
            (self.grasp.name, self.grasp.expected_n) = (Some(self.name.clone()), self.expected_n());
        }
        if !self.grasp.slips {
            self.grasp.command_n = command_n;
        }
    }

    /// Takes an event; gives what it has done to the memory.
    pub fn take(&mut self, event: &Event) -> Option<Remembered> {
        match event {
            Event::Slip(slip) => {
                self.slip(slip);
                None
            }
            Event::Grip { event: GripEvent::Found, command_n, .. } => self.found((*command_n)?),
            Event::Grip { event: GripEvent::Lost | GripEvent::Regrasped, .. } => {
                self.grasp = Grasp::default();
                None
            }
            Event::Grip { .. } | Event::Health { .. } => None,
        }
    }

    fn slip(&mut self, slip: &SlipReport) {
        let grasp = &mut self.grasp;
        if slip.first {
            let searched = |command_n: &f32| grasp.loaded || *command_n < grasp.expected_n;
            grasp.slipped_n = grasp.command_n.filter(searched);
            grasp.slips = true;
        }
        if slip.phase == Phase::Ended {
            (grasp.slips, grasp.loaded) = (false, true);
            if let Some(surface_um) = surface_um(slip) {
                grasp.seen.surface_um = Some(surface_um);
            }
        }
    }

    /// The force that the object is held with is known. A grasp counts once, with what it has shown first: later it may be pulled or hit.
    fn found(&mut self, held_n: f32) -> Option<Remembered> {
        if self.grasp.counted {
            return None;
        }
        let needed_n = f64::from(held_n / KAPPA);
        self.grasp.seen.needed_n = Some(needed_n).filter(|n| *n > 0.0);
        let ratio = self.grasp.slipped_n.map(|slipped_n| needed_n / f64::from(slipped_n));
        self.grasp.seen.friction_ratio = ratio.filter(|ratio| (1.0..3.0).contains(ratio));
        let in_hand = self.grasp.name.clone().unwrap_or_else(|| self.name.clone());
        let recognised = in_hand.is_empty();
        let name = if recognised { self.of_signature()? } else { in_hand };
        let before = self.objects.get(&name).copied().unwrap_or_default();
        if !self.objects.contains_key(&name) && self.objects.len() >= MOST_OBJECTS {
            return None;
        }
        let seen = self.grasp.seen;
        let differs = before.differs(&seen).any(|deviations| deviations > DIFFERS);
        let mut object = if differs {
            Object { forgotten: before.forgotten.saturating_add(1), ..Object::default() }
        } else {
            before
        };
        object.learn(&seen);
        self.objects.insert(name.clone(), object);
        self.grasp.counted = true;
        Some(match (differs, recognised) {
            (true, _) => {
                Remembered::Contradicted { name, before_n: before.needed_n.value, needed_n }
            }
            (_, true) => Remembered::Recognised(name),
            _ => Remembered::Learned(name),
        })
    }

    /// The one object with the needed force and the surface of this grasp.
    fn of_signature(&self) -> Option<String> {
        self.grasp.seen.surface_um?;
        let same = |object: &Object| {
            let deviations: Vec<f64> = object.differs(&self.grasp.seen).collect();
            let count = u32::try_from(deviations.len()).unwrap_or(u32::MAX);
            let mean = (deviations.iter().map(|z| z * z).sum::<f64>() / f64::from(count)).sqrt();
            // The force alone is no signature.
            count > 1 && mean <= SAME
        };
        let mut alike = self.objects.iter().filter(|(_, object)| same(object));
        let (name, _) = alike.next()?;
        alike.next().is_none().then(|| name.clone())
    }
}

fn is_name(name: &str) -> bool {
    name.len() <= LONGEST_NAME && !name.chars().any(char::is_control)
}

/// Mean distance and height of the irregularities of a slip (um), where it was long enough to know them.
fn surface_um(slip: &SlipReport) -> Option<(f64, f64)> {
    let count = slip.irregularities.filter(|count| *count >= SURFACE_OF)?;
    let moved_m = slip.moved_m.filter(|moved_m| *moved_m >= SURFACE_M)?;
    let spacing_um = 1e6 * f64::from(moved_m) / f64::from(count);
    let height_um = spacing_um * f64::from(slip.mean_slope?);
    (spacing_um > 0.0 && height_um > 0.0).then_some((spacing_um, height_um))
}

#[cfg(test)]
mod tests;
