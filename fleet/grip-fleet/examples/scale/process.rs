//! A part of this program in; a process of it, what it reports and what it costs out.

use super::Args;
use anyhow::Context as _;
use std::io::{BufRead as _, BufReader, Lines};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::{env, fs};

/// A process that ends when this one lets go of it.
pub(crate) struct Process {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Process {
    /// Starts this program as a part of itself and waits until it is ready.
    pub(crate) fn start(part: &[&str], args: &Args) -> anyhow::Result<Self> {
        let mut command = Command::new(env::current_exe()?);
        command.args(["--seconds", &args.seconds.to_string()]);
        if let Some(folder) = &args.quic {
            command.arg("--quic").arg(folder);
        }
        command.args(part).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().context("cannot start a part of this program")?;
        let out = child.stdout.take().context("no output")?;
        let mut process = Self { child, lines: BufReader::new(out).lines() };
        let first = process.line()?;
        anyhow::ensure!(first == "ready", "a part of this program says {first:?}");
        Ok(process)
    }

    /// The next line that it reports.
    pub(crate) fn line(&mut self) -> anyhow::Result<String> {
        self.lines.next().context("a part of this program has ended early")?.context("no line")
    }

    /// Processor time so far (s): clock ticks of 10 ms, as Linux reports them to everybody.
    pub(crate) fn processor_s(&self) -> anyhow::Result<f64> {
        processor_s(&self.child.id().to_string())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // One that has ended cannot be killed.
        let _ended = self.child.kill();
        let _ended = self.child.wait();
    }
}

/// Processor time of a process (s), user and system.
pub(crate) fn processor_s(process: &str) -> anyhow::Result<f64> {
    let path = format!("/proc/{process}/stat");
    let text = fs::read_to_string(&path).with_context(|| path.clone())?;
    let (_, after_name) = text.rsplit_once(')').with_context(|| path.clone())?;
    let ticks = after_name.split_whitespace().skip(11).take(2).map(str::parse::<u32>);
    let ticks = ticks.sum::<Result<u32, _>>().context(path)?;
    Ok(f64::from(ticks) / 100.0)
}

/// Bytes that have passed the loopback interface.
pub(crate) fn loopback_bytes() -> anyhow::Result<u64> {
    let text = fs::read_to_string("/proc/net/dev").context("/proc/net/dev")?;
    let line = text.lines().find_map(|line| line.trim_start().strip_prefix("lo:"));
    let bytes = line.and_then(|line| line.split_whitespace().nth(8)).context("no interface lo")?;
    Ok(bytes.parse()?)
}
