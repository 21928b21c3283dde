//! Pictures of the pipeline at work. A [`Recorder`] looks on and writes down where jobs are; a [`Recording`] has that and
//! whatever else there is to say of a run; [`html`] makes a page of it, and [`konata`] a log for a pipeline viewer.

mod heat;
mod html;
mod konata;
mod recorder;
mod recording;
mod timeline;

/// So many operations have a colour of their own: `--op0` and so on in `page.css`.
const COLOURS: usize = 8;

pub use html::html;
pub use konata::konata;
pub use recorder::Recorder;
pub use recording::{Image, JobTrace, Recording, Span, StageUse, Table, UnitUse, Window};
