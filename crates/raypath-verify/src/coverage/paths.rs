//! The ways that jobs take through the pipeline.

/// How a job entered the pipeline, and how it left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JobPath {
    /// Whether it was refused at least once before it was accepted.
    pub waited: bool,
    /// How it left.
    pub end: JobEnd,
}

/// How a job left the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobEnd {
    /// The sink took the outcome in its first cycle.
    Taken,
    /// The sink stalled the outcome at least once.
    Held,
    /// A reset discarded the job.
    Lost,
}

/// The names of all paths, in the order of [`JobPath::index`].
pub const PATHS: [&str; 6] = ["taken", "held", "lost", "waited, taken", "waited, held", "waited, lost"];

impl JobPath {
    /// Neither source nor sink stalled.
    pub const STRAIGHT: Self = Self { waited: false, end: JobEnd::Taken };

    /// The path's position in `PATHS`.
    pub fn index(self) -> usize {
        3 * usize::from(self.waited) + self.end as usize
    }
}
