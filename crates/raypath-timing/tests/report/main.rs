//! The report of a run: what the recorder writes down, the log, and the page in a browser.

mod browser;
mod common;
mod konata;
mod recorder;
