//! How much memory a program may take here: of the machine, and of the group that a container or a job of a cluster is.

use std::fs;
use std::path::Path;

/// Bytes that are free; nothing where the system does not say, as elsewhere than on Linux.
pub fn available() -> Option<u64> {
    let machine = of_machine(&fs::read_to_string("/proc/meminfo").ok()?)?;
    let group = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = group.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or_default();
    let groups =
        Path::new(group).ancestors().filter_map(|group| of_group(&Path::new("/sys/fs/cgroup").join(group)));
    Some(groups.fold(machine, u64::min))
}

fn of_machine(text: &str) -> Option<u64> {
    let kilobytes = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(1024 * kilobytes.trim().trim_end_matches(" kB").parse::<u64>().ok()?)
}

/// What a group may still take; nothing where it has no limit.
fn of_group(group: &Path) -> Option<u64> {
    let number = |file: &str| fs::read_to_string(group.join(file)).ok()?.trim().parse::<u64>().ok();
    Some(number("memory.max")?.saturating_sub(number("memory.current")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_free_is_read_from_the_systems_words() {
        let text =
            "MemTotal:       24689020 kB\nMemFree:  1 kB\nMemAvailable:   20480000 kB\nBuffers: 3 kB\n";
        assert_eq!(of_machine(text), Some(20_480_000 * 1024));
        assert_eq!(of_machine("MemTotal: 1 kB"), None);
        let group = std::env::temp_dir().join(format!("efam-group-{}", std::process::id()));
        fs::create_dir_all(&group).unwrap();
        fs::write(group.join("memory.max"), "max\n").unwrap();
        fs::write(group.join("memory.current"), "300\n").unwrap();
        assert_eq!(of_group(&group), None);
        fs::write(group.join("memory.max"), "1000\n").unwrap();
        assert_eq!(of_group(&group), Some(700));
        fs::remove_dir_all(&group).unwrap();
    }
}
