//! The parameters of a C3D file: groups of named arrays, one after another.

use std::collections::BTreeMap;

use super::BLOCK;
use super::number::Processor;

/// Arrays by `GROUP:NAME`.
pub(super) struct Parameters<'b> {
    arrays: BTreeMap<String, Array<'b>>,
    processor: Processor,
}

/// An array, with the first of its lengths the fastest.
struct Array<'b> {
    kind: i8,
    lengths: &'b [u8],
    data: &'b [u8],
}

/// Groups whose arrays are needed; of others it is no matter if they are broken.
const NEEDED: [&str; 2] = ["POINT", "TRIAL"];

/// First byte of the parameters, and the number of the processor.
pub(super) fn start(bytes: &[u8]) -> Option<(usize, u8)> {
    let start = usize::from(*bytes.first()?).checked_sub(1)? * BLOCK;
    Some((start, *bytes.get(start + 3)?))
}

impl<'b> Parameters<'b> {
    /// Reads all from `start` to their end, or to the end of the file.
    /// # Errors
    /// What reaches beyond the file.
    pub(super) fn read(bytes: &'b [u8], start: usize, processor: Processor) -> Result<Self, String> {
        let blocks = usize::from(bytes[start + 2]);
        let data = (bytes[16..18] != [0, 0]).then(|| usize::from(processor.word(&bytes[16..18])) - 1);
        // The count of blocks is one byte: long parameters go on up to the data.
        let end = (start + blocks * BLOCK).max(data.unwrap_or(0) * BLOCK).min(bytes.len());
        let section = &bytes[..end];
        let mut groups = BTreeMap::new();
        let mut found = Vec::new();
        let mut at = start + 4;
        while let Some([length, id]) = section.get(at..at + 2).map(|pair| [pair[0] as i8, pair[1] as i8]) {
            let name = at + 2;
            let offset = name + usize::from(length.unsigned_abs());
            let (Some(name), Some(next)) = (section.get(name..offset), section.get(offset..offset + 2))
            else {
                break;
            };
            if length == 0 || id == 0 {
                break;
            }
            let name = String::from_utf8_lossy(name).trim().to_uppercase();
            let next = usize::from(processor.word(next));
            if id < 0 {
                groups.insert(id.unsigned_abs(), name);
            } else {
                found.push((id.unsigned_abs(), name, array(section, offset + 2)));
            }
            if next == 0 {
                break;
            }
            at = offset + next;
        }
        let mut arrays = BTreeMap::new();
        for (id, name, array) in found {
            let Some(group) = groups.get(&id) else { continue };
            match array {
                Some(array) => drop(arrays.insert(format!("{group}:{name}"), array)),
                None if NEEDED.contains(&group.as_str()) => {
                    return Err(format!("parameter {group}:{name} reaches beyond its place"));
                }
                None => {}
            }
        }
        if arrays.keys().any(|key| key.starts_with("POINT:")) {
            Ok(Self { arrays, processor })
        } else {
            Err(format!("there are no parameters of a group POINT in block {}", start / BLOCK + 1))
        }
    }

    /// The first number of an array; integers count as without sign.
    pub(super) fn number(&self, key: &str) -> Option<f64> {
        let array = self.arrays.get(key)?;
        match array.kind {
            4 => array.data.get(..4).map(|bytes| f64::from(self.processor.float(bytes))),
            2 => array.data.get(..2).map(|bytes| f64::from(self.processor.word(bytes))),
            1 => array.data.first().map(|byte| f64::from(*byte)),
            _ => None,
        }
    }

    /// The words of an array of integers.
    pub(super) fn words(&self, key: &str) -> Option<Vec<u16>> {
        let array = self.arrays.get(key).filter(|array| array.kind == 2)?;
        Some(array.data.chunks_exact(2).map(|bytes| self.processor.word(bytes)).collect())
    }

    /// The texts of an array of letters, without blanks at their ends; none if there is no such array.
    pub(super) fn texts(&self, key: &str) -> Vec<String> {
        let Some(array) = self.arrays.get(key).filter(|array| array.kind == -1) else { return Vec::new() };
        let length = usize::from(array.lengths.first().copied().unwrap_or(1));
        if length == 0 {
            return Vec::new();
        }
        let text = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            text.trim_matches(|c: char| c == '\0' || c.is_whitespace()).to_owned()
        };
        array.data.chunks_exact(length).map(text).collect()
    }

    /// The first text of an array.
    pub(super) fn text(&self, key: &str) -> Option<String> {
        self.texts(key).into_iter().next()
    }
}

/// The array that begins at a byte; nothing if it reaches beyond the section.
fn array(section: &[u8], at: usize) -> Option<Array<'_>> {
    let (kind, count) = (*section.get(at)? as i8, usize::from(*section.get(at + 1)?));
    let lengths = section.get(at + 2..at + 2 + count)?;
    let size = usize::from(kind.unsigned_abs()).max(1);
    let bytes = lengths.iter().try_fold(size, |product, length| product.checked_mul(usize::from(*length)))?;
    let data = section.get(at + 2 + count..)?.get(..bytes)?;
    Some(Array { kind, lengths, data })
}
