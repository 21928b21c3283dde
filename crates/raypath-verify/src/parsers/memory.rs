//! The process's peak memory.

/// The peak resident memory of this process in bytes, if the system reports it (Linux: `VmHWM`).
pub fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(target_os = "linux")]
    fn a_large_allocation_shows() {
        let before = super::peak().expect("a number");
        let large = vec![1_u8; 300 << 20];
        let after = super::peak().expect("a number");
        assert!(
            large.iter().step_by(4096).all(|&byte| byte == 1) && after >= before + (200 << 20),
            "{before}, {after}"
        );
    }
}
