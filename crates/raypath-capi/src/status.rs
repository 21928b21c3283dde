//! Status codes and messages.

use raypath_embed::Error;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::LazyLock;

/// The result of a call: 0 success, above 0 success of another kind, below 0 an error.
pub type Status = i32;

/// Success; `raypath_pipeline_offer`: the job is accepted; `raypath_pipeline_step`: a result left.
pub const RAYPATH_OK: Status = 0;
/// `raypath_pipeline_offer`: the job is not accepted in this cycle.
pub const RAYPATH_BUSY: Status = 1;
/// `raypath_pipeline_step`: no result left in this cycle.
pub const RAYPATH_NO_RESULT: Status = 2;
/// A pointer is NULL.
pub const RAYPATH_ERROR_NULL: Status = -1;
/// An argument has a value that is not allowed.
pub const RAYPATH_ERROR_ARGUMENT: Status = -2;
/// A configuration is not valid, or cannot be elaborated.
pub const RAYPATH_ERROR_CONFIGURATION: Status = -3;
/// The datapath does not have the operation.
pub const RAYPATH_ERROR_OPERATION: Status = -4;
/// A pointer is not aligned to its type.
pub const RAYPATH_ERROR_ALIGNMENT: Status = -5;
/// An array of results overlaps another array of the call.
pub const RAYPATH_ERROR_OVERLAP: Status = -6;
/// A file cannot be written.
pub const RAYPATH_ERROR_IO: Status = -7;
/// A defect of raypath. The objects of the call must not be used again.
pub const RAYPATH_ERROR_INTERNAL: Status = -8;

/// The version of the binary interface. It changes when a program that was compiled against an older header would not
/// work.
pub const RAYPATH_ABI_VERSION: u32 = 1;

/// Why a call failed: a status and a message. Boxed, so that results fit into registers.
pub(crate) struct Failure(Box<(Status, String)>);

impl Failure {
    #[cold]
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self(Box::new((status, message.into())))
    }

    pub fn argument(message: impl Into<String>) -> Self {
        Self::new(RAYPATH_ERROR_ARGUMENT, message)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match &error {
            Error::Configuration(_) | Error::Elaboration(_) | Error::Unit(_) => RAYPATH_ERROR_CONFIGURATION,
            Error::Operation { .. } => RAYPATH_ERROR_OPERATION,
            Error::Argument(_) => RAYPATH_ERROR_ARGUMENT,
            Error::File(_) => RAYPATH_ERROR_IO,
        };
        Self::new(status, error.to_string())
    }
}

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::default();
}

/// The version of the binary interface of this library. A program compares it with `RAYPATH_ABI_VERSION`. Any thread
/// may call it.
#[unsafe(no_mangle)]
pub extern "C" fn raypath_abi_version() -> u32 {
    RAYPATH_ABI_VERSION
}

/// The commit of raypath from which the library was built, 40 hexadecimal digits; empty if it is not known. Any thread
/// may call it.
#[unsafe(no_mangle)]
pub extern "C" fn raypath_commit() -> *const c_char {
    static COMMIT: LazyLock<CString> =
        LazyLock::new(|| CString::new(option_env!("RAYPATH_COMMIT").unwrap_or_default()).unwrap_or_default());
    COMMIT.as_ptr()
}

/// The version of raypath, for example "0.1.0". Any thread may call it.
#[unsafe(no_mangle)]
pub extern "C" fn raypath_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

/// The message of the last call of this thread that failed: what was found, and what was expected. Empty if none
/// failed. It is valid until another call of this thread fails. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn raypath_last_error() -> *const c_char {
    MESSAGE.with_borrow(|message| message.as_ptr())
}

/// The status of `call`. Errors and panics leave their message.
#[inline(always)]
pub(crate) fn status(call: impl FnOnce() -> Result<Status, Failure>) -> Status {
    // The closure returns a number: a `Result` would be read in other pieces than it was written in, which stalls the
    // processor.
    catch_unwind(AssertUnwindSafe(|| call().unwrap_or_else(failed))).unwrap_or_else(|panic| panicked(&*panic))
}

/// The value of `call`, or 0 after an error.
pub(crate) fn value_or_zero<T: Default>(call: impl FnOnce() -> Result<T, Failure>) -> T {
    let mut value = T::default();
    status(|| {
        value = call()?;
        Ok(RAYPATH_OK)
    });
    value
}

/// The address of the value of `call`, or NULL after an error.
pub(crate) fn address_or_null<T>(call: impl FnOnce() -> Result<*const T, Failure>) -> *const T {
    let mut address = std::ptr::null();
    status(|| {
        address = call()?;
        Ok(RAYPATH_OK)
    });
    address
}

#[cold]
fn failed(failure: Failure) -> Status {
    let (status, message) = *failure.0;
    keep(&message);
    status
}

#[cold]
fn panicked(panic: &(dyn Any + Send)) -> Status {
    keep(&format!("internal error: {}", text(panic)));
    RAYPATH_ERROR_INTERNAL
}

fn keep(message: &str) {
    let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
    MESSAGE.set(message);
}

fn text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without a message")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message() -> String {
        // SAFETY: the message of this thread is a string, and no call fails while it is read.
        unsafe { CStr::from_ptr(raypath_last_error()) }.to_string_lossy().into_owned()
    }

    #[test]
    fn a_panic_becomes_a_status_and_a_message() {
        assert_eq!(status(|| panic!("in stage {}", 3)), RAYPATH_ERROR_INTERNAL);
        assert_eq!(message(), "internal error: in stage 3");
        assert_eq!(value_or_zero::<u32>(|| Err(Failure::argument("no\0nul"))), 0);
        assert_eq!(message(), "no nul");
    }
}
