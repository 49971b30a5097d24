//! Decks of plane strain, plane stress and axisymmetric elements beside closed forms of these states.

use std::collections::BTreeMap;
use std::fmt::Write;

use stiction::io::deck;
use stiction::mesh::CellKind;
use stiction::run::{Outcome, Prepared, pair_totals};
use stiction_fixtures::case_run::{at, solved_case};

const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;

/// A rectangle of plane elements, and the numbers of its nodes by their place in half cells.
struct Sheet {
    element: &'static str,
    low: [f64; 2],
    size: [f64; 2],
    cells: [usize; 2],
    /// Added to all numbers.
    first: usize,
    name: &'static str,
}

impl Sheet {
    fn new(element: &'static str, low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Sheet {
        Sheet { element, low, size, cells, first: 0, name: "BODY" }
    }

    fn count(&self) -> usize {
        self.element[3..4].parse().unwrap()
    }

    /// Corners of all elements in half cells, counter-clockwise.
    fn corners(&self) -> Vec<Vec<[usize; 2]>> {
        let mut all = Vec::new();
        for (i, j) in (0..self.cells[1]).flat_map(|j| (0..self.cells[0]).map(move |i| (2 * i, 2 * j))) {
            let c = [[i, j], [i + 2, j], [i + 2, j + 2], [i, j + 2]];
            match self.count() {
                4 | 8 => all.push(c.to_vec()),
                _ => all.extend([vec![c[0], c[1], c[2]], vec![c[0], c[2], c[3]]]),
            }
        }
        all
    }

    fn label(&self, [i, j]: [usize; 2]) -> usize {
        1 + self.first + i + (2 * self.cells[0] + 1) * j
    }

    fn place(&self, [i, j]: [usize; 2]) -> [f64; 2] {
        let part = [i as f64 / (2 * self.cells[0]) as f64, j as f64 / (2 * self.cells[1]) as f64];
        [0, 1].map(|c| self.low[c] + self.size[c] * part[c])
    }

    /// Nodes and elements with the set of all, sets of nodes `LEFT` and `BOTTOM`, surfaces `TOP`, `INNER`, `LOWER`.
    fn text(&self) -> String {
        let mut nodes: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
        let (mut elements, mut surfaces) = (String::new(), [String::new(), String::new(), String::new()]);
        for (number, corners) in (self.first + 1..).zip(self.corners()) {
            let next = |k: usize| corners[(k + 1) % corners.len()];
            let mut of = corners.clone();
            if self.count() > 4 {
                of.extend((0..corners.len()).map(|k| [0, 1].map(|c| (corners[k][c] + next(k)[c]) / 2)));
            }
            let labels: Vec<String> = of.iter().map(|&at| self.label(at).to_string()).collect();
            nodes.extend(of.iter().map(|&at| (self.label(at), at)));
            writeln!(elements, "{number}, {}", labels.join(", ")).unwrap();
            for (k, corner) in corners.iter().enumerate() {
                let on = |c: usize, value: usize| corner[c] == value && next(k)[c] == value;
                for (surface, yes) in [on(1, 2 * self.cells[1]), on(0, 0), on(1, 0)].into_iter().enumerate() {
                    if yes {
                        writeln!(surfaces[surface], "{number}, S{}", k + 1).unwrap();
                    }
                }
            }
        }
        let name = self.name;
        let mut text = format!("*NODE, NSET=ALL{name}\n");
        for (label, &at) in &nodes {
            let [x, y] = self.place(at);
            writeln!(text, "{label}, {x}, {y}, 0.").unwrap();
        }
        text += &format!("*ELEMENT, TYPE={}, ELSET={name}\n{elements}", self.element);
        for (set, c) in [("LEFT", 0), ("BOTTOM", 1)] {
            text += &format!("*NSET, NSET={set}{name}\n");
            nodes.iter().filter(|(_, at)| at[c] == 0).for_each(|(label, _)| writeln!(text, "{label},").unwrap());
        }
        for (surface, lines) in ["TOP", "INNER", "LOWER"].iter().zip(surfaces) {
            text += &format!("*SURFACE, NAME={surface}{name}\n{lines}");
        }
        text
    }
}

fn material(set: &str, thickness: &str) -> String {
    format!("*SOLID SECTION, ELSET={set}, MATERIAL=M\n{thickness}")
}

const MATERIAL: &str = "*MATERIAL, NAME=M\n*ELASTIC\n1000., 0.3\n*DENSITY\n2.\n";

fn deck_of(sheet: &Sheet, thickness: &str, boundary: &str, loads: &str) -> String {
    let section = material(sheet.name, thickness);
    format!("{}{MATERIAL}{section}*BOUNDARY\n{boundary}*STEP\n*STATIC\n{loads}*END STEP\n", sheet.text())
}

fn parse(text: &str) -> Result<deck::Deck, stiction::Error> {
    deck::parse(text.as_bytes(), "deck.inp", &|name| Err(format!("there is no {name}")))
}

fn solved(text: &str) -> (Outcome, Prepared) {
    let deck = parse(text).unwrap_or_else(|e| panic!("{e}"));
    solved_case(&deck.case(&[]).unwrap_or_else(|e| panic!("{e}\n{}", deck.text)))
}

/// `u = [a x, b y]` at all nodes of the deck, that is of the layer at z = 0.
fn is_uniform(run: &(Outcome, Prepared), sheet: &Sheet, [a, b]: [f64; 2], told: &str) {
    let scale = a.abs().max(b.abs()) * (sheet.size[0] + sheet.low[0] + sheet.size[1]);
    for corner in sheet.corners().concat() {
        let [x, y] = sheet.place(corner);
        let u = at(run, [x, y, 0.0]);
        for (found, exact) in u.into_iter().zip([a * x, b * y, 0.0]) {
            assert!((found - exact).abs() < 1e-8 * scale, "{told} at {x} {y}: {u:?}");
        }
    }
}

const SIDES: &str = "LEFTBODY, 1\nBOTTOMBODY, 2\n";

/// `(1 - nu²) p / E` and `nu (1 + nu) p / E` in plane strain, `p / E` and `nu p / E` in plane stress.
#[test]
fn a_pressed_sheet_has_the_strains_of_plane_strain_or_plane_stress() {
    let p = 7.0;
    for (elements, [along, across]) in [
        (
            ["CPE3", "CPE4", "CPE6", "CPE8", "CPE4R", "CPE8R"],
            [(1.0 - POISSON * POISSON) / YOUNG, POISSON * (1.0 + POISSON) / YOUNG],
        ),
        (["CPS3", "CPS4", "CPS6", "CPS8", "CPS4R", "CPS8R"], [1.0 / YOUNG, POISSON / YOUNG]),
    ] {
        for element in elements {
            let sheet = Sheet::new(element, [0.0; 2], [4.0, 3.0], [3, 2]);
            let run = solved(&deck_of(&sheet, "2.5\n", SIDES, &format!("*DSLOAD\nTOPBODY, P, {p}\n")));
            is_uniform(&run, &sheet, [across * p, -along * p], element);
        }
    }
}

/// The same by the forces of the whole thickness at the nodes of the top.
#[test]
fn forces_at_plane_nodes_are_those_of_the_whole_thickness() {
    let (p, thickness, length) = (7.0, 2.5, 4.0);
    for (element, along, across) in [
        ("CPE4", 1.0 - POISSON * POISSON, POISSON * (1.0 + POISSON)),
        ("CPE8", 1.0 - POISSON * POISSON, POISSON * (1.0 + POISSON)),
        ("CPS4", 1.0, POISSON),
        ("CPS8", 1.0, POISSON),
    ] {
        let sheet = Sheet::new(element, [0.0; 2], [length, 3.0], [2, 2]);
        let whole = p * thickness * length / 2.0;
        // Of one edge 1/2 1/2, or 1/6 2/3 1/6, of its force.
        let parts: &[f64] =
            if element.ends_with('4') { &[0.5, 0.0, 1.0, 0.0, 0.5] } else { &[1.0, 4.0, 2.0, 4.0, 1.0] };
        let unit = if element.ends_with('4') { 1.0 } else { 1.0 / 6.0 };
        let mut loads = String::from("*CLOAD\n");
        for (i, part) in parts.iter().enumerate().filter(|(_, part)| **part > 0.0) {
            writeln!(loads, "{}, 2, {}", sheet.label([i, 4]), -part * unit * whole).unwrap();
        }
        let run = solved(&deck_of(&sheet, &format!("{thickness}\n"), SIDES, &loads));
        is_uniform(&run, &sheet, [across * p / YOUNG, -along * p / YOUNG], element);
    }
}

/// A solid cylinder: its cells at the axis are wedges, and the uniform state is exact.
#[test]
fn a_pressed_cylinder_is_shortened_and_widened_uniformly_to_its_axis() {
    let p = 5.0;
    for (element, kinds) in [
        ("CAX4", [CellKind::Hex8, CellKind::Wedge6]),
        ("CAX8", [CellKind::Hex20, CellKind::Wedge15]),
        ("CAX8R", [CellKind::Hex20, CellKind::Wedge15]),
    ] {
        let sheet = Sheet::new(element, [0.0; 2], [2.0, 3.0], [3, 2]);
        let run = solved(&deck_of(&sheet, "", "BOTTOMBODY, 2\n", &format!("*DSLOAD\nTOPBODY, P, {p}\n")));
        is_uniform(&run, &sheet, [POISSON * p / YOUNG, -p / YOUNG], element);
        let used: Vec<CellKind> = run.1.mesh.cells.iter().filter(|c| !c.is_empty()).map(|c| c.kind).collect();
        assert_eq!(used, kinds, "{element}");
        let volume = std::f64::consts::PI * 4.0 * 3.0 / 180.0;
        assert!((run.1.mesh.volume() / volume - 1.0).abs() < 3e-4, "{element}");
    }
}

/// Two triangles over each rectangle of which one has an edge on the axis and the other a node: that one is refused.
#[test]
fn what_touches_the_axis_in_one_node_is_refused_with_a_remedy() {
    let sheet = Sheet::new("CAX3", [0.0; 2], [2.0, 3.0], [2, 2]);
    let refused = parse(&deck_of(&sheet, "", "BOTTOMBODY, 2\n", "*DSLOAD\nTOPBODY, P, 1.\n")).unwrap_err();
    assert!(refused.place.contains("element 1") && refused.what.contains("one node"), "{refused}");
    assert!(refused.remedy.contains("quadrilaterals"), "{refused}");
}

/// Lamé: a tube under the pressure p inside, free to lengthen, widens by `p a / E ((a² + b²) / (b² - a²) + nu)` at `a`.
#[test]
fn a_tube_under_pressure_widens_as_lame_says() {
    let (a, b, p) = (1.0, 2.0, 10.0);
    let exact = p * a / YOUNG * ((a * a + b * b) / (b * b - a * a) + POISSON);
    let error = |element, cells: usize| {
        let sheet = Sheet::new(element, [a, 0.0], [b - a, 0.5], [cells, cells / 2]);
        let run = solved(&deck_of(&sheet, "", "BOTTOMBODY, 2\n", &format!("*DSLOAD\nINNERBODY, P, {p}\n")));
        (at(&run, [a, 0.0, 0.0])[0] / exact - 1.0).abs()
    };
    // At the corner lies one triangle, which sees less of the pressure than a quadrilateral.
    for (element, rate) in [("CAX3", 1.4), ("CAX4", 1.8)] {
        let [coarse, fine] = [4, 8].map(|cells| error(element, cells));
        // The flat sides of the sector leave some 1e-4.
        assert!(fine < 0.01 && (coarse / fine).log2() > rate, "{element} {coarse:e} {fine:e}");
    }
    for element in ["CAX6", "CAX8"] {
        let fine = error(element, 6);
        assert!(fine < 3e-4, "{element} {fine:e}");
    }
}

/// A tube that rotates and cannot lengthen. In plane stress `u(a) = rho w² a / (4 E) ((3 + nu) b² + (1 - nu) a²)`; plane
/// strain has E / (1 - nu²) and nu / (1 - nu) in their places.
#[test]
fn a_rotating_tube_widens_as_the_closed_form_says() {
    let (a, b, square, density) = (1.0, 2.0, 9.0, 2.0);
    let (e, nu) = (YOUNG / (1.0 - POISSON * POISSON), POISSON / (1.0 - POISSON));
    let exact = density * square * a / (4.0 * e) * ((3.0 + nu) * b * b + (1.0 - nu) * a * a);
    let sheet = Sheet::new("CAX8", [a, 0.0], [b - a, 0.5], [6, 1]);
    let ends: String = (0..=12).filter(|i| i % 2 == 0).map(|i| format!("{}, 2\n", sheet.label([i, 2]))).collect();
    let middles: String = (0..12).filter(|i| i % 2 == 1).map(|i| format!("{}, 2\n", sheet.label([i, 2]))).collect();
    let load = format!("*DLOAD\nBODY, CENTRIF, {square}, 0., 0., 0., 0., 1., 0.\n");
    let run = solved(&deck_of(&sheet, "", &format!("BOTTOMBODY, 2\n{ends}{middles}"), &load));
    let found = at(&run, [a, 0.0, 0.0])[0];
    assert!((found / exact - 1.0).abs() < 3e-4, "{found} {exact}");
}

/// A force at a ring of nodes is that of the whole circle: the mean stress is the force over the area.
#[test]
fn forces_at_axisymmetric_nodes_are_those_of_the_whole_circle() {
    let (radius, force) = (2.0, 30.0);
    for element in ["CAX4", "CAX8"] {
        let sheet = Sheet::new(element, [1.0, 0.0], [radius - 1.0, 40.0], [1, 20]);
        let load = format!("*CLOAD\n{}, 2, -{force}\n", sheet.label([0, 40]));
        let run = solved(&deck_of(&sheet, "", "BOTTOMBODY, 2\n", &load));
        // Far from the ends the strain is that of the mean stress.
        let strain = (at(&run, [1.0, 10.0, 0.0])[1] - at(&run, [1.0, 20.0, 0.0])[1]) / 10.0;
        let exact = force / (std::f64::consts::PI * (radius * radius - 1.0) * YOUNG);
        assert!((strain / exact - 1.0).abs() < 2e-3, "{element} {strain} {exact}");
    }
}

/// A tube held at both ends and tightened at a cut, and one whose top moves as one under a force at one ring of nodes: the
/// mean stress is the force of the whole circle over the area.
#[test]
fn bolts_and_equations_of_axisymmetric_decks_are_those_of_the_whole_circle() {
    let (force, area) = (30.0, std::f64::consts::PI * (2.0 * 2.0 - 1.0));
    let sheet = Sheet::new("CAX4", [1.0, 0.0], [1.0, 2.0], [2, 4]);
    let stretch = force / area / YOUNG;
    let top: String = [0, 2, 4].iter().map(|&i| format!("{}, 2\n", sheet.label([i, 8]))).collect();
    let cut = "*NODE\n9999, 0., 0., 0.\n*SURFACE, NAME=CUT\n3, S3\n4, S3\n\
               *PRE-TENSION SECTION, NODE=9999, SURFACE=CUT\n0., 1., 0.\n*BOUNDARY\n";
    let deck = deck_of(&sheet, "", &format!("BOTTOMBODY, 2\n{top}"), &format!("*CLOAD\n9999, 1, {force}\n"));
    let run = solved(&deck.replacen("*BOUNDARY\n", cut, 1));
    let found = at(&run, [1.0, 0.5, 0.0])[1];
    assert!((found / (0.5 * stretch) - 1.0).abs() < 3e-4, "{found} {}", 0.5 * stretch);

    let [a, b, c] = [0, 2, 4].map(|i| sheet.label([i, 8]));
    let tied = format!("*EQUATION\n2\n{a}, 2, 1., {b}, 2, -1.\n2\n{b}, 2, 1., {c}, 2, -1.\n*BOUNDARY\n");
    let deck = deck_of(&sheet, "", "BOTTOMBODY, 2\n", &format!("*CLOAD\n{a}, 2, {force}\n"));
    let run = solved(&deck.replacen("*BOUNDARY\n", &tied, 1));
    let found = at(&run, [2.0, 2.0, 0.0])[1];
    assert!((found / (2.0 * stretch) - 1.0).abs() < 3e-4, "{found} {}", 2.0 * stretch);
}

/// Two cylinders on one another, or two sheets, of other elements: the pressure passes the contact, on triangles of wedges
/// too, and its force is that of the layer.
#[test]
fn a_uniform_pressure_passes_contact_between_plane_and_axisymmetric_bodies() {
    let p = 5.0;
    for elements in [["CAX8", "CAX8"], ["CAX4", "CAX4"], ["CPE8", "CPE4"], ["CPS4", "CPS8"]] {
        let low = Sheet { name: "LOW", ..Sheet::new(elements[0], [0.0; 2], [2.0, 1.0], [3, 2]) };
        let high = Sheet { name: "HIGH", first: 1000, ..Sheet::new(elements[1], [0.0, 1.0], [2.0, 1.0], [2, 2]) };
        let thickness = if elements[0].starts_with("CAX") { "" } else { "2.5\n" };
        let left = if thickness.is_empty() { "" } else { "LEFTLOW, 1\nLEFTHIGH, 1\n" };
        let text = format!(
            "{}{}{MATERIAL}{}{}*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n\
             *CONTACT PAIR, INTERACTION=I, TYPE=SURFACE TO SURFACE\nLOWERHIGH, TOPLOW\n\
             *BOUNDARY\n{left}BOTTOMLOW, 2\n*STEP\n*STATIC\n*DSLOAD\nTOPHIGH, P, {p}\n*END STEP\n",
            low.text(),
            high.text(),
            material("LOW", thickness),
            material("HIGH", thickness),
        );
        let run = solved(&text);
        let force = pair_totals(&run.1, &run.0)[0].1.normal_force;
        let high = run.1.mesh.nodes.iter().fold(0.0, |high: f64, x| high.max(x[2]));
        let area = if thickness.is_empty() { std::f64::consts::PI * 4.0 / 180.0 } else { 2.0 * high };
        assert!((force / (p * area) - 1.0).abs() < 3e-4, "{elements:?} {force} {}", p * area);
        let exact = match elements[0] {
            "CPE8" => 2.0 * p * (1.0 - POISSON * POISSON) / YOUNG,
            _ => 2.0 * p / YOUNG,
        };
        let found = at(&run, [2.0, 2.0, 0.0])[1];
        // Arcs of the sector are clipped as polygons where they are edges of faces in contact.
        let bound = if elements[0] == "CAX8" { 1e-6 } else { 1e-9 };
        assert!((found + exact).abs() < bound * exact, "{elements:?} {found} {exact}");
    }
}

#[test]
fn what_no_plane_state_answers_is_refused_with_its_place_and_remedy() {
    let sheet = Sheet::new("CAX4", [1.0, 0.0], [1.0, 1.0], [2, 2]);
    let good = deck_of(&sheet, "", "BOTTOMBODY, 2\n", "*DSLOAD\nINNERBODY, P, 1.\n");
    parse(&good).unwrap_or_else(|e| panic!("{e}"));
    let strain = deck_of(&Sheet::new("CPE4", [0.0; 2], [1.0; 2], [2, 2]), "1.\n", SIDES, "*DSLOAD\nTOPBODY, P, 1.\n");
    let load = "*DSLOAD\nINNERBODY, P, 1.\n";
    let turn = "*TRANSFORM, NSET=LEFTBODY\n0., 1., 0., -1., 0., 0.\n*BOUNDARY\n";
    for (text, words) in [
        (good.replacen("1, 1, 0, 0.", "1, -1, 0, 0.", 1), ["node 1", "radius x = -1", "y is the axis"]),
        (good.replacen("1, 1, 0, 0.", "1, 1, 0, 0.5", 1), ["node 1", "z = 0.5", "plane z = 0"]),
        (good.replace(load, "*DLOAD\nBODY, GRAV, 9., 1., 0., 0.\n"), ["line", "alike all around", "GRAV along y"]),
        (good.replacen("*BOUNDARY\n", turn, 1), ["line", "*TRANSFORM is not read", "along the radius"]),
        (
            strain.replacen("*MATERIAL", "*NODE\n99, 0.5, 2.\n*RIGID BODY, NSET=LEFTBODY, REF NODE=99\n*MATERIAL", 1),
            ["line", "reference point", "*BOUNDARY"],
        ),
        (strain.replacen("MATERIAL=M\n1.", "MATERIAL=M\n-1.", 1), ["line", "no thickness", "positive"]),
        (
            strain.replacen("*BOUNDARY\n", "*SOLID SECTION, ELSET=BODY, MATERIAL=M\n3.\n*BOUNDARY\n", 1),
            ["line", "several thicknesses", "one"],
        ),
        (
            good.replacen("*MATERIAL", "*ELEMENT, TYPE=CPS3, ELSET=X\n99, 1, 3, 11\n*MATERIAL", 1),
            ["deck.inp", "CAX4 and CPS3", "alone"],
        ),
    ] {
        let message = parse(&text).map(|_| ()).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    }
}
