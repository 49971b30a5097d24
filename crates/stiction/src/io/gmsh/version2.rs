//! Nodes and elements of MSH 2.2.

use super::contents::Contents;
use super::cursor::{Cursor, DAMAGED};
use super::types::{ElementType, element_type};
use crate::Error;

/// A count that is text in binary files too, and ends its line.
fn count(at: &mut Cursor, what: &str) -> Result<u64, Error> {
    let count = at.text_integer(what)?;
    if at.binary() {
        at.line();
    }
    u64::try_from(count).map_err(|_| at.fail(format!("{what} is {count}"), DAMAGED))
}

/// Lines `tag x y z`.
pub(super) fn nodes(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    let n = count(at, "the number of nodes")?;
    let n = at.room(n, "nodes", if at.binary() { 4 + 3 * 8 } else { 4 * 2 })?;
    contents.node_tags.reserve_exact(n);
    contents.nodes.reserve_exact(n);
    for _ in 0..n {
        contents.node_tags.push(at.natural("the number of a node")?);
        contents.nodes.push([at.float("x")?, at.float("y")?, at.float("z")?]);
    }
    Ok(())
}

/// Text: lines `tag type tag-count tags.. nodes..`; binary: `type count tag-count` before `count` times
/// `tag tags.. nodes..`. The first two tags of an element are its physical group and its entity.
pub(super) fn elements(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    let n = count(at, "the number of elements")?;
    // the shortest is a point: two integers in binary, four numbers as text
    let n = at.room(n, "elements", 8)?;
    contents.know_nodes()?;
    let mut read = 0;
    while read < n {
        if at.binary() {
            let kind = kind(at)?;
            let start = at.pos;
            let follow = at.natural("a number of elements")?;
            let tags = at.natural("a number of tags")?;
            let follow = at.room(follow, "elements", 4 * (1 + kind.nodes))?;
            if follow == 0 || follow > n - read {
                return Err(at.fail_at(
                    start,
                    format!("{follow} elements follow where {} are left", n - read),
                    DAMAGED,
                ));
            }
            for _ in 0..follow {
                let tag = at.natural("the number of an element")?;
                element(at, contents, kind, tag, tags)?;
            }
            read += follow;
        } else {
            let tag = at.natural("the number of an element")?;
            let kind = kind(at)?;
            let tags = at.natural("a number of tags")?;
            element(at, contents, kind, tag, tags)?;
            read += 1;
        }
    }
    Ok(())
}

/// The next element type.
pub(super) fn kind(at: &mut Cursor) -> Result<ElementType, Error> {
    let number = at.integer("an element type")?;
    let unknown = || at.fail(format!("element type {number} is not known"), "mesh with linear tetrahedra or hexahedra");
    element_type(number).ok_or_else(unknown)
}

/// The tags and nodes of one element.
fn element(at: &mut Cursor, contents: &mut Contents, kind: ElementType, tag: u64, tags: u64) -> Result<(), Error> {
    let mut known = [0; 2];
    for i in 0..tags {
        let value = at.integer("a tag of an element")?;
        if let Some(slot) = known.get_mut(i as usize) {
            *slot = value;
        }
    }
    let usable = contents.usable(kind, 1);
    if usable {
        contents.run(kind, known[1], known[0]).count += 1;
        contents.element_tags.push(tag);
    }
    for _ in 0..kind.nodes {
        let node = at.natural("the number of a node")?;
        if usable {
            contents.push_node(at, tag, node)?;
        }
    }
    Ok(())
}
