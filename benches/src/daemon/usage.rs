//! A process in; the processor time of each of its threads and its resident memory, as Linux reports them, out.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
};

/// What a process has used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Processor time of each thread by its name (ns); threads of one name are added up.
    pub threads: BTreeMap<String, u64>,
    /// Memory that is in use and not in a file that was mapped (kB): RssAnon.
    pub anonymous_kb: u64,
    /// Memory in use (kB): RssAnon, RssFile and RssShmem.
    pub resident_kb: u64,
    /// Times its threads have waited by themselves: wake-ups.
    pub waits: u64,
}

impl Usage {
    /// Usage of the process `id` as of now.
    ///
    /// # Errors
    /// Where the process is gone or the system has no `/proc`.
    pub fn of(id: u32) -> io::Result<Self> {
        let process = PathBuf::from(format!("/proc/{id}"));
        let status = fs::read_to_string(process.join("status"))?;
        let mut usage = Self {
            anonymous_kb: number(&status, "RssAnon:"),
            resident_kb: number(&status, "VmRSS:"),
            ..Self::default()
        };
        for task in fs::read_dir(process.join("task"))? {
            // A thread may end while it is looked at.
            let Ok((name, ns, waits)) = thread(&task?.path()) else { continue };
            *usage.threads.entry(name).or_default() += ns;
            usage.waits += waits;
        }
        Ok(usage)
    }

    /// Processor time of all threads (ns).
    #[must_use]
    pub fn total_ns(&self) -> u64 {
        self.threads.values().sum()
    }

    /// What each thread has used since `earlier` (ns).
    #[must_use]
    pub fn since(&self, earlier: &Self) -> BTreeMap<String, u64> {
        let before = |name: &String| earlier.threads.get(name).copied().unwrap_or(0);
        self.threads
            .iter()
            .map(|(name, ns)| (name.clone(), ns.saturating_sub(before(name))))
            .collect()
    }
}

/// Name, processor time (ns) and waits of a thread.
fn thread(task: &Path) -> io::Result<(String, u64, u64)> {
    let name = fs::read_to_string(task.join("comm"))?.trim().to_owned();
    let times = fs::read_to_string(task.join("schedstat"))?;
    let status = fs::read_to_string(task.join("status"))?;
    let ns = times.split_whitespace().next().and_then(|ns| ns.parse().ok());
    let ns = ns.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "no schedstat"))?;
    Ok((name, ns, number(&status, "voluntary_ctxt_switches:")))
}

/// The number behind `name` at the start of a line; 0 where there is none.
fn number(text: &str, name: &str) -> u64 {
    text.lines()
        .find_map(|line| line.strip_prefix(name)?.split_whitespace().next()?.parse().ok())
        .unwrap_or(0)
}
