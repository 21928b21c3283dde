//! Readers of vectors and of true neighbours. They take the path of a file, whose extension selects the format.

use crate::meshes::LIMIT;
use raypath_search::{Dataset, Vectors, read_neighbours, read_vectors, write_fvecs};
use std::io::Write;
use tempfile::{Builder, TempPath};

/// The base of neighbours.
const BASE: usize = 100;

pub fn fvecs(bytes: &[u8]) -> bool {
    vectors("fvecs", bytes) | vectors("bvecs", bytes)
}

pub fn ivecs(bytes: &[u8]) -> bool {
    vectors("ivecs", bytes) | neighbours("ivecs", bytes)
}

pub fn npy(bytes: &[u8]) -> bool {
    vectors("npy", bytes) | neighbours("npy", bytes)
}

pub fn hdf5(bytes: &[u8]) -> bool {
    let Some(file) = file("hdf5", bytes) else { return false };
    let whole = Dataset::read(&file, None, None, LIMIT);
    let own_base = read_vectors(&file, LIMIT);
    if let (Ok(dataset), Ok(base)) = (&whole, &own_base) {
        assert_eq!((&dataset.base, dataset.base.dimensions()), (base, dataset.queries.dimensions()));
    }
    own_base.is_ok_and(|base| is_written_alike(&base)) | neighbours("hdf5", bytes)
}

fn vectors(extension: &str, bytes: &[u8]) -> bool {
    let Some(file) = file(extension, bytes) else { return false };
    read_vectors(&file, LIMIT).is_ok_and(|vectors| is_written_alike(&vectors))
}

/// Vectors are the same after they were written.
fn is_written_alike(vectors: &Vectors) -> bool {
    let mut bytes = Vec::new();
    // Writing to memory cannot fail.
    let _ = write_fvecs(vectors, &mut bytes);
    if let Some(again) = file("fvecs", &bytes) {
        assert_eq!(read_vectors(&again, LIMIT).as_ref(), Ok(vectors));
    }
    true
}

fn neighbours(extension: &str, bytes: &[u8]) -> bool {
    let Some(file) = file(extension, bytes) else { return false };
    let Ok(neighbours) = read_neighbours(&file, BASE, LIMIT) else { return false };
    let rows: Vec<&[u32]> = neighbours.rows().collect();
    assert_eq!(rows.len(), neighbours.queries());
    let is_valid = |row: &&[u32]| row.len() == neighbours.count() && row.iter().all(|&index| (index as usize) < BASE);
    assert!(rows.iter().all(is_valid));
    true
}

/// A file with this content, which is deleted when the path goes out of scope. None if it cannot be written.
fn file(extension: &str, bytes: &[u8]) -> Option<TempPath> {
    let mut file = Builder::new().suffix(&format!(".{extension}")).tempfile().ok()?;
    // Truncating the new file, as `std::fs::write` does, would make ext4 wait for the disk.
    file.write_all(bytes).ok()?;
    Some(file.into_temp_path())
}
