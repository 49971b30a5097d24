//! From parts to one model: instances are placed, labels become indices.

use super::deck::{Block, Deck, Motion, Part};
use super::elements::Role;
use super::keyword::DAMAGED;
use super::sweep::Swept;
use crate::Error;
use crate::io::labels::Labels;
use crate::mesh::CellKind;

/// Memory in bytes that placing and resolving sets may take: this many times the input, and so much besides. Parts
/// that are placed often and sets made of sets can say a lot in few words.
pub(super) const TIMES_INPUT: usize = 8;
pub(super) const BESIDES: usize = 64 << 20;

/// All nodes and elements, numbered through.
#[derive(Default)]
pub(super) struct Model {
    pub nodes: Vec<[f64; 3]>,
    pub node_labels: Vec<u32>,
    pub blocks: Vec<Placed>,
    pub scopes: Vec<Scope>,
    /// Cells of each of `CellKind::ALL`: they are numbered kind by kind.
    counts: [usize; CellKind::ALL.len()],
    /// How plane elements became solids, if they did.
    pub swept: Option<Swept>,
}

/// A block of elements, their nodes by index.
pub(super) struct Placed {
    pub role: Role,
    pub type_name: String,
    pub labels: Vec<u32>,
    pub nodes: Vec<u32>,
    /// Number of its first element among all.
    pub first: usize,
    /// Number of its first element among the cells of its kind.
    pub first_cell: usize,
}

/// An instance, or what stands in no part: where its labels hold.
pub(super) struct Scope {
    /// Empty for what stands in no part.
    pub name: String,
    pub part: usize,
    nodes: Labels,
    first_node: usize,
    elements: Labels,
    first_element: usize,
}

impl Scope {
    /// Nodes or elements by their labels, as numbers among all.
    pub(super) fn find(&self, label: u32, nodes: bool) -> Option<u32> {
        let (labels, first) = self.of(nodes);
        labels.find(label.into()).map(|i| i + first as u32)
    }

    /// The lowest label not below `label` that a node or element has.
    pub(super) fn next(&self, label: u32, nodes: bool) -> Option<u32> {
        self.of(nodes).0.next(label.into()).and_then(|l| u32::try_from(l).ok())
    }

    fn of(&self, nodes: bool) -> (&Labels, usize) {
        if nodes { (&self.nodes, self.first_node) } else { (&self.elements, self.first_element) }
    }
}

/// Places all instances; what stands in no part comes first. Nodes and elements move out of their parts.
pub(super) fn place(deck: &mut Deck) -> Result<Model, Error> {
    let mut places: Vec<(String, usize, Motion)> = vec![(String::new(), 0, Motion::default())];
    if deck.instances.is_empty() {
        places.extend(deck.parts.iter().enumerate().skip(1).map(|(i, p)| (p.name.clone(), i, Motion::default())));
    } else {
        places.extend(deck.instances.iter().map(|instance| (instance.name.clone(), instance.part, instance.motion)));
    }
    refuse_flood(deck, &places)?;
    let mut last_use = vec![0; deck.parts.len()];
    places.iter().enumerate().for_each(|(i, place)| last_use[place.1] = i);
    let mut model = Model::default();
    for (i, (name, number, motion)) in places.into_iter().enumerate() {
        let part = &mut deck.parts[number];
        // the last copy is the original
        let copy = last_use[number] != i;
        let at = |e: Error| if name.is_empty() { e } else { e.at(&format!("instance {name}")) };
        one(&mut model, part, number, name.clone(), motion, copy).map_err(at)?;
    }
    model.recount();
    Ok(model)
}

fn refuse_flood(deck: &Deck, places: &[(String, usize, Motion)]) -> Result<(), Error> {
    let bytes = |part: &Part| {
        part.nodes.len() * 28 + part.blocks.iter().map(|b| 4 * (b.labels.len() + b.nodes.len())).sum::<usize>()
    };
    let sizes: Vec<usize> = deck.parts.iter().map(bytes).collect();
    let needed: f64 = places.iter().map(|place| sizes[place.1] as f64).sum();
    if needed <= (TIMES_INPUT * deck.bytes + BESIDES) as f64 {
        return Ok(());
    }
    let what = format!("its {} instances need {:.1} GB, far more than the input", places.len() - 1, needed / 1e9);
    Err(Error::new("", what, "write the assembled mesh without instances"))
}

fn one(
    model: &mut Model,
    part: &mut Part,
    number: usize,
    name: String,
    motion: Motion,
    copy: bool,
) -> Result<(), Error> {
    let first_node = model.nodes.len();
    let first_element = model.blocks.last().map_or(0, |block| block.first + block.labels.len());
    let twice = |what: &str| {
        let what = what.to_string();
        move |label: u64| Error::new(format!("{what} {label}"), "it is given more than once", DAMAGED)
    };
    let count: usize = part.nodes.len() + first_node;
    if count >= u32::MAX as usize {
        return Err(Error::new("", format!("{count} nodes are more than can be numbered"), "use fewer nodes"));
    }
    let nodes = Labels::new(part.node_labels.iter().map(|&l| u64::from(l))).map_err(twice("node"))?;

    let (first_block, mut next) = (model.blocks.len(), first_element);
    for block in if copy { part.blocks.clone() } else { std::mem::take(&mut part.blocks) } {
        let placed = resolve(block, &nodes, first_node, next, model)?;
        next += placed.labels.len();
        model.blocks.push(placed);
    }
    let labels: Vec<u32> = model.blocks[first_block..].iter().flat_map(|block| &block.labels).copied().collect();
    let elements = Labels::new(labels.iter().map(|&l| u64::from(l))).map_err(twice("element"))?;
    drop(labels);

    let (mut points, mut labels) = if copy {
        (part.nodes.clone(), part.node_labels.clone())
    } else {
        (std::mem::take(&mut part.nodes), std::mem::take(&mut part.node_labels))
    };
    if number != 0 {
        points.iter_mut().for_each(|x| *x = motion.apply(*x));
    }
    if model.nodes.is_empty() {
        (model.nodes, model.node_labels) = (points, labels);
    } else {
        model.nodes.append(&mut points);
        model.node_labels.append(&mut labels);
    }
    model.scopes.push(Scope { name, part: number, nodes, first_node, elements, first_element });
    Ok(())
}

/// The block with indices of nodes instead of labels.
fn resolve(mut block: Block, nodes: &Labels, first_node: usize, first: usize, model: &Model) -> Result<Placed, Error> {
    let k = block.role.nodes();
    for (i, node) in block.nodes.iter_mut().enumerate() {
        match nodes.find(u64::from(*node)) {
            Some(index) => *node = index + first_node as u32,
            None => {
                let place = format!("element {} (*ELEMENT of {})", block.labels[i / k], block.place);
                return Err(Error::new(place, format!("it names node {node}, which the file does not hold"), DAMAGED));
            }
        }
    }
    let same = |b: &&Placed| b.role == block.role;
    let first_cell = model.blocks.iter().rev().find(same).map_or(0, |b| b.first_cell + b.labels.len());
    let Block { role, type_name, labels, nodes, .. } = block;
    Ok(Placed { role, type_name, labels, nodes, first, first_cell })
}

impl Model {
    /// The block of an element and its number in it.
    pub(super) fn element(&self, element: u32) -> (&Placed, usize) {
        let element = element as usize;
        let block = &self.blocks[self.blocks.partition_point(|block| block.first <= element) - 1];
        (block, element - block.first)
    }

    /// Nodes of an element.
    pub(super) fn element_nodes(&self, element: u32) -> &[u32] {
        let (block, i) = self.element(element);
        let k = block.role.nodes();
        &block.nodes[i * k..(i + 1) * k]
    }

    /// The number an element has among the cells of the mesh, which are listed by kind.
    pub(super) fn cell(&self, element: u32) -> Option<u32> {
        let (block, i) = self.element(element);
        let Role::Cell(kind) = block.role else { return None };
        let before: usize =
            CellKind::ALL.iter().zip(&self.counts).take_while(|(k, _)| **k != kind).map(|(_, n)| n).sum();
        Some((before + block.first_cell + i) as u32)
    }

    /// Counts the cells of each kind, by which they are numbered.
    pub(super) fn recount(&mut self) {
        self.counts = CellKind::ALL.map(|kind| self.count(kind));
    }

    /// Cells of one kind.
    pub(super) fn count(&self, kind: CellKind) -> usize {
        self.blocks.iter().filter(|b| b.role == Role::Cell(kind)).map(|b| b.labels.len()).sum()
    }
}
