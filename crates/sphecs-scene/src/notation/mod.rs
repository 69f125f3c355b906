//! The notation of scene files: RON, read into a small tree in which every value knows its place.
//!
//! The `ron` crate has no places for values and stops at the first fault, so scenes have their own
//! reader; that what it accepts is RON is a test over the shipped scenes.
//!
//! * [`tree`]: the values with their places
//! * [`lexer`]: blanks, comments, numbers, names and strings
//! * [`reader`]: text → tree, with all syntax faults
//! * [`typed`]: tree → serde types, with all faults of kind and name
//! * [`paths`]: `--set path=value`

pub mod lexer;
pub mod paths;
pub mod reader;
pub mod tree;
pub mod typed;
