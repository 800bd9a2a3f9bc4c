//! Lines of what a host is asked in, what this crate's host does out, in the words of the Python peer.

use crate::host_words::{event_words, state_words};
use crate::targets::gripper::CONFIG;
use crate::targets::words::{hex, unhex};
use grip_link::frame::MAX_WIRE;
use grip_link::host::{GripCommand, HostConfig, HostLink};
use grip_link::message::{Config, FaultCode, GripMode, Heartbeat};

fn host() -> HostLink {
    HostLink::new(HostConfig::new(CONFIG)).unwrap()
}

fn config(words: &[&str]) -> Config {
    let mut bytes = CONFIG.to_bytes();
    let fields: Vec<i64> = words.iter().map(|word| word.parse().unwrap()).collect();
    let mut put = |at: usize, len: usize, field: usize| {
        bytes[at..at + len].copy_from_slice(&fields[field].to_le_bytes()[..len]);
    };
    // Values that CONFIG may not hold cannot be read back: they are set below.
    put(4, 1, 1);
    put(5, 1, 2);
    put(6, 2, 3);
    put(8, 4, 4);
    put(16, 4, 6);
    put(24, 2, 8);
    put(26, 1, 9);
    let whole = Config::parse(&bytes).unwrap();
    Config {
        sample_rate_hz: u32::try_from(fields[0]).unwrap(),
        force_max_mn: i32::try_from(fields[5]).unwrap(),
        hold_cap_mn: i32::try_from(fields[7]).unwrap(),
        ..whole
    }
}

fn grip(words: &[&str]) -> GripCommand {
    GripCommand {
        mode: match words[0] {
            "1" => GripMode::Force,
            "2" => GripMode::Open,
            "3" => GripMode::Passive,
            other => panic!("no such mode: {other}"),
        },
        answers_slip: words[1] == "1",
        ttl_ms: words[2].parse().unwrap(),
        force_mn: words[3].parse().unwrap(),
        slew_mn_s: words[4].parse().unwrap(),
        cause_sample: words[5].parse().unwrap(),
    }
}

/// All that a script makes a host say: the answers to each line, and how it stands afterwards.
pub(crate) fn play(lines: &[String]) -> Vec<String> {
    let mut player = Player { host: host(), said: Vec::new() };
    for line in lines {
        let words: Vec<&str> = line.trim_end().split(' ').collect();
        player.obey(words[0], words[1].parse().unwrap(), &words[2..]);
        player.said.push(state_words(&player.host));
    }
    player.said
}

struct Player {
    host: HostLink,
    said: Vec<String>,
}

impl Player {
    fn obey(&mut self, command: &str, now_us: u64, words: &[&str]) {
        let mut out = [0; MAX_WIRE];
        match command {
            "new" => self.host = host(),
            "open" => {
                let session = u16::from_str_radix(words[0], 16).unwrap();
                if self.host.open(now_us, session).is_err() {
                    self.said.push("refused".to_owned());
                }
            }
            "close" => self.host.close(),
            "rx" => {
                let bytes = unhex(words.first().unwrap_or(&""));
                let mut input = &bytes[..];
                while let Some(event) = self.host.receive(now_us, &mut input) {
                    let words = event_words(&self.host, &event);
                    self.said.push(words);
                }
            }
            "tx" => {
                while let Some(len) = self.host.poll_transmit(now_us, &mut out) {
                    self.said.push(format!("frame {}", hex(&out[..len])));
                }
            }
            "grip" => {
                let len = self.host.grip(now_us, &grip(words), &mut out);
                self.wrote(len, &out);
            }
            "beat" => {
                let [turns, longest_us] = [0, 1].map(|at| words[at].parse().unwrap());
                let [late, flags] = [2, 3].map(|at| words[at].parse().unwrap());
                let beat = Heartbeat { turns, longest_us, late, flags };
                let len = self.host.heartbeat(&beat, &mut out);
                self.wrote(len, &out);
            }
            "estop" => {
                let len = self.host.estop(&mut out);
                self.wrote(len, &out);
            }
            "config" => {
                if self.host.reconfigure(now_us, config(words)).is_err() {
                    self.said.push("refused".to_owned());
                }
            }
            "start" => self.host.start(now_us),
            "stop" => self.host.stop(now_us),
            "clear" => {
                let fault = u16::from_str_radix(words[0], 16).unwrap();
                self.host.clear_fault(now_us, FaultCode(fault));
            }
            other => panic!("no such command: {other}"),
        }
    }

    fn wrote(&mut self, len: Option<usize>, out: &[u8]) {
        self.said.push(len.map_or("none".to_owned(), |len| format!("frame {}", hex(&out[..len]))));
    }
}
