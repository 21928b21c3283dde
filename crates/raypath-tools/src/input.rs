//! Reads files up to a size limit, plain or gzip, so that a large file or a gzip bomb is an error and does not fill the
//! memory.

use crate::ToolError;
use flate2::read::MultiGzDecoder;
use std::fmt::{self, Display};
use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result};
use std::path::Path;
use std::str::FromStr;

/// The memory that a file may take: its bytes, and what is made of them. Readers check it before they take memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryLimit(u64);

impl MemoryLimit {
    /// 2 GiB.
    pub const DEFAULT: Self = Self(2 << 30);

    const UNITS: [(&'static str, u64); 4] = [("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10), ("", 1)];

    /// A limit of this many bytes.
    pub const fn of(bytes: u64) -> Self {
        Self(bytes)
    }

    /// Checks `count` things, named `what`, that take `each` bytes.
    ///
    /// # Errors
    /// They take more than the limit.
    pub fn check(self, count: u64, what: impl Display, each: u64) -> std::result::Result<(), String> {
        self.check_bytes(format_args!("{count} {what}"), u128::from(count) * u128::from(each))
    }

    /// Checks that `what` takes no more bytes than the limit.
    ///
    /// # Errors
    /// It takes more.
    pub fn check_bytes(self, what: impl Display, bytes: u128) -> std::result::Result<(), String> {
        if bytes <= self.0.into() {
            return Ok(());
        }
        Err(format!(
            "{what} take {bytes} bytes of memory, expected at most {self} (a greater --max-memory allows more)"
        ))
    }

    /// Reads a file whose bytes are within the limit.
    ///
    /// # Errors
    /// It cannot be read, or is larger.
    pub fn read(self, path: &Path) -> Result<Vec<u8>> {
        let file = File::open(path)?;
        let check =
            |bytes| self.check(bytes, "bytes", 1).map_err(|problem| Error::new(ErrorKind::FileTooLarge, problem));
        check(file.metadata()?.len())?;
        let mut bytes = Vec::new();
        // What is no file has no length.
        file.take(self.0.saturating_add(1)).read_to_end(&mut bytes)?;
        check(bytes.len() as u64)?;
        Ok(bytes)
    }
}

impl Default for MemoryLimit {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Display for MemoryLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fits = |unit: &&(&str, u64)| self.0 >= unit.1 && self.0.is_multiple_of(unit.1);
        let (name, bytes) = Self::UNITS.iter().find(fits).unwrap_or(&("", 1));
        write!(f, "{}{name}", self.0 / bytes)
    }
}

impl FromStr for MemoryLimit {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let read = |(name, bytes): (&str, u64)| text.strip_suffix(name)?.parse::<u64>().ok()?.checked_mul(bytes);
        let bytes = Self::UNITS.into_iter().find_map(read);
        bytes
            .map(Self)
            .ok_or_else(|| "expected a number of bytes below 2^64, or one with KiB, MiB or GiB, like 8GiB".to_string())
    }
}

/// Reads a file of at most `max` bytes, plain or gzip; of gzip, the unpacked bytes count.
///
/// # Errors
/// It cannot be read, its gzip is damaged, or it is larger.
pub fn read_within(path: &Path, max: u64) -> std::result::Result<Vec<u8>, ToolError> {
    File::open(path).and_then(|file| unpacked(file, max)).map_err(|problem| ToolError::file(path, "read", problem))
}

/// Reads a stream of at most `max` bytes, plain or gzip.
pub(crate) fn unpacked(stream: impl Read, max: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // One byte more than allowed, to detect a longer stream.
    plain_or_gzip(stream)?.take(max.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max {
        let problem = format!("more than {max} bytes (of gzip when unpacked), expected at most that");
        return Err(Error::new(ErrorKind::FileTooLarge, problem));
    }
    Ok(bytes)
}

/// Reads text of at most `max` bytes, plain or gzip.
///
/// # Errors
/// It cannot be read, its gzip is damaged, it is larger, or it is not UTF-8.
pub fn text(stream: impl Read, max: u64) -> Result<String> {
    let no_text = |_| Error::new(ErrorKind::InvalidData, "stream did not contain valid UTF-8");
    String::from_utf8(unpacked(stream, max)?).map_err(no_text)
}

/// Decompresses a stream that begins as gzip does, and passes any other through. Joined gzip files are read to the end.
///
/// # Errors
/// The first bytes cannot be read.
pub fn plain_or_gzip<'s>(stream: impl Read + 's) -> Result<Box<dyn BufRead + 's>> {
    let mut stream = BufReader::new(stream);
    let is_gzip = stream.fill_buf()?.starts_with(&[0x1f, 0x8b]);
    Ok(if is_gzip { Box::new(BufReader::new(MultiGzDecoder::new(stream))) } else { Box::new(stream) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).expect("compressed");
        encoder.finish().expect("compressed")
    }

    #[test]
    fn one_byte_more_than_the_limit_is_refused() {
        let bytes = vec![7; 1000];
        for stream in [bytes.clone(), gzip(&bytes)] {
            assert_eq!(unpacked(stream.as_slice(), 1000).expect("read"), bytes);
            let error = unpacked(stream.as_slice(), 999).expect_err("too large");
            assert_eq!(error.kind(), ErrorKind::FileTooLarge);
            assert!(error.to_string().starts_with("more than 999 bytes"), "{error}");
        }
    }

    /// gzip files can be joined; all parts count, for the content and for the limit.
    #[test]
    fn joined_gzip_is_read_to_its_end() {
        let joined = [gzip(b"one "), gzip(b"two")].concat();
        assert_eq!(unpacked(joined.as_slice(), 7).expect("read"), b"one two");
        assert!(unpacked(joined.as_slice(), 6).is_err());
    }

    /// 64 MiB of zeros in about 64 KiB: unpacked no further than the limit.
    #[test]
    fn a_gzip_bomb_is_an_error() {
        let bomb = gzip(&vec![0; 64 << 20]);
        assert!(bomb.len() < 1 << 20);
        assert_eq!(unpacked(bomb.as_slice(), 1 << 20).expect_err("a bomb").kind(), ErrorKind::FileTooLarge);
    }

    #[test]
    fn limits_are_written_as_they_are_read() {
        for (text, bytes) in [("2GiB", 2 << 30), ("3MiB", 3 << 20), ("1025", 1025), ("7KiB", 7 << 10), ("0", 0)] {
            assert_eq!(text.parse(), Ok(MemoryLimit(bytes)));
            assert_eq!(MemoryLimit(bytes).to_string(), text);
        }
        for text in ["", "GiB", "1.5GiB", "-1", "2 GiB", "99999999999GiB", "2GB"] {
            assert!(text.parse::<MemoryLimit>().is_err(), "{text}");
        }
        assert_eq!(MemoryLimit(12).check(3, "items", 4), Ok(()));
        let problem = MemoryLimit(11).check(3, "items", 4).expect_err("too many");
        assert!(problem.starts_with("3 items take 12 bytes of memory, expected at most 11 ("), "{problem}");
        assert!(MemoryLimit::DEFAULT.check(u64::MAX, "items", 4).is_err());
    }

    #[test]
    fn endless_files_are_refused() {
        if let Ok(zeros) = File::open("/dev/zero") {
            let problem = MemoryLimit(1 << 20).read(Path::new("/dev/zero")).expect_err("endless");
            assert!(problem.to_string().starts_with("1048577 bytes"), "{problem}");
            assert_eq!(unpacked(zeros, 1 << 20).expect_err("endless").kind(), ErrorKind::FileTooLarge);
        }
    }
}
