//! A run that is stopped, killed or damaged and resumed leaves the same bytes as one that was never broken off, and stays in its folder.

mod folder;
mod program;
mod stopped;
mod unfit;
