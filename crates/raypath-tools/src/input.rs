//! Reads files up to a size limit, plain or gzip, so that a large file or a gzip bomb is an error and does not fill the
//! memory.

use crate::ToolError;
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result};
use std::path::Path;

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
    fn endless_files_are_refused() {
        if let Ok(zeros) = File::open("/dev/zero") {
            assert_eq!(unpacked(zeros, 1 << 20).expect_err("endless").kind(), ErrorKind::FileTooLarge);
        }
    }
}
