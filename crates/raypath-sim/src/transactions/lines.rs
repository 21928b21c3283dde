//! The lines of a transaction file, plain or gzip, one at a time and within bounds: gzip of a megabyte can unpack to a
//! gigabyte, and a line need not end.

use raypath_tools::plain_or_gzip;
use std::io::{BufRead, Error, ErrorKind, Read, Result};

/// What is read at most.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    /// Bytes of a line; the longest, of 64 lanes, has 2,400.
    line: u64,
    /// Bytes of all lines, unpacked.
    text: u64,
}

const BOUNDS: Bounds = Bounds { line: 64 << 10, text: 4 << 30 };

/// A stream, line by line.
pub struct Lines<'s> {
    stream: Box<dyn BufRead + 's>,
    line: Vec<u8>,
    bounds: Bounds,
    /// Bytes that may still come.
    left: u64,
}

impl<'s> Lines<'s> {
    /// Looks at the first bytes of a stream, which say whether it is gzip.
    pub fn new(stream: impl Read + 's) -> Result<Self> {
        Self::within(stream, BOUNDS)
    }

    fn within(stream: impl Read + 's, bounds: Bounds) -> Result<Self> {
        Ok(Self { stream: plain_or_gzip(stream)?, line: Vec::new(), bounds, left: bounds.text })
    }

    /// The next line without its end, or nothing behind the last.
    pub fn next(&mut self) -> Result<Option<&str>> {
        let Bounds { line: most_in_line, text: most } = self.bounds;
        self.line.clear();
        // One byte more than there may be tells what is too long from what just fits.
        let length = (&mut self.stream).take(most_in_line + 1).read_until(b'\n', &mut self.line)? as u64;
        let too_large = |what: String| Error::new(ErrorKind::FileTooLarge, what);
        if length > most_in_line {
            return Err(too_large(format!("more than {most_in_line} bytes in a line")));
        }
        self.left = self.left.checked_sub(length).ok_or_else(|| too_large(format!("more than {most} bytes in all")))?;
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
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).expect("compressed");
        encoder.finish().expect("compressed")
    }

    fn all(mut lines: Lines<'_>) -> Result<Vec<String>> {
        let mut found = Vec::new();
        while let Some(line) = lines.next()? {
            found.push(line.to_string());
        }
        Ok(found)
    }

    #[test]
    fn lines_as_the_standard_library_has_them() {
        for text in ["", "\n", "a", "a\n", "a\r\nb\n\n c", "\r", "a\r\r\n"] {
            let expected: Vec<String> = text.as_bytes().lines().collect::<Result<_>>().expect("text");
            for stream in [text.as_bytes().to_vec(), gzip(text.as_bytes())] {
                assert_eq!(all(Lines::new(stream.as_slice()).expect("a stream")).expect("lines"), expected, "{text:?}");
            }
        }
    }

    #[test]
    fn what_just_fits_is_read_and_one_byte_more_is_not() {
        let read = |text: &str, line, most| {
            let found = [text.as_bytes().to_vec(), gzip(text.as_bytes())].map(|stream| {
                let lines = Lines::within(stream.as_slice(), Bounds { line, text: most }).expect("a stream");
                all(lines).map(|lines| lines.len()).map_err(|error| error.to_string())
            });
            assert_eq!(found[0], found[1], "plain and gzip");
            found[0].clone()
        };
        assert_eq!(read("ab\nab\n", 3, 6), Ok(2));
        assert_eq!(read("ab\nab\n", 3, 5), Err("more than 5 bytes in all".to_string()));
        assert_eq!(read("ab\nabc\n", 3, 9), Err("more than 3 bytes in a line".to_string()));
        assert_eq!(read("ab\nabc", 3, 9), Ok(2));
    }

    /// 64 MiB of zeros in one line, and a line that never ends.
    #[test]
    fn bombs_are_errors() {
        let bomb = gzip(&vec![b'0'; 64 << 20]);
        assert!(bomb.len() < 1 << 20);
        let fails = |mut lines: Lines<'_>| lines.next().map(|line| line.is_some()).expect_err("a bomb").to_string();
        assert_eq!(fails(Lines::new(bomb.as_slice()).expect("a stream")), "more than 65536 bytes in a line");
        assert_eq!(fails(Lines::new(std::io::repeat(b'0')).expect("a stream")), "more than 65536 bytes in a line");
    }
}
