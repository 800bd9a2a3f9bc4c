//! Check of the folder of recordings: its free space and how fast it takes them. A file of a few megabytes is written and removed.

use super::{super::clock, finding::Finding};
use core::time::Duration;
use rustix::fs::statvfs;
use std::{
    io::{self, Write as _},
    path::Path,
};

/// Size of the test file (bytes).
const TEST_BYTES: usize = 8 << 20;
/// Speed that a recording of every channel at 20 kHz needs (MB/s), with room for the rest.
const NEEDED_MB_S: f64 = 5.0;
/// Free space (MB) that is worth a warning, and that is a fault.
const SCARCE_MB: u64 = 2000;
const FULL_MB: u64 = 100;

pub(crate) fn findings(folder: &Path) -> Vec<Finding> {
    let mut findings = Vec::new();
    let shown = folder.display();
    match statvfs(folder) {
        Ok(stat) => {
            let free_mb = (stat.f_bavail.saturating_mul(stat.f_frsize)) / 1_000_000;
            findings.push(space(folder, free_mb));
        }
        Err(error) => {
            let text = format!("the folder of recordings {shown}: {error}");
            findings.push(Finding::fault("disk", text, format!("mkdir -p '{shown}'")));
            return findings;
        }
    }
    findings.push(match write_speed(folder) {
        Ok(speed) => {
            let text = format!("{shown} takes {speed:.0} MB/s");
            let remedy = "record to a faster disk, or record less (without --record)";
            Finding::judge(speed >= NEEDED_MB_S, "disk speed", text, remedy)
        }
        Err(error) => {
            let text = format!("recordings cannot be written to {shown}: {error}");
            let remedy = "record to a folder of your own, and name it here: --folder NAME";
            Finding::warning("disk speed", text, remedy.to_owned())
        }
    });
    findings
}

fn space(folder: &Path, free_mb: u64) -> Finding {
    let text = format!("{} has {:.1} GB free", folder.display(), free_mb as f64 / 1000.0);
    let remedy = "delete old recordings, or name another folder";
    if free_mb < FULL_MB {
        return Finding::fault("disk", text, remedy.to_owned());
    }
    Finding::judge(free_mb >= SCARCE_MB, "disk", text, remedy)
}

/// Megabytes a second that reach the disk itself.
fn write_speed(folder: &Path) -> io::Result<f64> {
    let mut file = tempfile::tempfile_in(folder)?;
    let block = vec![0x5A; 1 << 16];
    let start = clock::monotonic();
    for _ in 0..TEST_BYTES / block.len() {
        file.write_all(&block)?;
    }
    file.sync_data()?;
    let taken = clock::monotonic().saturating_sub(start).max(Duration::from_micros(1));
    let megabytes = TEST_BYTES as f64 / 1e6;
    Ok(megabytes / taken.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::{findings, space};
    use crate::commands::doctor::finding::Verdict;
    use std::{fs, path::Path};

    #[test]
    fn a_folder_is_measured_and_left_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let found = findings(folder.path());
        assert_eq!(found.len(), 2);
        assert!(found[1].text.contains("MB/s"), "{}", found[1]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let absent = findings(&folder.path().join("none"));
        assert!(absent.len() == 1 && absent[0].verdict == Verdict::Fault);
        // Nobody writes there, root neither; a folder of somebody else is not given away.
        let foreign = findings(Path::new("/proc"));
        let remedy = foreign[1].remedy.as_ref().unwrap();
        assert!(remedy.contains("--folder") && !remedy.contains("sudo"), "{remedy}");
    }

    #[test]
    fn space_runs_out() {
        let verdict = |mb| space(Path::new("x"), mb).verdict;
        assert_eq!(
            [verdict(50), verdict(500), verdict(5000)],
            [Verdict::Fault, Verdict::Warning, Verdict::Ok]
        );
    }
}
