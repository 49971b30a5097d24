//! What a deck asks to be written: `*NODE FILE`, `*EL FILE`, `*CONTACT FILE` and their `OUTPUT` forms, `*NODE PRINT`,
//! `*EL PRINT`, `*CONTACT PRINT`. No answer depends on them.

use super::reader::Reader;
use crate::io::abaqus::{Card, Input, Kind, Row};

/// The numbers that a deck gives the nodes and cells of its mesh.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DeckLabels {
    /// Of each node.
    pub nodes: Vec<u32>,
    /// Of each cell.
    pub cells: Vec<u32>,
}

/// What is asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Requests {
    /// Whether the file of results is to be binary.
    pub binary: bool,
    /// Keys of the file of results in capitals, each once: U, RF, S, E, CDIS ..
    pub file: Vec<String>,
    /// Tables of text.
    pub prints: Vec<Print>,
    /// Names of the slave and the master surface of each contact pair, in the order of the deck.
    pub pairs: Vec<[String; 2]>,
}

/// What a table is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Printed {
    /// Nodes of the mesh.
    Nodes,
    /// Cells of the mesh.
    Cells,
    /// Contact pairs.
    Contact,
}

/// A table of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Print {
    /// What it is of.
    pub of: Printed,
    /// The set as the card names it; of contact the slave surface.
    pub set: String,
    /// Nodes or cells of the mesh.
    pub places: Vec<u32>,
    /// Keys in capitals.
    pub keys: Vec<String>,
    /// Whether the single values are given, and whether their sum is.
    pub values: [bool; 2],
    /// The steps it is given for, from 1: up to the one before the next that asks for tables of the same kind, which takes the place of
    /// all before it, as in CalculiX.
    pub steps: std::ops::Range<usize>,
}

/// Numbers of nodes and cells; cells of a kind stand in the order of the deck.
pub(super) fn labels(input: &Input) -> DeckLabels {
    let used = input.nodes_of_cells();
    let nodes = (0u32..).zip(used).filter(|(_, used)| *used).map(|(node, _)| input.node_label(node)).collect();
    let cells = (0..input.counts()[1] as u32).filter_map(|element| {
        let element = input.element(element);
        element.cell.map(|(_, cell)| (cell, element.label))
    });
    let mut cells: Vec<(u32, u32)> = cells.collect();
    cells.sort_unstable();
    DeckLabels { nodes, cells: cells.into_iter().map(|(_, label)| label).collect() }
}

/// Reads what is asked for. A set that there is not is left out: nothing depends on it.
pub(super) fn requests(reader: &mut Reader) -> Requests {
    let mut asked = Requests::default();
    let input = reader.input;
    // Numbers of nodes in the mesh, which has those of cells only.
    let mut place = vec![u32::MAX; reader.used.len()];
    let kept = place.iter_mut().zip(&reader.used).filter(|(_, used)| **used);
    kept.zip(0u32..).for_each(|((place, _), number)| *place = number);
    let mut step = 0;
    for card in &input.cards {
        match card.keyword.name.as_str() {
            "STEP" => step += 1,
            "NODEFILE" | "ELFILE" | "CONTACTFILE" => file(&mut asked, card),
            "NODEOUTPUT" | "ELEMENTOUTPUT" | "CONTACTOUTPUT" => {
                asked.binary = true;
                file(&mut asked, card);
            }
            "NODEPRINT" | "ELPRINT" | "CONTACTPRINT" => {
                if let Some(print) = print(reader, card, &place, step.max(1)) {
                    let before = |old: &&mut Print| old.of == print.of && old.steps.start < print.steps.start;
                    let replaced = asked.prints.iter_mut().filter(before);
                    replaced.for_each(|old| old.steps.end = old.steps.end.min(print.steps.start));
                    asked.prints.push(print);
                }
            }
            _ => {}
        }
    }
    asked.pairs =
        reader.pairs.iter().map(|pair| pair.surfaces.each_ref().map(|surface| surface.name.clone())).collect();
    asked
}

fn words(card: &Card) -> Vec<String> {
    let words = |row: Row| row.fields.iter().filter(|word| !word.is_empty()).map(|w| w.to_uppercase()).collect();
    card.rows().flat_map::<Vec<String>, _>(words).collect()
}

fn file(asked: &mut Requests, card: &Card) {
    for key in words(card) {
        if !asked.file.contains(&key) {
            asked.file.push(key);
        }
    }
}

fn print(reader: &mut Reader, card: &Card, place: &[u32], step: usize) -> Option<Print> {
    let (of, kind, parameter) = match card.keyword.name.as_str() {
        "NODEPRINT" => (Printed::Nodes, Kind::Nodes, "NSET"),
        "ELPRINT" => (Printed::Cells, Kind::Elements, "ELSET"),
        _ => (Printed::Contact, Kind::Surface, "SLAVE"),
    };
    let set = card.keyword.get(parameter).unwrap_or_default().to_string();
    let scope = reader.input.scopes(card.part).first().copied().unwrap_or(0);
    let found = match of {
        Printed::Contact => None,
        _ => Some(reader.sets.find(scope, kind, &set)?.ok()?),
    };
    let places = match (of, found) {
        (Printed::Nodes, Some(found)) => {
            found.nodes.iter().map(|&node| place[node as usize]).filter(|&node| node != u32::MAX).collect()
        }
        (Printed::Cells, Some(found)) => {
            let cells = found.elements.iter().filter_map(|&element| reader.input.element(element).cell);
            cells.map(|(_, cell)| cell).collect()
        }
        _ => Vec::new(),
    };
    let values = match card.keyword.get("TOTALS").map(str::to_uppercase).as_deref() {
        Some("YES") => [true, true],
        Some("ONLY") => [false, true],
        _ => [true, false],
    };
    Some(Print { of, set, places, keys: words(card), values, steps: step..usize::MAX })
}
