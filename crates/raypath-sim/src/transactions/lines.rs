//! The lines of a transaction file, plain or gzip, within bounds. A line may lack an end, and a megabyte of gzip can
//! unpack to a gigabyte.

use raypath_tools::plain_or_gzip;
use std::io::{BufRead, Error, ErrorKind, Read, Result};

/// The maximum sizes in bytes.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    /// One line. Lines for 64 lanes, the longest, have 2,400.
    line: u64,
    /// All lines, unpacked.
    text: u64,
}

const BOUNDS: Bounds = Bounds { line: 64 << 10, text: 4 << 30 };

/// Reads a stream line by line.
pub struct Lines<'s> {
    stream: Box<dyn BufRead + 's>,
    line: Vec<u8>,
    bounds: Bounds,
    /// The number of bytes that may still be read.
    left: u64,
}

impl<'s> Lines<'s> {
    /// Starts to read a stream. Its first bytes determine whether it is gzip.
    pub fn new(stream: impl Read + 's) -> Result<Self> {
        Self::within(stream, BOUNDS)
    }

    fn within(stream: impl Read + 's, bounds: Bounds) -> Result<Self> {
        Ok(Self { stream: plain_or_gzip(stream)?, line: Vec::new(), bounds, left: bounds.text })
    }

    /// The next line without its end; `None` after the last.
    pub fn next(&mut self) -> Result<Option<&str>> {
        let Bounds { line: max_line, text: max } = self.bounds;
        self.line.clear();
        // One byte more than allowed, to detect a longer line.
        let length = (&mut self.stream).take(max_line + 1).read_until(b'\n', &mut self.line)? as u64;
        let too_large = |what: String| Error::new(ErrorKind::FileTooLarge, what);
        if length > max_line {
            return Err(too_large(format!("more than {max_line} bytes in a line")));
        }
        self.left = self.left.checked_sub(length).ok_or_else(|| too_large(format!("more than {max} bytes in all")))?;
        if length == 0 {
            return Ok(None);
        }
        let text = std::str::from_utf8(&self.line);
        let text = text.map_err(|_| Error::new(ErrorKind::InvalidData, "stream did not contain valid UTF-8"))?;
        let text = text.strip_suffix('\n').map_or(text, |line| line.strip_suffix('\r').unwrap_or(line));
        Ok(Some(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, bufread::GzEncoder};

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut compressed = Vec::new();
        GzEncoder::new(bytes, Compression::fast()).read_to_end(&mut compressed).expect("gzip");
        compressed
    }

    fn all(mut lines: Lines<'_>) -> Result<Vec<String>> {
        let mut found = Vec::new();
        while let Some(line) = lines.next()? {
            found.push(line.to_string());
        }
        Ok(found)
    }

    #[test]
    fn lines_equal_those_of_the_standard_library() {
        for text in ["", "\n", "a", "a\n", "a\r\nb\n\n c", "\r", "a\r\r\n"] {
            let expected: Vec<String> = text.as_bytes().lines().collect::<Result<_>>().expect("text");
            for stream in [text.as_bytes().to_vec(), gzip(text.as_bytes())] {
                assert_eq!(all(Lines::new(stream.as_slice()).expect("a stream")).expect("lines"), expected, "{text:?}");
            }
        }
    }

    #[test]
    fn one_byte_more_than_a_bound_is_an_error() {
        let read = |text: &str, line, all_lines| {
            let [plain, unpacked] = [text.as_bytes().to_vec(), gzip(text.as_bytes())].map(|stream| {
                let lines = Lines::within(stream.as_slice(), Bounds { line, text: all_lines }).expect("a stream");
                all(lines).map(|lines| lines.len()).map_err(|error| error.to_string())
            });
            assert_eq!(plain, unpacked);
            plain
        };
        assert_eq!(read("ab\nab\n", 3, 6), Ok(2));
        assert_eq!(read("ab\nab\n", 3, 5), Err("more than 5 bytes in all".to_string()));
        assert_eq!(read("ab\nabc\n", 3, 9), Err("more than 3 bytes in a line".to_string()));
        assert_eq!(read("ab\nabc", 3, 9), Ok(2));
    }

    /// A line of 64 MiB in a small gzip file, and a line without an end.
    #[test]
    fn bombs_are_errors() {
        let bomb = gzip(&vec![b'0'; 64 << 20]);
        assert!(bomb.len() < 1 << 20);
        let fails = |mut lines: Lines<'_>| lines.next().map(|line| line.is_some()).expect_err("a bomb").to_string();
        assert_eq!(fails(Lines::new(bomb.as_slice()).expect("a stream")), "more than 65536 bytes in a line");
        assert_eq!(fails(Lines::new(std::io::repeat(b'0')).expect("a stream")), "more than 65536 bytes in a line");
    }
}
