//! Bodies that hang over the edge of what they stand on: no pressure has its resultant beyond that edge.

use std::ops::ControlFlow;

use stiction::contact::{
    ALWAYS, ContactSurface, Counterpart, InitialGap, Master, Reason, Role, SurfaceFriction, contact_rows,
};
use stiction::fem::dof_map;
use stiction::friction::Status;
use stiction::io::case;
use stiction::mesh::{Block, BlockElement, Mesh, block, join};
use stiction::run::{Event, Settings, pair_totals, prepare, solve};
use stiction_fixtures::case_run::solved;

/// A block of 40 x 20 x 10 with `cells` along and across, of which `along` lies on a table in one direction and `across` in the other.
fn on_a_table(element: &str, cells: [usize; 2], [along, across]: [f64; 2], path: &str) -> Status {
    let [n, m] = cells;
    let text = format!(
        r#"
[mesh.parts.table]
block = {{ size = [60, 60, 20], cells = [5, 5, 2], element = "{element}", origin = [-60, -60, -20] }}
[mesh.parts.book]
block = {{ size = [40, 20, 10], cells = [{n}, {m}, 2], element = "{element}", origin = [{}, {}, 0] }}
[materials.m]
young = 20e3
poisson = 0.2
density = 2e-6
[[load]]
gravity = [0, 0, -9810]
[[fix]]
on = "table.z-min"
[[contact]]
on = "book.z-min"
against = "table.z-max"
friction = {{ coulomb = 0.3 }}
slave = "on"
[solver]
path = "{path}"
"#,
        -along, -across
    );
    let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let go_on = &mut |_: &Event| ControlFlow::Continue(());
    solve(&prepared, &Settings::of(&case.solver), go_on).unwrap_or_else(|e| panic!("{e}")).solution.status
}

/// It stands while its middle lies on the table: to a part in 500 of a face with linear elements, to a twentieth of a face with quadratic ones, wherever the
/// edge runs through the faces.
#[test]
fn a_block_tips_over_where_its_middle_leaves_the_table() {
    let linear = ["hex8", "tet4", "wedge6"].map(|element| (element, 0.002));
    let quadratic = ["hex20", "tet10", "wedge15"].map(|element| (element, 0.05));
    for (element, part) in linear.into_iter().chain(quadratic) {
        for cells in [[4, 2], [7, 3], [5, 2]] {
            let beyond = 20.0 - part * 40.0 / cells[0] as f64;
            let path = if cells[0] == 5 { "multigrid" } else { "auto" };
            let at = |seat: f64| on_a_table(element, cells, [seat, 30.0], path);
            assert_eq!(at(20.0 + 1e-3), Status::Solved, "{element} {cells:?}");
            assert_eq!(at(beyond - 0.03), Status::NoEquilibrium, "{element} {cells:?}");
            assert_eq!(at(13.0), Status::NoEquilibrium, "{element} {cells:?}");
        }
    }
}

/// Over two edges: it falls where the middle is not on the table, and stands from a third of a face behind the corner on.
#[test]
fn a_block_over_a_corner_tips_over_near_where_its_middle_leaves_the_table() {
    for element in ["hex8", "tet4", "hex20", "tet10"] {
        for n in [5, 7] {
            let behind = 20.0 + 40.0 / n as f64 / 2.0;
            let at = |seat: f64| on_a_table(element, [n, 3], [seat, seat / 2.0], "auto");
            assert_eq!(at(19.7), Status::NoEquilibrium, "{element} {n}");
            assert_eq!(at(behind), Status::Solved, "{element} {n}");
        }
    }
}

/// The lower faces of a block of `cells` on the upper ones of a smaller block without coordinates in common; and the first node of the former.
fn over(element: BlockElement, cells: [usize; 2], [length, width]: [f64; 2]) -> (Mesh, ContactSurface, usize) {
    let made = |size, cells, origin| block(&Block { size, cells, origin, grading: [1.0; 3], element }).unwrap();
    let low = made([length, width, 1.0], [2, 3, 1], [0.0, 0.0, -1.0]);
    let high = made([2.0, 2.0, 1.0], [cells[0], cells[1], 1], [-0.1, if width > 2.0 { 0.0 } else { -0.2 }, 0.0]);
    let first = low.nodes.len();
    let mesh = join(vec![("low".into(), low), ("high".into(), high)]);
    let faces = |group: &str| mesh.group(group).unwrap().faces.clone();
    let master = Master {
        faces: faces("low.z-max"),
        gap: InitialGap::AsMeshed,
        search: None,
        slave: Role::On,
        reason: Reason::Asked,
        nodes: None,
    };
    let surface = ContactSurface {
        name: "seat".into(),
        faces: faces("high.z-min"),
        against: Counterpart::Surface(master),
        friction: SurfaceFriction::None,
        stiffness: None,
        periods: vec![ALWAYS],
    };
    (mesh, surface, first)
}

/// Wherever the edges run: each point stands for a positive area, one everywhere is the load of a uniform pressure on what is covered, and
/// the force of no point acts beyond the edges (of one, not of corners, where a face is covered beyond neither of its sides alone).
#[test]
fn no_point_acts_beyond_the_edge_and_a_uniform_pressure_stays_one() {
    use BlockElement::{Hex8, Hex20, Tet4Six, Tet10Six, Wedge6, Wedge15};
    // Parts of a face: some nodes carry for neighbours that lie farther out, and quadratic functions of those are negative within.
    for (element, most) in
        [(Hex8, 0.002), (Tet4Six, 0.02), (Wedge6, 0.02), (Hex20, 0.1), (Tet10Six, 0.1), (Wedge15, 0.1)]
    {
        for cells in [[3, 4], [7, 5], [10, 9]] {
            for length in [0.9, 1.03, 1.11, 1.37, 1.46, 1.58] {
                for width in [2.5, 1.07, 1.33] {
                    let (mesh, surface, first) = over(element, cells, [length, width]);
                    let dofs = dof_map(&mesh, &[], 0.0).unwrap();
                    let (rows, _) = contact_rows(&mesh, &dofs, &[surface]).unwrap();
                    let at = format!("{element:?} {cells:?} {length} {width}");
                    let covered = [[0.0, length], [0.0, width.min(2.0)]];
                    let (mut force, mut moments) = (0.0, [0.0; 2]);
                    for j in 0..rows.area.len() {
                        assert!(rows.area[j] > 0.0, "{at}: point {j} stands for {}", rows.area[j]);
                        let (mut weight, mut centre) = (0.0, [0.0; 2]);
                        let (columns, values) = rows.B.row(j);
                        for (&column, &value) in columns.iter().zip(values) {
                            let node = column as usize / 3;
                            if node >= first {
                                weight += value;
                                (0..2).for_each(|c| centre[c] += value * mesh.nodes[node][c]);
                            }
                        }
                        force += rows.area[j] * weight;
                        (0..2).for_each(|c| moments[c] += rows.area[j] * centre[c]);
                        let beyond = centre[0] / weight - covered[0][1];
                        let face = 2.0 / cells[0] as f64;
                        if width > 2.0 {
                            assert!(beyond <= most * face, "{at}: point {j} acts {} of a face beyond", beyond / face);
                        }
                    }
                    let area: f64 = covered.iter().map(|[low, high]| high - low).product();
                    assert!((force.abs() - area).abs() < 1e-12, "{at}: {force} for {area}");
                    for c in 0..2 {
                        let middle = 0.5 * (covered[c][0] + covered[c][1]);
                        assert!(
                            (moments[c] / force - middle).abs() < 1e-12,
                            "{at}: {} for {middle}",
                            moments[c] / force
                        );
                    }
                }
            }
        }
    }
}

/// A block of two faces along it with its weight 3 beside the table, whose edges cut the faces on three sides: it falls whatever the mesh of the table. Parts
/// that are rounding are no neighbours.
#[test]
fn a_block_beside_a_strip_under_its_faces_falls_whatever_the_mesh_of_the_strip() {
    for cells in [[3, 3], [2, 2], [1, 1]] {
        let text = format!(
            r#"
[mesh.parts.t]
block = {{ size = [16.9, 40, 10], cells = [{}, {}, 1], element = "hex8", origin = [23, -10, -10] }}
[mesh.parts.book]
block = {{ size = [40, 20, 10], cells = [2, 2, 1], element = "hex8" }}
[materials.m]
young = 20e3
poisson = 0.2
density = 2e-6
[[load]]
gravity = [0, 0, -9810]
[[fix]]
on = "t.z-min"
[[contact]]
on = "book.z-min"
against = "t.z-max"
friction = {{ coulomb = 0.3 }}
slave = "on"
"#,
            cells[0], cells[1]
        );
        let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
        let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
        let go_on = &mut |_: &Event| ControlFlow::Continue(());
        let outcome = solve(&prepared, &Settings::of(&case.solver), go_on).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(outcome.solution.status, Status::NoEquilibrium, "{cells:?}");
    }
}

/// Held from above by 0.01 into the table: the points stand for what lies on it, and a gap that the contact is told to close is closed at
/// all of them.
#[test]
fn the_areas_of_all_states_are_what_is_covered_and_gaps_close_at_the_edge_too() {
    for (element, covered) in [("hex8", 3.5), ("hex8", 3.8), ("tet4", 3.6), ("hex20", 3.7), ("tet10", 3.2)] {
        for (height, gap) in [(0.0, ""), (0.05, "gap = { closed_within = 0.06 }\n")] {
            let run = solved(&format!(
                r#"
[mesh.parts.a]
block = {{ size = [{covered}, 3, 2], cells = [3, 2, 1], element = "{element}", origin = [0, 0, -2] }}
[mesh.parts.b]
block = {{ size = [5, 3, 1], cells = [5, 3, 1], element = "{element}", origin = [0, 0, {height}] }}
[materials.m]
young = 1000
poisson = 0.2
[[fix]]
on = "a.z-min"
[[fix]]
on = "b.z-max"
value = [0, 0, -0.01]
[[contact]]
on = "b.z-min"
against = "a.z-max"
friction = {{ coulomb = 0.3 }}
slave = "on"
{gap}"#
            ));
            let (outcome, prepared) = &run;
            let (_, totals) = &pair_totals(prepared, outcome)[0];
            let area = totals.open_area + totals.stick_area + totals.slip_area;
            assert!((area - 3.0 * covered).abs() < 1e-9, "{element} {covered}: {area}");
            assert!(totals.normal_force > 1.0, "{element} {covered}");
            assert!(prepared.problem.contact.gap.iter().all(|gap| gap.abs() < 1e-12), "{element} {covered}");
        }
    }
}
