//! What the machine says about its memory, its clocks and its name. Memory and name are known on Linux, clocks on macOS too;
//! elsewhere they are unknown.

use std::fs;
use std::path::Path;

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

#[cfg(any(target_os = "linux", target_vendor = "apple"))]
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

#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
fn clock(_: Clock) -> f64 {
    0.0
}

/// The name of this machine.
pub fn host_name() -> Option<String> {
    Some(fs::read_to_string("/proc/sys/kernel/hostname").ok()?.trim().to_string())
}

/// Memory that could be taken now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Available {
    /// How much, bytes.
    pub bytes: u64,
    /// What sets the limit, to be read after a number: "of free memory".
    pub of: &'static str,
    /// Whether other processes take of the same.
    pub shared: bool,
}

/// Memory that could be taken now without swapping: the least of what the system has left, of what the control groups this
/// process runs in have left, and of what the limits on its addresses leave.
pub fn available_memory() -> Option<Available> {
    available_to(1)
}

/// The same for each of so many processes like this one on this machine, which are about to share what it has.
pub(crate) fn available_to(processes: usize) -> Option<Available> {
    let number = |bytes: Option<u64>, of, shared| bytes.map(|bytes| Available { bytes, of, shared });
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let (status, groups) = (read("/proc/self/status"), read("/proc/self/cgroup"));
    let [addresses, data] = address_limits();
    let below = |limit: Option<u64>, used: &str| Some(limit?.saturating_sub(kilobytes(&status, used)?));
    let limits = [
        number(kilobytes(&read("/proc/meminfo"), "MemAvailable:"), "the memory that is free", true),
        number(
            control_groups(&groups, Path::new("/sys/fs/cgroup")),
            "what the control group of this process leaves",
            true,
        ),
        number(below(addresses, "VmSize:"), "what the limit on addresses (`ulimit -v`) leaves", false),
        number(below(data, "VmData:"), "what the limit on data (`ulimit -d`) leaves", false),
    ];
    let part = |available: Available| match available.shared {
        true => Available { bytes: available.bytes / processes.max(1) as u64, ..available },
        false => available,
    };
    limits.into_iter().flatten().map(part).min_by_key(|available| available.bytes)
}

/// `RLIMIT_AS` and `RLIMIT_DATA` where they are set, bytes.
#[cfg(target_os = "linux")]
fn address_limits() -> [Option<u64>; 2] {
    [libc::RLIMIT_AS, libc::RLIMIT_DATA].map(|which| {
        let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
        // SAFETY: the call writes one `rlimit`, which is ours.
        let known = unsafe { libc::getrlimit(which, &mut limit) } == 0;
        (known && limit.rlim_cur != libc::RLIM_INFINITY).then_some(limit.rlim_cur)
    })
}

#[cfg(not(target_os = "linux"))]
fn address_limits() -> [Option<u64>; 2] {
    [None, None]
}

/// What the limits of the control groups leave, bytes: those of version 2 and the memory controller of version 1, as
/// `/proc/self/cgroup` names them, below `root`.
fn control_groups(groups: &str, root: &Path) -> Option<u64> {
    let of_line = |line: &str| {
        let mut parts = line.splitn(3, ':');
        let (_, controllers, path) = (parts.next()?, parts.next()?, parts.next()?);
        let path = path.trim_start_matches('/');
        if controllers.is_empty() {
            least_left(root, path, ["memory.max", "memory.current"])
        } else if controllers.split(',').any(|name| name == "memory") {
            let names = ["memory.limit_in_bytes", "memory.usage_in_bytes"];
            least_left(&root.join("memory"), path, names)
        } else {
            None
        }
    };
    groups.lines().filter_map(of_line).min()
}

/// The least that the group `path` below `root` and every group above it leave.
fn least_left(root: &Path, path: &str, [limit, used]: [&str; 2]) -> Option<u64> {
    let left = |folder: &Path| {
        let number = |name: &str| fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
        // A group without a limit says "max", or a number beyond all memory.
        Some(number(limit)?.saturating_sub(number(used)?))
    };
    let folder = root.join(path);
    // In a container the path may be one of the host: its own groups then are those at the root.
    folder.ancestors().take_while(|folder| folder.starts_with(root)).filter_map(left).min()
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

    #[test]
    fn the_tightest_group_counts_in_both_versions() {
        let root = std::env::temp_dir().join(format!("stiction-groups-{}", std::process::id()));
        let write = |path: &str, text: &str| {
            fs::create_dir_all(root.join(path).parent().unwrap()).unwrap();
            fs::write(root.join(path), text).unwrap();
        };
        let with = |folder: &str, names: [&str; 2], limit: &str| {
            write(&format!("{folder}/{}", names[0]), limit);
            write(&format!("{folder}/{}", names[1]), "100\n");
        };
        let (second, first) = (["memory.max", "memory.current"], ["memory.limit_in_bytes", "memory.usage_in_bytes"]);
        with("a", second, "700\n");
        with("a/b", second, "max\n");
        with("memory/c", first, "9223372036854771712\n");
        with("memory/c/d", first, "50\n");
        // The group above is tighter; a limit below what is used leaves nothing.
        assert_eq!(control_groups("0::/a/b\n", &root), Some(600));
        assert_eq!(control_groups("3:cpu,memory:/c/d\n2:cpu:/a\n", &root), Some(0));
        assert_eq!(control_groups("0::/a/b\n3:memory:/c\n", &root), Some(600));
        // A path of the host, of which a container sees the end alone.
        with(".", second, "300\n");
        assert_eq!(control_groups("0::/host/x\n", &root), Some(200));
        assert_eq!(control_groups("nonsense\n", &root), None);
        fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn what_is_available_is_less_than_what_the_machine_has() {
        let all = kilobytes(&fs::read_to_string("/proc/meminfo").unwrap(), "MemTotal:").unwrap();
        let available = available_memory().unwrap();
        assert!(0 < available.bytes && available.bytes < all, "{available:?} of {all}");
    }
}
