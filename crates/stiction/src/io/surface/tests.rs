use super::*;
use crate::contact::{Side, Triangles};

/// The six faces of a unit cube, counter-clockwise seen from outside, as corners with bits for x, y, z.
const CUBE: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn corner(i: usize) -> [f64; 3] {
    [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| bit as f64)
}

fn triangles() -> Vec<[[f64; 3]; 3]> {
    CUBE.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).map(|t| t.map(corner)).collect()
}

fn as_text(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = "solid cube of facets\n".to_string();
    for t in triangles {
        text += " facet normal 0 0 0\n  outer loop\n";
        t.iter().for_each(|[x, y, z]| text += &format!("   vertex {x:e} {y} {z}\n"));
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid cube\n"
}

fn as_binary(heading: &str, triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = heading.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0; 12]);
        t.iter().flatten().for_each(|c| bytes.extend((*c as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn as_obj() -> String {
    let mut text = "# a cube\nmtllib a.mtl\no cube\n".to_string();
    (0..8).for_each(|i| text += &format!("v {} {} {} 1.0\nvt 0 0\n", corner(i)[0], corner(i)[1], corner(i)[2]));
    for (i, f) in CUBE.iter().enumerate() {
        let name = |v: usize| match i {
            0 => format!("{}", v + 1),
            1 => format!("{}/1", v + 1),
            2 => format!("{}//2", v + 1),
            _ => format!("{}/1/1", v as i64 - 8),
        };
        text += &format!("s 1\nf {} {} {} {}\n", name(f[0]), name(f[1]), name(f[2]), name(f[3]));
    }
    text
}

#[test]
fn a_cube_is_the_same_in_every_format() {
    let read = [
        parse_stl(as_text(&triangles()).as_bytes(), "cube.stl", 2.0).unwrap(),
        parse_stl(as_text(&triangles()).replace('\n', "\r\n").to_uppercase().as_bytes(), "cube.stl", 2.0).unwrap(),
        parse_stl(&as_binary("solid", &triangles()), "cube.stl", 2.0).unwrap(),
        parse_stl(&as_binary("made by hand", &triangles()), "cube.stl", 2.0).unwrap(),
        parse_obj(as_obj().as_bytes(), "cube.obj", 2.0).unwrap(),
    ];
    for raw in read {
        assert_eq!((raw.points.len(), raw.triangles.len()), (8, 12));
        let cube = Triangles::new(raw, "cube", Side::Outside, 30.0).unwrap();
        // Twelve edges are sharp, the diagonals of the faces are not.
        assert!((cube.border_edges, cube.sharp_edges) == (0, 12) && (cube.volume - 8.0).abs() < 1e-14);
    }
}

#[test]
fn what_is_wrong_is_told_with_its_line_or_triangle() {
    let stl = as_text(&triangles());
    let cases: [(&str, String, &str, &str); 13] = [
        ("stl", stl.replace("vertex 1e0 1 0", "vertex 1e0 l 0"), "line 6", "\"l\" is no number"),
        ("stl", stl.replacen("vertex 1e0 1 0", "vertex 1e0 1", 1), "line", "without z"),
        ("stl", stl.replacen("vertex 0e0 0 0", "vertex 0e0 inf 0", 1), "line 4", "not finite"),
        ("stl", stl.replacen("   vertex 0e0 0 0\n", "", 1), "line 2", "2 vertices"),
        ("stl", stl[..stl.len() - 24].to_string(), "line 79", "ends within this facet"),
        ("stl", "solid nothing\nendsolid".into(), "x.stl", "no facet"),
        ("stl", "hello".into(), "x.stl", "neither a text"),
        ("stl", stl.replacen("outer", "inner", 1), "line 3", "no word of an STL file"),
        ("obj", as_obj().replace("f 1 3 4 2", "f 1 3 14 2"), "line 21", "no vertex 14 among the 8"),
        ("obj", as_obj().replace("f 1 3 4 2", "f 1 3 0 2"), "line 21", "no vertex 0"),
        ("obj", as_obj().replace("f 1 3 4 2", "f 1 3"), "line 21", "2 corners"),
        ("obj", as_obj().replace("f 1 3 4 2", "f 1 3 4 3"), "line 21", "same place"),
        ("obj", as_obj().replace("vt 0 0", "cstype bezier"), "line 5", "curved surface"),
    ];
    for (format, text, place, what) in cases {
        let parse = if format == "stl" { parse_stl } else { parse_obj };
        let error = parse(text.as_bytes(), &format!("x.{format}"), 1.0).unwrap_err().to_string();
        assert!(error.contains(place) && error.contains(what) && error.contains(&format!("x.{format}")), "{error}");
    }
    let mut binary = as_binary("solid", &triangles());
    binary.pop();
    let error = parse_stl(&binary, "x.stl", 1.0).unwrap_err().to_string();
    assert!(error.contains("12 triangles") && error.contains("683"), "begins like a text and is none: {error}");
    binary[0] = b'b';
    let error = parse_stl(&binary, "x.stl", 1.0).unwrap_err().to_string();
    assert!(error.contains("12 triangles") && error.contains("683"), "{error}");
    let mut binary = as_binary("b", &triangles());
    binary[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = parse_stl(&binary, "x.stl", 1.0).unwrap_err().to_string();
    assert!(error.contains("triangle 2"), "{error}");
}

#[test]
fn surfaces_without_two_sides_are_refused() {
    let build = |t: &[[[f64; 3]; 3]]| {
        let raw = parse_stl(as_text(t).as_bytes(), "x.stl", 1.0).unwrap();
        Triangles::new(raw, "x", Side::Outside, 30.0).map(|_| ()).unwrap_err().to_string()
    };
    let mut turned = triangles();
    turned[3].swap(0, 1);
    let error = build(&turned);
    assert!(error.contains("opposite sides") && error.contains("line 23"), "{error}");
    let mut walled = triangles();
    walled.push([corner(0), corner(1), corner(6)]);
    let error = build(&walled);
    assert!(error.contains("3 triangles share one edge") && error.contains("line 86"), "{error}");
}

#[test]
fn whatever_the_bytes_nothing_panics() {
    let mut state = 7u64;
    let mut noise = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let files = [as_text(&triangles()).into_bytes(), as_binary("solid", &triangles()), as_obj().into_bytes()];
    for round in 0..3000 {
        let mut bytes = files[round % 3].clone();
        for _ in 0..1 + noise(4) {
            let at = noise(bytes.len());
            match noise(4) {
                0 => bytes[at] = noise(256) as u8,
                1 => bytes.truncate(at.max(1)),
                2 => bytes.insert(at, b"-/ 9\n.e\\"[noise(8)]),
                _ => drop(bytes.remove(at)),
            }
            if bytes.is_empty() {
                break;
            }
        }
        for parse in [parse_stl, parse_obj] {
            if let Ok(surface) = parse(&bytes, "x", 1.0).and_then(|raw| Triangles::new(raw, "x", Side::Outside, 30.0)) {
                let _ = crate::contact::Obstacle::Surface(surface.into()).distance([0.3, 0.4, 2.0]);
            }
        }
    }
}
