use super::{
    Actuator, BoardOptions, GripperForce, GripperReading, RowBoard, RowCounters, RowsError,
};
use crate::{HostConfig, Session, SessionOptions, Update, model, report::Event};
use core::fmt::Write as _;
use core::time::Duration;
use grip_link::device::Drive;
use grip_link::{frame::MAX_WIRE, message::ChannelKind};
use proptest::prelude::*;

const STREAM: BoardOptions = BoardOptions { actuator: None, datagrams: false };

/// A board and a session that talk to each other, 500 us a turn.
struct Bench {
    board: RowBoard,
    session: Session,
    now_us: u64,
    slips_s: Vec<f64>,
    samples: Vec<(u64, f32)>,
    forces_n: Vec<f32>,
    reports: Vec<String>,
    drives: Vec<(u64, Drive)>,
}

impl Bench {
    fn new(options: BoardOptions) -> Self {
        let mut config = HostConfig::default();
        config.link.sample_rate_hz = 20_000;
        let estimator = model::default_estimator().unwrap();
        let mut session = Session::new(config, estimator, SessionOptions::default()).unwrap();
        session.open(0, 7).unwrap();
        Self {
            board: RowBoard::new(options),
            session,
            now_us: 0,
            slips_s: Vec::new(),
            samples: Vec::new(),
            forces_n: Vec::new(),
            reports: Vec::new(),
            drives: Vec::new(),
        }
    }

    fn turn(&mut self) -> Result<(), RowsError> {
        let mut frame = [0; MAX_WIRE];
        self.now_us += 500;
        self.board.turn(self.now_us)?;
        let bytes = self.board.unsent().to_vec();
        self.board.sent(bytes.len());
        let mut left = &bytes[..];
        while let Some(update) = self.session.receive(self.now_us, &mut left).unwrap() {
            match update {
                Update::Event(Event::Slip(slip)) => self.slips_s.push(slip.t.as_seconds()),
                Update::Step { sample, .. } => {
                    self.samples.push((sample.t.0, sample.stylus));
                    self.forces_n.extend(sample.normal_force_n);
                }
                _ => {}
            }
        }
        let mut host = Vec::new();
        while let Some(len) = self.session.poll_transmit(self.now_us, &mut frame) {
            host.extend_from_slice(&frame[..len]);
        }
        if let Some(len) = self.session.command(self.now_us, &mut frame) {
            host.extend_from_slice(&frame[..len]);
        }
        if self.board.is_ready() {
            self.board.receive(self.now_us, &host);
        }
        self.drives.extend(self.board.drive(self.now_us));
        self.reports.extend(self.board.take_reports());
        Ok(())
    }

    /// Gives all of `text`, ends the input and runs until everything has arrived.
    fn run(&mut self, text: &[u8]) -> Result<(), RowsError> {
        let mut left = text;
        while !self.board.is_over() {
            let (now, later) = left.split_at(left.len().min(self.board.room()));
            self.board.push(now)?;
            left = later;
            if left.is_empty() {
                self.board.end()?;
            }
            self.turn()?;
            assert!(self.now_us < 60_000_000, "it ends");
        }
        self.turn()
    }
}

/// A number from -1 to 1.
fn noise(state: &mut u32) -> f64 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*state >> 16) / 32_768.0 - 1.0
}

/// Two seconds at 1600 Hz, ten times as loud from 1.5 s to 1.6 s.
fn vibration(first_s: f64) -> String {
    let (mut text, mut seed) = ("t_s,vibration,rate=1600\n".to_owned(), 1);
    for row in 0..3200 {
        let size = if (2400..2560).contains(&row) { 0.1 } else { 0.01 };
        let t_s = first_s + f64::from(row) / 1600.0;
        writeln!(text, "{t_s:.6},{:.6}", size * noise(&mut seed)).unwrap();
    }
    text
}

#[test]
fn rows_become_samples_and_slips_at_the_times_of_the_rows() {
    for first_s in [0.0, 1_700_000_000.0] {
        let mut bench = Bench::new(STREAM);
        bench.run(vibration(first_s).as_bytes()).unwrap();
        let counters = RowCounters { rows: 3200, ..RowCounters::default() };
        assert_eq!((bench.board.counters(), bench.session.lost()), (counters, 0));
        assert_eq!(bench.samples.len(), 3200, "each row arrives once");
        let first = bench.slips_s[0] - first_s;
        assert!((1.5..1.6).contains(&first), "{first}");
        assert_eq!(bench.session.counters().commands, 0);
        // A file runs in real time, and reports it once.
        assert!((1_500_000..2_200_000).contains(&bench.now_us), "{}", bench.now_us);
        assert_eq!(bench.reports.len(), 1, "{:?}", bench.reports);
    }
}

#[test]
fn packed_rows_give_the_same_samples() {
    let text = vibration(0.0);
    let mut csv = Bench::new(STREAM);
    csv.run(text.as_bytes()).unwrap();
    let mut bytes = b"vibration,rate=1600,format=f32\n".to_vec();
    for line in text.lines().skip(1) {
        let value: f32 = line.split_once(',').unwrap().1.parse().unwrap();
        bytes.extend(value.to_le_bytes());
    }
    let mut packed = Bench::new(STREAM);
    packed.run(&bytes).unwrap();
    let values = |bench: &Bench| bench.samples.iter().map(|(_, value)| *value).collect::<Vec<_>>();
    assert_eq!(values(&csv), values(&packed));
    assert_eq!(csv.slips_s.len(), packed.slips_s.len());
}

#[test]
fn the_first_row_decides_and_later_ones_are_left_out_where_they_are_bad() {
    let fails = |text: &str| Bench::new(STREAM).run(text.as_bytes()).unwrap_err().to_string();
    assert!(fails("vibration,rate=100\n1,2\n").contains("row 1: 2 values, the header names 1"));
    assert!(fails("vibration\n1\n").contains("rate is missing"));
    assert!(fails("").contains("before its first row"));
    assert!(fails("vibration,rate=100").contains("before its first row"));
    assert!(fails(&"x".repeat(3000)).contains("no line of text"));
    let mut milliseconds = "t_s,vibration,rate=1000\n".to_owned();
    (0..200).for_each(|row| writeln!(milliseconds, "{row},1").unwrap());
    assert!(fails(&milliseconds).contains("is t_s in seconds?"));
    assert!(fails(&milliseconds.replace(",1\n", "000,1\n")).contains("is t_s in seconds?"));
    let mut bench = Bench::new(STREAM);
    let mut text = "vibration,rate=1000\n".to_owned();
    for row in 0..500 {
        text += if row % 100 == 50 { "nan\n" } else { "1.5\n" };
    }
    bench.run(text.as_bytes()).unwrap();
    let counters = RowCounters { rows: 495, bad: 5, ..RowCounters::default() };
    assert_eq!((bench.board.counters(), bench.session.lost()), (counters, 5));
    assert!(
        bench.reports[0].contains("row 51: vibration has no finite value"),
        "{:?}",
        bench.reports
    );
    assert!(bench.reports.len() <= 4, "{:?}", bench.reports);
}

#[test]
fn a_stream_that_is_joined_within_its_first_time_has_the_times_of_the_next_rows() {
    for cut in ["001000,-0.06", "1000,-0.06", "0,-0.06"] {
        let mut bench = Bench::new(STREAM);
        let mut text = format!("t_s,vibration,rate=1000\n{cut}\n");
        let first_ms: u32 = if cut.starts_with("0,") { 12_001 } else { 5_001 };
        (0..1000).for_each(|row| {
            writeln!(text, "{:.6},1", f64::from(first_ms + row) / 1e3).unwrap();
        });
        bench.run(text.as_bytes()).unwrap();
        let counters = RowCounters { rows: 1000, bad: 1, ..RowCounters::default() };
        assert_eq!(bench.board.counters(), counters, "{cut}");
        assert!(bench.reports[0].contains("joined in its middle"), "{:?}", bench.reports);
        assert_eq!(bench.samples[0].0, u64::from(first_ms) * 1000);
    }
}

#[test]
fn late_and_missing_rows_are_counted() {
    let mut bench = Bench::new(STREAM);
    let mut text = "t_s,vibration,rate=1000\n".to_owned();
    for row in 0..1000 {
        let t_ms = match row {
            300 => 290,
            301.. => row + 100,
            _ => row,
        };
        writeln!(text, "{},1", f64::from(t_ms) / 1e3).unwrap();
    }
    bench.run(text.as_bytes()).unwrap();
    let counters = RowCounters { rows: 999, late: 1, missing: 101, ..RowCounters::default() };
    assert_eq!((bench.board.counters(), bench.session.lost()), (counters, 101));
    assert!(bench.reports.iter().any(|text| text.contains("row 301 is no newer")));
}

#[test]
fn a_time_that_is_set_back_does_not_end_the_rows() {
    let mut bench = Bench::new(STREAM);
    let mut text = "t_s,vibration,rate=1000\n".to_owned();
    for row in 0..4000 {
        let t_ms = if row < 1000 { 50_000 + row } else { row };
        writeln!(text, "{},1", f64::from(t_ms) / 1e3).unwrap();
    }
    bench.run(text.as_bytes()).unwrap();
    let counters = bench.board.counters();
    assert!((998..1001).contains(&counters.late) && counters.rows > 2998, "{counters:?}");
    assert!(bench.samples.windows(2).all(|pair| pair[0].0 < pair[1].0));
}

#[test]
fn datagrams_may_be_lost_doubled_or_late() {
    let options = BoardOptions { datagrams: true, ..STREAM };
    let error = RowBoard::new(options).push_datagram(b"vibration,rate=1000").unwrap_err();
    assert_eq!(error, RowsError::DatagramTime);
    let mut bench = Bench::new(options);
    let header = b"vibration,rate=1000,format=f32";
    bench.board.push_datagram(header).unwrap();
    for first in (0_u32..2000).step_by(4) {
        let numbers: &[u32] = match first {
            400 => &[],
            800 => &[800, 800],
            1200 => &[1204],
            1204 => &[1200],
            _ => &[first],
        };
        for number in numbers {
            let mut bytes = number.to_le_bytes().to_vec();
            (0..4).for_each(|_| bytes.extend(1.0_f32.to_le_bytes()));
            bench.board.push_datagram(&bytes).unwrap();
        }
        if first == 600 {
            bench.board.push_datagram(header).unwrap();
            bench.board.push_datagram(&[0; 7]).unwrap();
        }
        (0..8).for_each(|_| bench.turn().unwrap());
    }
    let counters = RowCounters { rows: 1992, bad: 1, late: 8, missing: 8 };
    assert_eq!((bench.board.counters(), bench.session.lost()), (counters, 8));
}

/// Rows of `text` as a sender gives them that is so many times as fast as 1600 a second; each is taken at once.
fn live(bench: &mut Bench, text: &str, speed: f64) {
    let mut lines = text.lines();
    bench.board.push(format!("{}\n", lines.next().unwrap()).as_bytes()).unwrap();
    let (mut sent, start_us) = (0_u32, bench.now_us);
    while lines.clone().next().is_some() {
        let passed_s = 1e-6 * (bench.now_us - start_us) as f64;
        while f64::from(sent) < 1600.0 * speed * passed_s
            && let Some(line) = lines.next()
        {
            bench.board.push(format!("{line}\n").as_bytes()).unwrap();
            sent += 1;
        }
        bench.turn().unwrap();
        let waiting = u64::from(sent) - bench.board.counters().rows;
        // The host needs a moment to begin.
        assert!(bench.now_us - start_us < 200_000 || waiting == 0, "{waiting} rows wait");
    }
    bench.board.end().unwrap();
    (0..8).for_each(|_| bench.turn().unwrap());
}

const ACTUATOR: Option<Actuator> =
    Some(Actuator { force_max_n: 20.0, slew_n_s: 200.0, holds_n: 0.0, shows_force: false });

#[test]
fn with_a_gripper_no_row_waits_however_fast_they_come() {
    for speed in [1.0, 1.12, 1.3, 3.0] {
        let mut bench = Bench::new(BoardOptions { actuator: ACTUATOR, ..STREAM });
        live(&mut bench, &vibration(0.0), speed);
        assert_eq!(bench.board.counters().rows, 3200);
    }
}

#[test]
fn rows_at_another_rate_are_reported_with_it_and_not_as_a_source_that_stopped() {
    for (actuator, speed, rate) in
        [(None, 0.8, "1280"), (None, 0.95, "1520"), (ACTUATOR, 1.3, "2080")]
    {
        let mut bench = Bench::new(BoardOptions { actuator, ..STREAM });
        live(&mut bench, &("vibration,rate=1600\n".to_owned() + &"1.0\n".repeat(8000)), speed);
        let wrong = format!("{rate} rows come in a second, rate= says 1600");
        let named = bench.reports.iter().filter(|text| text.contains(&wrong));
        assert_eq!(named.count(), 1, "{speed}: {:?}", bench.reports);
        assert!(!bench.reports.iter().any(|text| text.contains("stopped")), "{:?}", bench.reports);
    }
}

#[test]
fn a_time_far_ahead_is_not_waited_for() {
    for (actuator, ahead_s) in [(None, 1e6), (ACTUATOR, 1e6), (None, 30.0)] {
        let mut bench = Bench::new(BoardOptions { actuator, ..STREAM });
        let text = vibration(0.0).replacen("1.000000,", &format!("{},", 1.0 + ahead_s), 1);
        bench.run(text.as_bytes()).unwrap();
        // A second of rows is older than the wrong one; then their times are followed again.
        let counters = bench.board.counters();
        assert!(counters.rows >= 1590 && counters.missing == 0, "{counters:?}");
        assert!(
            bench.reports.iter().any(|text| text.contains("ahead at row")),
            "{:?}",
            bench.reports
        );
    }
}

#[test]
fn a_gripper_of_the_program_gets_the_force() {
    let mut bench = Bench::new(BoardOptions { actuator: ACTUATOR, ..STREAM });
    live(&mut bench, &vibration(0.0), 1.0);
    assert!(bench.session.counters().commands > 0);
    let forces: Vec<i32> = bench.drives.iter().map(|(_, drive)| drive.force_mn()).collect();
    let most = forces.iter().copied().max().unwrap();
    assert!((1000..=20_000).contains(&most), "{most}");
    // 500 us at 200 N/s.
    assert!(forces.windows(2).all(|pair| pair[1] - pair[0] <= 101), "within the slew rate");
    // Only what the command led by comes back, within 70 ms of the slip, which ends at 1.6 s.
    let falls = |pair: &[(u64, Drive)]| pair[1].1.force_mn() < pair[0].1.force_mn();
    let fell: Vec<u64> =
        bench.drives.windows(2).filter(|pair| falls(pair)).map(|pair| pair[1].0).collect();
    assert!(fell.iter().all(|t_us| (1_600_000..1_670_000).contains(t_us)), "{fell:?}");
    assert!(forces.last() >= Some(&(most / 10 * 9)), "nothing lets go at the end");
}

/// A gripper on a line of its own that shows no force but what it was asked for.
const OWN: BoardOptions = BoardOptions {
    actuator: Some(Actuator {
        force_max_n: 20.0,
        slew_n_s: 200.0,
        holds_n: 0.0,
        shows_force: true,
    }),
    ..STREAM
};

fn asked(force_n: f32) -> GripperReading {
    GripperReading { force: GripperForce::Asked { force_n, lag_s: 0.015 }, moving: false }
}

/// Rows for `ms` from row `from` on, and the state of the gripper before each turn; `None` is one that cannot be commanded.
fn hold(bench: &mut Bench, from: usize, ms: usize, reading: Option<f32>) {
    for row in 0..ms {
        if row % 5 == 0 {
            let mut text = String::new();
            (row..row + 8).for_each(|row| writeln!(text, "{}", ((from + row) % 7) as f32).unwrap());
            bench.board.push(text.as_bytes()).unwrap();
        }
        let now_us = bench.now_us;
        bench.board.set_gripper(now_us, reading.map(asked));
        bench.turn().unwrap();
        bench.turn().unwrap();
    }
}

#[test]
fn a_gripper_of_its_own_shows_its_force_in_the_rows_with_its_lag() {
    let mut bench = Bench::new(OWN);
    bench.board.push(b"vibration,rate=1600\n").unwrap();
    hold(&mut bench, 0, 500, Some(0.0));
    let layout = bench.session.link().ident().unwrap();
    assert_eq!(layout.channels().last().unwrap().kind, ChannelKind::NormalForce);
    assert!(bench.forces_n.iter().all(|force_n| *force_n <= 0.0), "nothing is between the fingers");
    bench.forces_n.clear();
    hold(&mut bench, 0, 100, Some(5.0));
    // 15 ms at 1600 Hz are 24 rows.
    assert!(bench.forces_n[12..36].iter().any(|force_n| (force_n / 5.0 - 0.632).abs() < 0.03));
    assert!((bench.forces_n.last().unwrap() - 5.0).abs() < 0.05);
}

#[test]
fn without_its_gripper_a_board_is_silent_and_its_rows_are_missing() {
    let mut bench = Bench::new(OWN);
    bench.board.push(b"vibration,rate=1600\n").unwrap();
    hold(&mut bench, 0, 400, Some(1.0));
    let (before, samples) = (bench.board.counters(), bench.samples.len());
    assert!(samples > 100);
    hold(&mut bench, 0, 100, None);
    let after = bench.board.counters();
    assert!(bench.samples.len() <= samples + 4 && after.rows <= before.rows + 4);
    assert!(after.missing >= before.missing + 100, "{after:?}");
}

#[test]
fn a_force_that_the_gripper_has_already_is_not_let_go() {
    let actuator = OWN.actuator.map(|actuator| Actuator { holds_n: 9.0, ..actuator });
    let mut bench = Bench::new(BoardOptions { actuator, ..OWN });
    bench.board.push(b"vibration,rate=1600\n").unwrap();
    hold(&mut bench, 0, 800, Some(9.0));
    let forces: Vec<i32> = bench.drives.iter().map(|(_, drive)| drive.force_mn()).collect();
    assert!(forces.len() > 1000 && bench.session.counters().commands > 0);
    assert!(forces.iter().all(|force_mn| *force_mn >= 8990), "{:?}", forces.iter().min());
    assert!(!bench.board.opens());
}

#[test]
fn what_others_have_opened_is_not_closed_without_a_client() {
    let actuator = OWN.actuator.map(|actuator| Actuator { holds_n: 9.0, ..actuator });
    let mut bench = Bench::new(BoardOptions { actuator, ..OWN });
    bench.board.push(b"vibration,rate=1600\n").unwrap();
    hold(&mut bench, 0, 400, Some(9.0));
    assert!(bench.drives.last().unwrap().1.force_mn() >= 8990);
    bench.drives.clear();
    let now_us = bench.now_us;
    bench.board.lose_object(now_us);
    hold(&mut bench, 0, 800, Some(0.0));
    assert!(bench.drives.len() > 1000);
    assert!(bench.drives.iter().all(|(_, drive)| *drive == Drive::Passive));
    assert!(!bench.board.opens());
}

#[test]
fn a_pause_is_at_most_as_long_as_a_row_waits() {
    let mut bench = Bench::new(STREAM);
    let longest = Duration::from_millis(2);
    assert_eq!(bench.board.pause(0, longest), longest);
    bench.board.push(vibration(0.0).as_bytes()).unwrap();
    while bench.reports.is_empty() {
        bench.turn().unwrap();
    }
    assert!(bench.board.pause(bench.now_us, longest) < Duration::from_millis(1));
}

proptest! {
    /// Whatever comes, in whatever pieces: no panic, and no more memory than there is room for.
    #[test]
    fn any_bytes_are_survived(
        packed in any::<bool>(),
        pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 0..40),
        datagrams in any::<bool>(),
    ) {
        let mut bench = Bench::new(BoardOptions { datagrams, ..STREAM });
        let header: &[u8] =
            if packed { b"force_n,stylus,rate=500,format=f32\n" } else { b"t_s,vibration,rate=500\n" };
        bench.board.push(header).unwrap();
        bench.board.push(if packed { &[0; 8] } else { b"0,1\n" }).unwrap();
        for piece in pieces {
            if datagrams {
                bench.board.push_datagram(&piece).unwrap();
            } else {
                bench.board.push(&piece).unwrap();
            }
            if bench.turn().is_err() {
                break;
            }
            prop_assert!(bench.board.room() <= 192 * 1024);
        }
    }
}

#[test]
fn a_text_stream_may_be_joined_in_its_middle() {
    let mut board = RowBoard::new(STREAM);
    board.push(b"t_s,vibration,rate=1600\n625,0.1,\n0.5,0.1\n0.500625,0.2\n").unwrap();
    board.turn(0).unwrap();
    assert_eq!((board.is_ready(), board.counters().bad), (true, 1));
    let reports = board.take_reports();
    assert!(reports[0].contains("row 1: 3 values") && reports[0].contains("joined in its middle"));
    for (rows, datagrams) in
        [("5,0.1,\n6,7,8\n", false), ("5,0.1,\n", false), ("5,0.1,\n1,2\n", true)]
    {
        let mut board = RowBoard::new(BoardOptions { actuator: None, datagrams });
        board.push(b"t_s,vibration,rate=1600\n").unwrap();
        board.push(rows.as_bytes()).unwrap();
        board.end().unwrap();
        let error = board.turn(0).unwrap_err().to_string();
        assert!(error.contains("row 1: 3 values"), "{rows}: {error}");
    }
}
