//! Reports of a run: an HTML page with a timeline of the pipeline, and a log for the pipeline viewer Konata.
//!
//! A [`Recorder`] observes a simulation and records the positions of jobs. A [`Recording`] has these together with
//! counts, configuration and pictures; [`html`] and [`konata`] convert it.

mod heat;
mod html;
mod konata;
mod recorder;
mod recording;
mod timeline;

/// The number of colours for operations: `--op0` and so on in `page.css`.
const COLOURS: usize = 8;

pub use html::html;
pub use konata::konata;
pub use recorder::Recorder;
pub use recording::{Image, JobTrace, Recording, Span, StageUse, Table, UnitUse, Window};
