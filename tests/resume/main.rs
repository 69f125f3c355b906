//! A resumed run leaves results bitwise identical to those of an uninterrupted run, and stays in
//! its folder.

mod folder;
#[cfg(unix)]
mod place;
mod program;
mod rejected;
mod stopped;
