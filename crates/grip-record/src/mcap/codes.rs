//! States of the pipeline in, the codes of the State message out, and back. A code is the place in its table.

use slip_core::{
    detector::ReferenceHealth, distance::TravelHealth, grip::GripState, health::Health,
    pressure::PressureHealth, scene::Scene,
};

use super::cdr::{CdrError, CdrReader};

pub(super) const SCENES: [Scene; 4] = [Scene::Idle, Scene::Moving, Scene::Holding, Scene::Slipping];

pub(super) const GRIPS: [Option<GripState>; 8] = [
    None,
    Some(GripState::Open),
    Some(GripState::Closing),
    Some(GripState::Settling),
    Some(GripState::Holding),
    Some(GripState::Slipping),
    Some(GripState::Fault),
    Some(GripState::Released),
];

pub(super) const STYLUS: [Health; 6] = [
    Health::Good,
    Health::Frozen,
    Health::Saturated,
    Health::Failed,
    Health::Drifting,
    Health::Doubted,
];

pub(super) const REFERENCE: [ReferenceHealth; 5] = [
    ReferenceHealth::Good,
    ReferenceHealth::Frozen,
    ReferenceHealth::Lost,
    ReferenceHealth::Late,
    ReferenceHealth::Uncoupled,
];

pub(super) const TRAVEL: [TravelHealth; 6] = [
    TravelHealth::Good,
    TravelHealth::Jumped,
    TravelHealth::Frozen,
    TravelHealth::Backwards,
    TravelHealth::Doubted,
    TravelHealth::Coarse,
];

pub(super) const PRESSURE: [PressureHealth; 3] =
    [PressureHealth::Good, PressureHealth::Frozen, PressureHealth::Failed];

/// The place of `value`; 255 where a later version knows more states than the table.
pub(super) fn code<T: PartialEq>(table: &[T], value: &T) -> u8 {
    table
        .iter()
        .position(|known| known == value)
        .and_then(|at| u8::try_from(at).ok())
        .unwrap_or(255)
}

/// The next field, a code of `table`.
pub(super) fn read<T: Copy>(table: &[T], reader: &mut CdrReader<'_>) -> Result<T, CdrError> {
    let code = reader.u8()?;
    table.get(usize::from(code)).copied().ok_or(CdrError::Code { code, at: reader.position() })
}
