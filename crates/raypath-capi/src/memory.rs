//! Pointers of callers as references and slices.

use crate::status::{Failure, RAYPATH_ERROR_ALIGNMENT, RAYPATH_ERROR_NULL, RAYPATH_ERROR_OVERLAP};
use std::ffi::{CStr, c_char};
use std::ops::Range;
use std::slice;

/// The object at a pointer.
///
/// # Safety
/// If it is neither null nor misaligned, it points to a value that nothing changes during `'p`.
#[inline(always)]
pub unsafe fn reference<'p, T>(name: &str, pointer: *const T) -> Result<&'p T, Failure> {
    check(name, pointer)?;
    // SAFETY: by the contract of this function.
    Ok(unsafe { &*pointer })
}

/// The object at a pointer, to be changed.
///
/// # Safety
/// If it is neither null nor misaligned, it points to a value that nothing else reads or changes during `'p`.
#[inline(always)]
pub unsafe fn reference_mut<'p, T>(name: &str, pointer: *mut T) -> Result<&'p mut T, Failure> {
    check(name, pointer)?;
    // SAFETY: by the contract of this function.
    Ok(unsafe { &mut *pointer })
}

/// An array of `count` elements. An empty array may be NULL.
///
/// # Safety
/// If it is neither null nor misaligned, it points to `count` values that nothing changes during `'p`.
#[inline(always)]
pub unsafe fn array<'p, T>(name: &str, pointer: *const T, count: usize) -> Result<&'p [T], Failure> {
    check_array(name, pointer, count)?;
    // SAFETY: by the contract of this function; the size was checked.
    Ok(if count == 0 { &[] } else { unsafe { slice::from_raw_parts(pointer, count) } })
}

/// An array of `count` elements of results, whose values may be undefined.
///
/// # Safety
/// If it is neither null nor misaligned, it points to memory for `count` values of a type that has no invalid values.
/// Nothing else uses the memory during `'p`, except arrays that [`separate`] has compared with it.
#[inline(always)]
pub unsafe fn results<'p, T: Copy>(name: &str, pointer: *mut T, count: usize) -> Result<&'p mut [T], Failure> {
    check_array(name, pointer, count)?;
    // SAFETY: by the contract of this function; the size was checked.
    Ok(if count == 0 { &mut [] } else { unsafe { slice::from_raw_parts_mut(pointer, count) } })
}

/// Copies bytes to a caller, if they fit, and returns their number.
pub fn copied(from: &[u8], to: &mut [u8]) -> usize {
    if let Some(to) = to.get_mut(..from.len()) {
        to.copy_from_slice(from);
    }
    from.len()
}

/// Writes values to a caller, as many as fit, and returns their number.
pub fn written<T>(from: impl Iterator<Item = T>, to: &mut [T]) -> usize {
    let mut count = 0;
    from.for_each(|value| {
        if let Some(place) = to.get_mut(count) {
            *place = value;
        }
        count += 1;
    });
    count
}

/// Frees an object. NULL is ignored.
///
/// # Safety
/// The pointer is NULL, or came from `Box::into_raw` and nothing else uses the object.
pub unsafe fn free<T>(pointer: *mut T) {
    if !pointer.is_null() {
        // SAFETY: by the contract of this function.
        drop(unsafe { Box::from_raw(pointer) });
    }
}

/// An error if two arrays share a byte. Call it before references to them exist.
pub fn separate<T, U>(a: (&str, *const T, usize), b: (&str, *const U, usize)) -> Result<(), Failure> {
    let (bytes_of_a, bytes_of_b) = (bytes(a)?, bytes(b)?);
    if bytes_of_a.start < bytes_of_b.end && bytes_of_b.start < bytes_of_a.end {
        let problem = format!("{} and {} overlap, expected separate arrays", a.0, b.0);
        return Err(Failure::new(RAYPATH_ERROR_OVERLAP, problem));
    }
    Ok(())
}

/// A text, or `None` for NULL.
///
/// # Safety
/// The pointer is NULL, or points to a string with a terminating zero that nothing changes during `'p`.
pub unsafe fn text<'p>(name: &str, pointer: *const c_char) -> Result<Option<&'p str>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: by the contract of this function.
    let text = unsafe { CStr::from_ptr(pointer) }.to_str();
    text.map(Some).map_err(|problem| Failure::argument(format!("{name}: {problem}, expected UTF-8")))
}

/// A text that must be there.
///
/// # Safety
/// That of [`text`].
pub unsafe fn required_text<'p>(name: &str, pointer: *const c_char) -> Result<&'p str, Failure> {
    // SAFETY: by the contract of this function.
    unsafe { text(name, pointer) }?.ok_or_else(|| null(name))
}

#[inline(always)]
fn check<T>(name: &str, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(null(name));
    }
    if !pointer.is_aligned() {
        return Err(misaligned(name, pointer.addr(), align_of::<T>()));
    }
    Ok(())
}

#[inline(always)]
fn check_array<T>(name: &str, pointer: *const T, count: usize) -> Result<(), Failure> {
    bytes((name, pointer, count))?;
    if count == 0 { Ok(()) } else { check(name, pointer) }
}

/// The addresses of an array.
#[inline(always)]
fn bytes<T>((name, pointer, count): (&str, *const T, usize)) -> Result<Range<usize>, Failure> {
    let size = count.checked_mul(size_of::<T>()).filter(|&size| isize::try_from(size).is_ok());
    let end = size.and_then(|size| pointer.addr().checked_add(size));
    end.map(|end| pointer.addr()..end).ok_or_else(|| too_long(name, count))
}

// The messages are not inlined, so that the checks are short.

#[cold]
fn null(name: &str) -> Failure {
    Failure::new(RAYPATH_ERROR_NULL, format!("{name} is NULL, expected a pointer"))
}

#[cold]
fn misaligned(name: &str, address: usize, alignment: usize) -> Failure {
    let problem = format!("{name} is at {address:#x}, expected a multiple of {alignment} bytes");
    Failure::new(RAYPATH_ERROR_ALIGNMENT, problem)
}

#[cold]
fn too_long(name: &str, count: usize) -> Failure {
    Failure::argument(format!("{name}: {count} elements do not fit into memory"))
}
