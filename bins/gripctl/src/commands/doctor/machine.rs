//! Check of what this computer grants to a real-time thread. What can be tried is tried, on a thread that ends at once.

use super::{System, finding::Finding};
use grip_daemon::realtime::{Measure, Outcome, RealtimeConfig, RealtimeMode, enter};
use std::{collections::BTreeSet, fs, thread};

pub(crate) fn findings(system: &System) -> Vec<Finding> {
    let mut findings = rights();
    findings.push(kernel(system));
    findings.push(governor(system));
    findings
}

/// What this user is granted; the unit of the package brings its own limits.
fn rights() -> Vec<Finding> {
    let config = RealtimeConfig { mode: RealtimeMode::Warn, ..RealtimeConfig::default() };
    let granted = thread::scope(|threads| threads.spawn(|| enter(&config)).join());
    let Ok(granted) = granted else {
        let remedy = "gripd --realtime warn".to_owned();
        return vec![Finding::fault("real time", "the try has failed".to_owned(), remedy)];
    };
    let reported = granted
        .attempts()
        .iter()
        .filter(|attempt| matches!(attempt.measure, Measure::LockedMemory | Measure::Priority));
    reported
        .map(|attempt| match attempt.outcome {
            Outcome::Refused(error) => Finding::warning(
                "real time",
                format!(
                    "{} is refused to this user ({error}); the unit of the package has it",
                    attempt.measure.name()
                ),
                attempt.measure.remedy().to_owned(),
            ),
            Outcome::Granted | Outcome::NotAsked => {
                Finding::ok("real time", format!("{} is granted", attempt.measure.name()))
            }
        })
        .collect()
}

fn kernel(system: &System) -> Finding {
    let version = fs::read_to_string(system.at("proc/version")).unwrap_or_default();
    let real_time = fs::read_to_string(system.at("sys/kernel/realtime"))
        .is_ok_and(|flag| flag.trim() == "1")
        || version.contains("PREEMPT_RT");
    let release = version.split_whitespace().nth(2).unwrap_or("unknown");
    let kind = if real_time {
        "real-time"
    } else if version.contains("PREEMPT") {
        "preemptible"
    } else {
        "not preemptible"
    };
    let text = format!("kernel {release}, {kind}");
    let remedy = "boot with preempt=full, or install a real-time kernel (linux-image-rt-amd64)";
    Finding::judge(kind != "not preemptible", "kernel", text, remedy)
}

fn governor(system: &System) -> Finding {
    let check = "processors";
    let folders = fs::read_dir(system.at("sys/devices/system/cpu")).into_iter().flatten().flatten();
    let governors: BTreeSet<String> = folders
        .filter_map(|folder| {
            fs::read_to_string(folder.path().join("cpufreq/scaling_governor")).ok()
        })
        .map(|name| name.trim().to_owned())
        .collect();
    if governors.is_empty() {
        return Finding::ok(check, "their frequency is not scaled by this system".to_owned());
    }
    let names: Vec<&str> = governors.iter().map(String::as_str).collect();
    let text = format!("frequency governor {}", names.join(", "));
    let remedy =
        "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
    Finding::judge(names == ["performance"], check, text, remedy)
}

#[cfg(test)]
mod tests {
    use super::{governor, kernel, rights};
    use crate::commands::doctor::{System, finding::Verdict};
    use std::fs;

    #[test]
    fn a_slow_machine_is_reported_what_helps() {
        let folder = tempfile::tempdir().unwrap();
        let system = System { root: folder.path().to_owned(), ..System::default() };
        let put = |file: &str, text: &str| {
            let file = folder.path().join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        };
        let cases = [
            ("Linux version 6.1.0-18-amd64 (x) #1 SMP Debian", Verdict::Warning, "not preemptible"),
            ("Linux version 6.1.0 (x) #1 SMP PREEMPT_DYNAMIC", Verdict::Ok, "preemptible"),
            ("Linux version 6.1.0-rt (x) #1 SMP PREEMPT_RT", Verdict::Ok, "real-time"),
        ];
        for (version, verdict, word) in cases {
            put("proc/version", version);
            let found = kernel(&system);
            assert!(found.verdict == verdict && found.text.contains(word), "{found}");
        }
        assert_eq!(governor(&system).verdict, Verdict::Ok);
        put("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
        assert_eq!(governor(&system).verdict, Verdict::Ok);
        put("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
        let found = governor(&system);
        assert_eq!(found.verdict, Verdict::Warning);
        assert!(found.remedy.unwrap().contains("scaling_governor"));
    }

    #[test]
    fn rights_are_tried_and_reported() {
        let found = rights();
        assert_eq!(found.len(), 2);
        for finding in found {
            assert_eq!(finding.verdict == Verdict::Ok, finding.remedy.is_none(), "{finding}");
        }
    }
}
