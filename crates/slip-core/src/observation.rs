//! Features of a slip, from its samples.
//!
//! Over a stretch of sliding the impulse balance of an object of mass m between two fingers with friction
//! mu is m dv = (m g - 2 mu F) dt, so with the mean force F and the mean acceleration a of the same
//! stretch the force at which the slip stops growing is F_req = F / (1 - a/g), whatever F did meanwhile. While the load is still
//! being put on, the same figure is what the load so far needs: too little, never too much.
//!
//! Where the moved distance is measured the stretch is the last two speed windows, so that a load that grows is followed within
//! milliseconds. Where only a speed is, it starts when the speed is first known and starts again from the last reading when it becomes longer
//! than [`ObservationConfig::longest_ms`]; a speed carries more noise than a distance.

use crate::{
    course::TravelNoise,
    esc::{EscSum, Reading, Trial},
    estimate::Features,
    irregularity::IrregularityExtractor,
    sample::Sample,
    settings::settings,
    units::Micros,
    velocity::{SpeedConfig, SpeedReading, SpeedWindow},
};

settings! {
    /// How a slip is measured.
    pub struct ObservationConfig as c in "observation" {
        shortest_ms: f32 = 3.0, 0.5..=1000.0 => "Shortest stretch that gives features (ms).";
        longest_ms: f32 = 40.0, c.shortest_ms..=10_000.0 => "Longest stretch before a new one starts (ms).";
        min_speed_m_s: f32 = 0.004, 1e-6..=10.0 =>
            "Slowest speed that counts as sliding (m/s). Below it a stretch ends: at rest the balance does not"
            "hold, and a load that is being put on shears the pads at 1 to 2 mm/s. After the object has stopped"
            "once, and where no distance is measured, three times as much: pads that swing back after a slip reach"
            "some mm/s.";
        recoil_m: f32 = 4e-6, 0.0..=1e-2 =>
            "Moving back by more than this (m) is the elastic recoil of a pad at rest, not sliding; the resolution"
            "and noise of the travel sensor must stay below it.";
        hysteresis_sigmas: f32 = 6.0, 1.0..=100.0 =>
            "A reversal of the stylus counts as peak or valley beyond this many deviations of its noise.";
        min_hysteresis_m: f32 = 2e-7, 1e-10..=1e-2 => "Smallest hysteresis (m).";
        esc_noise: f32 = 0.01, 0.0..=1.0 => "Relative noise of one delta/s, for the trust figures of E_sc.";
        esc: Reading = Reading::Literal => "The reading of E_sc that stands beside the literal one.";
        stylus_damping_n_s_m: f32 = Trial::<f32>::DAMPING_N_S_M, 0.0..=1e6 =>
            "Damper of the stylus (N s/m), for the reading `viscous_work` alone.";
        [speed]: SpeedConfig = SpeedConfig::default() => "Where the speed comes from.";
    }
}

/// The measurement of one slip.
#[derive(Clone, Copy, Debug)]
pub struct SlipObservation {
    config: ObservationConfig,
    rate_hz: f32,
    /// Deviation of one reading of the travel as configured, and as configured or seen in this slip (m).
    configured_sigma_m: f32,
    travel_sigma_m: f32,
    /// Deviation of the latest speed that is measured otherwise (m/s); `None` where it is not known.
    speed_sigma_m_s: Option<f32>,
    heights: bool,
    window: SpeedWindow,
    extractor: IrregularityExtractor,
    esc: EscSum,
    slope_sum: f32,
    onset: Option<Onset>,
    last_t: Micros,
    /// Time of the last reading of the travel.
    read_t: Micros,
    position_m: f64,
    furthest_m: f64,
    /// Whether the object has stopped and swung back since the slip was noticed.
    swung: bool,
    advance: Advance,
    noise: TravelNoise,
    stretch: Option<Stretch>,
}

/// Readings of the mean of the travel's noise, and before it is believed.
const NOISE_READINGS: u16 = 32;

/// The last time the object was seen to move forward by more than the recoil.
#[derive(Clone, Copy, Debug, Default)]
struct Advance {
    t: Micros,
    position_m: f64,
}

/// An object that has not moved forward for this long has stopped.
const STOPPED_AFTER: Micros = Micros(3000);
/// Deviations of a reading that are no movement.
const NOISES: f32 = 6.0;
/// A noise over the configured one from which it is believed.
const CLEARLY: f32 = 2.0;
/// Without a reading for this long the travel shows nothing.
const UNREAD_FOR: Micros = Micros(5000);
/// A speed that is older than this, and than two samples and a half, shows nothing of now.
const SPEED_LASTS: Micros = Micros(5000);

#[derive(Clone, Copy, Debug)]
struct Onset {
    travel_m: Option<f32>,
}

#[derive(Clone, Copy, Debug)]
struct Stretch {
    start: Micros,
    /// The time of the latest reading.
    end: Micros,
    start_speed_m_s: f32,
    impulse_ns: f64,
    latest: SpeedReading,
}

/// How the object moved over the stretch.
#[derive(Clone, Copy, Debug)]
struct Motion {
    span_s: f32,
    speed_m_s: f32,
    acceleration_m_s2: f32,
    acceleration_sigma_m_s2: Option<f32>,
    force_n: f32,
}

impl SlipObservation {
    /// An observation of samples at `rate_hz`.
    #[must_use]
    pub fn new(config: ObservationConfig, rate_hz: f32) -> Self {
        Self {
            config,
            rate_hz,
            configured_sigma_m: 0.0,
            travel_sigma_m: 0.0,
            speed_sigma_m_s: None,
            heights: true,
            window: SpeedWindow::new(config.speed, rate_hz),
            extractor: IrregularityExtractor::new(config.min_hysteresis_m),
            esc: EscSum::new(config.esc),
            slope_sum: 0.0,
            onset: None,
            last_t: Micros(0),
            read_t: Micros(0),
            position_m: 0.0,
            furthest_m: f64::NEG_INFINITY,
            swung: false,
            advance: Advance::default(),
            noise: TravelNoise::default(),
            stretch: None,
        }
    }

    /// The same for a travel sensor of which one reading has the deviation `travel_sigma_m` (m).
    #[must_use]
    pub fn with_travel_sigma(self, travel_sigma_m: f32) -> Self {
        Self { configured_sigma_m: travel_sigma_m, travel_sigma_m, ..self }
    }

    /// Deviation of one reading of the travel as configured (m).
    #[must_use]
    pub fn configured_sigma_m(&self) -> f32 {
        self.configured_sigma_m
    }

    /// Deviation of one reading of the travel (m): as configured, or as seen in this slip where that is clearly more.
    #[must_use]
    #[inline]
    pub fn travel_sigma_m(&self) -> f32 {
        self.travel_sigma_m
    }

    /// The next reading of the travel (m) is looked at for its noise.
    fn measure_noise(&mut self, travel_m: f32) {
        let differs = self.noise.push(travel_m, NOISE_READINGS, f32::INFINITY);
        if differs && self.noise.seen() >= NOISE_READINGS {
            let seen_m = self.noise.sigma_m();
            let clearly = seen_m > CLEARLY * self.configured_sigma_m;
            self.travel_sigma_m = if clearly { seen_m } else { self.configured_sigma_m };
        }
    }

    /// The deviation of the speed (m/s) in the samples that follow, where it does not come from the travel.
    #[inline]
    pub fn trust_speed(&mut self, sigma_m_s: Option<f32>) {
        self.speed_sigma_m_s = sigma_m_s;
    }

    /// Begins with the next sample. `noise_m` is the deviation of the stylus noise (m, rms), `None` where
    /// the stylus does not measure displacement and irregularities have no heights.
    pub fn begin(&mut self, noise_m: Option<f32>) {
        *self = Self::new(self.config, self.rate_hz).with_travel_sigma(self.configured_sigma_m);
        self.heights = noise_m.is_some();
        let hysteresis = self.config.hysteresis_sigmas * noise_m.unwrap_or(0.0);
        self.extractor = IrregularityExtractor::new(hysteresis.max(self.config.min_hysteresis_m));
    }

    /// Distance moved since the slip was noticed (m); `None` where no sensor shows.
    #[must_use]
    pub fn moved_m(&self, sample: &Sample) -> Option<f32> {
        self.onset?.travel_m.and_then(|start| Some((sample.travel_m? - start).abs()))
    }

    /// The latest slip speed (m/s), `None` before the first window is full.
    #[must_use]
    pub fn speed_m_s(&self) -> Option<f32> {
        self.fresh_stretch().map(|stretch| stretch.latest.speed_m_s)
    }

    /// The mean speed of the moved distance (m/s) and the length of its window (s); `None` where the speed is not measured so.
    #[must_use]
    pub fn travel_speed(&self) -> Option<(f32, f32)> {
        let measured = self.onset?.travel_m.is_some() && self.config.speed.fixed_m_s.is_none();
        let speed_m_s = self.speed_m_s().filter(|_| measured)?;
        Some((speed_m_s, self.window.span_s(self.rate_hz)))
    }

    /// Whether the travel was read lately.
    fn is_read(&self) -> bool {
        let age = self.last_t.since(self.read_t);
        age < UNREAD_FOR || age.as_seconds() * f64::from(self.rate_hz) <= 2.5
    }

    /// Whether the object moves forward right now; `None` where no sensor shows.
    #[must_use]
    pub fn advancing(&self) -> Option<bool> {
        let measured = self.onset?.travel_m.is_some() && self.is_read();
        measured.then(|| self.last_t.since(self.advance.t) < STOPPED_AFTER)
    }

    /// Takes the next sample of the slip.
    #[inline]
    pub fn push(&mut self, sample: &Sample) {
        let dt_s =
            if self.onset.is_some() { sample.t.since(self.last_t).as_seconds() } else { 0.0 };
        self.last_t = sample.t;
        if sample.travel_m.is_some() {
            if !self.is_read() {
                self.rest();
            }
            self.read_t = sample.t;
        }
        let force_n = sample.normal_force_n.unwrap_or(0.0);
        let onset = *self.onset.get_or_insert(Onset { travel_m: sample.travel_m });
        let reading = match (sample.travel_m, onset.travel_m) {
            (Some(travel_m), Some(start_m)) if self.config.speed.fixed_m_s.is_none() => {
                // The sign of the travel depends on how the sensor is mounted.
                let moved_m = (travel_m - start_m).abs();
                self.position_m = f64::from(moved_m);
                self.slide(sample.t, moved_m, force_n)
            }
            _ => {
                let reading = self.window.direct(sample.velocity_m_s, force_n);
                self.position_m +=
                    reading.map_or(0.0, |reading| f64::from(reading.speed_m_s) * dt_s);
                reading
            }
        };
        if self.heights
            && let Some(irregularity) = self.extractor.push(self.position_m, sample.stylus)
            && self.esc.push(f64::from(irregularity.delta_m), f64::from(irregularity.spacing_m))
        {
            self.slope_sum += irregularity.delta_m / irregularity.spacing_m;
        }
        if let Some(reading) = reading {
            self.extend_stretch(sample.t, reading);
        }
    }

    /// The speed over the window, as long as the object moves forward.
    fn slide(&mut self, t: Micros, travel_m: f32, force_n: f32) -> Option<SpeedReading> {
        self.measure_noise(travel_m);
        self.furthest_m = self.furthest_m.max(self.position_m);
        let recoil_m = f64::from(self.config.recoil_m.max(NOISES * self.travel_sigma_m()));
        if self.position_m > self.advance.position_m + recoil_m {
            self.advance = Advance { t, position_m: self.position_m };
        }
        if self.position_m < self.furthest_m - recoil_m {
            self.rest();
            self.swung = true;
            return None;
        }
        self.window.push(t, travel_m, force_n)
    }

    /// Sliding has ended: speeds and forces from before show nothing about what follows.
    fn rest(&mut self) {
        self.window.reset();
        self.stretch = None;
    }

    /// Slowest speed that counts as sliding (m/s).
    fn slowest_m_s(&self) -> f32 {
        let distance = self.onset.is_some_and(|onset| onset.travel_m.is_some());
        let factor = if distance && !self.swung { 1.0 } else { 3.0 };
        factor * self.config.min_speed_m_s
    }

    fn extend_stretch(&mut self, t: Micros, reading: SpeedReading) {
        let longest_s = f64::from(self.config.longest_ms) * 1e-3;
        if reading.speed_m_s.abs() < self.slowest_m_s() {
            self.stretch = None;
            return;
        }
        let last = self.stretch.filter(|stretch| self.is_recent(stretch.end, t));
        match last {
            Some(mut stretch) if t.since(stretch.start).as_seconds() <= longest_s => {
                let mean_n = 0.5 * (f64::from(stretch.latest.force_n) + f64::from(reading.force_n));
                stretch.impulse_ns += mean_n * t.since(stretch.end).as_seconds();
                stretch.end = t;
                stretch.latest = reading;
                self.stretch = Some(stretch);
            }
            _ => {
                self.stretch = Some(Stretch {
                    start: t,
                    end: t,
                    start_speed_m_s: reading.speed_m_s,
                    impulse_ns: 0.0,
                    latest: reading,
                });
            }
        }
    }

    /// The stretch, as long as its last speed is one of now.
    fn fresh_stretch(&self) -> Option<Stretch> {
        self.stretch.filter(|stretch| self.is_recent(stretch.end, self.last_t))
    }

    fn is_recent(&self, then: Micros, now: Micros) -> bool {
        let age = now.since(then);
        age <= SPEED_LASTS || age.as_seconds() * f64::from(self.rate_hz) <= 2.5
    }

    /// Speed, mean acceleration and mean force of the stretch (s, m/s, m/s^2, N); `None` while it is too short.
    #[expect(clippy::cast_possible_truncation, reason = "differences and sums were taken in f64")]
    fn motion(&self) -> Option<Motion> {
        let shortest_s = 1e-3 * self.config.shortest_ms;
        if self.onset?.travel_m.is_some() && self.config.speed.fixed_m_s.is_none() {
            // What was measured before the sensor was lost shows nothing of now.
            let balance = self.window.balance(shortest_s).filter(|_| self.is_read())?;
            let [before, now] = balance.speeds_m_s;
            return (before.min(now) >= self.slowest_m_s()).then_some(Motion {
                span_s: balance.span_s,
                speed_m_s: now,
                acceleration_m_s2: balance.acceleration_m_s2,
                acceleration_sigma_m_s2: Some(balance.acceleration_sigma(self.travel_sigma_m())),
                force_n: balance.force_n,
            });
        }
        let stretch = self.fresh_stretch()?;
        let span_s = stretch.end.since(stretch.start).as_seconds();
        if span_s < f64::from(shortest_s) || span_s <= 0.0 {
            return None;
        }
        let speed_m_s = stretch.latest.speed_m_s;
        let gained = f64::from(speed_m_s - stretch.start_speed_m_s);
        let span = span_s as f32;
        // Of two speeds that are equally unsure.
        let sigma = |sigma_m_s: f32| core::f32::consts::SQRT_2 * sigma_m_s / span;
        Some(Motion {
            span_s: span,
            speed_m_s,
            acceleration_m_s2: (gained / span_s) as f32,
            acceleration_sigma_m_s2: self.speed_sigma_m_s.map(sigma),
            force_n: (stretch.impulse_ns / span_s) as f32,
        })
    }

    /// The features of the slip so far; `None` while the stretch is too short or no speed is known.
    #[must_use]
    pub fn features(&self) -> Option<Features> {
        let motion = self.motion()?;
        let n = self.esc.n();
        let mean_slope = (n > 0).then(|| self.slope_sum / n as f32);
        let trial = Trial {
            damping_n_s_m: f64::from(self.config.stylus_damping_n_s_m),
            ..Trial::new(f64::from(motion.force_n), f64::from(motion.speed_m_s))
                .with_noise(f64::from(self.config.esc_noise))
        };
        let esc = self.esc.literal(&trial);
        #[expect(clippy::cast_possible_truncation, reason = "sums were taken in f64")]
        let micro_displacement_m = self.position_m as f32;
        Some(Features {
            slip_speed_m_s: motion.speed_m_s,
            contact_time_s: motion.span_s,
            slip_acceleration_m_s2: motion.acceleration_m_s2,
            slip_acceleration_sigma_m_s2: motion.acceleration_sigma_m_s2,
            micro_displacement_m,
            trial_force_n: motion.force_n,
            irregularities: n,
            mean_slope,
            esc,
            esc_chosen: self.esc.chosen(&trial, esc),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{ObservationConfig, SlipObservation};
    use crate::{sample::Sample, units::Micros};

    const G: f64 = 9.81;

    /// An object that needs 10 N, gripped with a force that rises from 2 N by 300 N/s.
    #[test]
    fn impulse_balance_gives_the_needed_force_while_the_force_rises() {
        let mut observation = SlipObservation::new(ObservationConfig::default(), 10_000.0);
        observation.begin(Some(1e-7));
        let (mut speed, mut travel) = (0.0_f64, 0.0_f64);
        let mut checked = 0;
        for i in 0..400_u16 {
            let t = f64::from(i) * 1e-4;
            let force = 2.0 + 300.0 * t;
            #[expect(clippy::cast_possible_truncation, reason = "test signal")]
            let sample = Sample {
                t: Micros(u64::from(i) * 100),
                stylus: 1e-5 * (core::f64::consts::TAU * travel / 2e-4).sin() as f32,
                normal_force_n: Some(force as f32),
                travel_m: Some(travel as f32),
                ..Sample::default()
            };
            observation.push(&sample);
            if let Some(features) = observation.features() {
                let a = f64::from(features.slip_acceleration_m_s2);
                let needed = f64::from(features.trial_force_n) / (1.0 - a / G);
                assert!((needed / 10.0 - 1.0).abs() < 0.02, "{needed} N after {t} s");
                checked += 1;
            }
            let step = (G - G / 10.0 * force) * 1e-4;
            travel += (speed + 0.5 * step) * 1e-4;
            speed += step;
        }
        let features = observation.features().unwrap();
        assert!(checked > 300 && features.irregularities > 5, "{checked} {features:?}");
        let slope = features.mean_slope.unwrap();
        assert!((slope - 0.1).abs() < 0.02, "2e-5 high, 2e-4 apart: {slope}");
    }

    /// A speed of 1 m/s that grows by 2 m/s^2, measured to 1 mm/s: over T seconds two of them show the acceleration to sqrt(2) mm/s / T.
    #[test]
    fn an_acceleration_is_as_unsure_as_the_speeds_it_comes_from() {
        for sigma_m_s in [None, Some(1e-3)] {
            let mut observation = SlipObservation::new(ObservationConfig::default(), 1000.0);
            observation.begin(None);
            for i in 0..20_u8 {
                observation.trust_speed(sigma_m_s);
                observation.push(&Sample {
                    normal_force_n: Some(2.0),
                    velocity_m_s: Some(1.0 + 2e-3 * f32::from(i)),
                    ..Sample::stylus(Micros(u64::from(i) * 1000), 0.0)
                });
            }
            let features = observation.features().unwrap();
            assert!((features.slip_acceleration_m_s2 - 2.0).abs() < 1e-3, "{features:?}");
            let sigma = features.slip_acceleration_sigma_m_s2;
            let wanted = sigma_m_s.map(|sigma| 1.414 * sigma / features.contact_time_s);
            let close = |(a, b): (f32, f32)| (a / b - 1.0).abs() < 1e-3;
            assert_eq!(sigma.is_some(), sigma_m_s.is_some());
            assert!(sigma.zip(wanted).is_none_or(close), "{sigma:?} {wanted:?}");
        }
    }

    /// A speed with every fifth sample gives what one with every sample does; where it ends there is nothing to go by soon.
    #[test]
    fn a_speed_that_comes_seldom_counts_and_one_that_has_gone_does_not() {
        let mut observation = SlipObservation::new(ObservationConfig::default(), 1000.0);
        observation.begin(None);
        let mut seen = [0_u8; 2];
        for i in 0..60_u8 {
            let speed = (i < 30 && i.is_multiple_of(5)).then(|| 0.5 + 4e-3 * f32::from(i));
            let sample = Sample::stylus(Micros(u64::from(i) * 1000), 0.0);
            let force_n = 2.0 + 0.1 * f32::from(i);
            observation.push(&Sample {
                normal_force_n: Some(force_n),
                velocity_m_s: speed,
                ..sample
            });
            let Some(features) = observation.features() else { continue };
            seen[usize::from(i >= 31)] += 1;
            assert!((features.slip_acceleration_m_s2 - 4.0).abs() < 1e-3, "{i}: {features:?}");
            let mean_n = 2.0 + 0.05 * f32::from(i / 5 * 5).min(25.0);
            assert!((features.trial_force_n - mean_n).abs() < 1e-4, "{i}: {features:?}");
        }
        assert_eq!(seen, [26, 0], "from the second speed on, until 5 ms after the last");
    }

    #[test]
    fn without_a_speed_there_are_no_features() {
        let mut observation = SlipObservation::new(ObservationConfig::default(), 1000.0);
        observation.begin(None);
        for i in 0..100_u8 {
            observation.push(&Sample::stylus(Micros(u64::from(i) * 1000), f32::from(i % 5)));
        }
        assert_eq!(observation.features(), None);
    }
}
