//! Reports: the recorder, the Konata log, and the page in a browser.

mod browser;
mod common;
mod konata;
mod recorder;
