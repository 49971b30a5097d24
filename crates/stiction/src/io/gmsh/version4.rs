//! Entities, nodes and elements of MSH 4.1.

use super::contents::Contents;
use super::cursor::{Cursor, DAMAGED};
use super::version2::kind;
use crate::Error;

/// Which physical groups each entity belongs to. The entities' shapes and boundaries are not used.
pub(super) fn entities(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = at.size("a number of entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = at.integer("the number of an entity")?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                at.float("a coordinate of an entity")?;
            }
            let mut physicals = Vec::new();
            for _ in 0..at.size("a number of physical groups")? {
                physicals.push(at.integer("the number of a physical group")?);
            }
            if dimension > 0 {
                for _ in 0..at.size("a number of bounding entities")? {
                    at.integer("the number of a bounding entity")?;
                }
            }
            if !physicals.is_empty() {
                contents.entities.insert((dimension as u8, tag), physicals);
            }
        }
    }
    Ok(())
}

/// The counts that head nodes and elements: blocks, and all records together.
pub(super) fn header(at: &mut Cursor) -> Result<[u64; 2], Error> {
    let counts = [at.size("a number of blocks")?, at.size("a number of nodes or elements")?];
    at.size("the lowest number")?;
    at.size("the highest number")?;
    Ok(counts)
}

/// The head of a block: dimension and tag of its entity.
pub(super) fn entity(at: &mut Cursor) -> Result<(u8, i64), Error> {
    let start = at.pos;
    let dimension = at.integer("the dimension of an entity")?;
    let tag = at.integer("the number of an entity")?;
    match u8::try_from(dimension) {
        Ok(d @ 0..=3) => Ok((d, tag)),
        _ => Err(at.fail_at(start, format!("{dimension} is not the dimension of an entity"), DAMAGED)),
    }
}

/// An error unless as many were read as announced.
fn complete(at: &Cursor, read: usize, announced: u64, what: &str) -> Result<(), Error> {
    if read as u64 == announced {
        return Ok(());
    }
    Err(at.fail(format!("{announced} {what} are announced, but the blocks hold {read}"), DAMAGED))
}

/// Blocks of node tags followed by as many coordinates.
pub(super) fn nodes(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    let [blocks, total] = header(at)?;
    let float_bytes = if at.binary() { 8 } else { 2 };
    let room = at.room(total, "nodes", at.size_bytes() + 3 * float_bytes)?;
    contents.node_tags.reserve_exact(room);
    contents.nodes.reserve_exact(room);
    for _ in 0..blocks {
        let (dimension, _) = entity(at)?;
        let parameters = if at.integer("0 or 1")? == 0 { 0 } else { dimension };
        let n = at.size("a number of nodes")?;
        let n = at.room(n, "nodes", at.size_bytes() + 3 * float_bytes)?;
        for _ in 0..n {
            contents.node_tags.push(at.size("the number of a node")?);
        }
        for _ in 0..n {
            contents.nodes.push([at.float("x")?, at.float("y")?, at.float("z")?]);
            for _ in 0..parameters {
                at.float("a parameter")?;
            }
        }
    }
    complete(at, contents.nodes.len(), total, "nodes")
}

/// Blocks of elements: tag and nodes each.
pub(super) fn elements(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    let [blocks, total] = header(at)?;
    contents.know_nodes()?;
    let mut read = 0;
    for _ in 0..blocks {
        let start = at.pos;
        let (dimension, entity) = entity(at)?;
        let kind = kind(at)?;
        if kind.dimension != dimension {
            let what = format!("a {} does not belong to an entity of dimension {dimension}", kind.name);
            return Err(at.fail_at(start, what, DAMAGED));
        }
        let n = at.size("a number of elements")?;
        let n = at.room(n, "elements", at.size_bytes() * (1 + kind.nodes))?;
        read += n;
        let usable = contents.usable(kind, n);
        if usable && n > 0 {
            contents.run(kind, entity, 0).count += n;
            contents.element_nodes.reserve(n * kind.nodes);
        }
        if usable && at.binary() && contents.nodes_known.is_some() {
            at.records(n, 1 + kind.nodes).and_then(|records| contents.push_elements(kind, records))?;
            continue;
        }
        for _ in 0..n {
            let tag = at.size("the number of an element")?;
            if usable {
                contents.element_tags.push(tag);
            }
            for _ in 0..kind.nodes {
                let node = at.size("the number of a node")?;
                if usable {
                    contents.push_node(at, tag, node)?;
                }
            }
        }
    }
    complete(at, read, total, "elements")
}
