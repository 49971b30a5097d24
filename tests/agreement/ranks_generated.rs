//! Meshes of blocks and rings that ranks make part by part, against the same meshes divided by rank 0.

use std::sync::Arc;

use stiction::io::case::{Case, MeshSource, Placing};
use stiction::mesh::MeshNotes;
use stiction::run::prepare;

use super::ranks::{agrees, case_of, on_ranks, refusal};

const STEEL: &str = "[materials.steel]\nyoung = 2e11\npoisson = 0.3\ndensity = 7800\nexpansion = 12e-6\n";

/// The case with its mesh made beforehand, which rank 0 divides.
fn given(case: &Case) -> Case {
    let mut given = case.clone();
    given.mesh.source = MeshSource::Given(Arc::new((prepare(case).unwrap().mesh, MeshNotes::default())));
    given.mesh.placing = Placing::default();
    given
}

/// Parts, hierarchies and iterations are the same, only means of all nodes are added in another order.
fn same(text: &str, sizes: &[usize]) {
    let case = case_of(text, "1e-9");
    let given = given(&case);
    for &size in sizes {
        let ((u, own), (expected, of_first)) = (on_ranks(&case, size), on_ranks(&given, size));
        assert_eq!(own.answer.counts.cycles, of_first.answer.counts.cycles, "{size} ranks");
        let [a, b] = [&own, &of_first].map(|of| of.ranks.as_ref().unwrap());
        let [own_dofs, dofs] = [&own, &of_first].map(|of| of.answer.dofs);
        assert_eq!((a.nodes, a.cells, own_dofs), (b.nodes, b.cells, dofs));
        for (own, first) in a.ranks.iter().zip(&b.ranks) {
            assert_eq!((own.nodes, own.ghosts, own.points), (first.nodes, first.ghosts, first.points), "{size} ranks");
        }
        let largest = expected.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        let differences = u.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        // `f64::max` would leave out what is not a number.
        let worst = differences.fold(0.0, |most: f64, d| if d <= most { most } else { d });
        assert!(worst <= 1e-10 * largest, "{size} ranks: {:e}", worst / largest);
    }
}

/// Supports, forces, weight and temperatures of regions that lie inside, by boxes, points and whole bodies. A block that is turned, be it
/// by nothing, starts from no coarser one, as a mesh does that is given.
fn regions(element: &str) -> String {
    format!(
        "[mesh]\nturn = {{ axis = [0, 0, 1], degrees = 0 }}\nblock = {{ size = [4, 2, 1], cells = [12, 7, 5], {element}, grading = [2, 1, 0.5], origin = [0, 0, 1] }}\n{STEEL}\
         [[fix]]\non = {{ box = [[0, 0, 1], [0.7, 0.6, 2]] }}\n[[fix]]\non = \"y-min\"\ncondition = \"symmetry\"\n\
         [[fix]]\non = {{ point = [2.1, 1.2, 1.4] }}\ncomponents = \"y\"\n\
         [[load]]\ngravity = [0, 0, -9.81e4]\non = {{ box = [[0.5, 0, 1.1], [4, 2, 2]] }}\n\
         [[load]]\ntemperature = \"60*x\"\n[[load]]\nnodal = [0, 0, -2e5]\non = {{ point = [3.1, 0.9, 1.6] }}\n\
         [[load]]\nnodal = [1e4, 0, 0]\non = {{ box = [[3, 0.5, 1.2], [3.9, 1.5, 1.9]] }}\n\
         [[load]]\non = \"x-max\"\nforce = [0, 0, -1e7]\n[[contact]]\non = \"z-min\"\n\
         against = {{ plane = {{ point = [0, 0, 0.9999], normal = [0, 0, 1] }} }}\nfriction = {{ coulomb = 0.3 }}\n"
    )
}

#[test]
fn regions_inside_a_mesh_that_ranks_make_are_those_of_the_whole() {
    for element in
        ["element = \"hex8\"", "element = \"tet4\"", "element = \"tet10\", split = \"six\"", "element = \"wedge15\""]
    {
        same(&regions(element), &[1, 3, 4]);
    }
    agrees(&regions("element = \"tet4\", split = \"six\""), &[4]);
}

/// A ring pressed into another, turned, and a block upon both, of other cells and another material; bodies that contact alone holds.
const PARTS: &str = "\
    [mesh]\nturn = { axis = [0, 0, 1], degrees = 20 }\nmove = [1, 2, 3]\n\
    [mesh.parts.bush]\nring = { radii = [1, 2], height = 1, degrees = 90, cells = [4, 12, 5], element = \"hex20\" }\n\
    [mesh.parts.housing]\nring = { radii = [1.999, 3], height = 1, degrees = 90, cells = [3, 9, 4], element = \"tet10\", split = \"six\" }\n\
    [mesh.parts.lid]\nblock = { size = [3, 3, 0.5], cells = [8, 8, 3], element = \"wedge6\" }\nmove = [0, 0, 1]\n\
    [materials.soft]\nyoung = 2e9\npoisson = 0.3\non = [\"bush\"]\n\
    [materials.steel]\nyoung = 2e11\npoisson = 0.3\non = [\"housing.body\", \"lid\"]\n\
    [[fix]]\non = \"housing.outer\"\n[[fix]]\non = [\"bush.z-min\", \"housing.z-min\"]\ncomponents = \"z\"\n[[fix]]\non = \"lid.y-max\"\ncomponents = \"xy\"\n[[load]]\non = \"lid.z-max\"\ntraction = [0, 0, -1e5]\n\
    [[contact]]\nname = \"fit\"\non = \"bush.outer\"\nagainst = \"housing.inner\"\nfriction = { coulomb = 0.2 }\n\
    [[contact]]\nname = \"seat\"\non = \"lid.z-min\"\nagainst = [\"bush.z-max\", \"housing.z-max\"]\nfriction = { coulomb = 0.2 }\n";

#[test]
fn parts_that_are_turned_and_joined_by_contact_are_the_same_made_by_ranks() {
    same(PARTS, &[1, 2, 5]);
}

/// What the boundary alone cannot pose is asked of the whole: a region that has cells inside only, and mistakes with their words.
#[test]
fn what_the_boundary_lacks_is_found_in_the_whole() {
    let inside =
        regions("element = \"hex8\"").replace("[[0.5, 0, 1.1], [4, 2, 2]]", "[[0.5, 0.3, 1.2], [3.4, 1.7, 1.8]]");
    same(&inside, &[3]);
    let nowhere = inside.replace("[[0.5, 0.3, 1.2], [3.4, 1.7, 1.8]]", "[[9, 9, 9], [10, 10, 10]]");
    let error = refusal(&case_of(&nowhere, "1e-8"), 3, None);
    assert!(error.what.contains("no cell lies inside the box"), "{error:?}");
    // Boxes through the block that cross inside.
    let hot =
        |low: [f64; 3], high: [f64; 3]| format!("[[load]]\non = {{ box = [{low:?}, {high:?}] }}\ntemperature = 9\n");
    let crossing = regions("element = \"hex8\"").replace("[[load]]\ntemperature = \"60*x\"\n", "")
        + &hot([0.0, 0.5, 1.2], [4.0, 1.5, 1.8])
        + &hot([1.0, 0.0, 1.2], [3.0, 2.0, 1.8]);
    let error = refusal(&case_of(&crossing, "1e-8"), 3, None);
    assert!(error.what.contains("have a temperature already"), "{error:?}");
    let wrong = PARTS.replace("\"lid.z-max\"", "\"lid.top\"");
    let error = refusal(&case_of(&wrong, "1e-8"), 2, None);
    assert!(error.what.contains("no group \"lid.top\""), "{error:?}");
    let many = refusal(&case_of(&regions("element = \"hex8\"").replace("[12, 7, 5]", "[2, 1, 1]"), "1e-8"), 13, None);
    assert!(many.what.contains("12 nodes and there are 13 ranks") || many.what.contains("too few"), "{many:?}");
}
