//! Join of a recording with the files beside it: one recording with a travel channel and a taxel array.
//!
//! A reading of a companion goes to the first sample that is not earlier, so that nothing is known before its time.

use grip_record::{Channel, CsvError, Recording, Taxels, Travel};
use std::path::Path;

/// Adds what the recording itself does not have.
pub(super) fn join(
    file: &Path,
    recording: &Recording,
    travel: Option<&Travel>,
) -> Result<Recording, CsvError> {
    let mut joined = recording.clone();
    if let Some(travel) = travel
        && !recording.channels.has(Channel::Travel)
    {
        add_travel(&mut joined, travel);
    }
    if joined.taxels.is_none() {
        joined.taxels = Taxels::read_beside(file, &joined.samples)?;
    }
    Ok(joined)
}

fn add_travel(recording: &mut Recording, travel: &Travel) {
    for &(t, travel_mm) in travel.points() {
        let place = recording.samples.partition_point(|sample| sample.t < t);
        let Some(sample) = recording.samples.get_mut(place) else { break };
        #[expect(clippy::cast_possible_truncation, reason = "a sensor reading")]
        let travel_m = (1e-3 * travel_mm) as f32;
        sample.travel_m = Some(travel_m);
    }
    recording.channels = recording.channels.clone().with(Channel::Travel);
}
