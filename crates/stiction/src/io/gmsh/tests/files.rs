//! Files written by Gmsh itself; `tests/meshes/make_meshes.py` made them.

use super::*;

/// Cells and faces of all groups by the places of their nodes, independent of any numbering.
fn canonical(mesh: &Mesh) -> Vec<String> {
    let place = |n: &u32| mesh.nodes[*n as usize].map(|x| (x * 1e9).round() as i64);
    let places = |nodes: &[u32]| {
        let mut places: Vec<_> = nodes.iter().filter(|&&n| n != u32::MAX).map(place).collect();
        places.sort_unstable();
        format!("{places:?}")
    };
    let mut all: Vec<String> = mesh.cell_iter().map(|(_, c)| places(c)).collect();
    for g in &mesh.groups {
        all.extend(g.cells.iter().map(|&c| format!("{} cell {}", g.name, places(mesh.cell(c as usize).1))));
        all.extend(g.faces.iter().map(|&f| format!("{} face {}", g.name, places(mesh.faces[f as usize].nodes()))));
        all.extend(g.interior_faces.iter().map(|f| format!("{} between {}", g.name, places(f))));
        all.push(format!("{} nodes {}", g.name, places(&g.nodes)));
    }
    all.sort_unstable();
    all
}

#[test]
fn all_four_formats_give_the_same_mesh() {
    for model in ["cylinders", "bar"] {
        let [first, rest @ ..] =
            SUFFIXES.map(|suffix| canonical(&read(&path(&format!("{model}-{suffix}.msh")), 1.0).unwrap().0));
        assert!(!first.is_empty());
        assert!(rest.iter().all(|other| *other == first), "{model}");
    }
}

#[test]
fn volumes_and_areas_are_those_meshio_finds() {
    let reference = std::fs::read_to_string(path("reference.txt")).unwrap();
    for line in reference.lines() {
        let [model, group, expected] = line.split('\t').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let expected: f64 = expected.parse().unwrap();
        for suffix in SUFFIXES {
            let (mesh, _) = read(&path(&format!("{model}-{suffix}.msh")), 1.0).unwrap();
            let g = info(&mesh).groups.into_iter().find(|g| g.name == group).unwrap();
            if group == "between" {
                assert_eq!((g.faces, g.interior_faces), (0, 18), "an interface is no boundary");
                continue;
            }
            let found = if g.cells > 0 { g.volume } else { g.area };
            assert!((found - expected).abs() <= 1e-13 * expected, "{line} {suffix}: {found}");
        }
    }
}

#[test]
fn the_groups_of_the_cylinders_are_all_there() {
    for suffix in SUFFIXES {
        let (mesh, notes) = read(&path(&format!("cylinders-{suffix}.msh")), 1.0).unwrap();
        let names: Vec<&str> = mesh.groups.iter().map(|g| g.name.as_str()).collect();
        assert_eq!(names, ["seam", "rim", "bottom", "between", "side", "lower part", "upper part", "all", "77"]);
        // the volumes are in two groups each: MSH 2.2 writes their cells twice, and they must be merged
        assert_eq!(mesh.group("all").unwrap().cells.len(), mesh.cell_count());
        let [lower, upper] = ["lower part", "upper part"].map(|name| mesh.group(name).unwrap().cells.len());
        assert_eq!(lower + upper, mesh.cell_count());
        let on_rim: Vec<[f64; 3]> = mesh.group("rim").unwrap().nodes.iter().map(|&n| mesh.nodes[n as usize]).collect();
        assert_eq!(on_rim.len(), 10);
        assert!(on_rim.iter().all(|x| (x[0].hypot(x[1]) - 0.5).abs() < 1e-12 && (x[2] - 1.0).abs() < 1e-12));
        let [seam] = mesh.group("seam").unwrap().nodes[..] else { panic!("one point") };
        assert!((mesh.nodes[seam as usize][0] - 0.5).abs() < 1e-15 && mesh.nodes[seam as usize][2].abs() < 1e-15);
        // the polygon of the top is that of the bottom
        let info = info(&mesh);
        let area = |name: &str| info.groups.iter().find(|g| g.name == name).unwrap().area;
        assert!((area("77") - area("bottom")).abs() < 1e-13);
        assert_eq!((info.bodies, info.open_edges, info.non_manifold_edges), (1, 0, 0));
        assert!(info.cells[0].min_quality > 0.1 && info.cells[0].mean_quality < 1.0);
        let between = MeshNote::InteriorFaces { group: "between".into(), count: 18 };
        assert_eq!(notes.0, [between]);
    }
}

#[test]
fn the_scale_multiplies_lengths() {
    let (mesh, _) = read(&path("bar-41-binary.msh"), 1e-3).unwrap();
    assert!((mesh.volume() - 2e-9).abs() < 1e-22);
    assert_eq!(mesh.cell_count(), 12);
}
