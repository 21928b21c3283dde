//! `.npy`: an array of two axes, vectors along the first, in either order and of any numeric type.

use super::{FileError, check};
use npyz::{DType, Deserialize, NpyFile, NpyHeader, Order, TypeChar};
use raypath_tools::MemoryLimit;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// Reads the dimension and all coordinates.
pub(super) fn vectors(file: &Path, limit: MemoryLimit) -> Result<(usize, Vec<f32>), FileError> {
    let array = Array::open(file, limit)?;
    let coordinates = match array.kind {
        (TypeChar::Float, 2) => array.read(half::f16::to_f32),
        (TypeChar::Float, 4) => array.read(|x: f32| x),
        (TypeChar::Float, 8) => array.read(|x: f64| x as f32),
        _ => return array.integers(|x| x as f32, "floats of 2, 4 or 8 bytes, or integers of 1, 2, 4 or 8"),
    };
    coordinates.map_err(FileError::of(file))
}

/// Reads the number of neighbours per query, and all indices. An index that exceeds `i64` becomes −1.
pub(super) fn indices(file: &Path, limit: MemoryLimit) -> Result<(usize, Vec<i64>), FileError> {
    Array::open(file, limit)?.integers(|x| x.try_into().unwrap_or(-1), "integers of 1, 2, 4 or 8 bytes")
}

/// An array with a validated header.
struct Array<'f> {
    file: &'f Path,
    npy: NpyFile<BufReader<File>>,
    kind: (TypeChar, u64),
    rows: usize,
    columns: usize,
}

impl<'f> Array<'f> {
    /// Reads the header and checks it against the length of the file and the limit.
    fn open(file: &'f Path, limit: MemoryLimit) -> Result<Self, FileError> {
        let io = FileError::of(file);
        let mut source = BufReader::new(File::open(file).map_err(&io)?);
        let length = source.get_ref().metadata().map_err(&io)?.len();

        let bytes = header_bytes(file, &mut source)?;
        let header = NpyHeader::from_reader(bytes.as_slice())
            .map_err(|error| FileError::content(file, "header", format_args!("`{error}`"), "a NumPy header"))?;
        let &[rows, columns] = header.shape() else {
            let found = format!("shape {:?}", header.shape());
            return Err(FileError::content(file, "header", found, "two axes: vectors, coordinates"));
        };
        let dtype = header.dtype();
        let (kind, size) = match &dtype {
            DType::Plain(plain) => ((plain.type_char(), plain.size_field()), plain.num_bytes()),
            _ => ((TypeChar::RawData, 0), None),
        };
        let data = length - bytes.len() as u64;
        let claimed = |size: usize| rows.checked_mul(columns)?.checked_mul(size as u64);
        if size.is_some_and(|size| claimed(size) != Some(data)) {
            let expected = format!("{rows} x {columns} of type {}", dtype.descr());
            return Err(FileError::content(file, "data", format_args!("{data} bytes"), expected));
        }
        check(file, rows, columns, limit)?;
        let fits = |size: u64| usize::try_from(size).unwrap_or(usize::MAX);
        Ok(Self { file, npy: NpyFile::with_header(header, source), kind, rows: fits(rows), columns: fits(columns) })
    }

    /// Reads the number of columns, and all numbers row by row.
    fn read<T: Deserialize, U: Copy>(self, convert: impl Fn(T) -> U) -> io::Result<(usize, Vec<U>)> {
        let (rows, columns, order) = (self.rows, self.columns, self.npy.order());
        let numbers = self.npy.data::<T>().map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
        let mut data = Vec::with_capacity(rows * columns);
        for number in numbers {
            data.push(convert(number?));
        }
        if order == Order::Fortran {
            data = (0..rows).flat_map(|row| data.iter().skip(row).step_by(rows).copied()).collect();
        }
        Ok((columns, data))
    }

    /// As [`read`](Self::read), for integers of any type; an error that names the `expected` types for others.
    fn integers<U: Copy>(self, convert: fn(i128) -> U, expected: &str) -> Result<(usize, Vec<U>), FileError> {
        let file = self.file;
        let integers = match self.kind {
            (TypeChar::Int, 1) => self.read(|x: i8| convert(x.into())),
            (TypeChar::Int, 2) => self.read(|x: i16| convert(x.into())),
            (TypeChar::Int, 4) => self.read(|x: i32| convert(x.into())),
            (TypeChar::Int, 8) => self.read(|x: i64| convert(x.into())),
            (TypeChar::Uint, 1) => self.read(|x: u8| convert(x.into())),
            (TypeChar::Uint, 2) => self.read(|x: u16| convert(x.into())),
            (TypeChar::Uint, 4) => self.read(|x: u32| convert(x.into())),
            (TypeChar::Uint, 8) => self.read(|x: u64| convert(x.into())),
            _ => {
                let found = format!("type {}", self.npy.dtype().descr());
                return Err(FileError::content(file, "header", found, expected));
            }
        };
        integers.map_err(FileError::of(file))
    }
}

/// The maximum length of a header in bytes, as in NumPy.
const MAX_HEADER: usize = 10_000;

/// Reads magic number, version, length and text of a header, and checks that it is safe to parse: short, without deep
/// nesting, and without sizes whose product overflows.
fn header_bytes(file: &Path, source: &mut impl Read) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    let mut take = |count: usize, bytes: &mut Vec<u8>| {
        let read = source.take(count as u64).read_to_end(bytes).map_err(FileError::of(file))?;
        let found = format!("the end of the file after {} bytes", bytes.len());
        if read < count { Err(FileError::content(file, "header", found, "a NumPy header")) } else { Ok(()) }
    };
    take(10, &mut bytes)?;
    if !bytes.starts_with(b"\x93NUMPY") {
        let found = String::from_utf8_lossy(&bytes[..6]).into_owned();
        return Err(FileError::content(
            file,
            "first bytes",
            format_args!("{found:?}"),
            "the magic number of an .npy file",
        ));
    }
    let length = if bytes[6] == 1 {
        usize::from(u16::from_le_bytes([bytes[8], bytes[9]]))
    } else {
        take(2, &mut bytes)?;
        u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize
    };
    if length > MAX_HEADER {
        return Err(FileError::content(file, "header", format_args!("{length} bytes"), "10000 at most"));
    }
    let start = bytes.len();
    take(length, &mut bytes)?;
    let text = String::from_utf8_lossy(&bytes[start..]).into_owned();
    if !is_safe(&text) {
        let found = format!("`{}`", text.trim_end().chars().take(200).collect::<String>());
        return Err(FileError::content(file, "header", found, "sizes of 64 bits together, and little nesting"));
    }
    Ok(bytes)
}

fn is_safe(text: &str) -> bool {
    let depth = text.chars().filter(|c| "([{".contains(*c)).count();
    let other_base = text.as_bytes().windows(2).any(|pair| pair[0].is_ascii_digit() && b"xXoObB_".contains(&pair[1]));
    let mut numbers = text.split(|c: char| !c.is_ascii_digit()).filter(|digits| !digits.is_empty());
    let product = numbers.try_fold(1u64, |product, digits| product.checked_mul(digits.parse::<u64>().ok()?.max(1)));
    depth <= 16 && !other_base && product.is_some()
}
