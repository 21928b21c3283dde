//! Bytes from outside, within a bound: what is larger, or unpacks to more, is an error and not a full memory.

use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result};
use std::path::Path;

/// Reads a file of at most `most` bytes, plain or gzip; of gzip it is the unpacked bytes that count.
///
/// # Errors
/// It cannot be read, its gzip is damaged, or it is larger.
pub fn read_within(path: &Path, most: u64) -> Result<Vec<u8>> {
    unpacked(File::open(path)?, most)
}

/// The same of a stream.
pub(crate) fn unpacked(stream: impl Read, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // One byte more than there may be tells what is too large from what just fits.
    plain_or_gzip(stream)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let problem = format!("more than {most} bytes (of gzip when unpacked), expected at most that");
        return Err(Error::new(ErrorKind::FileTooLarge, problem));
    }
    Ok(bytes)
}

/// The same as text.
pub(crate) fn text(stream: impl Read, most: u64) -> Result<String> {
    let no_text = |_| Error::new(ErrorKind::InvalidData, "stream did not contain valid UTF-8");
    String::from_utf8(unpacked(stream, most)?).map_err(no_text)
}

/// A stream as it is, or unpacked: its first bytes say whether it is gzip. All parts of joined gzip count.
///
/// # Errors
/// Those first bytes cannot be read.
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
    fn what_just_fits_is_read_and_one_byte_more_is_not() {
        let bytes = vec![7; 1000];
        for stream in [bytes.clone(), gzip(&bytes)] {
            assert_eq!(unpacked(stream.as_slice(), 1000).expect("read"), bytes);
            let error = unpacked(stream.as_slice(), 999).expect_err("too large");
            assert_eq!(error.kind(), ErrorKind::FileTooLarge);
            assert!(error.to_string().starts_with("more than 999 bytes"), "{error}");
        }
    }

    /// gzip files can be joined; all parts count, for the content and for the bound.
    #[test]
    fn joined_gzip_is_read_to_its_end() {
        let joined = [gzip(b"one "), gzip(b"two")].concat();
        assert_eq!(unpacked(joined.as_slice(), 7).expect("read"), b"one two");
        assert!(unpacked(joined.as_slice(), 6).is_err());
    }

    /// 64 MiB of zeros in 64 KiB or so: unpacked no further than the bound.
    #[test]
    fn a_gzip_bomb_is_an_error() {
        let bomb = gzip(&vec![0; 64 << 20]);
        assert!(bomb.len() < 1 << 20);
        assert_eq!(unpacked(bomb.as_slice(), 1 << 20).expect_err("a bomb").kind(), ErrorKind::FileTooLarge);
    }

    #[test]
    fn endless_files_end() {
        if let Ok(zeros) = File::open("/dev/zero") {
            assert_eq!(unpacked(zeros, 1 << 20).expect_err("endless").kind(), ErrorKind::FileTooLarge);
        }
    }
}
