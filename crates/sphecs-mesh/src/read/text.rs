//! Words of a text file with their lines and columns.

use crate::facets::coordinate_fault;
use crate::fault::{Fault, Place};

/// Most bytes of a word that a message quotes.
const QUOTED: usize = 40;

/// A word between blanks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word<'a> {
    /// Bytes of the word; not necessarily UTF-8.
    pub bytes: &'a [u8],
    /// Place of its first byte.
    pub place: Place,
}

impl Word<'_> {
    /// Returns true for a keyword, in upper or lower case.
    pub(super) fn is(&self, keyword: &str) -> bool {
        self.bytes.eq_ignore_ascii_case(keyword.as_bytes())
    }

    /// Returns the word as text for a message, shortened where it is long.
    pub(super) fn quoted(&self) -> String {
        quoted(self.bytes)
    }

    /// Returns the coordinate that the word is.
    ///
    /// # Errors
    /// If it is not a finite number below 1e30.
    pub(super) fn coordinate(&self, file: &str) -> Result<f64, Fault> {
        let text = std::str::from_utf8(self.bytes).unwrap_or_default();
        let Ok(value) = text.parse::<f64>() else {
            let advice = if text.contains(',') {
                "write a decimal point, not a comma"
            } else {
                "export the file again"
            };
            let message = format!("has `{}` where a coordinate must be: {advice}", self.quoted());
            return Err(Fault::new(file, self.place, message));
        };
        match coordinate_fault(value) {
            Some(message) => Err(Fault::new(file, self.place, message)),
            None => Ok(value),
        }
    }
}

/// Returns bytes as text for a message, shortened where they are long.
pub(super) fn quoted(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(QUOTED)]);
    let printable = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect::<String>();
    if bytes.len() > QUOTED { printable + "…" } else { printable }
}

/// Returns the first word of a text, behind a byte order mark and blanks.
pub(super) fn first_word(bytes: &[u8]) -> &[u8] {
    let rest = without_mark(bytes).trim_ascii_start();
    &rest[..rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len())]
}

fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Reads a text word by word or line by line.
#[derive(Clone, Debug)]
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    line_start: usize,
}

impl<'a> Words<'a> {
    /// Begins at the first line, behind a byte order mark.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes: without_mark(bytes), at: 0, line: 1, line_start: 0 }
    }

    /// Returns the place of the next byte.
    pub(super) fn place(&self) -> Place {
        Place::Text { line: self.line, column: (self.at - self.line_start) as u64 + 1 }
    }

    /// Returns the next word, on this or a later line; None at the end.
    pub(super) fn next(&mut self) -> Option<Word<'a>> {
        loop {
            match self.next_on_line() {
                Some(word) => return Some(word),
                None if self.at >= self.bytes.len() => return None,
                None => self.end_line(),
            }
        }
    }

    /// Returns the next word of this line; None at its end.
    pub(super) fn next_on_line(&mut self) -> Option<Word<'a>> {
        while self.bytes.get(self.at).is_some_and(|byte| is_blank(*byte)) {
            self.at += 1;
        }
        let place = self.place();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| is_blank(*byte) || is_line_end(*byte)).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then_some(Word { bytes: &rest[..length], place })
    }

    /// Returns the next word of this line, or of the next ones where a `\` at the end joins them.
    pub(super) fn next_on_joined_lines(&mut self) -> Option<Word<'a>> {
        loop {
            let word = self.next_on_line()?;
            if word.bytes != b"\\" || !self.rest_of_line().is_empty() {
                return Some(word);
            }
            self.next_line();
        }
    }

    /// Returns the rest of this line without blanks around it, and stays at the end of the line.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| is_line_end(*byte)).unwrap_or(rest.len());
        self.at += length;
        rest[..length].trim_ascii()
    }

    /// Returns the rest of this line, or the part of it before two given words in a row.
    pub(super) fn rest_of_line_before(&mut self, stop: [&str; 2]) -> &'a [u8] {
        let start = self.at;
        loop {
            let mut ahead = self.clone();
            let Some(word) = ahead.next_on_line() else { break };
            let end = ahead.at - word.bytes.len();
            if word.is(stop[0]) && ahead.clone().next_on_line().is_some_and(|next| next.is(stop[1])) {
                self.at = end;
                break;
            }
            self.at = ahead.at;
        }
        self.bytes[start..self.at].trim_ascii()
    }

    /// Returns the offset of the next byte in the text, without a byte order mark.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// Moves to the next line; returns false at the end of the text.
    pub(super) fn next_line(&mut self) -> bool {
        self.rest_of_line();
        if self.at >= self.bytes.len() {
            return false;
        }
        self.end_line();
        true
    }

    /// Steps over the end of a line: `\n`, `\r\n` or `\r`.
    fn end_line(&mut self) {
        self.at += if self.bytes[self.at..].starts_with(b"\r\n") { 2 } else { 1 };
        self.line += 1;
        self.line_start = self.at;
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c')
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}
