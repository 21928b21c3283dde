//! Reports: the recorder, the Konata log, and the page in a browser.

mod browser;
mod chromium;
mod common;
mod konata;
mod recorder;
