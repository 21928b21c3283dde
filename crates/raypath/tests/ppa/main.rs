//! Area and timing: what is shown of a report, what the commands say and how they end, and the elaborator's netlists on
//! the way through the real tools.

mod command;
mod elaborated;
mod shown;
