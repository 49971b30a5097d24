//! Where the blocks of a binary file of MSH 4.1 are, and any of its nodes and elements.

use std::collections::HashMap;
use std::ops::Range;

use super::assemble::groups;
use super::contents::{Contents, Run};
use super::cursor::{Cursor, DAMAGED, Encoding};
use super::types::{ElementType, Role, order};
use super::version2::kind;
use super::version4::{entity, header};
use super::{ONCE, Read, section};
use crate::Error;
use crate::io::ranges::{Elements, Stored};
use crate::mesh::ascending;

/// The blocks of a file.
#[derive(Default)]
pub(in crate::io) struct Blocks {
    pub groups: Vec<String>,
    /// Sets of groups that elements are in.
    sets: Vec<Vec<u32>>,
    nodes: Vec<NodeBlock>,
    elements: Vec<ElementBlock>,
    big: bool,
    /// Bytes of a `size_t`.
    size: u64,
}

struct NodeBlock {
    /// Nodes before it.
    first: u64,
    count: u64,
    /// Where its numbers begin, which the places follow.
    at: u64,
    /// Coordinates and parameters of each node.
    floats: u64,
}

struct ElementBlock {
    /// Elements before it.
    first: u64,
    count: u64,
    at: u64,
    kind: ElementType,
    set: u32,
}

/// The nodes of cells that are left out are looked at in the whole (`complete.rs`).
const COMPLETE: [i64; 2] = [12, 13];

/// Sections that are read with the whole file, if at all.
const WITH_THE_WHOLE: [&str; 5] =
    ["$NodeData", "$ElementData", "$ElementNodeData", "$PartitionedEntities", "$ParametricNodes"];

/// Finds the blocks of a file; none where it has to be read as a whole.
///
/// # Errors
/// If it is damaged.
pub(in crate::io) fn blocks(file: &Stored) -> Result<Option<Blocks>, Error> {
    let (mut read, mut blocks, mut at) = (Read::default(), Blocks::default(), 0);
    loop {
        let (name, begin) = file.head(at, next_section)?;
        let Some(name) = name else { break };
        let large = ONCE[1..3].iter().find(|large| **large == name);
        match (large, read.encoding) {
            _ if WITH_THE_WHOLE.contains(&name.as_str()) => return Ok(None),
            (Some(large), Encoding::Binary { big, size }) => {
                if read.seen.contains(large) {
                    return Err(Error::new("", format!("a second section {name}"), DAMAGED));
                }
                read.seen.push(large);
                (blocks.big, blocks.size) = (big, size as u64);
                let walk = Walk { file, section: large, encoding: read.encoding };
                at = match *large {
                    "$Nodes" => walk.nodes(at + begin, &mut blocks.nodes)?,
                    _ => walk.elements(at + begin, &mut blocks.elements, &mut read.contents)?,
                };
            }
            _ => at += file.head(at, |bytes| small(&bytes, &mut read))?,
        }
        if !matches!((read.version, read.encoding), (Some(4), Encoding::Binary { .. })) {
            return Ok(None);
        }
    }
    let usable =
        |block: &ElementBlock| !matches!(block.kind.role, Role::Refused(_)) && !COMPLETE.contains(&block.kind.number);
    let has_cells = blocks.elements.iter().any(|block| block.kind.dimension == 3);
    if !ONCE[..3].iter().all(|needed| read.seen.contains(needed)) || !has_cells || !blocks.elements.iter().all(usable) {
        return Ok(None);
    }
    blocks.name_groups(&read.contents);
    Ok(Some(blocks))
}

/// The name of the next section, if there is one, and the byte after its line.
fn next_section(bytes: Vec<u8>) -> Result<(Option<String>, u64), Error> {
    let mut at = Cursor::new(&bytes);
    if !at.skip_space() {
        return Ok((None, 0));
    }
    let name = String::from_utf8_lossy(at.line()).into_owned();
    Ok((Some(name), at.pos as u64))
}

/// Reads a section that is all in `bytes`; how many of them.
fn small(bytes: &[u8], read: &mut Read) -> Result<u64, Error> {
    // Tried until there are enough bytes: what has been read counts if all of the section has.
    let (version, encoding, seen) = (read.version, read.encoding, read.seen.clone());
    let mut tried = Read { version, encoding, seen, contents: Contents::default() };
    let mut at = Cursor::new(bytes);
    at.encoding = encoding;
    at.skip_space();
    section(&mut at, &mut tried)?;
    let Contents { names, entities, .. } = tried.contents;
    read.contents.names.extend(names);
    read.contents.entities.extend(entities);
    (read.version, read.encoding, read.seen) = (tried.version, tried.encoding, tried.seen);
    Ok(at.pos as u64)
}

/// On the way through the blocks of a section.
struct Walk<'a> {
    file: &'a Stored,
    section: &'static str,
    encoding: Encoding,
}

impl Walk<'_> {
    /// What stands in the next bytes.
    fn read<T>(&self, at: &mut u64, count: u64, of: impl Fn(&mut Cursor) -> Result<T, Error>) -> Result<T, Error> {
        let bytes = self.file.bytes(*at, count)?;
        let mut cursor = Cursor::new(&bytes);
        // Three bytes that begin a text are numbers here.
        (cursor.pos, cursor.encoding, cursor.section) = (0, self.encoding, self.section);
        *at += count;
        of(&mut cursor)
    }

    /// The place after the end of a section.
    fn end(&self, at: u64) -> Result<u64, Error> {
        self.file.head(at, |bytes| {
            let mut cursor = Cursor::new(&bytes);
            (cursor.encoding, cursor.section) = (self.encoding, self.section);
            cursor.expect_end()?;
            Ok(at + cursor.pos as u64)
        })
    }

    /// Where so many records of so many bytes end, if they are in the file.
    fn after(&self, at: u64, count: u64, each: u64) -> Result<u64, Error> {
        let end =
            count.checked_mul(each).and_then(|bytes| at.checked_add(bytes)).filter(|&end| end <= self.file.length);
        let what = || format!("{count} records of {each} bytes are announced in {}", self.section);
        end.ok_or_else(|| Error::new(format!("byte {at}"), what(), DAMAGED))
    }

    fn complete(&self, read: u64, announced: u64) -> Result<(), Error> {
        let what = || format!("{announced} records are announced in {}, but its blocks hold {read}", self.section);
        if read == announced { Ok(()) } else { Err(Error::new("", what(), DAMAGED)) }
    }

    fn size(&self) -> u64 {
        if let Encoding::Binary { size, .. } = self.encoding { size as u64 } else { 0 }
    }

    /// Finds the blocks of nodes from a place on; the place after the section.
    fn nodes(&self, mut at: u64, found: &mut Vec<NodeBlock>) -> Result<u64, Error> {
        let [blocks, total] = self.read(&mut at, 4 * self.size(), header)?;
        let mut first = 0;
        for _ in 0..blocks {
            let (floats, count) = self.read(&mut at, 12 + self.size(), |cursor| {
                let (dimension, _) = entity(cursor)?;
                let parameters = if cursor.integer("0 or 1")? == 0 { 0 } else { u64::from(dimension) };
                Ok((3 + parameters, cursor.size("a number of nodes")?))
            })?;
            let block = NodeBlock { first, count, at, floats };
            at = self.after(at, count, self.size() + 8 * floats)?;
            first += count;
            found.push(block);
        }
        self.complete(first, total)?;
        self.end(at)
    }

    /// Finds the blocks of elements from a place on; the place after the section.
    fn elements(&self, mut at: u64, found: &mut Vec<ElementBlock>, contents: &mut Contents) -> Result<u64, Error> {
        let [blocks, total] = self.read(&mut at, 4 * self.size(), header)?;
        let mut first = 0;
        for _ in 0..blocks {
            let (dimension, entity, kind, count) = self.read(&mut at, 12 + self.size(), |cursor| {
                let (dimension, entity) = entity(cursor)?;
                Ok((dimension, entity, kind(cursor)?, cursor.size("a number of elements")?))
            })?;
            if kind.dimension != dimension {
                let what = format!("a {} does not belong to an entity of dimension {dimension}", kind.name);
                return Err(Error::new(format!("byte {at}"), what, DAMAGED));
            }
            if count > 0 {
                contents.runs.push(Run { kind, entity, physical: 0, first: 0, count: 0, first_node: 0 });
                found.push(ElementBlock { first, count, at, kind, set: found.len() as u32 });
            }
            at = self.after(at, count, self.size() * (1 + kind.nodes as u64))?;
            first += count;
        }
        self.complete(first, total)?;
        self.end(at)
    }
}

impl Blocks {
    /// The groups, and the set that each block is in.
    fn name_groups(&mut self, contents: &Contents) {
        let (groups, group_of) = groups(contents);
        self.groups = groups.into_iter().map(|group| group.name).collect();
        let mut known: HashMap<Vec<u32>, u32> = HashMap::new();
        for (block, run) in self.elements.iter_mut().zip(&contents.runs) {
            let physicals = contents.physicals(run);
            let set = ascending(physicals.iter().filter_map(|p| group_of.get(p)).map(|&group| group as u32));
            block.set = *known.entry(set).or_insert_with_key(|set| {
                self.sets.push(set.clone());
                self.sets.len() as u32 - 1
            });
        }
    }

    /// Nodes and elements.
    pub(in crate::io) fn sizes(&self) -> [u64; 2] {
        let nodes = self.nodes.last().map_or(0, |block| block.first + block.count);
        [nodes, self.elements.last().map_or(0, |block| block.first + block.count)]
    }

    /// Numbers and places of some nodes.
    pub(in crate::io) fn nodes(&self, file: &Stored, range: Range<u64>) -> Result<(Vec<u64>, Vec<[f64; 3]>), Error> {
        let (mut numbers, mut places) = (Vec::new(), Vec::new());
        for block in &self.nodes {
            let Some([from, count]) = part(&range, block.first, block.count) else { continue };
            let tags = file.bytes(block.at + self.size * from, self.size * count)?;
            numbers.extend(tags.chunks_exact(self.size as usize).map(|bytes| self.number(bytes)));
            let each = 8 * block.floats;
            let floats = file.bytes(block.at + self.size * block.count + each * from, each * count)?;
            let place = |bytes: &[u8]| [0, 1, 2].map(|c| f64::from_bits(self.number(&bytes[8 * c..8 * c + 8])));
            places.extend(floats.chunks_exact(each as usize).map(place));
        }
        Ok((numbers, places))
    }

    /// Some elements.
    pub(in crate::io) fn elements(&self, file: &Stored, range: Range<u64>) -> Result<Elements, Error> {
        let mut found = Elements::with(self.sets.clone());
        for block in &self.elements {
            let Some([from, count]) = part(&range, block.first, block.count) else { continue };
            let each = self.size * (1 + block.kind.nodes as u64);
            let bytes = file.bytes(block.at + each * from, each * count)?;
            for record in bytes.chunks_exact(each as usize) {
                let nodes = &record[self.size as usize..];
                let node = |k: usize| self.number(&nodes[k * self.size as usize..(k + 1) * self.size as usize]);
                match block.kind.role {
                    Role::Cell(kind) => {
                        let cells = found.of_kind(kind);
                        cells.nodes.extend(order(kind).iter().map(|&k| node(k)));
                        cells.sets.push(block.set);
                    }
                    Role::Face => {
                        let last = if matches!(block.kind.nodes, 3 | 6) { u64::MAX } else { node(3) };
                        found.faces.push(([node(0), node(1), node(2), last], block.set));
                    }
                    _ => found.nodes.extend((0..block.kind.nodes).map(|k| (node(k), block.set))),
                }
            }
        }
        Ok(found)
    }

    /// The number in four or eight bytes.
    fn number(&self, bytes: &[u8]) -> u64 {
        super::cursor::size_t(bytes, self.big)
    }
}

/// What of a block is in a range: the first, counted in the block, and how many.
fn part(range: &Range<u64>, first: u64, count: u64) -> Option<[u64; 2]> {
    let [from, to] = [range.start, range.end].map(|end| end.clamp(first, first + count) - first);
    (to > from).then(|| [from, to - from])
}
