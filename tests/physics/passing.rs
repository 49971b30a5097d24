//! Bodies that pass through each other are no answer, or at least said.

use std::ops::ControlFlow;

use std::sync::Arc;

use stiction::contact::{
    Assembly, ContactSurface, Counterpart, Moved, Obstacle, Overlap, OverlapKind, RawSurface, Side, SurfaceFacts,
    SurfaceFriction, Triangles, overlaps,
};
use stiction::friction::Status;
use stiction::io::case::{self, Case};
use stiction::mesh::{Block, BlockElement, Mesh, Ring, block, bodies, join, ring};
use stiction::run::{self, Outcome, Prepared, Settings};

const LOW: &str = "[mesh.parts.a]\nblock = { size = [10, 10, 10], cells = [3, 3, 3], element = \"hex8\" }\n";
const FLOOR: &str = "[[fix]]\non = \"a.z-min\"\n";

/// Two blocks 4 apart: `more` says what moves the upper one and what is between them.
fn two(low: &str, more: &str) -> Case {
    let text = format!(
        "{low}[mesh.parts.b]\nblock = {{ size = [10, 10, 10], cells = [2, 2, 2], element = \"hex8\", origin = [0, 0, 14] }}\n\
         [materials.s]\nyoung = 1000\npoisson = 0.3\n{more}"
    );
    case::parse(&text, "blocks", &[]).unwrap()
}

/// The upper one moved down by `down`.
fn blocks(down: f64, contact: &str) -> Case {
    two(LOW, &format!("{FLOOR}[[fix]]\non = \"b.z-max\"\nvalue = [0, 0, {}]\n{contact}", -down))
}

const PAIR: &str = "[[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\nfriction = { coulomb = 0.3 }\n";

fn solved(case: &Case) -> (Prepared, Outcome) {
    let prepared = run::prepare(case).unwrap();
    let settings = Settings::of(&case.solver);
    let outcome = run::solve(&prepared, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
    (prepared, outcome)
}

fn the_only(outcome: &Outcome) -> Overlap {
    assert_eq!(outcome.overlaps.len(), 1, "{:?}", outcome.overlaps);
    outcome.overlaps[0].clone()
}

#[test]
fn surfaces_that_meet_beyond_search_are_no_answer_and_with_contact_there_the_one_of_a_larger_search() {
    let case = blocks(6.0, PAIR);
    let (prepared, outcome) = solved(&case);
    assert_eq!(outcome.solution.status, Status::PassesThrough);
    let overlap = the_only(&outcome);
    assert!((overlap.depth - 2.0).abs() < 1e-12, "{overlap:?}");
    assert!(overlap.place[2] == 14.0 || overlap.place[2] == 10.0, "{overlap:?}");
    assert!(matches!(overlap.kind, OverlapKind::BeyondSearch { search } if (search - 6.0).abs() < 1e-12));
    let told = run::passes_through(&prepared, &outcome).unwrap();
    assert!(["b.z-min", "by 2 at", "search = 6"].iter().all(|word| told.contains(word)), "{told}");

    let wider = run::widened(&case, &prepared, &outcome).unwrap();
    let (prepared, outcome) = solved(&wider);
    assert_eq!((outcome.solution.status, &outcome.overlaps[..]), (Status::Solved, &[][..]));
    assert!(run::widened(&wider, &prepared, &outcome).is_none());
    let (_, by_hand) = solved(&blocks(6.0, &format!("{PAIR}search = 8\n")));
    assert_eq!(by_hand.solution.status, Status::Solved);
    for (a, b) in [(&outcome.solution.u, &by_hand.solution.u), (&outcome.solution.lambda, &by_hand.solution.lambda)] {
        let largest = b.iter().fold(0.0, |l: f64, x| l.max(x.abs()));
        assert!(largest > 1.0 && a.len() == b.len());
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-8 * largest));
    }
}

#[test]
fn a_surface_that_has_left_the_other_side_of_a_body_has_passed_through_it() {
    let (_, outcome) = solved(&blocks(40.0, PAIR));
    assert_eq!(outcome.solution.status, Status::PassesThrough);
    let overlap = the_only(&outcome);
    assert!((overlap.depth - 36.0).abs() < 1e-12 && overlap.part == 1.0, "{overlap:?}");
    // Nobody named it: seen on the way.
    let (_, outcome) = solved(&blocks(40.0, ""));
    assert_eq!(outcome.solution.status, Status::Solved);
    let overlap = the_only(&outcome);
    assert!(overlap.kind == OverlapKind::Unnamed && overlap.part < 1.0 && overlap.depth > 1.0, "{overlap:?}");
}

#[test]
fn surfaces_that_stay_apart_beyond_search_are_solved() {
    for contact in [PAIR, ""] {
        let (_, outcome) = solved(&blocks(3.999, contact));
        assert_eq!((outcome.solution.status, &outcome.overlaps[..]), (Status::Solved, &[][..]));
    }
}

/// The upper block turns as it comes down by `3 + 0.3 x`, and lies `0.3 x - 1` deep.
#[test]
fn where_no_contact_is_named_place_and_depth_are_told() {
    let turned = |on: &str| format!("[[fix]]\non = \"{on}\"\nvalue = [0, 0, \"-3 - 0.3*x\"]\n");
    let case = two(LOW, &format!("{FLOOR}{}{}", turned("b.z-max"), turned("b.z-min")));
    let (prepared, outcome) = solved(&case);
    assert_eq!(outcome.solution.status, Status::Solved);
    let overlap = the_only(&outcome);
    assert_eq!((overlap.kind, overlap.surface), (OverlapKind::Unnamed, None));
    // Deepest at the edge x = 10, but for the distance the samples keep from borders.
    let [x, _, z] = overlap.place;
    assert!((9.6..=10.0).contains(&x), "{overlap:?}");
    // A point of the lower face is off the top by that, along the normal of the turned face.
    let turned = (1.0f64 + 0.09).sqrt();
    let depth = if z == 14.0 { (0.3 * x - 1.0) * turned } else { 0.3 * x - 1.0 };
    assert!((overlap.depth - depth).abs() < 1e-9, "{overlap:?} is not {depth}");
    let report = run::report(&prepared, &outcome).to_string();
    let words = ["warning", "deep in body", "no contact is named", "b.z-min", "a.z-max"];
    assert!(words.iter().all(|word| report.contains(word)), "{report}");
}

const PLANE: &str = "against = { plane = { point = [0, 0, 10], normal = [0, 0, 1] } }\n";

#[test]
fn a_body_gets_into_an_obstacle_only_where_its_surface_is_not_named() {
    let down = "[[fix]]\non = \"b.z-max\"\nvalue = [0, 0, -6]\n";
    let alone = |contact: &str| solved(&two("", &format!("{down}[[contact]]\nfriction = \"none\"\n{contact}{PLANE}")));
    let (_, outcome) = alone("on = \"b.z-min\"\n");
    assert_eq!((outcome.solution.status, &outcome.overlaps[..]), (Status::Solved, &[][..]));
    // A wall at x = 12 for the lower block, and the upper one is moved through it.
    let wall = "[[contact]]\non = \"a.x-max\"\nfriction = \"none\"\n\
                against = { plane = { point = [12, 0, 0], normal = [-1, 0, 0] } }\n";
    let aside = "[[fix]]\non = \"b.z-max\"\nvalue = [6, 0, 0]\n";
    let (prepared, outcome) = solved(&two(LOW, &format!("{FLOOR}{aside}{wall}")));
    assert_eq!(outcome.solution.status, Status::Solved);
    let overlap = the_only(&outcome);
    assert_eq!((overlap.kind, overlap.surface, overlap.bodies), (OverlapKind::Unnamed, Some(0), [1, 1]));
    assert!((overlap.depth - 4.0).abs() < 1e-9 && overlap.place[0] == 10.0, "{overlap:?}");
    let report = run::report(&prepared, &outcome).to_string();
    assert!(report.contains("deep in the obstacle of contact \"a.x-max\""), "{report}");
}

/// On a layer that yields by 0.5 a block sinks with its sides, which is no overlap; what lies deeper beside it is one.
#[test]
fn a_body_sinks_into_a_layer_with_its_sides() {
    let sunk = |more: &str| {
        let text = format!(
            "[mesh.parts.b]\nblock = {{ size = [10, 10, 10], cells = [3, 3, 3], element = \"hex8\" }}\n{more}\
             [materials.s]\nyoung = 1000\npoisson = 0.3\n\
             [[fix]]\non = [\"b.x-min\", \"b.y-min\"]\ncomponents = \"xy\"\n\
             [[load]]\non = \"b.z-max\"\ntraction = [0, 0, -1]\n\
             [[contact]]\non = \"b.z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
             friction = \"none\"\nstiffness = {{ normal = 2 }}\n"
        );
        solved(&case::parse(&text, "layer", &[]).unwrap()).1
    };
    assert!(sunk("").overlaps.is_empty());
    let leg = "[mesh.parts.leg]\nblock = { size = [4, 4, 4], cells = [1, 1, 1], element = \"hex8\", origin = [20, 0, 0.2] }\n\
               [[fix]]\non = \"leg.z-max\"\nvalue = [0, 0, -2]\n";
    let overlap = the_only(&sunk(leg));
    assert!(overlap.kind == OverlapKind::Unnamed && (overlap.depth - 1.8).abs() < 1e-9, "{overlap:?}");
}

/// Overlaps of a mesh without contact whose nodes move as `to` says.
fn of(mesh: &Mesh, to: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> Vec<Overlap> {
    let (surfaces, facts): (Vec<ContactSurface>, Vec<&SurfaceFacts>) = Default::default();
    let assembly = Assembly { mesh, body: bodies(mesh), surfaces: &surfaces, facts };
    let u = |(node, x): (usize, &[f64; 3])| {
        let at = to(node, *x);
        [0, 1, 2].map(|c| at[c] - x[c])
    };
    let before = Moved { u: vec![[0.0; 3]; mesh.nodes.len()], obstacles: Vec::new() };
    overlaps(&assembly, &before, &Moved { u: mesh.nodes.iter().enumerate().map(u).collect(), ..before.clone() }, 1e-6)
}

#[test]
fn a_ring_that_closes_beyond_its_ends_lies_in_itself() {
    let grading = [1.0; 3];
    for element in [
        BlockElement::Hex8,
        BlockElement::Tet4Six,
        BlockElement::Tet10Six,
        BlockElement::Hex20,
        BlockElement::Wedge6,
        BlockElement::Wedge15,
    ] {
        let three_quarters =
            Ring { radii: [9.0, 10.0], height: 1.0, degrees: 270.0, cells: [2, 54, 2], grading, element };
        let mesh = ring(&three_quarters).unwrap();
        let closed = |degrees: f64| {
            of(&mesh, |_, [x, y, z]| {
                let (r, angle) = (x.hypot(y), y.atan2(x).rem_euclid(2.0 * std::f64::consts::PI) * degrees / 270.0);
                [r * angle.cos(), r * angle.sin(), z]
            })
        };
        assert_eq!(closed(359.9), [], "{element:?}");
        let found = closed(363.0);
        assert!(found.len() == 1 && found[0].bodies == [0, 0], "{element:?} {found:?}");
        // By three degrees at the outer radius, less what samples keep from borders.
        let depth = 10.0 * 3f64.to_radians().sin();
        assert!((0.95 * depth..1.01 * depth).contains(&found[0].depth), "{element:?} {found:?} {depth}");
    }
}

/// A shaft in a bore, meshed with faces that do not match: the meshes overlap by the rise of the arcs, before and after
/// the shaft has turned by half a face. A step to the side is an overlap.
#[test]
fn meshes_of_a_curved_surface_overlap_by_the_rise_of_their_arcs_and_that_is_none() {
    let grading = [1.0; 3];
    for element in [BlockElement::Hex8, BlockElement::Tet4Six, BlockElement::Tet10Six] {
        let part = |radii, cells| ring(&Ring { radii, height: 3.0, degrees: 180.0, cells, grading, element }).unwrap();
        let mesh =
            join(vec![("shaft".into(), part([2.0, 5.0], [2, 16, 2])), ("hub".into(), part([5.0, 8.0], [2, 11, 3]))]);
        let body = bodies(&mesh);
        let moved = |turn: f64, up: f64| {
            of(&mesh, |node, [x, y, z]| {
                if body[node] == 1 {
                    return [x, y, z];
                }
                let turn = turn.to_radians();
                [x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos() + up, z]
            })
        };
        assert_eq!(moved(5.0, 0.0), [], "{element:?}");
        let found = moved(0.0, 0.5);
        assert!(found.len() == 1 && (0.4..0.6).contains(&found[0].depth), "{element:?} {found:?}");
    }
}

#[test]
fn a_thin_sheet_that_bends_far_does_not_lie_in_itself() {
    for element in [BlockElement::Hex8, BlockElement::Tet4Six] {
        let sheet = Block { size: [20.0, 5.0, 0.1], cells: [40, 5, 1], origin: [0.0; 3], grading: [1.0; 3], element };
        let mesh = block(&sheet).unwrap();
        assert_eq!(of(&mesh, |_, [x, y, z]| [x, y, z + 0.02 * x * x]), []);
    }
}

/// A block slides over the border of a sheet at x = 10 and down through it. Nodes at x <= 10 have contact points, those up
/// to x = 13 cross the sheet, the others pass it by.
#[test]
fn nodes_beyond_the_border_of_an_obstacle_that_get_through_it_are_out_of_reach() {
    let element = BlockElement::Hex8;
    let size = [10.0, 4.0, 4.0];
    let mesh = block(&Block { size, cells: [10, 4, 4], origin: [8.0, 2.0, 1.0], grading: [1.0; 3], element }).unwrap();
    let mut raw = RawSurface::new("number");
    let [a, b, c, d] = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0]].map(|[x, y]| raw.point([x, y, 0.0]));
    raw.triangle([a, b, c], 1);
    raw.triangle([a, c, d], 2);
    let sheet = Triangles::new(raw.finish(), "sheet", Side::Outside, 30.0).unwrap();
    let bottom = mesh.group("z-min").unwrap().faces.clone();
    let nodes = mesh.face_nodes(&bottom).into_iter().filter(|&node| mesh.nodes[node as usize][0] <= 10.0).collect();
    let surfaces = [ContactSurface {
        name: "bottom".into(),
        faces: bottom,
        against: Counterpart::Obstacle(Obstacle::Surface(Arc::new(sheet))),
        friction: SurfaceFriction::None,
        stiffness: None,
        periods: vec![stiction::contact::ALWAYS],
    }];
    let facts = SurfaceFacts { nodes, ..SurfaceFacts::default() };
    let assembly = Assembly { mesh: &mesh, body: bodies(&mesh), surfaces: &surfaces, facts: vec![&facts] };
    let by = |way: [f64; 3]| {
        let still = Moved { u: vec![[0.0; 3]; mesh.nodes.len()], obstacles: vec![[0.0; 3]] };
        let moved = Moved { u: vec![way; mesh.nodes.len()], ..still.clone() };
        // The same where the sheet moves the other way.
        let sheet = Moved { obstacles: vec![way.map(|c| -c)], ..still.clone() };
        let found = overlaps(&assembly, &still, &moved, 1e-6);
        assert_eq!(overlaps(&assembly, &still, &sheet, 1e-6), found);
        found
    };
    assert_eq!(by([-6.0, 0.0, -0.9]), []);
    let found = by([-6.0, 0.0, -2.0]);
    let kinds: Vec<OverlapKind> = found.iter().map(|overlap| overlap.kind).collect();
    assert_eq!(kinds, [OverlapKind::InContact, OverlapKind::OutOfReach], "{found:?}");
    assert!(found.iter().all(|overlap| (overlap.depth - 1.0).abs() < 1e-12), "{found:?}");
    let [first, _, _] = found[1].place;
    assert!(first > 10.0 && first <= 13.0, "{found:?}");
    // Beside the sheet all the way.
    assert_eq!(by([6.0, 0.0, -2.0]).iter().filter(|overlap| overlap.kind != OverlapKind::InContact).count(), 0);
}

/// A ball pressed into the middle of a face: between nodes that it does not touch it meets no contact point, and there is no force; on
/// smaller faces there is one.
#[test]
fn a_ball_between_the_nodes_of_a_face_that_is_too_large_is_named() {
    let pressed = |cells: usize, element: &str| {
        let text = format!(
            "[mesh]\nblock = {{ size = [24, 24, 12], cells = [{cells}, {cells}, {}], element = \"{element}\" }}\n\
             [materials.s]\nyoung = 2e5\npoisson = 0.3\n[[fix]]\non = \"z-min\"\n[[contact]]\non = \"z-max\"\n\
             against = {{ sphere = {{ center = [10.5, 10.5, 20], radius = 8 }}, motion = [0, 0, -0.1] }}\nfriction = \"none\"\n",
            cells / 2
        );
        let (prepared, outcome) = solved(&case::parse(&text, "ball", &[]).unwrap());
        (run::totals(&prepared, &outcome).normal_force, outcome.overlaps)
    };
    let (force, found) = pressed(8, "hex8");
    let [Overlap { kind: OverlapKind::BetweenPoints, place, depth, .. }] = found[..] else { panic!("{found:?}") };
    assert!(force == 0.0 && (0.05..=0.1).contains(&depth) && place[2] == 12.0, "{force} {found:?}");
    assert!((place[0] - 10.5).hypot(place[1] - 10.5) < 1.0, "{place:?}");
    let (force, found) = pressed(24, "hex8");
    assert!(force > 0.0 && found.is_empty(), "{force} {found:?}");
}

/// Ridges along y with their crests at `crests` (x, z), as high as they are wide on either side times `slope`.
fn ridges(crests: &[[f64; 2]], slope: f64) -> String {
    let facet = |[p, q, r]: [[f64; 3]; 3]| {
        let vertex = |[x, y, z]: [f64; 3]| format!("vertex {x} {y} {z}\n");
        format!("facet normal 0 0 0\nouter loop\n{}{}{}endloop\nendfacet\n", vertex(p), vertex(q), vertex(r))
    };
    let of_crest = |&[x, z]: &[f64; 2]| {
        let [left, crest, right] = [[x - 0.3, z - 0.3 * slope], [x, z], [x + 0.3, z - 0.3 * slope]];
        let side = |[a, b]: [[f64; 2]; 2]| {
            let at = |[x, z]: [f64; 2], y: f64| [x, y, z];
            facet([at(a, -1.0), at(b, -1.0), at(b, 3.0)]) + &facet([at(a, -1.0), at(b, 3.0), at(a, 3.0)])
        };
        side([left, crest]) + &side([crest, right]) + &side([right, left])
    };
    format!("solid ridges\n{}endsolid ridges\n", crests.iter().map(of_crest).collect::<String>())
}

/// A ridge between rows of nodes meets none of them, however it has come there and whatever its obstacle touches elsewhere: the crest is
/// found where it is. Nothing is said where only nodes are met.
#[test]
fn a_ridge_between_rows_of_nodes_is_named() {
    let folder = stiction_fixtures::folder::Folder::new("ridges");
    let pressed = |crests: &[[f64; 2]], slope: f64, down: f64, element: &str| {
        folder.write("ridges.stl", ridges(crests, slope));
        let text = format!(
            "[mesh]\nblock = {{ size = [2, 2, 1], cells = [4, 4, 2], element = \"{element}\" }}\n[materials.s]\nyoung = 1e3\npoisson = 0.3\n\
             [[fix]]\non = \"z-max\"\nvalue = [0, 0, {}]\n[[contact]]\non = \"z-min\"\nagainst = {{ surface = \"ridges.stl\" }}\nfriction = \"none\"\n",
            -down
        );
        let case = case::read(folder.write("case.toml", text), &[]).unwrap();
        let (prepared, outcome) = solved(&case);
        assert_eq!(outcome.solution.status, Status::Solved);
        (run::totals(&prepared, &outcome).normal_force, outcome.overlaps)
    };
    for element in ["hex8", "tet4", "tet10"] {
        // Middles of edges are nodes of tet10 at 1.25.
        for (x, slope) in [(1.12, 1.0), (1.37, 3.0), (1.12, 3.5)] {
            // From below, half of it there already, and all of it.
            for (crest, down) in [(0.0, 0.03), (0.015, 0.015), (0.03, 0.0), (-0.01, 0.04)] {
                let (force, found) = pressed(&[[x, crest]], slope, down, element);
                let [Overlap { kind: OverlapKind::BetweenPoints, place, depth, .. }] = found[..] else {
                    panic!("{element} {slope} {crest}: {found:?}")
                };
                assert!(force == 0.0 && (depth - 0.03).abs() < 1e-12, "{element} {slope} {crest}: {depth}");
                assert!((place[0] - x).abs() < 1e-12 && place[2].abs() < 1e-12, "{place:?}");
            }
            let (force, found) = pressed(&[[x, 0.03], [0.0, 0.0]], slope, 0.001, element);
            assert!(force > 0.0, "{element} {slope}");
            assert!(matches!(found[..], [Overlap { kind: OverlapKind::BetweenPoints, .. }]), "{found:?}");
        }
        let (force, found) = pressed(&[[1.0, 0.0]], 1.0, 0.03, element);
        assert!(force > 0.0 && found.is_empty(), "{element}: {found:?}");
        let (force, found) = pressed(&[[1.12, -0.03]], 1.0, 0.02, element);
        assert!(force == 0.0 && found.is_empty(), "{element}: {found:?}");
    }
}

/// Facets of a bore lie in the shaft by up to the rise of their arcs, and jaws on the other side of a thin plate lie behind its faces:
/// neither reaches into anything.
#[test]
fn facets_and_what_lies_behind_a_thin_body_are_not_reached_into() {
    for (element, clearance) in [("hex8", 1e-4), ("tet4", 1e-3), ("hex20", 1e-4), ("tet10", 1e-3), ("hex8", 0.0)] {
        let text = format!(
            "[mesh.parts.a]\nring = {{ radii = [1, 2], height = 1, degrees = 180, cells = [2, 8, 2], element = \"{element}\" }}\n\
             [materials.s]\nyoung = 1e3\npoisson = 0.3\n[[fix]]\non = \"a.outer\"\nvalue = [0.0005, 0, 0]\n[[contact]]\non = \"a.inner\"\n\
             against = {{ cylinder = {{ point = [0, 0, 0], axis = [0, 0, 1], radius = {} }} }}\nfriction = {{ coulomb = 0.2 }}\n",
            1.0 - clearance
        );
        let (_, outcome) = solved(&case::parse(&text, "bore", &[]).unwrap());
        assert!(outcome.overlaps.is_empty(), "{element} {clearance}: {:?}", outcome.overlaps);
    }
    let folder = stiction_fixtures::folder::Folder::new("jaws");
    let below = ridges(&[[1.12, -0.01], [0.62, -0.01]], 1.0);
    // The same upside down, on a plate 0.05 thick.
    let turned = |line: &str| match line.strip_prefix("vertex ") {
        Some(x) => {
            let x: Vec<f64> = x.split(' ').map(|c| c.parse().unwrap()).collect();
            format!("vertex {} {} {}\n", x[0], 2.0 - x[1], 0.05 - x[2])
        }
        None => format!("{line}\n"),
    };
    let above: String = below.lines().map(turned).collect();
    folder.write("jaws.stl", below + &above);
    let text = "[mesh]\nblock = { size = [2, 2, 0.05], cells = [4, 4, 1], element = \"hex8\" }\n[materials.s]\nyoung = 1e3\npoisson = 0.3\n\
                [[fix]]\non = \"x-min\"\nvalue = [0, 0, 0]\n[[contact]]\non = [\"z-min\", \"z-max\"]\nagainst = { surface = \"jaws.stl\" }\n\
                friction = \"none\"\n";
    let (_, outcome) = solved(&case::read(folder.write("case.toml", text), &[]).unwrap());
    assert!(outcome.overlaps.is_empty(), "{:?}", outcome.overlaps);
}
