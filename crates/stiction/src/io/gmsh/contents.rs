//! What both versions of the format say, in the numbers of the file.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::cursor::{Cursor, DAMAGED, Records};
use super::data::Data;
use super::tags::Tags;
use super::types::{ElementType, Role};
use crate::Error;
use crate::io::labels::Labels;
use crate::mesh::ascending;

/// A physical group: dimension and number.
pub(super) type Physical = (u8, i64);

/// The contents of a file.
#[derive(Default)]
pub(super) struct Contents {
    /// Dimension, number and name of physical groups in the order of the file.
    pub names: Vec<(u8, i64, String)>,
    /// Physical groups of the entity with that dimension and tag (4.1).
    pub entities: HashMap<(u8, i64), Vec<i64>>,
    pub node_tags: Vec<u64>,
    /// Coordinates, not yet scaled.
    pub nodes: Vec<[f64; 3]>,
    pub runs: Vec<Run>,
    pub element_tags: Tags,
    /// Nodes of elements: by their indices where `nodes_known`, otherwise by their tags.
    pub element_nodes: Vec<u32>,
    /// From tags to indices, once elements are read behind the nodes.
    pub nodes_known: Option<Labels>,
    /// Numbers of elements that cannot be used, by type.
    pub refused: BTreeMap<i64, usize>,
    pub data: Vec<Data>,
    /// Length of the file.
    pub bytes: usize,
}

/// Consecutive elements that have everything in common but their nodes.
#[derive(Clone)]
pub(super) struct Run {
    pub kind: ElementType,
    pub entity: i64,
    /// The physical group, 0 for none (2.2 only; in 4.1 the entity knows).
    pub physical: i64,
    /// Elements: those at the places `first..first + count` of `element_tags`.
    pub first: usize,
    pub count: usize,
    /// Where its nodes begin in `element_nodes`.
    pub first_node: usize,
}

impl Contents {
    /// Makes room for elements of one kind: the run that the next tags and nodes belong to.
    pub(super) fn run(&mut self, kind: ElementType, entity: i64, physical: i64) -> &mut Run {
        let fits = |r: &Run| r.kind == kind && r.entity == entity && r.physical == physical;
        if !self.runs.last().is_some_and(fits) {
            let (first, first_node) = (self.element_tags.len(), self.element_nodes.len());
            self.runs.push(Run { kind, entity, physical, first, count: 0, first_node });
        }
        let last = self.runs.len() - 1;
        &mut self.runs[last]
    }

    /// Looks nodes up from now on, if there are any.
    pub(super) fn know_nodes(&mut self) -> Result<(), Error> {
        if !self.node_tags.is_empty() {
            let twice = |tag: u64| Error::new(format!("node {tag}"), "it is given more than once", DAMAGED);
            self.nodes_known = Some(Labels::new(self.node_tags.iter().copied()).map_err(twice)?);
        }
        Ok(())
    }

    /// Adds a node of the element `element`.
    pub(super) fn push_node(&mut self, at: &Cursor, element: u64, tag: u64) -> Result<(), Error> {
        let node = match &self.nodes_known {
            Some(labels) => labels.find(tag).ok_or_else(|| unknown(element, tag))?,
            None => u32::try_from(tag)
                .map_err(|_| at.fail(format!("node {tag} has too large a number"), "write $Nodes before $Elements"))?,
        };
        self.element_nodes.push(node);
        Ok(())
    }

    /// Adds elements of one kind, a number and the nodes each, whose nodes are known.
    pub(super) fn push_elements(&mut self, kind: ElementType, records: Records) -> Result<(), Error> {
        let Some(labels) = &self.nodes_known else { return Ok(()) };
        records.iter().for_each(|record| self.element_tags.push(records.size(record, 0)));
        let first = self.element_nodes.len();
        self.element_nodes.resize(first + records.iter().len() * kind.nodes, 0);
        let nodes = self.element_nodes[first..].par_chunks_exact_mut(kind.nodes);
        let unknown = nodes.zip(records.par_iter()).with_min_len(1024).find_map_first(|(nodes, record)| {
            nodes.iter_mut().zip(1..).find_map(|(node, place)| {
                let tag = records.size(record, place);
                match labels.find(tag) {
                    Some(found) => *node = found,
                    None => return Some(unknown(records.size(record, 0), tag)),
                }
                None
            })
        });
        unknown.map_or(Ok(()), Err)
    }

    /// Notes elements that cannot be used; whether they can.
    pub(super) fn usable(&mut self, kind: ElementType, count: usize) -> bool {
        let usable = !matches!(kind.role, Role::Refused(_));
        if !usable && count > 0 {
            *self.refused.entry(kind.number).or_default() += count;
        }
        usable
    }

    /// The nodes of each element of a run.
    pub(super) fn nodes_of(&self, run: &Run) -> impl Iterator<Item = &[u32]> {
        self.element_nodes[run.first_node..][..run.count * run.kind.nodes].chunks_exact(run.kind.nodes)
    }

    /// The physical groups of a run.
    pub(super) fn physicals(&self, run: &Run) -> Vec<Physical> {
        let dimension = run.kind.dimension;
        // a minus sign means that the group sees the entity from its other side
        let tags =
            self.entities.get(&(dimension, run.entity)).map_or(std::slice::from_ref(&run.physical), Vec::as_slice);
        ascending(tags.iter().filter(|&&t| t != 0).map(|t| (dimension, t.abs())))
    }
}

/// Element `element` names a node that is not there.
pub(super) fn unknown(element: u64, tag: u64) -> Error {
    let what = format!("it names node {tag}, which the file does not hold");
    Error::new(format!("element {element}"), what, DAMAGED)
}
