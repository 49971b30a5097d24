//! The runs behind each published table.

use super::compare::{Band, Quantity};
use super::published::Published;
use stiction::friction::Splitting;

/// The paper's four methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    Alg1,
    Alg2,
    Cfs1,
    Cfs2,
}

/// A method with the parameters that the tables vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Variant 1 or 2.
    Alg1 {
        variant: u8,
        splitting: Splitting,
    },
    Alg2 {
        log10_rho: i32,
    },
    Cfs1 {
        splitting: Splitting,
    },
    Cfs2 {
        log10_rho: i32,
    },
}

impl Method {
    pub fn family(self) -> Family {
        match self {
            Method::Alg1 { .. } => Family::Alg1,
            Method::Alg2 { .. } => Family::Alg2,
            Method::Cfs1 { .. } => Family::Cfs1,
            Method::Cfs2 { .. } => Family::Cfs2,
        }
    }
}

impl Method {
    /// Whether the friction is Coulomb's.
    pub fn is_coulomb(self) -> bool {
        matches!(self.family(), Family::Cfs1 | Family::Cfs2)
    }

    /// Whether Step 1 is one quadratic program of all copies.
    pub fn is_one_program(self) -> bool {
        matches!(self.family(), Family::Alg2 | Family::Cfs2)
    }
}

/// What is run: nothing but the setting is left open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Experiment {
    pub partition: u8,
    pub squares: usize,
    pub method: Method,
}

impl Experiment {
    /// `CFS2, rho 1e-8, partition 1, N = 2`.
    pub fn words(self) -> String {
        let method = match self.method {
            Method::Alg1 { variant, splitting } => format!("ALG1, variant {variant}, splitting {}", name(splitting)),
            Method::Alg2 { log10_rho } => format!("ALG2, rho 1e{log10_rho}"),
            Method::Cfs1 { splitting } => format!("CFS1, splitting {}", name(splitting)),
            Method::Cfs2 { log10_rho } => format!("CFS2, rho 1e{log10_rho}"),
        };
        format!("{method}, partition {}, N = {}", self.partition, self.squares)
    }
}

fn name(splitting: Splitting) -> &'static str {
    match splitting {
        Splitting::No => "no",
        Splitting::Partial => "partial",
        Splitting::Complete => "complete",
    }
}

/// A line of a published table, or a part of it for one number of squares.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    pub label: String,
    pub experiment: Experiment,
    /// Published numbers; `None` where the paper stopped the run.
    pub published: Vec<(Quantity, Option<f64>)>,
}

/// The runs of a table and the reference of its column `Eff (%)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub lines: Vec<Line>,
    /// The reference run for each line.
    pub reference: Vec<Option<Experiment>>,
}

/// The runs of a table.
pub fn plan(table: &Published) -> Plan {
    let mut lines = Vec::new();
    for row in 0..table.rows.len() {
        match table.number {
            6 | 7 | 12 => [2, 4, 6].iter().for_each(|&n| lines.push(line_of_squares(table, row, n))),
            _ => lines.push(line(table, row)),
        }
    }
    let reference = lines.iter().map(|line| reference(table.number, line.experiment)).collect();
    Plan { lines, reference }
}

fn line(table: &Published, row: usize) -> Line {
    let number = |column| table.number(row, column);
    let splitting = splitting(table.text(row, "splitting"));
    let log10_rho = number("log10_rho").unwrap_or(0.0) as i32;
    let named = table.text(row, "splitting");
    let (label, partition, squares, method) = match table.number {
        1 | 2 => {
            let variant = if table.text(row, "variant") == "1" { 1 } else { 2 };
            let label = format!("variant {variant}, splitting {named}");
            (label, table.number as u8, 2, Method::Alg1 { variant, splitting })
        }
        3 | 9 => {
            let squares = number("n_squares").unwrap_or(2.0) as usize;
            let complete = Splitting::Complete;
            let alg1 = Method::Alg1 { variant: 2, splitting: complete };
            let method = if table.number == 3 { alg1 } else { Method::Cfs1 { splitting: complete } };
            (format!("N = {squares}"), 1, squares, method)
        }
        4 | 5 => (rho_label(log10_rho), table.number as u8 - 3, 2, Method::Alg2 { log10_rho }),
        8 => {
            let partition = if table.text(row, "partition") == "1" { 1 } else { 2 };
            (format!("partition {partition}, splitting {named}"), partition, 2, Method::Cfs1 { splitting })
        }
        _ => (rho_label(log10_rho), table.number as u8 - 9, 2, Method::Cfs2 { log10_rho }),
    };
    let columns = [
        ("iter", Quantity::Iterations),
        ("qpps", Quantity::QpProblems),
        ("cg_steps", Quantity::CgSteps),
        ("prec", Quantity::Precision),
        ("cont", Quantity::FixedPoint),
        ("rel_error", Quantity::Change),
        ("eff_percent", Quantity::Efficiency),
    ];
    let has = |(column, _): &(&str, Quantity)| table.columns.contains(column);
    let published = columns.into_iter().filter(has).map(|(column, quantity)| (quantity, number(column))).collect();
    Line { label, experiment: Experiment { partition, squares, method }, published }
}

/// Tables 6, 7 and 12: columns for each number of squares.
fn line_of_squares(table: &Published, row: usize, squares: usize) -> Line {
    let (label, partition, method) = if table.number == 12 {
        let partition = row as u8 + 1;
        (format!("partition {partition}, N = {squares}"), partition, Method::Cfs2 { log10_rho: -8 })
    } else {
        let log10_rho = table.number(row, "log10_rho").unwrap_or(0.0) as i32;
        let partition = table.number as u8 - 5;
        (format!("{}, N = {squares}", rho_label(log10_rho)), partition, Method::Alg2 { log10_rho })
    };
    let published = vec![
        (Quantity::Iterations, table.number(row, &format!("iter_n{squares}"))),
        (Quantity::CgSteps, table.number(row, &format!("cg_n{squares}"))),
    ];
    Line { label, experiment: Experiment { partition, squares, method }, published }
}

fn rho_label(log10_rho: i32) -> String {
    format!("log rho = {log10_rho}")
}

fn splitting(name: &str) -> Splitting {
    match name {
        "partial" => Splitting::Partial,
        "complete" => Splitting::Complete,
        _ => Splitting::No,
    }
}

/// The run to whose operations the column `Eff (%)` of a table refers.
fn reference(table: usize, of: Experiment) -> Option<Experiment> {
    let at = |squares, method| Some(Experiment { partition: of.partition, squares, method });
    match table {
        1 | 2 | 4 | 5 => at(2, Method::Alg1 { variant: 1, splitting: Splitting::No }),
        3 | 9 => at(2, of.method),
        8 | 10 | 11 => at(2, Method::Cfs1 { splitting: Splitting::No }),
        _ => None,
    }
}

/// The band in which a number of ours is expected (stated before the program's own numbers were known, from two
/// independent prototypes).
pub fn band(table: usize, line: &Line, quantity: Quantity) -> Band {
    use Quantity::{CgSteps, Change, Iterations};
    let Experiment { squares, method, .. } = line.experiment;
    let log10_rho = match method {
        Method::Alg2 { log10_rho } | Method::Cfs2 { log10_rho } => log10_rho,
        _ => 0,
    };
    let split = match method {
        Method::Alg1 { splitting, .. } | Method::Cfs1 { splitting } => splitting,
        _ => Splitting::No,
    };
    let count = |steps: f64, relative: f64, from: f64| Band::Steps { steps, relative, from };
    match (table, quantity) {
        (1 | 3, Iterations) => Band::Relative(0.1),
        (2, Iterations) if split != Splitting::Complete => Band::Relative(0.1),
        (3, Change) => Band::Relative(0.1),
        (4 | 5, Iterations) if log10_rho <= -2 => count(1.0, 0.1, 0.0),
        (4 | 5, CgSteps) if (-9..=-6).contains(&log10_rho) => Band::Relative(0.3),
        (6 | 7, Iterations) if squares > 2 && (-8..=-7).contains(&log10_rho) => count(2.0, 0.0, 0.0),
        (6 | 7, CgSteps) if squares > 2 && (-8..=-7).contains(&log10_rho) => Band::Factor(2.0),
        (8, Iterations) if split == Splitting::No => Band::Relative(0.05),
        (9, Change) => Band::Relative(0.15),
        (10 | 11, Iterations) if (-10..=-3).contains(&log10_rho) => count(1.0, 0.1, 20.0),
        (12, Iterations) => count(2.0, 0.0, 0.0),
        (12, CgSteps) => Band::Factor(2.0),
        _ => Band::None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::published::published;
    use super::*;

    fn lines(table: usize) -> Vec<Line> {
        plan(&published(table).unwrap()).lines
    }

    #[test]
    fn every_published_number_has_its_run() {
        for number in 1..=12 {
            let table = published(number).unwrap();
            let printed = table.rows.iter().flatten().filter(|cell| !cell.is_empty()).count();
            // What names a run is not compared: one or two columns.
            let names = table
                .columns
                .iter()
                .filter(|c| matches!(**c, "variant" | "splitting" | "n_squares" | "log10_rho" | "partition"))
                .count();
            let compared = lines(number).iter().flat_map(|l| &l.published).filter(|p| p.1.is_some()).count();
            assert_eq!(printed - names * table.rows.len(), compared, "table {number}");
        }
    }

    #[test]
    fn runs_and_bands_follow_the_tables() {
        let first = &lines(2)[5];
        assert_eq!(first.experiment.partition, 2);
        assert_eq!(first.experiment.method, Method::Alg1 { variant: 2, splitting: Splitting::Complete });
        assert_eq!(band(2, first, Quantity::Iterations), Band::None);
        let star = lines(7).into_iter().find(|l| l.label == "log rho = -8, N = 6").unwrap();
        assert_eq!(star.published[1], (Quantity::CgSteps, Some(1375.0)));
        assert_eq!(band(7, &star, Quantity::CgSteps), Band::Factor(2.0));
        assert_eq!(
            lines(12)[4].experiment,
            Experiment { partition: 2, squares: 4, method: Method::Cfs2 { log10_rho: -8 } }
        );
        let eff = plan(&published(11).unwrap());
        assert!(eff.reference.iter().all(|r| r.unwrap().method == Method::Cfs1 { splitting: Splitting::No }));
    }
}
