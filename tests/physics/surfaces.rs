//! Obstacles of triangles: distances against closed forms, contact against the smooth obstacles they stand for.

use std::sync::Arc;

use stiction::contact::{Obstacle, RawSurface, Side, SurfaceFriction, Triangles};
use stiction::io::surface::parse_stl;
use stiction::mesh::BlockElement;
use stiction_fixtures::*;

type V3 = [f64; 3];

fn surface(triangles: &[[V3; 3]], side: Side) -> Triangles {
    let mut raw = RawSurface::new("number");
    for (number, t) in triangles.iter().enumerate() {
        let corners = t.map(|x| raw.point(x));
        raw.triangle(corners, number + 1);
    }
    Triangles::new(raw.finish(), "made here", side, 30.0).unwrap()
}

fn obstacle(triangles: &[[V3; 3]]) -> Obstacle {
    Obstacle::Surface(Arc::new(surface(triangles, Side::Outside)))
}

/// The cube from -1 to 1, its faces cut into `2 n²` triangles.
fn cube(n: usize) -> Vec<[V3; 3]> {
    let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let mut triangles = Vec::new();
    for (axis, end) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        let place = |i: usize, j: usize| {
            let mut x = [end; 3];
            // Counter-clockwise seen from outside.
            let (first, second) =
                if end > 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            (x[first], x[second]) = (at(i), at(j));
            x
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [a, b, c, d] = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// A ball of radius `r` around `c`: an octahedron whose faces are cut into `n²`, pushed out, in no special position.
fn ball(n: usize, r: f64, c: V3) -> Vec<[V3; 3]> {
    let push = |x: V3| {
        let l = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
        let [x, y, z] = x.map(|v| r * v / l);
        // Turned about two axes.
        let (x, y) = (0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y);
        let (y, z) = (0.28 * y - 0.96 * z, 0.96 * y + 0.28 * z);
        [c[0] + x, c[1] + y, c[2] + z]
    };
    let mut triangles = Vec::new();
    for signs in 0..8 {
        let s = [0, 1, 2].map(|b| if signs >> b & 1 == 1 { -1.0 } else { 1.0 });
        let point = |i: usize, j: usize| {
            let k = n - i - j;
            push([s[0] * i as f64, s[1] * j as f64, s[2] * k as f64])
        };
        let mut add = |[a, b, c]: [V3; 3]| triangles.push(if s[0] * s[1] * s[2] > 0.0 { [a, b, c] } else { [a, c, b] });
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            add([point(i, j), point(i + 1, j), point(i, j + 1)]);
            if i + j + 2 <= n {
                add([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
            }
        }
    }
    triangles
}

fn noise() -> impl FnMut() -> f64 {
    let mut state = 5u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[test]
fn distances_from_a_cube_are_those_of_the_formula_inside_and_outside() {
    let mut noise = noise();
    for n in [1, 5] {
        let (outside, inside) = (surface(&cube(n), Side::Outside), surface(&cube(n), Side::Inside));
        assert_eq!((outside.border_edges, outside.sharp_edges), (0, 12 * n));
        assert!((outside.volume - 8.0).abs() < 1e-13);
        let (outside, inside) = (Obstacle::Surface(outside.into()), Obstacle::Surface(inside.into()));
        for i in 0..3000 {
            // Some exactly in the planes of faces and over edges and corners.
            let x: V3 = std::array::from_fn(|c| if i % 5 == c { noise().signum() } else { 2.0 * noise() });
            let beyond = x.map(|v: f64| (v.abs() - 1.0).max(0.0));
            let deep = x.iter().fold(f64::INFINITY, |d: f64, v| d.min(1.0 - v.abs()));
            let far = beyond.iter().map(|v| v * v).sum::<f64>().sqrt();
            let expected = if deep >= 0.0 { -deep } else { far };
            let (distance, normal) = outside.distance(x).unwrap();
            assert!((distance - expected).abs() < 1e-13, "{x:?}: {distance} {expected}");
            let (other, away) = inside.distance(x).unwrap();
            assert!(other == -distance && away == normal.map(|v| 0.0 - v));
            // Clear of the fillets the normal is the gradient.
            if far > 0.2 {
                let gradient = [0, 1, 2].map(|c| x[c].signum() * beyond[c] / far);
                let apart = (0..3).map(|c| (gradient[c] - normal[c]).powi(2)).sum::<f64>().sqrt();
                assert!(apart < 0.02, "{x:?} {normal:?} {gradient:?}");
            }
        }
    }
}

#[test]
fn the_normal_turns_gradually_around_an_edge_however_close() {
    let cube = obstacle(&cube(3));
    // Along a path over one face, around the edge at x = z = 1 and down the next, at several heights, 0 included.
    for height in [0.0, 1e-9, 1e-4, 1e-2] {
        let step = 1e-5;
        let mut before: Option<V3> = None;
        let mut place = |x: V3| {
            let (_, normal) = cube.distance(x).unwrap();
            if let Some(old) = before {
                let turn = (0..3).map(|c| (old[c] - normal[c]).powi(2)).sum::<f64>().sqrt();
                // A quarter turn over a fillet of 3.5e-3 and more, whatever the height.
                assert!(turn < 0.01, "{height} {x:?} {old:?} {normal:?}");
            }
            before = Some(normal);
        };
        (0..1000).for_each(|i| place([0.99 + f64::from(i) * step, 0.1, 1.0 + height]));
        let quarter = std::f64::consts::FRAC_PI_2;
        (0..=1000)
            .map(|i| f64::from(i) / 1000.0 * quarter)
            .for_each(|a| place([1.0 + height * a.sin(), 0.1, 1.0 + height * a.cos()]));
        (0..1000).for_each(|i| place([1.0 + height, 0.1, 1.0 - f64::from(i) * step]));
    }
}

/// A prism along y over the polygon of these corners in x and z, counter-clockwise seen against y; its ends are open.
fn prism(polygon: &[[f64; 2]]) -> Vec<[V3; 3]> {
    let side = |(i, &[x, z]): (usize, &[f64; 2])| {
        let [u, w] = polygon[(i + 1) % polygon.len()];
        let [a, b, c, d] = [[x, -1.0, z], [u, -1.0, w], [u, 1.0, w], [x, 1.0, z]];
        [[a, c, b], [a, d, c]]
    };
    polygon.iter().enumerate().flat_map(side).collect()
}

/// What a node exactly over an edge meets does not hang on the last digit, wherever the obstacle stands and however it is turned: of a
/// box the top, of a ridge the mean of its flanks, of a prism with twelve sides the same at all its edges.
#[test]
fn rounding_does_not_choose_the_side_of_an_edge() {
    let ridge = [[0.0, 0.0], [-1.0, -0.4], [1.0, -0.4]];
    let round: Vec<[f64; 2]> =
        (0..12).map(|i| f64::from(i) * std::f64::consts::PI / 6.0).map(|a| [-a.sin(), a.cos() - 1.0]).collect();
    let low: Vec<[V3; 3]> = cube(1).iter().map(|t| t.map(|[x, y, z]| [x, y, z - 1.0])).collect();
    let shapes = [
        ("box", low, [[1.0, 0.3, 0.0], [1.0, 1.0, 0.0], [-1.0, 0.0, 0.0]].to_vec()),
        ("ridge", prism(&ridge), [[0.0, 0.3, 0.0], [0.0, -0.7, 0.0]].to_vec()),
        ("prism", prism(&round), [[0.0, 0.3, 0.0], [0.0, -0.7, 0.0]].to_vec()),
    ];
    let mut noise = noise();
    for (name, triangles, nodes) in shapes {
        for case in 0..400 {
            // Turned about all axes, moved, and known to some digits.
            let turns: [f64; 3] = std::array::from_fn(|_| if case == 0 { 0.0 } else { 3.0 * noise() });
            let turn = |mut x: V3| {
                for (c, angle) in turns.iter().enumerate() {
                    let (i, j) = ((c + 1) % 3, (c + 2) % 3);
                    let (sin, cos) = angle.sin_cos();
                    (x[i], x[j]) = (cos * x[i] - sin * x[j], sin * x[i] + cos * x[j]);
                }
                x
            };
            let rounding = [0.0, 1e-15, 1e-12, 1e-9, 1e-7][case % 5];
            let by: V3 = std::array::from_fn(|_| 10.0 * noise());
            let mut put = |x: V3| -> V3 {
                let x = turn(x);
                std::array::from_fn(|c| x[c] + by[c] + rounding * noise())
            };
            // Corners of triangles are the same points after rounding as before.
            let mut places: Vec<(V3, V3)> = Vec::new();
            let moved: Vec<[V3; 3]> = (triangles.iter())
                .map(|t| {
                    t.map(|x| match places.iter().find(|p| p.0 == x) {
                        Some(&(_, there)) => there,
                        None => {
                            let there = put(x);
                            places.push((x, there));
                            there
                        }
                    })
                })
                .collect();
            let obstacle = obstacle(&moved);
            for &node in &nodes {
                let (distance, normal) = obstacle.distance_facing(put(node), turn([0.0, 0.0, -1.0])).unwrap();
                let up = turn([0.0, 0.0, 1.0]);
                let apart = (0..3).map(|c| (up[c] - normal[c]).powi(2)).sum::<f64>().sqrt();
                assert!(distance.abs() < 10.0 * rounding + 1e-13, "{name} {rounding} {node:?}: {distance}");
                assert!(apart < 1e3 * rounding + 1e-10, "{name} {rounding} {node:?}: {normal:?} for {up:?}");
            }
        }
    }
}

/// A body on a closed box whose triangles look into it is not in that box.
#[test]
fn a_surface_turned_inside_out_is_refused() {
    let low: Vec<[V3; 3]> = cube(2).iter().map(|t| t.map(|[x, y, z]| [3.0 * x, 3.0 * y, z - 1.0])).collect();
    let turned: Vec<[V3; 3]> = low.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let pose = |triangles: &[[V3; 3]], side: Side| {
        let obstacle = Obstacle::Surface(Arc::new(surface(triangles, side)));
        let case = block_of([1.0; 3], [3, 3, 3], BlockElement::Hex8, 1e9, 0.3).fix("z-max", HELD);
        case.contact("z-min", obstacle, SurfaceFriction::None).try_pose().map(|posed| posed.facts[0].gap_max)
    };
    for (triangles, side) in [(&low, Side::Outside), (&turned, Side::Inside)] {
        assert_eq!(pose(triangles, side), Ok(0.0));
    }
    for (triangles, side) in [(&turned, Side::Outside), (&low, Side::Inside)] {
        let refused = pose(triangles, side).unwrap_err();
        assert!(refused.what.contains("does not lie in the closed surface"), "{refused}");
    }
}

/// A box without one of its sides whose triangles look into it turns its back to the body on it: the body meets the inside of its
/// floor. Jaws around a thin body do not, whichever is nearer.
#[test]
fn an_open_surface_turned_inside_out_is_told() {
    let moved = |up: f64| move |t: &[V3; 3]| t.map(|[x, y, z]| [3.0 * x, 3.0 * y, z + up]);
    let turned = |list: &[[V3; 3]]| list.iter().map(|&[a, b, c]| [a, c, b]).collect::<Vec<_>>();
    let low: Vec<[V3; 3]> = cube(2).iter().map(moved(-1.0)).collect();
    let is_side = |t: &&[V3; 3]| t.iter().all(|x| x[0] == 3.0);
    let open: Vec<[V3; 3]> = low.iter().filter(|t| !is_side(t)).copied().collect();
    let told = |triangles: &[[V3; 3]], side: Side, group: &str| {
        let obstacle = Obstacle::Surface(Arc::new(surface(triangles, side)));
        let case = block_of([1.0, 1.0, 0.3], [3, 3, 1], BlockElement::Hex8, 1e9, 0.3).fix("x-max", HELD);
        let facts = &case.contact(group, obstacle, SurfaceFriction::None).pose().facts[0];
        (facts.behind_backs, facts.gap_max)
    };
    assert_eq!(told(&open, Side::Outside, "z-min"), (0, 0.0));
    assert_eq!(told(&turned(&open), Side::Inside, "z-min"), (0, 0.0));
    // All nodes but those that are held.
    assert_eq!(told(&turned(&open), Side::Outside, "z-min"), (12, 2.0));
    assert_eq!(told(&open, Side::Inside, "z-min"), (12, 2.0));
    // The floor at a distance of 0.4, the ceiling 0.1 above the body.
    let floor: Vec<[V3; 3]> = open.iter().map(|t| t.map(|[x, y, z]| [x, y, z - 0.4])).collect();
    let ceiling: Vec<[V3; 3]> = cube(2).iter().map(moved(1.4)).filter(|t| !is_side(&t)).collect();
    for group in ["z-min", "z-max"] {
        assert_eq!(told(&[floor.clone(), ceiling.clone()].concat(), Side::Outside, group).0, 0, "{group}");
    }
}

#[test]
fn beyond_the_border_of_an_open_surface_nothing_is_met() {
    let plate = obstacle(&[
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
    ]);
    for (x, expected) in [
        ([0.3, 0.9, 0.7], Some(0.7)),
        ([0.3, 0.9, -0.7], Some(-0.7)),
        ([1.0, 0.5, 0.2], Some(0.2)),
        ([1.0, 1.0, -0.2], Some(-0.2)),
        ([1.01, 0.5, 0.2], None),
        ([1.01, 0.5, 0.0], None),
        ([-0.1, -0.1, -0.4], None),
    ] {
        let found = plate.distance(x);
        assert_eq!(found.map(|f| f.0), expected, "{x:?}");
        assert!(found.is_none_or(|f| f.1 == [0.0, 0.0, 1.0]));
    }
    // A block that hangs over the plate: only what stands over it has contact points.
    let case = || block_of([2.0, 1.0, 1.0], [8, 4, 4], BlockElement::Hex8, 1e9, 0.3).fix("z-max", HELD);
    let posed = case().contact("z-min", plate.clone(), SurfaceFriction::None).pose();
    assert_eq!((posed.facts[0].points, posed.facts[0].beyond), (25, 20));
    let away = case().contact("x-max", plate, SurfaceFriction::None).try_pose().map(|_| ()).unwrap_err();
    assert!(away.what.contains("beyond the border"), "{away}");
}

/// A mesh tool writes each corner once for each triangle, rounded differently: the ball stays closed, and its distances are those of the
/// sphere between its facets' planes and itself.
#[test]
fn a_ball_whose_corners_differ_in_the_last_digits_is_closed() {
    let (radius, n) = (30.0, 12);
    let mut noise = noise();
    for rounding in [1e-13, 1e-9, 1e-6] {
        let mut triangles = ball(n, radius, [0.0; 3]);
        triangles.iter_mut().flatten().flatten().for_each(|x| *x += rounding * noise());
        let ball = surface(&triangles, Side::Outside);
        assert_eq!((ball.border_edges, ball.triangles().len()), (0, 8 * n * n), "{rounding}");
        // Three corners of each triangle, of the points that an octahedron cut so has.
        assert_eq!(ball.stitched, 3 * 8 * n * n - (4 * n * n + 2));
        let sphere = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert!(ball.volume < sphere && ball.volume > 0.97 * sphere, "{}", ball.volume);
        let ball = Obstacle::Surface(ball.into());
        for _ in 0..1000 {
            let x: V3 = std::array::from_fn(|_| noise());
            let length = x.iter().map(|v| v * v).sum::<f64>().sqrt();
            let x = x.map(|v| 1.01 * radius * v / length);
            let (distance, _) = ball.distance(x).expect("a closed surface has a closest point everywhere");
            // Facets of 7.5 degrees lie 0.2 % of the radius below the sphere at most.
            assert!((distance - 0.01 * radius).abs() < 0.0025 * radius, "{distance}");
        }
    }
}

#[test]
fn a_flat_surface_is_a_plane_to_the_last_digits() {
    let law = SurfaceFriction::Coulomb(0.35);
    let a = brick(4, BlockElement::Tet4Six, BrickLoad::Lift, law.clone()).pose().problem;
    let mut case = brick(4, BlockElement::Tet4Six, BrickLoad::Lift, law);
    let corner = |x: f64, y: f64| [x, y, 0.0];
    let [p, q, r, s] = [corner(-1.0, -2.0), corner(5.0, -1.0), corner(4.0, 3.0), corner(-2.0, 2.0)];
    case.surfaces[0].against = obstacle(&[[p, q, r], [p, r, s]]).into();
    let b = case.pose().problem;
    let (a, b) = (solved(&a, 1e-11), solved(&b, 1e-11));
    assert!(distance(&a.u, &b.u) < 1e-12 && a.states == b.states);
}

#[test]
fn a_ball_of_triangles_approaches_the_sphere_as_they_get_smaller() {
    // A block pressed on a ball from above: displacements and forces against the analytic sphere.
    let (radius, centre) = (3.0, [0.4, 0.6, -3.02]);
    let pressed = |obstacle: Obstacle| {
        let case = block_of([1.0; 3], [6, 6, 4], BlockElement::Hex8, 1e9, 0.3)
            .fix("z-max", [Some(0.01), Some(0.0), Some(-0.05)])
            .contact("z-min", obstacle, SurfaceFriction::Coulomb(0.3));
        let p = case.pose().problem;
        let s = solved(&p, 1e-10);
        assert!(s.counts.newton_steps <= 20, "{:?}", s.counts);
        (s.u, normal_force(&p, &s.lambda))
    };
    let (u, force) = pressed(Obstacle::Sphere { center: centre, radius, side: Side::Outside });
    let mut last = f64::INFINITY;
    for n in [8, 16, 32, 64] {
        let (v, other) = pressed(obstacle(&ball(n, radius, centre)));
        let error = distance(&u, &v).max((force - other).abs() / force);
        println!("{n}: {error:.3e}");
        // Distances of second order in the size of the triangles, normals of first order at worst.
        assert!(error < 0.6 * last, "{n}: {error} after {last}");
        last = error;
    }
    assert!(last < 2e-3, "{last}");
}

#[test]
fn a_body_in_a_bore_of_triangles_is_held_by_its_walls() {
    // A block in a cube a little wider: the gap is the clearance, of nodes over edges and corners that to the floor.
    let room: Vec<[V3; 3]> = cube(2).iter().map(|t| t.map(|x| x.map(|v| 0.5 + 0.51 * v))).collect();
    let inside = Obstacle::Surface(Arc::new(surface(&room, Side::Inside)));
    let case = block_of([1.0; 3], [3, 3, 3], BlockElement::Hex8, 1e9, 0.3).fix("z-max", HELD);
    let posed = case.contact("z-min", inside, SurfaceFriction::None).pose();
    assert!((posed.facts[0].gap_min - 0.01).abs() < 1e-14 && (posed.facts[0].gap_max - 0.01).abs() < 1e-14);
    assert_eq!(posed.facts[0].facing_away, 0);
}

#[test]
fn a_ball_read_from_bytes_has_the_distances_of_a_sphere() {
    // A closed surface without holes has half as many points as triangles, and two; each distance is
    // that of the ball to the error of a chord.
    let n = 64;
    let triangles = ball(n, 1.0, [0.0; 3]);
    let mut bytes = vec![b'x'; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in &triangles {
        bytes.extend([0; 12]);
        t.iter().flatten().for_each(|c| bytes.extend((*c as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    let raw = parse_stl(&bytes, "ball.stl", 1.0).unwrap();
    assert_eq!((raw.triangles.len(), raw.points.len()), (8 * n * n, 4 * n * n + 2));
    let ball = Triangles::new(raw, "ball.stl", Side::Outside, 30.0).unwrap();
    assert_eq!((ball.border_edges, ball.sharp_edges), (0, 0));
    let ball = Obstacle::Surface(ball.into());
    let mut noise = noise();
    for _ in 0..1000 {
        let x: V3 = std::array::from_fn(|_| noise());
        let far = x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let x = x.map(|v| v * (1.0 + 0.02 * far) / far);
        let radius = x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let (distance, normal) = ball.distance(x).unwrap();
        // A chord of length h lies h²/8, here up to 0.7 / n², below its arc: most of that is seen.
        assert!((distance - (radius - 1.0)).abs() < 0.05 / (n * n) as f64, "{distance} {radius}");
        let apart = (0..3).map(|c| (normal[c] - x[c] / radius).powi(2)).sum::<f64>().sqrt();
        assert!(apart < 0.1 / n as f64, "{apart}");
    }
}

#[test]
fn a_case_with_a_plate_from_a_file_steps_like_the_same_case_on_a_plane() {
    let folder = folder::Folder::new("plate");
    // A plate in millimetres that stands upright along x before it is turned, its normal along -y.
    let [a, b, c, d] = ["-2e4 0 -2e4", "4e4 0 -2e4", "4e4 0 3e4", "-2e4 0 3e4"];
    let facet = |p: &str, q: &str, r: &str| {
        format!("facet normal 0 0 0\nouter loop\nvertex {p}\nvertex {q}\nvertex {r}\nendloop\nendfacet\n")
    };
    let text = format!("solid plate\n{}{}endsolid plate\n", facet(a, b, c), facet(a, c, d));
    folder.write("plate.stl", text);
    let case = |obstacle: &str| {
        let text = format!(
            "[mesh]\nblock = {{ size = [20, 10, 10], cells = [6, 4, 4], element = \"hex8\" }}\n\
             [materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = \"z-max\"\n\
             [[contact]]\non = \"z-min\"\nagainst = {{ {obstacle}, motion = [\"max(0, 0.02*(t - 1))\", \"0.01*t\", \"0.02*min(t, 1)\"] }}\n\
             friction = {{ coulomb = [\"0.2 + 0.01*x\", 0.1], direction = [1, 1, 0], limit = 60 }}\n\
             [[step]]\nuntil = 1\n[[step]]\nuntil = 2\nincrements = 2\n"
        );
        let path = folder.write("case.toml", text);
        let case = stiction::io::case::read(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
        let mut prepared = stiction::run::prepare(&case).unwrap_or_else(|e| panic!("{e}"));
        let settings = stiction::run::Settings::of(&case.solver);
        let on = |_: &stiction::run::Event| std::ops::ControlFlow::Continue(());
        let outcome =
            stiction::run::solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), &mut { on }).unwrap();
        assert!(outcome.steps.iter().all(|step| step.answer.certificate.passed));
        (prepared.facts.to_string(), outcome)
    };
    let (_, plane) = case("plane = { point = [0, 0, 0], normal = [0, 0, 1] }");
    let (facts, plate) =
        case("surface = \"plate.stl\", scale = 1e-3, turn = { axis = [1, 0, 0], degrees = 90 }, side = \"inside\"");
    assert!(facts.contains("plate.stl: 2 triangles, open with 4 edges on its border, 0 sharp edges"), "{facts}");
    assert!(plane.solution.states == plate.solution.states);
    assert!(distance(&plane.solution.u, &plate.solution.u) < 1e-7);
    let slipping = plane.solution.states.iter().filter(|&&s| s == stiction::friction::PointState::Slip).count();
    assert!(slipping > 5, "{slipping}");
}

#[test]
fn a_result_with_ellipses_a_limit_and_a_surface_is_judged_anew_from_its_files() {
    use stiction::run::{Origin, Settings, check, prepare, solve, write};
    let folder = folder::Folder::new("judged");
    let text = "[mesh]\nblock = { size = [2, 1, 1], cells = [6, 4, 4], element = \"hex8\" }\n\
        [materials.steel]\nyoung = 2e9\npoisson = 0.3\n[[fix]]\non = \"z-max\"\nvalue = [2e-3, 1e-3, -2e-3]\n\
        [[contact]]\non = \"z-min\"\nagainst = { surface = \"plate.obj\" }\n\
        friction = { coulomb = [0.1, \"0.2 + 0.1*x\"], direction = [1, 1, 0], limit = 5e5 }\n";
    folder.write("plate.obj", "v -1 -1 0\nv 4 -1 0\nv 4 4 0\nv -1 4 0\nf 1 2 3 4\n");
    let case = stiction::io::case::read(folder.write("case.toml", text), &[]).unwrap_or_else(|e| panic!("{e}"));
    let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let mut outcome =
        solve(&prepared, &Settings::of(&case.solver), &mut |_| std::ops::ControlFlow::Continue(())).unwrap();
    let origin = Origin { case_text: text.into(), ..Origin::default() };
    let results = folder.at("results");
    let files = write(&prepared, &mut outcome, &origin, &results).unwrap();
    assert!(files.iter().any(|file| file == "obstacles.vtu"), "{files:?}");
    let found = check(&results).unwrap_or_else(|e| panic!("{e}"));
    assert!(found.passed(), "{found:?}");
}

/// A plate glued to an obstacle is held at the faces that look at it, whether these are named or all faces of the plate are.
#[test]
fn glue_on_an_obstacle_holds_the_faces_that_look_at_it() {
    use stiction_fixtures::case_run;
    let run = |on: &str| {
        case_run::solved(&format!(
            "[mesh]\nblock = {{ size = [20, 20, 2], cells = [4, 4, 2], element = \"hex8\" }}\n\
             [materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[load]]\non = \"z-max\"\nforce = [50, 0, -1000]\n\
             [[contact]]\non = [{on}]\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\nfriction = \"bonded\"\n"
        ))
    };
    let [face, skin] = ["\"z-min\"", "\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-min\", \"z-max\""].map(run);
    let [a, b] = [&face, &skin].map(case_run::displacement);
    let top = a.iter().flatten().fold(0.0, |most: f64, c| c.abs().max(most));
    // Of the mean compression at least half is left: nothing holds the top.
    assert!(top > 0.5 * 2.0 * 1000.0 / 400.0 / 210e3 && skin.1.facts.points == 25);
    assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= 1e-9 * top));
}
