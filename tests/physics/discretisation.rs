//! The estimate of the discretisation error beside errors that are known.

use std::array::from_fn;
use std::sync::Arc;

use stiction::accuracy::{Estimate, Straining, estimate};
use stiction::contact::{ContactSurface, SurfaceFriction, pose};
use stiction::fem::elements::{Element, Hex8, Hex20, Tet4, Tet10, Wedge6, Wedge15, volume_points};
use stiction::fem::{Field, Fix, Formulation, Material, Solid, assemble, full_displacement};
use stiction::mesh::{Block, BlockElement, CellKind, Mesh, block};
use stiction_fixtures::case_run::{self, CORNER};
use stiction_fixtures::{FLOOR, solved};

type V3 = [f64; 3];

const ELEMENTS: [BlockElement; 6] = [
    BlockElement::Tet4Six,
    BlockElement::Hex8,
    BlockElement::Wedge6,
    BlockElement::Tet10Six,
    BlockElement::Hex20,
    BlockElement::Wedge15,
];

fn cube(element: BlockElement, cells: [usize; 3]) -> Mesh {
    block(&Block { size: [1.0; 3], cells, origin: [0.0; 3], grading: [1.0; 3], element }).unwrap()
}

/// The mesh with its inner corners moved by up to `part` of a cell, edges straight.
fn distorted(mut mesh: Mesh, part: f64) -> Mesh {
    let old = mesh.nodes.clone();
    let inside = |x: &V3| x.iter().all(|c| (1e-9..1.0 - 1e-9).contains(c));
    for (i, x) in mesh.nodes.iter_mut().enumerate().filter(|(_, x)| inside(x)) {
        *x = from_fn(|c| x[c] + part * (12.9898 * (i * 3 + c) as f64).sin());
    }
    let cells: Vec<(CellKind, Vec<u32>)> = mesh.cell_iter().map(|(kind, nodes)| (kind, nodes.to_vec())).collect();
    for (kind, nodes) in cells {
        for (k, ends) in kind.edges().iter().enumerate() {
            let [a, b] = ends.map(|end| mesh.nodes[nodes[end] as usize]);
            mesh.nodes[nodes[kind.linear().nodes() + k] as usize] = from_fn(|c| 0.5 * (a[c] + b[c]));
        }
    }
    assert!(part == 0.0 || old != mesh.nodes);
    mesh
}

fn steel() -> Material {
    let formulation = Formulation::Full;
    Material { name: "steel".into(), young: 210e3, poisson: 0.3, formulation, ..Material::default() }
}

/// What to solve: `u` is prescribed on `held`, and the lowest side stands on a plane.
struct Posed<'a> {
    mesh: &'a Mesh,
    materials: &'a [Material],
    material_of_cell: &'a [u32],
    held: &'a [&'a str],
    u: fn(V3) -> V3,
    floor: Option<SurfaceFriction>,
}

impl Posed<'_> {
    /// Displacements of all nodes, and the estimate.
    fn solved(&self) -> (Vec<f64>, Estimate) {
        let Posed { mesh, materials, material_of_cell, .. } = *self;
        let solid = Solid { mesh, materials, material_of_cell };
        let faces = |name: &str| mesh.group(name).unwrap().faces.clone();
        let component = |c: usize| {
            let u = self.u;
            Some(Field::Function { text: "in the test".into(), value: Arc::new(move |x, _| u(x)[c]) })
        };
        let fix =
            |name: &&str| Fix { nodes: mesh.face_nodes(&faces(name)), value: from_fn(component), ..Fix::default() };
        let fixes: Vec<Fix> = self.held.iter().map(fix).collect();
        let mut model = assemble(&solid, &[], &fixes, 1.0).unwrap();
        let surface = |friction: &SurfaceFriction| ContactSurface {
            name: "floor".into(),
            faces: faces("z-min"),
            against: FLOOR.into(),
            friction: friction.clone(),
            stiffness: None,
            periods: vec![stiction::contact::ALWAYS],
        };
        let surfaces: Vec<ContactSurface> = self.floor.iter().map(surface).collect();
        let (problem, _) = pose(mesh, &mut model, &surfaces).unwrap();
        let u = full_displacement(&model, &solved(&problem, 1e-11).u);
        let estimate = self.estimate(&u);
        (u, estimate)
    }

    fn estimate(&self, u: &[f64]) -> Estimate {
        let Posed { mesh, materials, material_of_cell, .. } = *self;
        let straining = Straining { displacement: u, initial: &[], rise: &[], cuts: &[], region: material_of_cell };
        estimate(&Solid { mesh, materials, material_of_cell }, &straining)
    }
}

const SIDES: [&str; 5] = ["x-min", "x-max", "y-min", "y-max", "z-max"];

/// Uniform stress under uniform slip (friction is mu gamma over the pressure) and where all sticks: no mesh has an error,
/// however it is distorted.
#[test]
fn uniform_stress_over_a_sliding_or_sticking_surface_has_no_error() {
    let slide: fn(V3) -> V3 = |x| [0.02 + 1e-3 * x[0] + 4e-4 * x[2], 0.0, -2e-3 * x[2]];
    let stick: fn(V3) -> V3 = |x| [4e-4 * x[2], 0.0, -2e-3 * x[2]];
    let (mu, lambda) = (210e3 / 2.6, 210e3 * 0.3 / (1.3 * 0.4));
    let pressure = -(lambda * (1e-3 - 2e-3) - 2.0 * mu * 2e-3);
    let coefficient = mu * 4e-4 / pressure;
    for (u, coefficient) in [(slide, coefficient), (stick, 0.5)] {
        for element in ELEMENTS {
            for part in [0.0, 0.06] {
                let mesh = distorted(cube(element, [3, 4, 3]), part);
                let posed = Posed {
                    mesh: &mesh,
                    materials: &[steel()],
                    material_of_cell: &vec![0; mesh.cell_count()],
                    held: &SIDES,
                    u,
                    floor: Some(SurfaceFriction::Coulomb(coefficient)),
                };
                let (found, estimate) = posed.solved();
                let off = found.as_chunks::<3>().0.iter().zip(&mesh.nodes).flat_map(|(found, x)| {
                    let wanted = u(*x);
                    (0..3).map(move |c: usize| (found[c] - wanted[c]).abs())
                });
                assert!(off.fold(0.0, f64::max) < 1e-12, "{element:?} {part}: no uniform stress");
                assert!(
                    estimate.norm2 > 0.0 && estimate.relative() < 1e-9,
                    "{element:?} {part}: {}",
                    estimate.relative()
                );
            }
        }
    }
}

/// Bars of different stiffness side by side, stretched alike: stress jumps from one to the other.
#[test]
fn a_jump_of_stress_between_materials_is_no_error() {
    let bar = |young| Material { young, poisson: 0.0, ..steel() };
    for element in ELEMENTS {
        let mesh = cube(element, [3, 4, 2]);
        let middle = |nodes: &[u32]| nodes.iter().map(|&i| mesh.nodes[i as usize][1]).sum::<f64>() / nodes.len() as f64;
        let material_of_cell: Vec<u32> = mesh.cell_iter().map(|(_, nodes)| u32::from(middle(nodes) > 0.5)).collect();
        let posed = Posed {
            mesh: &mesh,
            materials: &[bar(210e3), bar(3e3)],
            material_of_cell: &material_of_cell,
            held: &["x-min", "x-max"],
            u: |x| [1e-3 * x[0], 0.0, 0.0],
            floor: None,
        };
        let (u, estimate) = posed.solved();
        assert!(estimate.relative() < 1e-9, "{element:?}: {}", estimate.relative());
        let one = Posed { materials: &[bar(210e3), bar(210e3)], ..posed };
        assert!(one.estimate(&u).relative() < 1e-9);
    }
}

/// Waves along the floor.
const K: V3 = [1.3, 0.9, 1.581_138_830_084_189_8];

/// `u = ∇φ` with `φ = cosh(k z) sin(k1 x + k2 y - 2.8)` and `k² = k1² + k2²`: harmonic, so nothing acts inside. The floor
/// at z = 0 is a plane of symmetry pressed all over, as the sine is negative there.
fn smooth(x: V3) -> V3 {
    let ([k1, k2, k], phase) = (K, K[0] * x[0] + K[1] * x[1] - 2.8);
    let (c, s) = ((k * x[2]).cosh(), (k * x[2]).sinh());
    [1e-3 * k1 * c * phase.cos(), 1e-3 * k2 * c * phase.cos(), 1e-3 * k * s * phase.sin()]
}

/// Its stress, `2 mu` times the second derivatives of `φ`.
fn smooth_stress(x: V3, mu: f64) -> [f64; 6] {
    let ([k1, k2, k], phase) = (K, K[0] * x[0] + K[1] * x[1] - 2.8);
    let (c, s) = ((k * x[2]).cosh(), (k * x[2]).sinh());
    let (sine, cosine) = phase.sin_cos();
    let second = [-k1 * k1 * c * sine, -k2 * k2 * c * sine, k * k * c * sine];
    let mixed = [-k1 * k2 * c * sine, k * k2 * s * cosine, k * k1 * s * cosine];
    from_fn(|i| 2e-3 * mu * if i < 3 { second[i] } else { mixed[i - 3] })
}

/// Energy norm of the difference between the stress of `u` in a cell and [`smooth_stress`], squared.
fn squared_error(mesh: &Mesh, (kind, nodes): (CellKind, &[u32]), u: &[f64]) -> f64 {
    fn stress<const N: usize, const Q: usize>(
        e: Element<N, Q>,
        nodes: &[u32],
        u: &[f64],
        lame: [f64; 2],
    ) -> Vec<[f64; 6]> {
        let at = |gradient: &[V3; N]| {
            let h = |a: usize, b: usize| (0..N).map(|i| u[3 * nodes[i] as usize + a] * gradient[i][b]).sum::<f64>();
            let pressure = lame[0] * (0..3).map(|a| h(a, a)).sum::<f64>();
            let shear = |a, b| lame[1] * (h(a, b) + h(b, a));
            [
                pressure + shear(0, 0),
                pressure + shear(1, 1),
                pressure + shear(2, 2),
                shear(0, 1),
                shear(1, 2),
                shear(0, 2),
            ]
        };
        e.gradient.iter().map(at).collect()
    }
    let (young, poisson) = (210e3, 0.3);
    let lame = [young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))];
    let x = |i: usize| mesh.nodes[nodes[i] as usize];
    let found = match kind {
        CellKind::Tet4 => vec![stress(Tet4::new(&from_fn(x)).unwrap(), nodes, u, lame)[0]; 4],
        CellKind::Hex8 => stress(Hex8::new(&from_fn(x)).unwrap(), nodes, u, lame),
        CellKind::Tet10 => stress(Tet10::new(&from_fn(x)).unwrap(), nodes, u, lame),
        CellKind::Hex20 => stress(Hex20::new(&from_fn(x)).unwrap(), nodes, u, lame),
        CellKind::Wedge6 => stress(Wedge6::new(&from_fn(x)).unwrap(), nodes, u, lame),
        CellKind::Wedge15 => stress(Wedge15::new(&from_fn(x)).unwrap(), nodes, u, lame),
    };
    let points = volume_points(kind, mesh, nodes).unwrap();
    let density = |(point, found): (&stiction::fem::elements::VolumePoint, &[f64; 6])| {
        let exact = smooth_stress(point.position, lame[1]);
        let d: [f64; 6] = from_fn(|k| exact[k] - found[k]);
        let (trace, direct) = (d[0] + d[1] + d[2], d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        let shear = d[3] * d[3] + d[4] * d[4] + d[5] * d[5];
        point.weight / young * ((1.0 + poisson) * (direct + 2.0 * shear) - poisson * trace * trace)
    };
    points.iter().zip(&found).map(density).sum()
}

/// On a smooth solution in contact the estimate is near the true error and both fall with their order.
#[test]
fn the_estimate_of_a_smooth_solution_in_contact_is_near_its_error() {
    let meshes = [
        (BlockElement::Tet4Six, [6, 12], 1.0, 1.15),
        (BlockElement::Hex8, [6, 12], 1.0, 1.15),
        (BlockElement::Tet10Six, [4, 8], 2.0, 1.15),
        (BlockElement::Hex20, [4, 8], 2.0, 1.15),
        (BlockElement::Wedge6, [6, 12], 1.0, 1.15),
        // Polynomials through the nodes of quadratic wedges are less accurate: the estimate is on the safe side.
        (BlockElement::Wedge15, [4, 8], 2.0, 1.3),
    ];
    for (element, counts, order, most) in meshes {
        for part in [0.0, 0.12] {
            let errors = counts.map(|n| {
                let mesh = distorted(cube(element, [n; 3]), part / n as f64);
                let posed = Posed {
                    mesh: &mesh,
                    materials: &[steel()],
                    material_of_cell: &vec![0; mesh.cell_count()],
                    held: &SIDES,
                    u: smooth,
                    floor: Some(SurfaceFriction::None),
                };
                let (u, estimate) = posed.solved();
                let squares: Vec<f64> = mesh.cell_iter().map(|cell| squared_error(&mesh, cell, &u)).collect();
                [squares.iter().sum::<f64>().sqrt(), estimate.error2().sqrt(), estimate.norm2.sqrt()]
            });
            let effectivity = errors.map(|[error, estimate, _]| estimate / error);
            let rates: [f64; 2] = from_fn(|k| (errors[0][k] / errors[1][k]).log2());
            let told = format!("{element:?} {part}: {errors:?} {effectivity:?} {rates:?}");
            assert!((0.9..most).contains(&effectivity[1]), "{told}");
            assert!((rates[0] - order).abs() < 0.25 && (order - 0.25..order + 0.6).contains(&rates[1]), "{told}");
        }
    }
}

/// The brick without friction: the energy norm of the error is `√(2 (J_h - J))`, and J = -72.6928(5) is known from a
/// sequence of refined meshes (to four digits from both sides, by bounds).
#[test]
fn the_estimate_of_the_brick_is_near_the_error_its_energy_tells() {
    let meshes = [
        ("element = \"tet4\", split = \"six\"", [24, 8, 8]),
        ("element = \"hex8\"", [24, 8, 8]),
        ("element = \"tet10\", split = \"six\"", [12, 4, 4]),
        ("element = \"hex20\"", [12, 4, 4]),
    ];
    for (element, cells) in meshes {
        let rest = case_run::CASE.split_once("[materials").unwrap().1.replace("coulomb = 0.35", "coulomb = 0");
        let text = case_run::block([3.0, 1.0, 1.0], cells, element) + "[materials" + &rest;
        let (outcome, prepared) = case_run::solved(&text);
        let (elastic, u) = (&prepared.problem.elastic, &outcome.solution.u);
        let energy: f64 = elastic.K.times(u).iter().zip(&elastic.f).zip(u).map(|((k, f), u)| (0.5 * k - f) * u).sum();
        let error = (2.0 * (energy + 72.6928)).sqrt();
        let estimate = outcome.estimate.unwrap();
        let told = format!(
            "{element}: error {error}, estimate {}, relative {}",
            estimate.error2().sqrt(),
            estimate.relative()
        );
        assert!((0.85..1.2).contains(&(estimate.error2().sqrt() / error)), "{told}");
        assert!((estimate.norm2.sqrt() / 12.05 - 1.0).abs() < 0.05, "{told}");
    }
}

/// Free expansion under a temperature that varies along a line, and a bar that a bolt tightens between rigid ends: the
/// stress is none and uniform.
#[test]
fn strain_without_stress_is_no_error() {
    let steel = "[materials.steel]\nyoung = 200e3\npoisson = 0.0\nexpansion = 12e-6\nreference_temperature = 20\n";
    let points = "[[fix]]\non = { point = [0, 0, 0] }\n[[fix]]\non = { point = [4, 0, 0] }\ncomponents = \"yz\"\n\
                  [[fix]]\non = { point = [0, 2, 0] }\ncomponents = \"z\"\n";
    for element in ["tet10", "hex20"] {
        let mesh = case_run::block([4.0, 2.0, 2.0], [4, 2, 2], &format!("element = \"{element}\""));
        let text = mesh + steel + points + "[[load]]\ntemperature = \"20 + 30*x - 5*y\"\n";
        let (outcome, _) = case_run::solved(&text);
        let estimate = outcome.estimate.unwrap();
        let left = ((estimate.norm2 + estimate.error2()) / estimate.suppressed2).sqrt();
        assert!(estimate.suppressed2 > 0.0 && left < 1e-9, "{element}: {left}");
        assert_eq!(estimate.relative(), 0.0);
    }
    for element in ["tet4", "hex8", "tet10", "hex20"] {
        let mesh = case_run::block([4.0, 2.0, 2.0], [4, 2, 2], &format!("element = \"{element}\""));
        let ends = "[[fix]]\non = \"x-min\"\n[[fix]]\non = \"x-max\"\n";
        let bolt = "[[bolt]]\non = \"body\"\naxis = [1, 0, 0]\npoint = [2, 0, 0]\nshortening = 1e-3\n";
        let (outcome, _) = case_run::solved(&(mesh + steel + ends + bolt));
        let estimate = outcome.estimate.unwrap();
        // E (s/L)² V
        assert!((estimate.norm2 / (200e3 * (1e-3f64 / 4.0).powi(2) * 16.0) - 1.0).abs() < 1e-9, "{element}");
        assert!(estimate.relative() < 1e-9, "{element}: {}", estimate.relative());
    }
}

/// A body that is moved without strain has no stress and no error; one that is strained by little on its way has that of the same strain at rest.
#[test]
fn a_rigid_motion_is_no_error() {
    for element in ["tet4", "hex8", "tet10", "hex20", "wedge6", "wedge15"] {
        let estimate = |way: f64, stretch: f64| {
            let text = case_run::block([1.0, 1.0, 1.0], [4, 3, 3], &format!("element = \"{element}\""))
                + &format!(
                    "[materials.steel]\nyoung = 200e3\npoisson = 0.3\n[[fix]]\non = \"x-min\"\nvalue = [{way:e}, 0, {:e}]\n\
                     [[fix]]\non = \"x-max\"\nvalue = [{:e}, 0, {:e}]\n",
                    -way,
                    way + stretch,
                    -way
                );
            case_run::solved(&text).0.estimate.unwrap().relative()
        };
        assert_eq!(estimate(3e-2, 0.0), 0.0, "{element}");
        let at_rest = estimate(0.0, 1e-9);
        assert!(at_rest > 0.02, "{element}: {at_rest}");
        let moved = estimate(3e-2, 1e-9);
        assert!((moved / at_rest - 1.0).abs() < 1e-4, "{element}: {moved} {at_rest}");
    }
}

/// To the bit.
#[test]
fn the_estimate_does_not_depend_on_the_number_of_threads() {
    for (element, cells) in ELEMENTS.into_iter().zip([16, 18, 9, 9]) {
        let mesh = distorted(cube(element, [cells; 3]), 0.01);
        let u: Vec<f64> = mesh.nodes.iter().flat_map(|x| smooth(*x)).collect();
        let posed = Posed {
            mesh: &mesh,
            materials: &[steel()],
            material_of_cell: &vec![0; mesh.cell_count()],
            held: &SIDES,
            u: smooth,
            floor: None,
        };
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| posed.estimate(&u))
        };
        let one = by(1);
        assert!(one.error2() > 0.0 && [2, 5].into_iter().all(|threads| by(threads) == one), "{element:?}");
    }
}

/// Uniaxial tension is uniform also where the material is nearly incompressible or orthotropic.
#[test]
fn uniform_tension_of_any_law_has_no_error() {
    let laws = [
        "young = 10\npoisson = 0.4999",
        "young = [11000, 900, 500]\npoisson = [0.4, 0.45, 0.3]\nshear = [700, 600, 60]",
    ];
    for law in laws {
        for element in ["tet4", "hex8", "tet10", "hex20"] {
            let mesh = case_run::block([4.0, 2.0, 2.0], [3, 2, 2], &format!("element = \"{element}\""));
            let text = mesh + "[materials.any]\n" + law + "\n" + CORNER + "[[load]]\non = \"x-max\"\npressure = -3\n";
            let (outcome, _) = case_run::solved(&text);
            let estimate = outcome.estimate.unwrap();
            let young = if law.contains('[') { 11000.0 } else { 10.0 };
            assert!((estimate.norm2 / (9.0 / young * 16.0) - 1.0).abs() < 1e-7, "{element}");
            assert!(estimate.relative() < 1e-7, "{element}: {}", estimate.relative());
        }
    }
}
