//! Health of a sensor as the State message has it: each sensor counts its own states, a code is the place in its table.

use slip_core::health::SensorHealth;

pub(super) const STYLUS: [SensorHealth; 6] = [
    SensorHealth::Good,
    SensorHealth::Frozen,
    SensorHealth::Saturated,
    SensorHealth::Failed,
    SensorHealth::Drifting,
    SensorHealth::Doubted,
];

pub(super) const REFERENCE: [SensorHealth; 5] = [
    SensorHealth::Good,
    SensorHealth::Frozen,
    SensorHealth::Lost,
    SensorHealth::Late,
    SensorHealth::Uncoupled,
];

pub(super) const TRAVEL: [SensorHealth; 6] = [
    SensorHealth::Good,
    SensorHealth::Jumped,
    SensorHealth::Frozen,
    SensorHealth::Backwards,
    SensorHealth::Doubted,
    SensorHealth::Coarse,
];

pub(super) const PRESSURE: [SensorHealth; 3] =
    [SensorHealth::Good, SensorHealth::Frozen, SensorHealth::Failed];

/// The place of `value`; that of a later version as it was read, 255 where this sensor has no such state. The samples show which
/// sensors there are: one that is absent counts as good.
pub(super) fn code(table: &[SensorHealth], value: SensorHealth) -> u8 {
    let place = table.iter().position(|known| *known == value);
    place.and_then(|at| u8::try_from(at).ok()).unwrap_or(match value {
        SensorHealth::Other(code) => code,
        SensorHealth::Absent => 0,
        _ => 255,
    })
}

/// The state at this place; one of a later version is kept.
pub(super) fn health(table: &[SensorHealth], code: u8) -> SensorHealth {
    table.get(usize::from(code)).copied().unwrap_or(SensorHealth::Other(code))
}
