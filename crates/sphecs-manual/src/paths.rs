//! Paths with `/`, as they are written in links.

/// Returns the folder of a file, empty at the root.
pub fn folder(file: &str) -> &str {
    file.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Returns the path that a link in a folder leads to, without `.` and `..`; None outside the root.
pub fn join(folder: &str, link: &str) -> Option<String> {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in link.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            _ => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// Returns the link from a file in a folder to a path.
pub fn relative(folder: &str, path: &str) -> String {
    let from: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    let to: Vec<&str> = path.split('/').collect();
    let shared = from.iter().zip(&to[..to.len() - 1]).take_while(|(a, b)| a == b).count();
    let mut parts = vec![".."; from.len() - shared];
    parts.extend(&to[shared..]);
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_paths_have_no_dots() {
        assert_eq!(join("docs/book", "../a/./b.md"), Some("docs/a/b.md".to_owned()));
        assert_eq!(join("docs", "../../a.md"), None);
    }

    #[test]
    fn relative_is_the_inverse_of_join() {
        for (folder, path) in [("", "a.md"), ("a", "a/b.md"), ("a/b", "a/c/d.md"), ("a", "b.md"), ("a", "a")]
        {
            assert_eq!(join(folder, &relative(folder, path)).as_deref(), Some(path));
        }
    }
}
