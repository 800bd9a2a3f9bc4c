//! The methods joined: one evidence from stylus, travel and taxels, and the slip state it makes.
//!
//! Evidence of each method over the wanted interval is an e-value; their weighted mean is one too, however they depend on each other (V. Vovk,
//! R. Wang, Ann. Statist. 49 (2021)), so the interval holds for all of them together. A slip begins when the mean over the methods
//! that have a channel reaches 1, with the state of the highest, and ends when none shows it.
//!
//! Travel and taxels have limits of their own (elastic shear, creep), which lie far above their noise: at its limit a travel has a
//! log-likelihood ratio of 72 (12 deviations) and more where 14 would do. So their weights may be small, w = 1/1000, and their evidence
//! still large enough at the limit to be a slip alone. The stylus keeps 1 - w for each: no method delays another.
//!
//! ```text
//! x = exp(k (y - 1)) / w      y: moved distance or change of the pattern over its limit      k = 72; n taxels: n h/2 (1 - 1/6), at most 72
//! ```

use crate::{
    alarm::{Method, Methods},
    detector::SlipState,
    distance::{DistanceConfig, Fingers, MovedDistance, TravelReading},
    error::ConfigError,
    health::SensorHealth,
    load::TravelSensor,
    pressure::{MAX_TAXELS, PATTERN_GONE, PressureConfig, PressurePattern},
    sample::Sample,
    units::Micros,
};

/// What the methods detect together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Weighted mean of the evidence of the methods, over the wanted interval: 1 and above is a slip.
    pub statistic: f32,
    /// The highest slip state, once that was reached.
    pub state: SlipState,
    /// Whose state that is; of equals the first in the order stylus, travel, pressure.
    pub method: Method,
}

/// An object that was seen to move within this time moves now.
const ADVANCED_WITHIN: Micros = Micros(3000);
/// Travel without a reading for this long is gone.
const TRAVEL_GONE: Micros = Micros(50_000);
/// The same for a pattern, which comes frame by frame.
const CHANGED_WITHIN: Micros = Micros(20_000);

/// The methods beside the stylus, and the rule that joins them.
#[derive(Clone, Copy, Debug)]
pub struct Fusion {
    methods: Methods,
    travel: MovedDistance,
    pressure: PressurePattern<MAX_TAXELS>,
    healths: (SensorHealth, SensorHealth),
    /// Whether the travel shows the object, as far as its slips have shown.
    trusts_travel: bool,
    put_by: PutBy,
    /// Whether the evidence has shown a slip that goes on.
    slips: bool,
}

/// Log-likelihood ratio of a travel at its limit.
const AT_LIMIT: f32 = 72.0;
/// Weight of a method beside the stylus.
const WEIGHT: f32 = 1e-3;

/// Most readings of the travel that are put by: those of a block of the stylus at 50 kHz.
const MOST: usize = 25;

/// Readings of the travel (m) with their times, not yet looked at.
#[derive(Clone, Copy, Debug)]
struct PutBy {
    readings: [(Micros, f32); MOST],
    len: usize,
}

impl Fusion {
    /// Joins `methods`.
    ///
    /// # Errors
    /// Where a value of a configuration is outside its range, or no method is left.
    pub fn new(
        methods: Methods,
        travel: DistanceConfig,
        pressure: PressureConfig,
    ) -> Result<Self, ConfigError> {
        check(methods)?;
        Ok(Self {
            methods,
            travel: MovedDistance::new(travel)?,
            pressure: PressurePattern::new(pressure)?,
            healths: Default::default(),
            trusts_travel: true,
            put_by: PutBy { readings: [(Micros(0), 0.0); MOST], len: 0 },
            slips: false,
        })
    }

    /// Whether `method` may speak.
    #[must_use]
    #[inline]
    pub fn uses(&self, method: Method) -> bool {
        self.methods.has(method)
    }

    /// An object has just been taken: travel and pattern start afresh.
    pub fn prime(&mut self) {
        self.travel.prime();
        self.pressure.prime();
        self.trusts_travel = true;
        self.slips = false;
    }

    /// States whether the travel shows the object.
    pub fn trust_travel(&mut self, trusts: bool) {
        self.trusts_travel = trusts;
    }

    /// Whether a travel that is usable is not believed.
    #[must_use]
    #[inline]
    pub fn doubts_travel(&self) -> bool {
        !self.trusts_travel
    }

    /// The travel as it was at rest, and how far it has moved since (m, with its sign); `None` without readings.
    #[must_use]
    pub fn travel_sensor(&self, t: Micros) -> Option<(TravelSensor, f32)> {
        let usable = self.uses(Method::Travel)
            && self.healths.0 != SensorHealth::Frozen
            && self.travel.is_live(t, TRAVEL_GONE);
        let [rest_m, last_m] = self.travel.stood_m().filter(|_| usable)?;
        let (sigma_m, read) = self.travel.noise();
        let step_m = Some(self.travel.smallest_step_m()).filter(|step_m| step_m.is_finite());
        #[expect(clippy::cast_possible_truncation, reason = "a time between two readings")]
        let read_s = read.map(|read| read.as_seconds() as f32);
        let step_m = step_m.unwrap_or(0.0);
        let equal = self.travel.longest_equal();
        Some((TravelSensor { rest_m, sigma_m, step_m, read_s, equal }, last_m - rest_m))
    }

    /// The reading of the travel without the leaps of the sensor (m).
    #[must_use]
    #[inline]
    pub fn travel_m(&self, travel_m: Option<f32>) -> Option<f32> {
        let travel_m = travel_m.filter(|_| self.uses(Method::Travel))?;
        Some(self.travel.without_leaps(travel_m))
    }

    /// Whether the travel has a part.
    #[inline]
    fn has_travel(&self) -> bool {
        self.healths.0 != SensorHealth::Frozen && self.trusts_travel
    }

    /// A slip has ended: the distance counts from here.
    pub fn slip_ended(&mut self) {
        self.travel.stand();
    }

    /// States of the travel channel and of the taxel array while an object was last held.
    #[must_use]
    #[inline]
    pub fn healths(&self) -> (SensorHealth, SensorHealth) {
        self.healths
    }

    /// Whether every channel that may speak beside the stylus can be believed.
    #[must_use]
    pub fn healthy(&self) -> bool {
        let (travel, pressure) = self.healths;
        ((travel == SensorHealth::Good && self.trusts_travel) || !self.uses(Method::Travel))
            && (pressure == SensorHealth::Good || !self.uses(Method::Pressure))
    }

    /// Whether travel or pressure could show a slip at `t`: it may speak, has lately had readings, and is not frozen or failed.
    #[must_use]
    pub fn is_usable(&self, t: Micros) -> bool {
        let pressure = self.healths.1;
        let travel = self.has_travel() && self.travel.is_live(t, TRAVEL_GONE);
        let pressure = pressure == SensorHealth::Good && self.pressure.is_live(t, PATTERN_GONE);
        (self.uses(Method::Travel) && travel) || (self.uses(Method::Pressure) && pressure)
    }

    /// The travel to measure with: without the leaps of the sensor, and absent where it is frozen.
    #[must_use]
    #[inline]
    pub fn believed_travel(&self, travel_m: Option<f32>) -> Option<f32> {
        travel_m.filter(|_| self.has_travel()).map(|travel_m| self.travel.without_leaps(travel_m))
    }

    /// Whether travel or pressure shows the slip going on right now.
    #[must_use]
    pub fn is_fresh(&self, t: Micros) -> bool {
        (self.uses(Method::Travel)
            && self.has_travel()
            && self.travel.advancing(t, ADVANCED_WITHIN))
            || (self.uses(Method::Pressure) && self.pressure.changing(t, CHANGED_WITHIN))
    }

    /// Puts a reading of the travel (m, finite) by until the next call of [`Fusion::watch`] or [`Fusion::catch_up`]: the fingers
    /// are still and no other method sees a gross slip. A reading for which there is no room is looked at, with those before it.
    #[inline]
    pub fn put_by(&mut self, t: Micros, travel_m: f32) {
        if self.put_by.len == MOST {
            self.catch_up();
        }
        if let Some(place) = self.put_by.readings.get_mut(self.put_by.len) {
            *place = (t, travel_m);
            self.put_by.len += 1;
        }
    }

    /// Looks at the readings that were put by.
    #[inline]
    pub fn catch_up(&mut self) {
        let (fingers, others_gross) = (Fingers::Still, false);
        for &(t, travel_m) in self.put_by.readings.get(..self.put_by.len).unwrap_or(&[]) {
            self.travel.step(TravelReading { t, travel_m, fingers, others_gross });
        }
        self.put_by.len = 0;
    }

    /// Takes the travel of the next sample, finite where there is one; `stylus` is statistic and state of the stylus, where it is received.
    /// `decides` states whether an object is held; what is seen otherwise only costs time, and [`Fusion::prime`] forgets it.
    #[inline]
    pub fn watch(&mut self, sample: &Sample, stylus: Option<(f32, SlipState)>, decides: bool) {
        self.catch_up();
        if let Some(travel_m) = sample.travel_m {
            // An arm that moves carries fingers and object alike.
            let fingers = if decides { Fingers::Still } else { Fingers::Moving };
            let others_gross = stylus.is_some_and(|(_, state)| state == SlipState::Gross);
            self.travel.step(TravelReading { t: sample.t, travel_m, fingers, others_gross });
        }
    }

    /// The same for a frame of the taxel array; `rests`: whether an object is held and does not slip. While the grip force does not
    /// stand its pattern changes by itself.
    #[inline]
    pub fn watch_taxels(&mut self, t: Micros, taxels: &[f32], force_stands: bool, rests: bool) {
        if !force_stands {
            self.pressure.wait();
        }
        if force_stands || self.pressure.state() != SlipState::Quiet {
            self.pressure.step(t, taxels, rests);
        }
    }

    /// What the methods show together, with the statistic and state of the `stylus`, where it is received.
    #[inline]
    pub fn detect(&mut self, stylus: Option<(f32, SlipState)>) -> Option<Detection> {
        self.healths = (self.travel.health(), self.pressure.health());
        self.join(stylus)
    }

    #[inline]
    fn join(&mut self, stylus: Option<(f32, SlipState)>) -> Option<Detection> {
        let mut joined = Joined::default();
        if let Some((evidence, state)) = stylus.filter(|_| self.uses(Method::Stylus)) {
            let others = f32::from(self.travel.has_begun()) + f32::from(self.pressure.has_begun());
            joined.add(evidence * (1.0 - WEIGHT * others), state, Method::Stylus);
        }
        if self.uses(Method::Travel) && self.has_travel() {
            let evidence = at_limit(self.travel.statistic(), AT_LIMIT);
            joined.add(evidence, self.travel.state(), Method::Travel);
        }
        if self.uses(Method::Pressure) {
            let log = self.pressure.log_at_limit().min(AT_LIMIT);
            let evidence = at_limit(self.pressure.statistic(), log);
            joined.add(evidence, self.pressure.state(), Method::Pressure);
        }
        let Joined { statistic, state, method } = joined;
        let method = method?;
        self.slips = statistic >= 1.0 || (self.slips && state != SlipState::Quiet);
        Some(Detection {
            statistic,
            state: if self.slips { state } else { SlipState::Quiet },
            method,
        })
    }
}

/// Weighted evidence of a method that shows `over_limit` times its limit, with the log-likelihood ratio that it has there.
#[inline]
fn at_limit(over_limit: f32, log: f32) -> f32 {
    if over_limit <= 0.5 { 0.0 } else { libm::expf((log * (over_limit - 1.0)).min(AT_LIMIT)) }
}

/// What the methods show together.
#[derive(Clone, Copy, Debug, Default)]
struct Joined {
    statistic: f32,
    state: SlipState,
    /// Whose state that is.
    method: Option<Method>,
}

impl Joined {
    /// A method with its weighted evidence and its state.
    #[inline]
    fn add(&mut self, evidence: f32, state: SlipState, method: Method) {
        self.statistic += evidence;
        if self.method.is_none() || state > self.state {
            (self.state, self.method) = (state, Some(method));
        }
    }
}

/// # Errors
/// Where the set is empty.
pub(crate) fn check(methods: Methods) -> Result<(), ConfigError> {
    if methods.count() > 0 {
        return Ok(());
    }
    Err(ConfigError::Range { name: "methods", value: 0.0, low: 1.0, high: 3.0 })
}

#[cfg(test)]
mod tests {
    use super::{Detection, Fusion};
    use crate::{
        alarm::{Method, Methods},
        detector::SlipState,
        distance::DistanceConfig,
        pressure::PressureConfig,
        sample::Sample,
        units::Micros,
    };

    fn fusion(methods: Methods) -> Fusion {
        Fusion::new(methods, DistanceConfig::default(), PressureConfig::default()).unwrap()
    }

    fn moved_to(i: u16, travel_m: f32) -> Sample {
        let t = Micros(100 * u64::from(i));
        Sample { travel_m: Some(travel_m), ..Sample::stylus(t, 0.0) }
    }

    /// 10 kHz: the stylus quiet up to sample 200, then gross; travel 10 mm/s from sample 100 on.
    fn stated(fusion: &mut Fusion, i: u16) -> Option<Detection> {
        let moved = 1e-6 * f32::from(i.saturating_sub(100));
        let stylus = if i < 200 { (0.1, SlipState::Quiet) } else { (2.0, SlipState::Gross) };
        fusion.watch(&moved_to(i, moved), Some(stylus), true);
        fusion.detect(Some(stylus))
    }

    fn first(methods: Methods) -> (u16, Method) {
        let mut fusion = fusion(methods);
        let quiet = |joined: &Detection| joined.state == SlipState::Quiet;
        (0..2000)
            .find_map(|i| {
                stated(&mut fusion, i)
                    .filter(|joined| !quiet(joined))
                    .map(|joined| (i, joined.method))
            })
            .unwrap()
    }

    #[test]
    fn the_first_to_see_it_speaks_and_none_waits_for_another() {
        let alone = first(Methods::only(Method::Stylus));
        assert_eq!(alone, (200, Method::Stylus));
        let (at, method) = first(Methods::ALL);
        assert_eq!((at, method), (alone.0.min(at), Method::Stylus));
        let (at, method) = first(Methods::only(Method::Travel));
        assert!(method == Method::Travel && (200..205).contains(&at), "{at}");
    }

    #[test]
    fn a_set_without_methods_is_refused() {
        let (travel, pressure) = (DistanceConfig::default(), PressureConfig::default());
        assert!(Fusion::new(Methods::NONE, travel, pressure).is_err());
    }

    #[test]
    fn what_is_watched_where_no_object_is_held_is_forgotten() {
        let mut fusion = fusion(Methods::ALL);
        for i in 0..500_u16 {
            fusion.watch(&moved_to(i, 1e-5 * f32::from(i)), None, false);
        }
        fusion.prime();
        assert_eq!(stated(&mut fusion, 501).unwrap().method, Method::Stylus);
    }
}
