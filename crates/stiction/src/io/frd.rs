//! Writer of CalculiX's result files (`.frd`), as text and as binary.
//!
//! Format: "CalculiX GraphiX User's Manual", chapters "Result Format" and "Element Types" (K. Wittig). Text has the long format
//! (numbers of ten digits); binary has coordinates in double and results in single precision, integers of four bytes, all little
//! endian.

use std::io::{self, Write};

use crate::mesh::{CellKind, Mesh};

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// Text with six digits.
    #[default]
    Ascii,
    /// Bytes.
    Binary,
}

/// A mesh as a file of results has it.
#[derive(Debug, Clone, Copy)]
pub struct FrdMesh<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The number of each node, > 0.
    pub nodes: &'a [u32],
    /// The number of each cell, > 0.
    pub cells: &'a [u32],
    /// The material of each cell, counted from 0.
    pub materials: &'a [u32],
}

/// What results at nodes mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// `DISP`: displacement, length.
    Displacement,
    /// `STRESS`: xx, yy, zz, xy, yz, zx.
    Stress,
    /// `TOSTRAIN`: the same of the whole strain, shear as the component of the tensor.
    Strain,
    /// `FORC`: forces of supports and loads on the body.
    Force,
    /// `CONTACT`: opening, slip along two axes, pressure, shear along the same axes.
    Contact,
}

/// A time at which results are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrdTime {
    /// Since the start of the first step.
    pub time: f64,
    /// Number of the step, from 1.
    pub step: usize,
    /// Number of the increment in its step, from 1.
    pub increment: usize,
    /// Number of the increment since the start, from 1.
    pub count: usize,
}

impl Quantity {
    /// The name of its block, and those of its components with what places them in a vector or a tensor.
    fn entities(self) -> (&'static str, &'static [(&'static str, usize, usize)]) {
        const TENSOR: [(usize, usize); 6] = [(1, 1), (2, 2), (3, 3), (1, 2), (2, 3), (3, 1)];
        macro_rules! tensor {
            ($($name:literal),*) => {{
                const NAMES: [&str; 6] = [$($name),*];
                const ALL: [(&str, usize, usize); 6] = {
                    let (mut all, mut i) = ([("", 0, 0); 6], 0);
                    while i < 6 {
                        all[i] = (NAMES[i], TENSOR[i].0, TENSOR[i].1);
                        i += 1;
                    }
                    all
                };
                &ALL
            }};
        }
        match self {
            Quantity::Displacement => ("DISP", &[("D1", 1, 0), ("D2", 2, 0), ("D3", 3, 0)]),
            Quantity::Force => ("FORC", &[("F1", 1, 0), ("F2", 2, 0), ("F3", 3, 0)]),
            Quantity::Stress => ("STRESS", tensor!("SXX", "SYY", "SZZ", "SXY", "SYZ", "SZX")),
            Quantity::Strain => ("TOSTRAIN", tensor!("EXX", "EYY", "EZZ", "EXY", "EYZ", "EZX")),
            Quantity::Contact => ("CONTACT", tensor!("COPEN", "CSLIP1", "CSLIP2", "CPRESS", "CSHEAR1", "CSHEAR2")),
        }
    }
}

/// Number of a kind of cell in this format.
fn type_number(kind: CellKind) -> u32 {
    match kind {
        CellKind::Hex8 => 1,
        CellKind::Wedge6 => 2,
        CellKind::Tet4 => 3,
        CellKind::Hex20 => 4,
        CellKind::Wedge15 => 5,
        CellKind::Tet10 => 6,
    }
}

/// Places of the nodes of a kind of cell in this format: in hexahedra and wedges the middles of the edges between bottom and top stand before those
/// of the top.
fn order(kind: CellKind) -> impl Iterator<Item = usize> {
    let place = move |i: usize| match (kind, i) {
        (CellKind::Hex20, 12..16) => i + 4,
        (CellKind::Hex20, 16..20) => i - 4,
        (CellKind::Wedge15, 9..12) => i + 3,
        (CellKind::Wedge15, 12..15) => i - 3,
        _ => i,
    };
    (0..kind.nodes()).map(place)
}

/// Characters that a line of the heading holds.
const HEADING: usize = 66;

/// A line of the heading: a name and what it is.
pub fn heading(name: &str, text: &str) -> String {
    format!("{name:<18}{text}")
}

/// Writes what stands before all results: lines of a heading, nodes and elements.
///
/// # Errors
/// If it cannot be written.
pub fn write_mesh(out: &mut impl Write, of: &FrdMesh, form: Form, heading: &[String]) -> io::Result<()> {
    line(out, "    1C")?;
    for text in heading {
        let text: String = text.chars().filter(|c| !c.is_control()).take(HEADING).collect();
        line(out, &format!("    1U{text}"))?;
    }
    let (nodes, cells) = (of.mesh.nodes.len(), of.mesh.cell_count());
    line(out, &format!("    2C{:18}{nodes:12}{:37}{}", "", "", if form == Form::Ascii { 1 } else { 3 }))?;
    for (number, x) in of.nodes.iter().zip(&of.mesh.nodes) {
        match form {
            Form::Ascii => row(out, *number, x.iter().copied())?,
            Form::Binary => {
                out.write_all(&(*number as i32).to_le_bytes())?;
                x.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
            }
        }
    }
    end(out, form)?;
    line(out, &format!("    3C{:18}{cells:12}{:37}{}", "", "", format_number(form)))?;
    let mut all = of.cells.iter().zip(of.materials);
    for block in &of.mesh.cells {
        let (width, kind) = (block.kind.nodes(), type_number(block.kind));
        for (nodes, (number, material)) in block.nodes.chunks_exact(width).zip(&mut all) {
            let nodes = order(block.kind).map(|place| of.nodes[nodes[place] as usize]);
            let head = [*number, kind, 0, material + 1];
            match form {
                Form::Binary => {
                    let mut all = head.into_iter().chain(nodes);
                    all.try_for_each(|n| out.write_all(&(n as i32).to_le_bytes()))?;
                }
                Form::Ascii => {
                    let [number, kind, group, material] = head;
                    line(out, &format!(" -1{number:10}{kind:5}{group:5}{material:5}"))?;
                    let nodes: Vec<String> = nodes.map(|node| format!("{node:10}")).collect();
                    nodes.chunks(10).try_for_each(|ten| line(out, &format!(" -2{}", ten.concat())))?;
                }
            }
        }
    }
    end(out, form)
}

/// Writes results at the nodes, a line of `values` for each: as many as the quantity has components. `number` counts the blocks of
/// results from 1.
///
/// # Errors
/// If it cannot be written.
pub fn write_results<const N: usize>(
    out: &mut impl Write,
    of: &FrdMesh,
    form: Form,
    (quantity, number): (Quantity, usize),
    at: &FrdTime,
    values: &[[f64; N]],
) -> io::Result<()> {
    let FrdTime { time, step, increment, count } = *at;
    line(out, &format!("    1PSTEP{number:26}{increment:12}{step:12}{:10}", ""))?;
    let (nodes, format) = (of.nodes.len(), format_number(form));
    let time = time_field(time);
    line(out, &format!("  100CL{:5}{time}{nodes:12}{:20}{:2}{count:5}{:10}{format:2}", 100 + count, "", 0, ""))?;
    let (name, entities) = quantity.entities();
    let (vector, kind) = if entities.len() == 3 { (true, 2) } else { (false, 4) };
    line(out, &format!(" -4  {name:<8}{:5}{:5}", entities.len() + usize::from(vector), 1))?;
    for (entity, first, second) in entities {
        line(out, &format!(" -5  {entity:<8}{:5}{kind:5}{first:5}{second:5}", 1))?;
    }
    if vector {
        line(out, &format!(" -5  {:<8}{:5}{kind:5}{:5}{:5}{:5}ALL", "ALL", 1, 0, 0, 1))?;
    }
    for (number, values) in of.nodes.iter().zip(values) {
        match form {
            Form::Ascii => row(out, *number, values.iter().copied())?,
            Form::Binary => {
                out.write_all(&(*number as i32).to_le_bytes())?;
                values.iter().try_for_each(|value| out.write_all(&(*value as f32).to_le_bytes()))?;
            }
        }
    }
    end(out, form)
}

/// Writes the end of the file.
///
/// # Errors
/// If it cannot be written.
pub fn write_end(out: &mut impl Write) -> io::Result<()> {
    line(out, " 9999")
}

fn format_number(form: Form) -> u32 {
    match form {
        Form::Ascii => 1,
        Form::Binary => 2,
    }
}

fn line(out: &mut impl Write, text: &str) -> io::Result<()> {
    out.write_all(text.as_bytes())?;
    out.write_all(b"\n")
}

fn row(out: &mut impl Write, number: u32, values: impl Iterator<Item = f64>) -> io::Result<()> {
    let mut text = format!(" -1{number:10}");
    values.for_each(|value| text += &scientific(value, 12, 5));
    line(out, &text)
}

/// Blocks of text end with a line, those of bytes by their length.
fn end(out: &mut impl Write, form: Form) -> io::Result<()> {
    if form == Form::Ascii { line(out, " -3") } else { Ok(()) }
}

/// A number in `width` columns with an exponent of two digits. Smaller ones are zero, larger ones the largest that fits.
pub fn scientific(value: f64, width: usize, digits: usize) -> String {
    const LARGEST: f64 = 9.999e99;
    if value.is_nan() {
        return format!("{:>width$}", "NaN");
    }
    let value = if value.abs() < 1e-99 { 0.0 } else { value.clamp(-LARGEST, LARGEST) };
    let text = format!("{value:.digits$E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>width$}", format!("{mantissa}E{sign}{:02}", exponent.abs()))
}

/// A time in twelve columns with ten digits.
fn time_field(time: f64) -> String {
    let decimals = 9 - (time.abs().max(1.0).log10().floor() as i64).clamp(0, 9);
    let text = format!("{time:12.*}", decimals as usize);
    if text.len() <= 12 && (time == 0.0 || time.abs() >= 1e-4) { text } else { scientific(time, 12, 5) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Block, BlockElement, block};

    fn a_block(element: BlockElement) -> Mesh {
        block(&Block { size: [1.0; 3], cells: [1; 3], origin: [0.0; 3], grading: [1.0; 3], element }).unwrap()
    }

    fn written(element: BlockElement, form: Form) -> Vec<u8> {
        let mesh = a_block(element);
        let nodes: Vec<u32> = (0..mesh.nodes.len() as u32).map(|i| 10 * i + 7).collect();
        let cells: Vec<u32> = (0..mesh.cell_count() as u32).map(|i| i + 100).collect();
        let materials = vec![0; cells.len()];
        let of = FrdMesh { mesh: &mesh, nodes: &nodes, cells: &cells, materials: &materials };
        let at = FrdTime { time: 0.5, step: 2, increment: 3, count: 4 };
        let values: Vec<[f64; 3]> = mesh.nodes.iter().map(|x| x.map(|x| -1.25e-3 * x)).collect();
        let mut out = Vec::new();
        write_mesh(&mut out, &of, form, &[heading("PGM", "stiction")]).unwrap();
        write_results(&mut out, &of, form, (Quantity::Displacement, 5), &at, &values).unwrap();
        write_end(&mut out).unwrap();
        out
    }

    /// Lines by the columns of the manual.
    #[test]
    fn lines_have_the_columns_of_the_manual() {
        let text = String::from_utf8(written(BlockElement::Hex20, Form::Ascii)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(&lines[..2], ["    1C", "    1UPGM               stiction"]);
        let head = "    2C                            20                                     1";
        assert_eq!((lines[2], head.len()), (head, 74));
        assert_eq!(lines[3], " -1         7 0.00000E+00 0.00000E+00 0.00000E+00");
        let at = |line: &str| lines.iter().position(|other| *other == line).unwrap_or_else(|| panic!("{line}\n{text}"));
        let elements = at("    3C                             1                                     1");
        assert_eq!(lines[elements + 1], " -1       100    4    0    1");
        // Twenty nodes in two lines of ten.
        assert!(lines[elements + 2].len() == 103 && lines[elements + 3].len() == 103 && lines[elements + 4] == " -3");
        let step = at("    1PSTEP                         5           3           2          ");
        assert_eq!(lines[step + 1], "  100CL  104 0.500000000          20                     0    4           1");
        assert_eq!(lines[step + 2], " -4  DISP        4    1");
        assert_eq!(lines[step + 3], " -5  D1          1    2    1    0");
        assert_eq!(lines[step + 6], " -5  ALL         1    2    0    0    1ALL");
        assert_eq!(&lines[lines.len() - 2..], [" -3", " 9999"]);
    }

    /// The middle of an edge lies between the corners that the manual names: bottom, then upright, then top.
    #[test]
    fn middles_of_edges_stand_in_the_order_of_the_manual() {
        const HEX: [[usize; 2]; 12] =
            [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 5], [2, 6], [3, 7], [4, 5], [5, 6], [6, 7], [7, 4]];
        const TET: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
        for (element, corners, edges) in [(BlockElement::Hex20, 8, &HEX[..]), (BlockElement::Tet10Six, 4, &TET[..])] {
            let mesh = a_block(element);
            let cells = &mesh.cells[0];
            let nodes = &cells.nodes[..cells.kind.nodes()];
            let x: Vec<[f64; 3]> = order(cells.kind).map(|place| mesh.nodes[nodes[place] as usize]).collect();
            for (i, &[a, b]) in edges.iter().enumerate() {
                assert_eq!(x[corners + i], [0, 1, 2].map(|c| 0.5 * (x[a][c] + x[b][c])), "{element:?} {i}");
            }
        }
    }

    #[test]
    fn bytes_hold_the_same_numbers() {
        let bytes = written(BlockElement::Hex8, Form::Binary);
        let after = |text: &str| {
            bytes.windows(text.len()).position(|at| at == text.as_bytes()).unwrap_or_else(|| panic!("{text}"))
                + text.len()
        };
        let nodes = after("    2C                             8                                     3\n");
        let elements = after("    3C                             1                                     2\n");
        // A number of four bytes and three of eight for each of eight nodes, then the next head.
        assert_eq!(elements - 75 - nodes, 8 * 28);
        let whole = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!((whole(nodes), whole(nodes + 28)), (7, 17));
        assert_eq!([0, 1, 2, 3, 4].map(|i| whole(elements + 4 * i)), [100, 1, 0, 1, 7]);
        let results = after("    1ALL\n");
        assert_eq!(bytes.len() - results, 8 * 16 + " 9999\n".len());
        let last = results + 7 * 16;
        let value = f32::from_le_bytes(bytes[last + 4..last + 8].try_into().unwrap());
        assert!(whole(last) == 77 && value == -1.25e-3);
    }

    #[test]
    fn numbers_fit_their_columns() {
        let shown = [1.0, -1.140_684e-5, 1e-105, 9e200, -9e200, 0.0].map(|value| scientific(value, 12, 5));
        let wanted = [" 1.00000E+00", "-1.14068E-05", " 0.00000E+00", " 9.99900E+99", "-9.99900E+99", " 0.00000E+00"];
        assert_eq!(shown, wanted);
        for (time, wanted) in
            [(1.0, " 1.000000000"), (0.05, " 0.050000000"), (12.5, " 12.50000000"), (1e-7, " 1.00000E-07")]
        {
            assert_eq!(time_field(time).trim(), wanted.trim());
            assert_eq!(time_field(time).len(), 12);
        }
    }
}
