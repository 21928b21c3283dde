//! The commands `ppa` and `explore`: their messages, their exit codes, and how they stop.

mod command;
