//! Text of scene and table files as editors on any system write it.

/// Returns the text of a file: UTF-8, or UTF-16 with a byte order mark. The mark is left out, and
/// line ends become `\n`.
///
/// # Errors
/// The reason why the bytes are no text.
pub(crate) fn decoded(bytes: Vec<u8>) -> Result<String, String> {
    let mark = bytes.get(..2).map(|mark| [mark[0], mark[1]]);
    let text = match mark {
        Some([0xfe, 0xff]) => utf16(&bytes[2..], u16::from_be_bytes)?,
        Some([0xff, 0xfe]) => utf16(&bytes[2..], u16::from_le_bytes)?,
        _ => String::from_utf8(bytes).map_err(|error| error.utf8_error().to_string())?,
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    Ok(text.replace("\r\n", "\n").replace('\r', "\n"))
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, String> {
    let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
    String::from_utf16(&units).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_any_editor_is_read() {
        let text = "Scene(\n  // ρ0\n)";
        let windows = text.replace('\n', "\r\n");
        let utf16 = |unit: fn(u16) -> [u8; 2]| {
            let marked = format!("\u{feff}{windows}");
            marked.encode_utf16().flat_map(unit).collect::<Vec<u8>>()
        };
        let old_mac = text.replace('\n', "\r");
        for bytes in [
            text.as_bytes().to_vec(),
            windows.as_bytes().to_vec(),
            format!("\u{feff}{windows}").into_bytes(),
            old_mac.into_bytes(),
            utf16(u16::to_le_bytes),
            utf16(u16::to_be_bytes),
        ] {
            assert_eq!(decoded(bytes).as_deref(), Ok(text));
        }
        assert!(decoded(vec![0x89, b'H', b'D', b'F']).is_err());
        assert!(decoded(vec![0xff, 0xfe, 0x00, 0xd8]).is_err());
        assert_eq!(decoded(Vec::new()).as_deref(), Ok(""));
    }
}
