//! Judge of the bytes that a gripper gets: the commands among them that no daemon may ever send.
//!
//! The rules look at one thing only: what reached the gripper, in its order. Times are those of the gripper's own samples (a command names
//! the sample that caused it), so a busy machine breaks none of them.

use grip_link::{
    decoder::{Decoder, Role, Verdict},
    message::{Config, Grip, GripMode, Kind},
};

/// What a first command may lie above the force that the gripper already has (mN): noise of its force sensor (200), and what the closing
/// fingers gain (20 N/s) over the rows of one read, where the daemon had to wait before it could answer the first of them (40 ms).
const TAKE_OVER_MN: i32 = 1_000;
/// Rounding of a set point to whole millinewtons, twice.
const ROUNDING_MN: i64 = 2;
/// Violations that are kept word for word.
const KEPT: usize = 4;

/// What the gripper knows as bytes arrive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Present {
    /// Its settings, once it has some.
    pub(crate) config: Option<Config>,
    /// The force its drive is given (mN).
    pub(crate) drive_mn: i32,
    /// Number of the row after the newest that was sent.
    pub(crate) rows: u32,
}

/// The limits of the configuration that gripd runs with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Largest force (mN).
    pub(crate) force_max_mn: i32,
    /// Fastest rise (mN/s).
    pub(crate) slew_mn_s: u32,
}

/// Counts commands, and what is wrong with them.
#[derive(Debug)]
pub(crate) struct Judge {
    limits: Limits,
    decoder: Decoder,
    last: Option<Grip>,
    /// A stranger must be asked who it is, and nothing else.
    stranger: bool,
    /// A client asked for a release: the fingers may be opened, and must then stay open.
    may_open: bool,
    opened: bool,
    /// A client asked for a grasp, and no force has come since.
    closes: bool,
    /// GRIP frames.
    pub(crate) commands: u64,
    /// Sessions that were opened.
    pub(crate) sessions: u64,
    /// CONFIG frames.
    pub(crate) configs: u64,
    /// Oldest sample that a rise of the force was ever based on (rows behind the newest).
    pub(crate) oldest_rise_rows: u32,
    /// What broke a rule.
    pub(crate) broken: u64,
    /// The first of these, word for word.
    pub(crate) violations: Vec<String>,
}

impl Judge {
    /// A judge of the daemon's right gripper, or of a `stranger` that must be left alone.
    pub(crate) fn new(limits: Limits, stranger: bool) -> Self {
        Self {
            limits,
            decoder: Decoder::new(Role::Device),
            last: None,
            stranger,
            may_open: false,
            opened: false,
            closes: false,
            commands: 0,
            sessions: 0,
            configs: 0,
            oldest_rise_rows: 0,
            broken: 0,
            violations: Vec::new(),
        }
    }

    /// A client asks for a release from now on.
    pub(crate) fn allow_open(&mut self) {
        self.may_open = true;
    }

    /// A client asks for a grasp from now on; what still arrives from before may open, until the first force.
    pub(crate) fn allow_close(&mut self) {
        (self.closes, self.opened) = (true, false);
    }

    /// Whether the fingers were commanded to open since [`Judge::allow_open`].
    pub(crate) fn has_opened(&self) -> bool {
        self.opened
    }

    /// The gripper has restarted: what still arrives of the old session is refused by it, and is no command.
    pub(crate) fn restarted(&mut self) {
        self.decoder.close_session();
        self.last = None;
    }

    /// Something that must not be.
    pub(crate) fn violation(&mut self, text: String) {
        self.broken += 1;
        if self.violations.len() < KEPT {
            self.violations.push(text);
        }
    }

    /// Panics where a rule was broken.
    #[track_caller]
    pub(crate) fn must_be_kept(&self) {
        assert!(self.broken == 0, "{} rules broken: {:#?}", self.broken, self.violations);
    }

    /// Listens to what the gripper is about to get.
    pub(crate) fn receive(&mut self, mut bytes: &[u8], present: &Present) {
        loop {
            let (header, grip) = match self.decoder.next(&mut bytes) {
                None => return,
                Some(Verdict::Bad(_)) => continue,
                Some(Verdict::Frame(frame)) if frame.header.kind == Kind::GRIP => {
                    (frame.header, Grip::parse(frame.payload).ok())
                }
                Some(Verdict::Frame(frame)) => (frame.header, None),
            };
            match header.kind {
                Kind::HELLO => {
                    self.decoder.open_session(header.session, Some(header.seq));
                    self.last = None;
                    self.sessions += 1;
                }
                Kind::CONFIG | Kind::START if self.stranger => {
                    self.violation(format!("{:?} to a stranger", header.kind));
                }
                Kind::CONFIG => {
                    self.configs += 1;
                    self.last = None;
                }
                Kind::GRIP => self.command(grip, present),
                _ => {}
            }
        }
    }

    fn command(&mut self, grip: Option<Grip>, present: &Present) {
        self.commands += 1;
        let Some(grip) = grip else { return self.violation("a GRIP that is too short".to_owned()) };
        let reported = self.within_limits(&grip).and_then(|()| self.mode(&grip));
        let reported = reported.and_then(|()| self.rise(&grip, present));
        if let Err(what) = reported {
            let Grip { cmd_id, mode, force_mn, slew_mn_s, cause_sample, .. } = grip;
            let last = self.last.map(|last| (last.mode, last.force_mn, last.cause_sample));
            let Present { drive_mn, rows, .. } = present;
            self.violation(format!(
                "{what}: command {cmd_id}, mode {mode}, {force_mn} mN, {slew_mn_s} mN/s, caused by row {cause_sample} of {rows}; \
                 before it {last:?}; the drive is at {drive_mn} mN"
            ));
        }
        self.last = Some(grip);
    }

    fn within_limits(&self, grip: &Grip) -> Result<(), &'static str> {
        if self.stranger {
            return Err("a force for a stranger");
        }
        if !(0..=self.limits.force_max_mn).contains(&grip.force_mn) {
            return Err("a force beyond the limit");
        }
        if grip.slew_mn_s > self.limits.slew_mn_s {
            return Err("a slew beyond the limit");
        }
        if grip.ttl_ms != 0 && !(Config::TTL_MIN_MS..=Config::TTL_MAX_MS).contains(&grip.ttl_ms) {
            return Err("a life beyond the limit");
        }
        Ok(())
    }

    fn mode(&mut self, grip: &Grip) -> Result<(), &'static str> {
        match GripMode::from_code(grip.mode) {
            Some(GripMode::Open) if self.may_open => {
                self.opened = !self.closes;
                Ok(())
            }
            Some(GripMode::Force) if !self.opened => {
                self.may_open &= !self.closes;
                self.closes = false;
                Ok(())
            }
            Some(GripMode::Force) => Err("a force after a release"),
            Some(GripMode::Open) => Err("opened, and nobody asked for it"),
            _ => Err("a mode that gripd has no use for"),
        }
    }

    /// Never faster than the slew over the samples in between, never without a new sample, and not beyond what the gripper has at the start.
    fn rise(&mut self, grip: &Grip, present: &Present) -> Result<(), &'static str> {
        let Some(config) = present.config else { return Err("a command before CONFIG") };
        let age = present.rows.wrapping_sub(grip.cause_sample);
        if age == 0 || age > u32::MAX / 2 {
            return Err("caused by a sample that was never taken");
        }
        let Some(last) = self.last else {
            let most_mn = present.drive_mn + TAKE_OVER_MN;
            return if grip.force_mn <= most_mn { Ok(()) } else { Err("a leap at the start") };
        };
        let rise_mn = i64::from(grip.force_mn) - i64::from(last.force_mn);
        if rise_mn <= 0 || grip.mode != last.mode {
            return Ok(());
        }
        let rows = grip.cause_sample.wrapping_sub(last.cause_sample);
        if rows == 0 {
            return Err("raised without a new sample");
        }
        self.oldest_rise_rows = self.oldest_rise_rows.max(age);
        let most_mn = i64::from(rows) * i64::from(self.limits.slew_mn_s)
            / i64::from(config.sample_rate_hz.max(1));
        if rise_mn > most_mn + ROUNDING_MN { Err("raised faster than the slew") } else { Ok(()) }
    }
}

mod tests {
    use super::{Judge, Limits, Present};
    use grip_link::{
        frame::{Direction, Header, MAX_WIRE, encode},
        message::{Config, Grip, Kind, LossAction, SampleFormat},
    };

    const LIMITS: Limits = Limits { force_max_mn: 30_000, slew_mn_s: 1_000_000 };
    const PRESENT: Present = Present {
        config: Some(Config {
            sample_rate_hz: 10_000,
            batch: 10,
            format: SampleFormat::F32,
            ttl_ms: 50,
            channel_mask: 1,
            force_max_mn: 30_000,
            slew_mn_s: 1_000_000,
            hold_cap_mn: 30_000,
            loss_after_ms: 1000,
            loss_action: LossAction::Hold,
        }),
        drive_mn: 2_000,
        rows: 5_000,
    };

    /// What `judge` finds of commands (mode, mN, cause).
    fn verdict(mut judge: Judge, commands: &[(u8, i32, u32)]) -> String {
        let mut hear = |kind, seq, payload: &[u8]| {
            let mut out = [0; MAX_WIRE];
            let header = Header::new(Direction::ToDevice, kind, seq, 7);
            let len = encode(&header, payload, &mut out).unwrap();
            judge.receive(&out[..len], &PRESENT);
        };
        hear(Kind::HELLO, 0, &[1, 1]);
        for (seq, &(mode, force_mn, cause_sample)) in (1..).zip(commands) {
            let cmd_id = u32::from(seq);
            let grip =
                Grip { cmd_id, mode, flags: 0, ttl_ms: 0, force_mn, slew_mn_s: 0, cause_sample };
            let mut payload = [0; Grip::SIZE];
            grip.write(&mut payload).unwrap();
            hear(Kind::GRIP, seq, &payload);
        }
        assert_eq!((judge.commands, judge.sessions), (commands.len() as u64, 1));
        judge.violations.join("\n")
    }

    #[test]
    fn what_is_not_allowed_is_reported_and_nothing_else() {
        let usual = || Judge::new(LIMITS, false);
        let opens = || {
            let mut judge = usual();
            judge.allow_open();
            judge
        };
        let reported = [
            (verdict(usual(), &[(1, 2_100, 10), (1, 3_100, 20), (1, 1_000, 20)]), ""),
            (verdict(opens(), &[(1, 2_000, 10), (2, 0, 20), (2, 0, 30)]), ""),
            (verdict(usual(), &[(1, 3_100, 10)]), "a leap at the start"),
            (verdict(usual(), &[(1, 30_001, 10)]), "beyond the limit"),
            (verdict(usual(), &[(1, -1, 10)]), "beyond the limit"),
            (verdict(usual(), &[(1, 2_000, 10), (1, 3_010, 20)]), "faster than the slew"),
            (verdict(usual(), &[(1, 2_000, 10), (1, 2_001, 10)]), "without a new sample"),
            (verdict(usual(), &[(1, 2_000, 5_001)]), "never taken"),
            (verdict(usual(), &[(2, 0, 10)]), "nobody asked"),
            (verdict(usual(), &[(3, 0, 10)]), "no use for"),
            (verdict(opens(), &[(2, 0, 10), (1, 100, 20)]), "a force after a release"),
            (verdict(Judge::new(LIMITS, true), &[(1, 0, 10)]), "for a stranger"),
        ];
        for (stated, wanted) in reported {
            assert!(stated.contains(wanted) && stated.is_empty() == wanted.is_empty(), "{stated}");
        }
    }
}
