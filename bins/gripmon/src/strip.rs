//! Which plots there are, and which curves of a model each of them shows, in which tone.

use crate::palette::{SERIES, Tone};
use crate::plot::{DASHED, Kind};
use egui_plot::LineStyle;
use grip_scope::{Channel, Model};
use serde::{Deserialize, Serialize};

slip_msg::named! {
    /// One plot of the stack.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum StripId {
        fn title: "What stands over it.";
        fn nothing: "A sentence for its place while the model has nothing for it.";
    }
    Stylus: "The stylus, with peaks and valleys where single samples are seen.", "Stylus", "No stylus samples yet.";
    Spectrogram: "How strong each frequency of the stylus is.",
        "Spectrogram", "A spectrum needs some hundred stylus samples without a gap.";
    Bands: "Energies of the detector's bands.",
        "Band energy / floor", "Band energies begin once the noise floor is learned (0.2 s at rest).";
    Statistic: "Evidence of a slip.", "Slip evidence", "No evidence of a slip yet: neither for nor against.";
    Force: "Forces.", "Force", "This source has no forces.";
    Esc: "E_sc.", "E_sc", "E_sc is known while an object slips.";
    Speed: "Slip speed.", "Slip speed", "Slip speed is known while an object slips.";
    Travel: "Moved distance.", "Travel", "This source measures no travel.";
    Reference: "Motion reference.", "Motion reference", "This source has no motion reference.";
    Pressure: "Pressure distribution.", "Pressure", "This source measures no pressure.";
}

impl StripId {
    /// Whether it shows nothing but samples, or what is derived of them.
    #[must_use]
    pub const fn needs_samples(self) -> bool {
        !matches!(self, Self::Statistic | Self::Force | Self::Esc)
    }

    /// How its values are spread.
    #[must_use]
    pub const fn kind(self) -> Kind {
        match self {
            Self::Bands | Self::Statistic => Kind::Log,
            _ => Kind::Linear,
        }
    }

    /// Height relative to the others.
    #[must_use]
    pub const fn weight(self) -> f32 {
        match self {
            Self::Stylus | Self::Force => 1.3,
            Self::Esc | Self::Speed | Self::Travel | Self::Reference => 0.8,
            _ => 1.0,
        }
    }

    /// Whether it shows curves of this model, and not a picture. A lone value of pressure is a curve, an array is a picture.
    #[must_use]
    pub fn has_curves(self, model: &Model) -> bool {
        match self {
            Self::Spectrogram => false,
            Self::Pressure => !has_array(model),
            _ => true,
        }
    }
}

/// One curve of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// What is drawn.
    pub channel: Channel,
    /// In which colour.
    pub tone: Tone,
    /// How.
    pub style: LineStyle,
}

const fn curve(channel: Channel, tone: Tone) -> Curve {
    Curve { channel, tone, style: LineStyle::Solid }
}

const fn limit(channel: Channel, tone: Tone) -> Curve {
    Curve { channel, tone, style: DASHED }
}

/// The curves of a plot that the model has data of, in the order in which they are drawn.
#[must_use]
pub fn curves(strip: StripId, model: &Model) -> Vec<Curve> {
    let mut found = wanted(strip);
    found.retain(|curve| {
        model.series(curve.channel).is_some_and(|series| series.latest().is_some())
    });
    found
}

fn wanted(strip: StripId) -> Vec<Curve> {
    match strip {
        StripId::Stylus => {
            vec![curve(Channel::SecondStylus, Tone::Orange), curve(Channel::Stylus, Tone::Blue)]
        }
        StripId::Bands => bands(),
        StripId::Statistic => {
            vec![curve(Channel::OwnStatistic, Tone::Quiet), curve(Channel::Statistic, Tone::Blue)]
        }
        StripId::Force => vec![
            curve(Channel::OwnEstimate, Tone::Quiet),
            curve(Channel::NormalForce, Tone::Green),
            curve(Channel::Applied, Tone::Sky),
            curve(Channel::TangentialForce, Tone::Purple),
            curve(Channel::Estimate, Tone::Orange),
            curve(Channel::Need, Tone::Yellow),
            curve(Channel::Command, Tone::Blue),
            limit(Channel::NeedTruth, Tone::Yellow),
            limit(Channel::ForceLimit, Tone::Red),
        ],
        StripId::Esc => {
            vec![curve(Channel::OwnEsc, Tone::Quiet), curve(Channel::Esc, Tone::Purple)]
        }
        StripId::Speed => {
            vec![curve(Channel::Velocity, Tone::Green), curve(Channel::SlipSpeed, Tone::Orange)]
        }
        StripId::Travel => vec![curve(Channel::Travel, Tone::Green)],
        StripId::Reference => {
            vec![curve(Channel::Motion, Tone::Orange), curve(Channel::Reference, Tone::Blue)]
        }
        StripId::Pressure => vec![curve(Channel::Pressure, Tone::Blue)],
        StripId::Spectrogram => Vec::new(),
    }
}

fn bands() -> Vec<Curve> {
    // The lowest band is drawn last, on top.
    let toned = Channel::BANDS.into_iter().zip(SERIES).rev();
    toned.map(|(band, tone)| curve(band, tone)).collect()
}

/// The two curves between which the value of a plot's curve lies. Of a needed force the source reports them; the others belong to the values of
/// the scope's own observer, which may have other settings than the source.
#[must_use]
pub const fn enclosure(channel: Channel) -> Option<(Channel, Channel)> {
    match channel {
        Channel::Need => Some((Channel::NeedLow, Channel::NeedHigh)),
        Channel::OwnEstimate => Some((Channel::EstimateLow, Channel::EstimateHigh)),
        Channel::OwnEsc => Some((Channel::EscLow, Channel::EscHigh)),
        _ => None,
    }
}

/// Whether the model has anything for a plot.
#[must_use]
pub fn has_data(strip: StripId, model: &Model) -> bool {
    match strip {
        StripId::Spectrogram => !model.spectrogram().is_empty(),
        StripId::Pressure => has_array(model) || !curves(strip, model).is_empty(),
        _ => !curves(strip, model).is_empty(),
    }
}

/// Whether the model has frames of a pressure array.
#[must_use]
pub fn has_array(model: &Model) -> bool {
    model.span().is_some_and(|span| model.taxels(span.to_s).is_some())
}

#[cfg(test)]
mod tests {
    use super::{StripId, enclosure, wanted};
    use grip_link::message::daemon::{GripState, Reading, Scene};
    use grip_scope::feed::{DerivedBlock, Feed};
    use grip_scope::{Channel, Model};
    use slip_core::PipelineState;
    use slip_core::units::Micros;

    #[test]
    fn one_unit_is_on_an_axis() {
        for strip in StripId::ALL {
            for curve in wanted(strip) {
                assert_eq!(curve.channel.unit(), wanted(strip)[0].channel.unit(), "{strip:?}");
            }
        }
    }

    /// A source that states other values than the scope's own observer.
    fn disagreeing() -> Model {
        let kind = Reading::Literal;
        let mut model = Model::new(1 << 20);
        model.take(Feed::State(PipelineState {
            t: Micros(1_000_000),
            scene: Scene::Slipping,
            grip: GripState::Slipping,
            esc_kind: kind,
            esc: Some(0.2),
            estimate_n: Some(5.0),
            need_low_n: Some(3.0),
            need_n: Some(4.0),
            need_high_n: Some(6.0),
            rate_hz: 1000,
            ..PipelineState::UNKNOWN
        }));
        let mut block = DerivedBlock::default();
        let esc = [(Channel::OwnEsc, 0.5), (Channel::EscLow, 0.4), (Channel::EscHigh, 0.6)];
        block.put(1.0, esc);
        let [low, high] = [(Channel::EstimateLow, 8.0), (Channel::EstimateHigh, 10.0)];
        block.put(1.0, [(Channel::OwnEstimate, 9.0), low, high]);
        model.take(Feed::Derived(Box::new(block)));
        model
    }

    #[test]
    fn an_enclosure_stands_beside_the_value_that_lies_in_it() {
        let model = disagreeing();
        let value = |channel: Channel| model.series(channel).unwrap().latest().unwrap().1;
        let mut found = Vec::new();
        for curve in StripId::ALL.into_iter().flat_map(wanted) {
            if let Some((low, high)) = enclosure(curve.channel) {
                let is = value(curve.channel);
                assert!(value(low) <= is && is <= value(high), "{curve:?}: {is}");
                found.push(curve.channel);
            }
        }
        assert_eq!(found, [Channel::OwnEstimate, Channel::Need, Channel::OwnEsc]);
    }
}
