//! Damage to files.

/// One change to a file.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    Set(usize, u8),
    Digit(usize, u8),
    Insert(usize, Vec<u8>),
    Remove(usize, usize),
    Cut(usize),
}

/// Makes it; a place beyond the end of the file changes nothing.
pub(crate) fn apply(bytes: &mut Vec<u8>, change: Change) {
    match change {
        Change::Set(at, value) if at < bytes.len() => bytes[at] = value,
        Change::Digit(at, value) => {
            // The first digit from there on, so that numbers change more often than names.
            if let Some(digit) = bytes.iter_mut().skip(at).find(|b| b.is_ascii_digit()) {
                *digit = value;
            }
        }
        Change::Insert(at, more) if at < bytes.len() => {
            bytes.splice(at..at, more);
        }
        Change::Remove(at, n) if at < bytes.len() => {
            let end = (at + n).min(bytes.len());
            bytes.drain(at..end);
        }
        Change::Cut(at) => bytes.truncate(at),
        _ => {}
    }
}
