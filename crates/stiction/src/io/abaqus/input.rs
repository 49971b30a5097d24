//! A whole input: its mesh and its sets by name and number, and the cards that pose a problem on it.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::cards::Card;
use super::deck::{Deck, Kind};
use super::elements::Role;
use super::place::{Model, place};
use super::sets::Resolver;
use super::sweep::{Swept, sweep};
use super::{Include, assemble, included, read};
use crate::Error;
use crate::mesh::{CellKind, Mesh, MeshArrays, MeshNotes, RawGroup};

/// A deck whose parts are placed.
pub(in crate::io) struct Input {
    deck: Deck,
    model: Model,
    pub cards: Vec<Card>,
}

/// An element among all of an input.
pub(in crate::io) struct Element<'a> {
    /// Its number in the file.
    pub label: u32,
    /// As the file calls its type, in capitals.
    pub type_name: &'a str,
    /// What it is if it belongs to the body, and its number among the cells of the mesh.
    pub cell: Option<(CellKind, u32)>,
}

impl Input {
    /// Reads the file at `path`; includes as [`super::read`] does.
    pub(in crate::io) fn read(path: &Path, include: &[PathBuf]) -> Result<Input, Error> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let include = |file: &str| included(folder, include, file);
        let bytes = crate::io::mesh_bytes(path)?;
        Input::of(read::deck(Cow::Owned(bytes), &include, true)?)
    }

    /// Reads what stands in `bytes`.
    pub(in crate::io) fn parse(bytes: &[u8], include: Include) -> Result<Input, Error> {
        Input::of(read::deck(Cow::Borrowed(bytes), include, true)?)
    }

    fn of(mut deck: Deck) -> Result<Input, Error> {
        let mut model = place(&mut deck)?;
        let cards = deck.cards.take().unwrap_or_default();
        model.swept = sweep(&mut model, &cards)?;
        Ok(Input { deck, model, cards })
    }

    /// How its plane elements became solids, if they did.
    pub(in crate::io) fn swept(&self) -> Option<&Swept> {
        self.model.swept.as_ref()
    }

    /// What looks up its sets.
    pub(in crate::io) fn sets(&self) -> Resolver<'_> {
        Resolver::new(&self.deck, &self.model)
    }

    /// Where the numbers and names of a part hold: in all its instances.
    pub(in crate::io) fn scopes(&self, part: usize) -> Vec<usize> {
        (0..self.model.scopes.len()).filter(|&scope| self.model.scopes[scope].part == part).collect()
    }

    /// How many nodes and elements there are.
    pub(in crate::io) fn counts(&self) -> [usize; 2] {
        let elements = self.model.blocks.last().map_or(0, |block| block.first + block.labels.len());
        [self.model.nodes.len(), elements]
    }

    /// The number that the file gives a node.
    pub(in crate::io) fn node_label(&self, node: u32) -> u32 {
        self.model.node_labels.get(node as usize).copied().unwrap_or(0)
    }

    /// Coordinates of a node.
    pub(in crate::io) fn node(&self, node: u32) -> [f64; 3] {
        self.model.nodes.get(node as usize).copied().unwrap_or([f64::NAN; 3])
    }

    /// An element.
    pub(in crate::io) fn element(&self, element: u32) -> Element<'_> {
        let (block, i) = self.model.element(element);
        let cell = match block.role {
            Role::Cell(kind) => self.model.cell(element).map(|cell| (kind, cell)),
            _ => None,
        };
        Element { label: block.labels[i], type_name: &block.type_name, cell }
    }

    /// The nodes of an element.
    pub(in crate::io) fn nodes_of(&self, element: u32) -> Vec<u32> {
        self.model.element_nodes(element).to_vec()
    }

    /// Whether each node belongs to a cell.
    pub(in crate::io) fn nodes_of_cells(&self) -> Vec<bool> {
        let mut used = vec![false; self.model.nodes.len()];
        let cells = self.model.blocks.iter().filter(|block| matches!(block.role, Role::Cell(_)));
        cells.flat_map(|block| &block.nodes).for_each(|&node| used[node as usize] = true);
        used
    }

    /// Types of elements in the order of the file, each once, and whether they are cells.
    pub(in crate::io) fn types(&self) -> Vec<(&str, bool)> {
        let mut types: Vec<(&str, bool)> = Vec::new();
        for block in &self.model.blocks {
            let entry = (block.type_name.as_str(), matches!(block.role, Role::Cell(_)));
            if !types.contains(&entry) {
                types.push(entry);
            }
        }
        types
    }

    /// The corners of a face of a cell, counted from 0; `None` if there is no such face.
    pub(in crate::io) fn corners(&self, element: u32, side: u8) -> Option<[u32; 4]> {
        assemble::corners(&self.model, (element, side))
    }

    /// The mesh with these groups and arrays, whose nodes and cells have the numbers of this input.
    pub(in crate::io) fn build(self, groups: Vec<RawGroup>, arrays: MeshArrays) -> Result<(Mesh, MeshNotes), Error> {
        let Input { deck, model, .. } = self;
        drop(deck);
        assemble::finish(model, groups, arrays, Vec::new(), 1.0)
    }
}

/// What a set is called in messages.
pub(in crate::io) fn kind_name(kind: Kind) -> &'static str {
    ["node set", "element set", "surface"][kind as usize]
}
