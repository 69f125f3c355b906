//! A resumed run leaves results bitwise identical to those of an uninterrupted run, and stays in
//! its folder.

mod folder;
mod program;
mod rejected;
mod stopped;
