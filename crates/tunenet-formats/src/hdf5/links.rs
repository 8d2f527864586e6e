//! Links of a group that name a path or another file: the crate passes over them, or refuses the group in which they stand.
//!
//! Source: HDF5 File Format Specification 3.0: object headers (IV.A.1), link messages (IV.A.2.g), symbol tables (III.A, III.C, III.D).
//! Links in the dense storage of a large group (III.G) are not listed.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use hdf5_pure::Superblock;

use crate::shown::shortened;
use crate::source::open;

/// Most objects and blocks that are looked at, the most bytes of one, and of all together.
const MOST_OBJECTS: usize = 20_000;
const MOST_BLOCKS: usize = 1_000;
const LARGEST: u64 = 1 << 20;
const MOST_BYTES: u64 = 64 << 20;
/// How deep groups are looked into, and how many bytes of a name count.
const DEEPEST: usize = 32;
const LONGEST: usize = 1024;

/// Numbers of messages in an object header.
const LINK: u16 = 0x06;
const CONTINUATION: u16 = 0x10;
const SYMBOL_TABLE: u16 = 0x11;

/// What a link names.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Target {
    /// An object of the file, by its address.
    Object(u64),
    /// A path in the file, or an object of another one.
    Named(String),
}

/// The links below the group with this path that are not followed, each with its own path below it and what it names. What is broken ends the
/// search: whoever reads the file says so.
pub(super) fn links(path: &Path, superblock: &Superblock, group: &str) -> Vec<(String, String)> {
    let Ok(file) = open(path) else { return Vec::new() };
    let widths = (u64::from(superblock.offset_size), u64::from(superblock.length_size));
    let mut bytes = Bytes { file, widths, base: superblock.base_address.get(), left: MOST_BYTES };
    let mut top = superblock.root_group_address;
    for part in group.split('/').filter(|part| !part.is_empty()) {
        let inner = bytes.children(top).into_iter().find(|(name, _)| name == part);
        let Some((_, Target::Object(address))) = inner else { return Vec::new() };
        top = address;
    }
    let (mut found, mut seen, mut groups) = (Vec::new(), BTreeSet::from([top]), vec![(top, String::new(), 0)]);
    while let Some((address, prefix, depth)) = groups.pop().filter(|_| seen.len() < MOST_OBJECTS) {
        for (name, target) in bytes.children(address) {
            match target {
                Target::Object(address) if depth < DEEPEST && seen.insert(address) => {
                    groups.push((address, format!("{prefix}{name}."), depth + 1));
                }
                Target::Object(_) => {}
                Target::Named(named) => found.push((format!("{prefix}{name}"), named)),
            }
        }
    }
    found.sort();
    found
}

/// The file by its bytes.
struct Bytes {
    file: File,
    /// Bytes of an address, and of a length.
    widths: (u64, u64),
    /// Where its addresses count from.
    base: u64,
    /// How many bytes may still be read.
    left: u64,
}

impl Bytes {
    /// So many bytes from an address on.
    fn at(&mut self, address: u64, count: u64) -> Option<Vec<u8>> {
        self.left = self.left.checked_sub(count)?;
        let mut bytes = Vec::new();
        self.file.seek(SeekFrom::Start(self.base.checked_add(address)?)).ok()?;
        (&mut self.file).take(count.min(LARGEST)).read_to_end(&mut bytes).ok()?;
        (bytes.len() as u64 == count).then_some(bytes)
    }

    /// The links of the object at an address; none where it is no group.
    fn children(&mut self, address: u64) -> Vec<(String, Target)> {
        let mut found = Vec::new();
        for (kind, body) in self.messages(address).unwrap_or_default() {
            match kind {
                LINK => found.extend(self.link(&body)),
                SYMBOL_TABLE => found.extend(self.symbols(&body).unwrap_or_default()),
                _ => {}
            }
        }
        found
    }

    /// The messages about links of an object header, with those of its continuations.
    fn messages(&mut self, address: u64) -> Option<Vec<(u16, Vec<u8>)>> {
        let second = self.at(address, 4)? == b"OHDR";
        let (begin, size, ordered) = if second {
            let flags = self.at(address.checked_add(5)?, 1)?[0];
            let skipped = 6 + if flags & 0x20 == 0 { 0 } else { 16 } + if flags & 0x10 == 0 { 0 } else { 4 };
            let width = 1 << (flags & 3);
            (address + skipped + width, number(&self.at(address + skipped, width)?), flags & 4 != 0)
        } else {
            (address.checked_add(16)?, number(&self.at(address + 8, 4)?), false)
        };
        let (mut found, mut blocks, mut looked_at) = (Vec::new(), vec![(begin, size)], 0);
        while let Some((begin, size)) = blocks.pop().filter(|_| looked_at < MOST_BLOCKS) {
            looked_at += 1;
            let block = self.at(begin, size)?;
            let mut rest = block.as_slice();
            while let Some((kind, body, after)) = message(rest, second, ordered) {
                if kind == CONTINUATION {
                    let (address, length) = self.pair(body)?;
                    // A mark before it, and a checksum behind it.
                    let inner = || Some((address.checked_add(4)?, length.checked_sub(8)?));
                    blocks.push(if second { inner()? } else { (address, length) });
                }
                if matches!(kind, LINK | SYMBOL_TABLE) {
                    found.push((kind, body.to_vec()));
                }
                rest = after;
            }
        }
        Some(found)
    }

    /// An address and a length.
    fn pair(&self, bytes: &[u8]) -> Option<(u64, u64)> {
        let (address, rest) = split(bytes, self.widths.0)?;
        Some((number(address), number(split(rest, self.widths.1)?.0)))
    }

    /// The link of a message.
    fn link(&self, body: &[u8]) -> Option<(String, Target)> {
        let flags = *body.get(1)?;
        let mut rest = body.get(2..)?;
        let mut kind = 0;
        if flags & 0x08 != 0 {
            kind = *rest.first()?;
            rest = &rest[1..];
        }
        // The order of creation and the set of characters.
        rest = split(rest, if flags & 0x04 == 0 { 0 } else { 8 } + u64::from(flags >> 4 & 1))?.1;
        let (length, after) = split(rest, 1 << (flags & 3))?;
        let (name, target) = split(after, number(length))?;
        let target = if kind == 0 {
            Target::Object(number(split(target, self.widths.0)?.0))
        } else {
            let (length, named) = split(target, 2)?;
            // Of another file, its name and the path are separated by a zero byte.
            let parts = text(split(named, number(length))?.0).replace('\0', " ");
            Target::Named(format!("`{}`", shortened(parts.trim())))
        };
        Some((text(name), target))
    }

    /// The links of a symbol table, whose names stand in a heap.
    fn symbols(&mut self, body: &[u8]) -> Option<Vec<(String, Target)>> {
        let (offset, length) = self.widths;
        let (tree, rest) = split(body, offset)?;
        let heap = number(split(rest, offset)?.0);
        let head = self.at(heap, 8 + 2 * length + offset)?;
        let size = number(split(&head[8..], length)?.0);
        let names = number(split(&head[8..], 2 * length)?.1);
        let names = self.at(names, size)?;
        let name = |at: u64| {
            names.get(usize::try_from(at).ok()?..).map(|rest| text(rest.split(|b| *b == 0).next().unwrap_or(rest)))
        };
        let (mut found, mut nodes, mut looked_at) = (Vec::new(), vec![number(tree)], 0);
        while let Some(node) = nodes.pop().filter(|_| looked_at < MOST_BLOCKS && found.len() < MOST_OBJECTS) {
            looked_at += 1;
            let head = self.at(node, 8)?;
            let count = number(&head[6..8]);
            if head.starts_with(b"TREE") {
                let children = self.at(node + 8 + 2 * offset, count * (length + offset))?;
                let each = children.chunks_exact(usize::try_from(length + offset).ok()?);
                nodes.extend(each.filter_map(|one| Some(number(split(one, length)?.1))));
                continue;
            }
            let symbols = self.at(node + 8, count * (2 * offset + 24))?;
            for one in symbols.chunks_exact(usize::try_from(2 * offset + 24).ok()?) {
                let (at, rest) = split(one, offset)?;
                let (address, rest) = split(rest, offset)?;
                let target = match number(&rest[..4]) {
                    2 => Target::Named(format!("`{}`", shortened(&name(number(&rest[8..12]))?))),
                    _ => Target::Object(number(address)),
                };
                found.push((name(number(at))?, target));
            }
        }
        Some(found)
    }
}

/// The first message of a block: its number, its body, and what follows it.
fn message(block: &[u8], second: bool, ordered: bool) -> Option<(u16, &[u8], &[u8])> {
    let (head, rest) = split(block, if second { 4 + 2 * u64::from(ordered) } else { 8 })?;
    let (kind, size) = if second {
        (u16::from(head[0]), u16::from_le_bytes([head[1], head[2]]))
    } else {
        (u16::from_le_bytes([head[0], head[1]]), u16::from_le_bytes([head[2], head[3]]))
    };
    let (body, rest) = split(rest, u64::from(size))?;
    Some((kind, body, rest))
}

fn split(bytes: &[u8], at: u64) -> Option<(&[u8], &[u8])> {
    bytes.split_at_checked(usize::try_from(at).ok()?)
}

/// A whole number of at most eight bytes, the lowest first.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().take(8).rev().fold(0, |value, byte| value << 8 | u64::from(*byte))
}

/// A name, or its beginning.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST)]).into_owned()
}
