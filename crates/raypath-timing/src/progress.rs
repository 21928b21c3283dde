use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A callback for progress and cancellation. It is called at intervals with the number of completed items, such as
/// agents, rays or queries; the work stops when it returns false.
pub type Progress<'p> = &'p (dyn Fn(u64) -> bool + Sync);

/// The progress of work that several threads share.
pub struct ProgressCounter<'p> {
    progress: Progress<'p>,
    completed: AtomicU64,
    stopped: AtomicBool,
}

impl<'p> ProgressCounter<'p> {
    /// A counter at 0 that reports to `progress`.
    pub fn new(progress: Progress<'p>) -> Self {
        Self { progress, completed: AtomicU64::new(0), stopped: AtomicBool::new(false) }
    }

    /// Reports `items` more completed items. Returns whether to continue.
    pub fn add(&self, items: u64) -> bool {
        let completed = self.completed.fetch_add(items, Ordering::Relaxed) + items;
        if !(self.progress)(completed) {
            self.stopped.store(true, Ordering::Relaxed);
        }
        !self.is_stopped()
    }

    /// Whether the callback has stopped the work.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}
