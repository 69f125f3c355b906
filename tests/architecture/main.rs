//! Structure, language and citations of the repository, read from its files.

mod citation;
mod language;
mod links;
mod references;
mod source_tree;
mod structure;
mod validation_pages;
