//! Structs of Thrift's compact protocol, walked by what they say of themselves, and held against what is due.
//!
//! Source: Apache Thrift, doc/specs/thrift-compact-protocol.md.

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FieldType {
    Flag,
    Byte,
    Whole,
    Double,
    Binary,
    List,
    Map,
    Struct,
}
use FieldType::{Binary, Byte, Double, Flag, List, Map, Struct, Whole};

/// Structs in structs, at most.
const DEEPEST: usize = 24;

/// Bytes that are walked from a place on.
pub(super) struct Walk<'b> {
    pub bytes: &'b [u8],
    pub at: usize,
    /// Ids of the fields that lead here; a list's members have the list's.
    path: Vec<i16>,
}

/// Receives each part of the structure; each method may refuse it.
pub(super) trait Visitor {
    /// A field: what it holds, and what the members of a list do.
    fn field(&mut self, path: &[i16], kind: FieldType, members: Option<FieldType>) -> Option<()>;
    /// A member of a list of structs begins.
    fn member(&mut self, path: &[i16]) -> Option<()>;
    /// A whole number.
    fn whole(&mut self, path: &[i16], value: i64) -> Option<()>;
}

impl<'b> Walk<'b> {
    pub(super) fn new(bytes: &'b [u8], at: usize) -> Self {
        Self { bytes, at, path: Vec::new() }
    }

    /// Walks through a struct, up to behind its end; nothing where it is none, or is refused.
    pub(super) fn structure(&mut self, to: &mut dyn Visitor) -> Option<()> {
        if self.path.len() > DEEPEST {
            return None;
        }
        let mut id = 0_i16;
        loop {
            let head = self.byte()?;
            if head & 0xf == 0 {
                return Some(());
            }
            id = match head >> 4 {
                0 => i16::try_from(self.zigzag()?).ok()?,
                delta => id.checked_add(i16::from(delta))?,
            };
            self.path.push(id);
            let kind = kind(head & 0xf)?;
            if kind != List {
                to.field(&self.path, kind, None)?;
            }
            match kind {
                // Its value is its type.
                Flag => {}
                kind => self.value(kind, to)?,
            }
            self.path.pop();
        }
    }

    fn value(&mut self, kind: FieldType, to: &mut dyn Visitor) -> Option<()> {
        match kind {
            Flag | Byte => drop(self.byte()?),
            Whole => {
                let value = self.zigzag()?;
                to.whole(&self.path, value)?;
            }
            Double => self.skip(8)?,
            Binary => {
                let length = self.varint()?;
                self.skip(length)?;
            }
            Struct => self.structure(to)?,
            List => self.list(to)?,
            // None of Parquet's structs has one.
            Map => return None,
        }
        Some(())
    }

    fn list(&mut self, to: &mut dyn Visitor) -> Option<()> {
        let head = self.byte()?;
        let count = match head >> 4 {
            15 => self.varint()?,
            count => u64::from(count),
        };
        // A list of nothing may be of no type.
        let members = if head == 0 { None } else { Some(kind(head & 0xf)?) };
        to.field(&self.path, List, members)?;
        // Each member has a byte at least.
        if count > (self.bytes.len() - self.at) as u64 || self.path.len() > DEEPEST {
            return None;
        }
        for _ in 0..count {
            let members = members?;
            if members == Struct {
                to.member(&self.path)?;
            }
            self.value(members, to)?;
        }
        Some(())
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn skip(&mut self, count: u64) -> Option<()> {
        let end = self.at.checked_add(usize::try_from(count).ok()?)?;
        self.at = Some(end).filter(|end| *end <= self.bytes.len())?;
        Some(())
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn zigzag(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }
}

fn kind(code: u8) -> Option<FieldType> {
    Some(match code {
        1 | 2 => Flag,
        3 => Byte,
        4..=6 => Whole,
        7 => Double,
        8 => Binary,
        9 | 10 => List,
        11 => Map,
        12 => Struct,
        _ => return None,
    })
}
