//! One object, its sensors, and what the posterior makes of them.

extern crate std;
use super::*;

const DT_S: f32 = 1e-4;
const G: f32 = 9.806_65;

struct Random(u32);

impl Random {
    /// From -1 to 1.
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from(u16::try_from(self.0 >> 16).unwrap()) / 32_768.0 - 1.0
    }
}

/// An object under Coulomb friction, that slides over a wave of 0.3 mm.
struct Object {
    need_n: f32,
    x: f32,
    v: f32,
    random: Random,
}

impl Object {
    fn new(need_n: f32, seed: u32) -> Self {
        Self { need_n, x: 6e-6, v: 0.01, random: Random(seed) }
    }

    fn step(&mut self, force_n: f32) {
        self.v = (self.v + DT_S * G * (1.0 - force_n / self.need_n)).max(0.0);
        self.x += self.v * DT_S;
    }

    fn stylus(&mut self) -> f32 {
        let wave = libm::sinf(core::f32::consts::TAU * self.x / 3e-4);
        5e-6 * wave + 1.7e-7 * self.random.next()
    }

    fn travel(&mut self) -> f32 {
        self.x + 1.7e-6 * self.random.next()
    }
}

fn alarm() -> Alarm {
    Alarm {
        signal: Signal::Displacement,
        sigma: Some(1e-7),
        dt_s: DT_S,
        force_n: 2.0,
        most_n: 60.0,
        travel: Some(TravelSensor {
            rest_m: 0.0,
            sigma_m: 1e-6,
            step_m: 0.0,
            read_s: None,
            equal: 0,
        }),
        moved_m: 6e-6,
        by_stylus: true,
        searched: false,
        held_s: 0.0,
        rested_s: f32::INFINITY,
    }
}

fn reading(force_n: f32) -> Reading {
    Reading { stylus: None, travel_m: None, force_n, sinks_per_n: 0.0, dead_s: 0.0, evident: true }
}

fn begun(alarm: &Alarm) -> Load<CELLS> {
    let mut load = Load::<CELLS>::new(Grid::MICRO);
    load.begin(alarm);
    load
}

fn in_order(load: &Load<CELLS>) {
    quantiles_in_order(load.bank.summary.whole_n);
    let now = load.bank.summary;
    assert!(now.speed_m_s.is_finite(), "{now:?}");
    for p in [now.p_travel, now.p_null, load.seen.p_travel, load.seen.p_null] {
        assert!((0.0..=1.001).contains(&p), "{now:?}");
    }
}

fn quantiles_in_order(now: [f32; 3]) {
    let [low_n, median_n, high_n] = now;
    let ordered = 0.0 < low_n && low_n <= median_n && median_n <= high_n && high_n.is_finite();
    assert!(ordered, "{now:?}");
}

/// Slides for `ms` under a constant force; the travel shows what `seen` makes of it. Probability that it shows the object.
fn slides(ms: u16, seed: u32, seen: fn(f32) -> f32) -> f32 {
    let (mut object, mut load) = (Object::new(4.0, seed), begun(&alarm()));
    for _ in 0..10 * ms {
        object.step(2.0);
        let travel_m = Some(seen(object.travel()));
        load.push(&Reading { stylus: Some(object.stylus()), travel_m, ..reading(2.0) });
        in_order(&load);
    }
    load.seen.p_travel
}

#[test]
fn a_travel_that_agrees_keeps_its_probability_and_one_that_is_stuck_loses_it() {
    for seed in 1..10 {
        let good = slides(20, seed, |x| x);
        assert!(good > 0.9, "{seed}: {good}");
        let stuck = slides(20, seed, |x| 6e-6 + 1e-3 * x);
        assert!(stuck < 0.1, "{seed}: stuck {stuck}");
    }
}

/// The force follows the median with a lag of 5 ms: what is needed by then (N).
fn stopped(need_n: f32, seed: u32, travel: bool, stylus: bool) -> [f32; 3] {
    let sigma = alarm().sigma.filter(|_| stylus);
    let sensor = alarm().travel.filter(|_| travel);
    let mut load = begun(&Alarm { sigma, travel: sensor, by_stylus: stylus, ..alarm() });
    let (mut object, mut force_n) = (Object::new(need_n, seed), 2.0_f32);
    for _ in 0..3000 {
        let wanted_n = 1.3 * load.bank.summary.whole_n[1];
        force_n += DT_S / 5e-3 * (wanted_n - force_n);
        object.step(force_n);
        let (x, y) = (object.stylus(), object.travel());
        load.push(&Reading {
            stylus: Some(x).filter(|_| stylus),
            travel_m: Some(y).filter(|_| travel),
            evident: object.v > 0.0,
            ..reading(force_n)
        });
        in_order(&load);
        if load.stage == Stage::Rests {
            return load.bank.summary.whole_n;
        }
    }
    panic!("{need_n} N: never stopped, {:?}", load.bank.summary);
}

#[test]
fn the_stop_shows_what_the_object_needs_by_each_set_of_sensors() {
    for (travel, stylus, within) in [(true, true, 1.4), (true, false, 1.4), (false, true, 2.0)] {
        for (seed, need_n) in (1..).zip([3.0, 4.0, 6.0, 10.0, 16.0, 25.0]) {
            let now @ [low_n, median_n, high_n] = stopped(need_n, seed, travel, stylus);
            let over = (median_n / need_n).max(need_n / median_n);
            assert!(over < within, "{need_n} N by {travel} {stylus}: {now:?}");
            assert!(low_n <= 1.25 * need_n && need_n <= 1.25 * high_n, "{need_n} N: {now:?}");
        }
    }
}

/// Beside a travel the turns of the stylus are no evidence of their own; those of a vibration are none at all.
#[test]
fn turns_count_for_a_stylus_without_a_travel_only() {
    for (travel, signal, counts) in [
        (false, Signal::Displacement, true),
        (true, Signal::Displacement, false),
        (false, Signal::Vibration, false),
    ] {
        let sensor = alarm().travel.filter(|_| travel);
        let load = begun(&Alarm { travel: sensor, signal, ..alarm() });
        assert_eq!(load.bank.counts_turns(), counts, "travel: {travel}, {signal:?}");
    }
}

/// What slips have shown is reported until another object is taken.
#[test]
fn what_is_needed_is_reported_until_another_object_is_in_hand() {
    let mut load = begun(&alarm());
    assert_eq!(load.needed(3.0), None);
    let mut object = Object::new(4.0, 1);
    for _ in 0..300 {
        object.step(2.0);
        let (x, y) = (object.stylus(), object.travel());
        load.push(&Reading { stylus: Some(x), travel_m: Some(y), ..reading(2.0) });
    }
    let need = load.needed(8.0).unwrap();
    assert!(need.low_n <= 4.4 && need.high_n >= 3.6 && need.low_n <= need.high_n, "{need:?}");
    load.end();
    assert!(load.needed(8.0).is_some() && load.stage == Stage::Rests);
    load.take(None);
    assert_eq!(load.needed(8.0), None);
    load.take(Some(7.0));
    load.begin(&alarm());
    assert!(load.prior.is_known(), "a memory states it");
}

/// A stylus that is gone leaves the travel, a travel that is gone the stylus, and where both are gone it is reported.
#[test]
fn sensors_that_are_lost_in_a_slip_are_left_out() {
    for (stylus, travel) in [(false, true), (true, false), (false, false)] {
        let (mut object, mut load) = (Object::new(4.0, 3), begun(&alarm()));
        for i in 0..300 {
            object.step(2.0);
            let (x, y) = (object.stylus(), object.travel());
            load.push(&Reading {
                stylus: Some(x).filter(|_| stylus || i < 100),
                travel_m: Some(y).filter(|_| travel || i < 100),
                ..reading(2.0)
            });
            in_order(&load);
        }
        let (seen, [low_n, _, high_n]) = (load.seen, load.bank.summary.whole_n);
        assert_eq!((seen.informed, load.stage), (stylus || travel, Stage::Moves), "{seen:?}");
        assert!(low_n <= 4.4 && high_n >= 3.6, "{low_n} to {high_n} N");
    }
}

/// A moving robot whose stylus shows its own motion, and no travel: the methods show that it slips, and nothing shows how.
#[test]
fn what_no_sensor_has_shown_teaches_nothing() {
    let mut load = begun(&Alarm { sigma: None, travel: None, ..alarm() });
    for i in 0..400_u16 {
        let force_n = 2.0 + 0.02 * f32::from(i.min(300));
        load.push(&Reading { evident: i < 300, ..reading(force_n) });
    }
    assert!(load.stage == Stage::Rests && !load.seen.informed, "{:?}", load.seen);
    assert_eq!(load.needed(8.0), None);
    load.end();
    load.begin(&alarm());
    assert!(!load.prior.is_known());
}

/// An alarm of pads that move within their shear, while the object is held with enough.
#[test]
fn an_alarm_in_which_nothing_slides_needs_no_more() {
    let mut load = begun(&Alarm { moved_m: 0.0, ..alarm() });
    let mut random = Random(5);
    for i in 0..600_u16 {
        let swing = 2e-6 * libm::expf(-f32::from(i) / 30.0);
        let swing = swing * libm::sinf(f32::from(i) / 8.0);
        let stylus = Some(swing + 1.7e-7 * random.next());
        let travel_m = Some(swing + 1.7e-6 * random.next());
        load.push(&Reading { stylus, travel_m, evident: i < 50, ..reading(2.0) });
        in_order(&load);
    }
    assert!(load.stage == Stage::Rests && load.seen.p_null > 0.5, "{:?}", load.seen);
    assert!(!load.prior.is_known(), "it has taught nothing");
}

/// Whatever comes: no panic, and quantiles that are numbers in order.
#[test]
fn garbage_gives_numbers_in_order() {
    for seed in 11..19 {
        garbage(seed);
    }
}

fn garbage(seed: u32) {
    let mut random = Random(seed);
    let mut pick = |odd: bool| -> f32 {
        let odds = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 0.0, 1e-42, -3.0];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 8")]
        let place = (4.0 * (random.next() + 1.0)) as usize;
        if odd && random.next() > 0.3 { odds[place.min(7)] } else { 5.0 * (random.next() + 1.0) }
    };
    for run in 0..60_u8 {
        let odd = run % 3 > 0;
        let mut load = Load::<CELLS>::new(Grid::MICRO);
        load.take((run % 4 == 0).then(|| pick(odd)));
        for slip in 0..4_u8 {
            load.begin(&Alarm {
                signal: if run % 2 == 0 { Signal::Displacement } else { Signal::Vibration },
                sigma: (slip != 1).then(|| if odd { pick(odd) } else { 1e-7 }),
                dt_s: if odd { pick(odd) } else { DT_S },
                force_n: pick(odd),
                most_n: pick(odd),
                travel: (slip != 2).then(|| TravelSensor {
                    rest_m: pick(odd),
                    sigma_m: pick(odd),
                    step_m: pick(odd),
                    read_s: (run % 5 == 0).then(|| pick(odd)),
                    equal: 7,
                }),
                moved_m: pick(odd),
                by_stylus: run % 2 == 0,
                searched: slip == 3,
                held_s: pick(odd),
                rested_s: pick(odd),
            });
            for i in 0..100_u8 {
                load.push(&Reading {
                    stylus: (i % 7 > 0).then(|| 1e-6 * pick(true)),
                    travel_m: (i % 5 > 0).then(|| 1e-5 * pick(true)),
                    force_n: pick(true),
                    sinks_per_n: 1e-7 * pick(true),
                    dead_s: 1e-3 * pick(true),
                    evident: i % 3 > 0,
                });
                load.needed.into_iter().for_each(quantiles_in_order);
                assert!(load.needed(2.0).is_none_or(|need| need.admissible_m_s2.is_finite()));
            }
            load.end();
        }
    }
}
