//! A Parquet file looked through before the parquet package reads it.
//!
//! That package trusts what a file states of itself: it takes memory for lists and pages of any stated length,
//! and calls itself for each group within a group; both end the program, and no panic that could be caught. So
//! footer and heads of pages are walked here first, and counts are held against the bytes that are there.
//!
//! Source: parquet.thrift of the format, version 2.12, for the fields and their types.

mod thrift;

use thrift::{FieldType, Visitor, Walk};

/// First and last bytes of a file.
pub const MAGIC: &[u8] = b"PAR1";
/// Members of lists of structs: so many, and one more for so many bytes of the footer. Each takes some hundred
/// bytes of memory.
const MEMBERS: [usize; 2] = [16_384, 16];
/// Groups within groups, at most.
const DEEPEST: usize = 32;
/// Snappy, the one compression that is compiled in, writes 64 bytes by 3 at best.
const MOST_COMPRESSED: i64 = 22;
/// A page of no values has a head alone, and a short one is more head than page.
const SMALL_PAGE: i64 = 4096;

/// Why a file is refused, in words.
pub(crate) type Refused = String;

/// What a footer says of one column in one group of rows.
#[derive(Clone, Copy, Debug, Default)]
struct Chunk {
    values: i64,
    length: i64,
    data: i64,
    dictionary: Option<i64>,
}

/// Looks through a whole file; `plain` admits no encoding by which one text may represent many.
/// # Errors
/// In words, what does not hold together.
pub fn look_through(file: &[u8], plain: bool) -> Result<(), Refused> {
    let footer = footer_of(file)?;
    for chunk in chunks(footer)? {
        let pages = chunk.range(file.len()).ok_or("the place of a column is beyond its end")?;
        pages_hold(&file[..pages.end], pages.start, chunk.values, plain)?;
    }
    Ok(())
}

/// Looks through a footer alone.
/// # Errors
/// As [`look_through`].
pub(crate) fn look_through_footer(footer: &[u8]) -> Result<(), Refused> {
    chunks(footer).map(drop)
}

/// The footer of a file whose end these bytes are.
/// # Errors
/// As [`look_through`].
pub(crate) fn footer_of(file: &[u8]) -> Result<&[u8], Refused> {
    let cut = || "it does not end with a footer and PAR1: it was cut short, or is no Parquet".to_owned();
    let (rest, end) = file.split_last_chunk::<8>().ok_or_else(cut)?;
    if &end[4..] != MAGIC {
        return Err(cut());
    }
    let length = u32::from_le_bytes([end[0], end[1], end[2], end[3]]) as usize;
    rest.len().checked_sub(length).map(|start| &rest[start..]).ok_or_else(cut)
}

fn chunks(footer: &[u8]) -> Result<Vec<Chunk>, Refused> {
    let mut seen = Footer { members: MEMBERS[0] + footer.len() / MEMBERS[1], ..Footer::default() };
    Walk::new(footer, 0).structure(&mut seen).ok_or("its footer does not hold together")?;
    if seen.is_shallow() {
        Ok(seen.chunks)
    } else {
        Err(format!(
            "its schema has more groups within groups than {DEEPEST}, or fewer columns than it states"
        ))
    }
}

impl Chunk {
    fn range(&self, length: usize) -> Option<std::ops::Range<usize>> {
        let start = usize::try_from(self.dictionary.unwrap_or(self.data)).ok()?;
        let end = start.checked_add(usize::try_from(self.length).ok()?)?;
        (end <= length && usize::try_from(self.data).ok()? <= length).then_some(start..end)
    }
}

/// Walks from page to page.
fn pages_hold(bytes: &[u8], start: usize, values: i64, plain: bool) -> Result<(), Refused> {
    let mut at = start;
    while at < bytes.len() {
        let mut head = Page::default();
        let mut walk = Walk::new(bytes, at);
        walk.structure(&mut head).ok_or("the head of a page does not hold together")?;
        let rest = (bytes.len() - walk.at) as i64;
        if !(0..=rest).contains(&head.compressed) {
            return Err(format!("a page states {} bytes, and {rest} are there", head.compressed));
        }
        let most = SMALL_PAGE + MOST_COMPRESSED * head.compressed;
        if !(0..=most).contains(&head.uncompressed) {
            return Err(format!(
                "a page of {} bytes states {} without compression",
                head.compressed, head.uncompressed
            ));
        }
        // A dictionary has no more values than it has bits.
        let most = if head.is_dictionary { 8 * most } else { values };
        if !(0..=most).contains(&head.values) {
            return Err(format!("a page states {} values, which it cannot hold", head.values));
        }
        if plain && head.encoding != PLAIN {
            return Err("a column is in an encoding that efam does not write".to_owned());
        }
        at = walk.at + head.compressed as usize;
    }
    Ok(())
}

/// The number of the encoding that is none.
const PLAIN: i64 = 0;

/// Content of a footer, a struct FileMetaData.
#[derive(Default)]
struct Footer {
    chunks: Vec<Chunk>,
    /// Children of each member of the schema.
    children: Vec<i64>,
    /// Members that may still come.
    members: usize,
}

impl Footer {
    /// Whether the schema is a tree of little depth: its members follow one another, parents before children.
    fn is_shallow(&self) -> bool {
        let mut open: Vec<i64> = Vec::new();
        for children in &self.children {
            while open.last() == Some(&0) {
                open.pop();
            }
            if let Some(left) = open.last_mut() {
                *left -= 1;
            }
            if *children < 0 || *children > self.children.len() as i64 || open.len() > DEEPEST {
                return false;
            }
            open.push(*children);
        }
        open.iter().all(|left| *left == 0)
    }
}

/// Types of the fields of a struct by their ids from one: `f`lag, `y` for a byte, `i`nteger, `b`inary, `s`truct, list
/// of structs `S`, binaries `B`, integers `I`. Empty where any will do: nobody reads it.
fn of_footer(path: &[i16]) -> &'static str {
    match path {
        [] => "iSiSSbSsb",
        [2] => "iiibiiiiis",
        [2, 10] => "sssssssssssssssss",
        [2, 10, 5] => "ii",
        [2, 10, 7 | 8] => "fs",
        [2, 10, 7 | 8, 2] => "sss",
        [2, 10, 10] => "yf",
        [2, 10, 16] => "y",
        [2, 10, 17] => "b",
        [2, 10, 18] => "bi",
        [4] => "SiiSiii",
        [4, 1] => "bisiiiisb",
        [4, 1, 3] => "iIBiiiiSiiisSiiss",
        [4, 1, 3, 8] | [5] => "bb",
        [4, 1, 3, 12] => STATISTICS,
        [4, 1, 3, 13] => "iii",
        [4, 1, 3, 16] => "iII",
        [4, 1, 3, 17] => "sI",
        [4, 4] => "iff",
        [7] => "ss",
        _ => "",
    }
}

const STATISTICS: &str = "bbiibbff";

/// The same of the head of a page, a struct PageHeader.
fn of_page(path: &[i16]) -> &'static str {
    match path {
        [] => "iiiissss",
        [5] => "iiiis",
        [7] => "iif",
        [8] => "iiiiiifs",
        [5, 5] | [8, 8] => STATISTICS,
        _ => "",
    }
}

/// Whether a field is of the type that its struct has in its place; what comes after is read otherwise if not.
fn fits(of: &str, path: &[i16], kind: FieldType, members: Option<FieldType>) -> Option<()> {
    let id = usize::try_from(*path.last()?).ok()?.checked_sub(1)?;
    let fits = match (of.as_bytes().get(id), kind) {
        (None, _) => true,
        (Some(b'f'), FieldType::Flag) | (Some(b'y'), FieldType::Byte) | (Some(b'i'), FieldType::Whole) => {
            true
        }
        (Some(b'b'), FieldType::Binary) | (Some(b's'), FieldType::Struct) => true,
        (Some(b'S'), FieldType::List) => members.is_none_or(|of| of == FieldType::Struct),
        (Some(b'B'), FieldType::List) => members.is_none_or(|of| of == FieldType::Binary),
        (Some(b'I'), FieldType::List) => members.is_none_or(|of| of == FieldType::Whole),
        _ => false,
    };
    fits.then_some(())
}

impl Visitor for Footer {
    fn field(&mut self, path: &[i16], kind: FieldType, members: Option<FieldType>) -> Option<()> {
        fits(of_footer(&path[..path.len() - 1]), path, kind, members)
    }

    fn member(&mut self, path: &[i16]) -> Option<()> {
        self.members = self.members.checked_sub(1)?;
        match path {
            [2] => self.children.push(0),
            [4, 1] => self.chunks.push(Chunk::default()),
            _ => {}
        }
        Some(())
    }

    fn whole(&mut self, path: &[i16], value: i64) -> Option<()> {
        let chunk = self.chunks.last_mut();
        match path {
            [2, 5] => *self.children.last_mut()? = value,
            [4, 1, 3, 5] => chunk?.values = value,
            [4, 1, 3, 7] => chunk?.length = value,
            [4, 1, 3, 9] => chunk?.data = value,
            [4, 1, 3, 11] => chunk?.dictionary = Some(value),
            _ => {}
        }
        Some(())
    }
}

/// Content of the head of a page.
#[derive(Default)]
struct Page {
    uncompressed: i64,
    compressed: i64,
    values: i64,
    encoding: i64,
    is_dictionary: bool,
}

impl Visitor for Page {
    fn field(&mut self, path: &[i16], kind: FieldType, members: Option<FieldType>) -> Option<()> {
        fits(of_page(&path[..path.len() - 1]), path, kind, members)
    }

    fn member(&mut self, _path: &[i16]) -> Option<()> {
        // No head of a page has lists.
        None
    }

    fn whole(&mut self, path: &[i16], value: i64) -> Option<()> {
        match path {
            [1] => self.is_dictionary = value == 2,
            [2] => self.uncompressed = value,
            [3] => self.compressed = value,
            [5 | 7 | 8, 1] => self.values = value,
            [5 | 7, 2] | [8, 4] => self.encoding = value,
            _ => {}
        }
        Some(())
    }
}
