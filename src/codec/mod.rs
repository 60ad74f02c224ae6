//! Files for displays. One format, one file.

pub mod png;
