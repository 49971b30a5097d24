//! `*EQUATION`: linear equations between displacements.

use super::history::number;
use super::reader::Reader;
use super::supports::direction;
use super::text::{of_row, quoted, triple};
use super::write::Writer;
use crate::Error;
use crate::io::abaqus::{Card, Row};

/// Terms of an equation at most: the program the decks are written for has no more on a line of its file.
const MOST_TERMS: usize = 100_000;

/// Node, component and factor.
type Term = (u32, usize, f64);

/// Terms whose sum is zero.
pub(super) struct EquationCard<'a> {
    row: Row<'a>,
    terms: Vec<Term>,
}

impl<'a> Reader<'a> {
    pub(super) fn equation(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&[])?;
        if self.in_step {
            return Err(card.error("*EQUATION stands in a step", "move it above the steps: it holds in all of them"));
        }
        let mut missing = 0;
        for row in card.rows() {
            if missing == 0 {
                let count = row.whole(0).and_then(|n| usize::try_from(n).ok()).filter(|n| (1..=MOST_TERMS).contains(n));
                row.ends(1)?;
                let remedy = "write how many terms follow, then node, direction and factor of each";
                missing = count.ok_or_else(|| row.error("this is no number of terms", remedy))?;
                self.equations.push(EquationCard { row, terms: Vec::new() });
                continue;
            }
            for i in (0..row.fields.len()).step_by(3).filter(|&i| row.word(i).is_some()) {
                if missing == 0 {
                    return Err(row.error("this equation has more terms than it says", "correct their number"));
                }
                let (component, factor) = (direction(&row, i + 1)?, row.value(i + 2, "the factor")?);
                if component > 3 {
                    let what =
                        format!("direction {component} is a rotation or another quantity, which solids have not");
                    return Err(row.error(what, "give directions 1, 2 and 3"));
                }
                let nodes = self.nodes(&row, i)?;
                let [node] = nodes[..] else {
                    let what = format!("{} stands for {} nodes", row.word(i).unwrap_or_default(), nodes.len());
                    return Err(row.error(what, "write an equation for each node"));
                };
                if !self.used[node as usize] {
                    let what = format!("node {} belongs to no solid element", self.input.node_label(node));
                    return Err(row.error(what, "let equations hold nodes of the body"));
                }
                if let Some(equation) = self.equations.last_mut().filter(|_| factor != 0.0) {
                    equation.terms.push((node, component - 1, factor));
                }
                missing -= 1;
            }
        }
        if missing > 0 {
            return Err(
                card.error(format!("{missing} terms are missing at the end"), "write them, or correct the number")
            );
        }
        Ok(())
    }
}

impl EquationCard<'_> {
    /// The same equation between the copies of its nodes, if all have one and not all are their own.
    pub(super) fn copied(&self, copy: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        let terms = self.terms.iter().map(|&(node, c, factor)| Some((copy(node)?, c, factor)));
        let terms: Vec<Term> = terms.collect::<Option<_>>()?;
        (terms != self.terms).then(|| EquationCard { row: self.row.clone(), terms })
    }
}

impl Writer<'_, '_> {
    pub(super) fn equations(&mut self) -> Result<(), Error> {
        let equations = std::mem::take(&mut self.reader.equations);
        for equation in equations.iter().filter(|equation| !equation.terms.is_empty()) {
            self.out.table("[[equation]]", of_row(&equation.row));
            let mut terms = Vec::new();
            for &(node, component, factor) in &equation.terms {
                let group = self.named(&[node], &format!("node {}", self.reader.input.node_label(node)));
                let along = self.reader.unit(node as usize, component, equation.row.card)?;
                let along = match self.reader.is_turned(node) {
                    true => triple(along),
                    false => quoted(["x", "y", "z"][component]),
                };
                terms.push(format!("{{ on = {}, along = {along}, factor = {} }}", quoted(&group), number(factor)));
            }
            self.out.line("terms", &format!("[{}]", terms.join(", ")));
        }
        Ok(())
    }
}
