//! The arbiter of a cluster: the timing of `raypath_arbiter`.

/// Grants the first of up to 64 requests after the one that was taken last. A grant stays until it is taken, as long as
/// its request does.
#[derive(Debug, Clone, Copy, Default)]
pub struct Arbiter {
    after: u64,
    held: u64,
}

impl Arbiter {
    /// The request that is granted, as the only bit; 0 if there is none.
    #[inline]
    pub fn grant(&self, requests: u64) -> u64 {
        let (held, later) = (requests & self.held, requests & self.after);
        let from = if later != 0 { later } else { requests };
        if held != 0 { held } else { from & from.wrapping_neg() }
    }

    /// The clock edge: whether the grant is taken.
    #[inline]
    pub fn edge(&mut self, grant: u64, is_taken: bool) {
        if is_taken && grant != 0 {
            self.after = !(grant | grant.wrapping_sub(1));
        }
        self.held = if is_taken { 0 } else { grant };
    }
}
