//! Building straight to a file: what the file's bytes depend on, what memory is asked for, and what is left after a failure.

mod bytes;
mod failures;
mod limits;
mod sources;
