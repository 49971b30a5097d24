//! What the machine says about its memory, its clocks and its name; Linux only, unknown elsewhere.

use std::fs;

/// Largest resident memory of this process so far, bytes.
pub fn peak_memory() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Processor time of all threads of this process so far, seconds; zero where the system does not tell it.
pub fn cpu_seconds() -> f64 {
    clock(Clock::Process)
}

/// The same of this thread alone.
pub fn thread_cpu_seconds() -> f64 {
    clock(Clock::Thread)
}

enum Clock {
    Process,
    Thread,
}

#[cfg(target_os = "linux")]
fn clock(clock: Clock) -> f64 {
    let id = match clock {
        Clock::Process => libc::CLOCK_PROCESS_CPUTIME_ID,
        Clock::Thread => libc::CLOCK_THREAD_CPUTIME_ID,
    };
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the clock writes one `timespec`, which is ours.
    match unsafe { libc::clock_gettime(id, &mut time) } {
        0 => time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64,
        _ => 0.0,
    }
}

#[cfg(not(target_os = "linux"))]
fn clock(_: Clock) -> f64 {
    0.0
}

/// The name of this machine.
pub fn host_name() -> Option<String> {
    Some(fs::read_to_string("/proc/sys/kernel/hostname").ok()?.trim().to_string())
}

/// Memory that could be taken now without swapping, bytes: what the system has left, or what the control group this
/// process runs in has left, if that is less.
pub fn available_memory() -> Option<u64> {
    let system = kilobytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    Some(control_group().map_or(system, |group| group.min(system)))
}

/// What the limit of the control group (version 2) leaves, bytes.
fn control_group() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let path = groups.lines().find_map(|line| line.strip_prefix("0::"))?;
    // Every group above this one may set a limit of its own.
    let mut folder = std::path::PathBuf::from(format!("/sys/fs/cgroup{path}"));
    let mut least = None;
    loop {
        let number = |name: &str| fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
        if let (Some(max), Some(used)) = (number("memory.max"), number("memory.current")) {
            let left = max.saturating_sub(used);
            least = Some(least.map_or(left, |other: u64| other.min(left)));
        }
        if !folder.starts_with("/sys/fs/cgroup/") || !folder.pop() {
            return least;
        }
    }
}

/// The number of kilobytes behind `name`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    Some(1024 * line.split_ascii_whitespace().next()?.parse::<u64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kilobytes_become_bytes_and_nonsense_nothing() {
        assert_eq!(kilobytes("VmPeak:\t 9 kB\nVmHWM:\t    2048 kB\n", "VmHWM:"), Some(2_097_152));
        assert_eq!(kilobytes("VmHWM: many kB", "VmHWM:"), None);
        assert_eq!(kilobytes("", "VmHWM:"), None);
    }
}
