//! Notation of scene files: RON, read into a tree of values with their positions.
//!
//! The `ron` crate has no positions of values and stops at the first fault, so scenes have their
//! own reader. A test checks that the `ron` crate reads all shipped scenes.
//!
//! * [`tree`]: the values with their positions
//! * [`lexer`]: blanks, comments, numbers, names and strings
//! * [`reader`]: text → tree, with all syntax faults
//! * [`typed`]: tree → serde types, with all faults of kind and name
//! * [`paths`]: `--set path=value`
//! * [`same_content`](mod@same_content): comparison without comments and layout

pub mod lexer;
pub mod paths;
pub mod reader;
pub mod same_content;
pub mod tree;
pub mod typed;
