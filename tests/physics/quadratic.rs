//! Quadratic elements in contact: curved faces, and what they are worth.

use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;

use stiction::contact::{ContactSurface, Counterpart, InitialGap, Master, Reason, Role, SurfaceFriction, pose};
use stiction::dual::Form;
use stiction::fem::{Field, Fix, Formulation, Material, Solid, assemble};
use stiction::friction::solve;
use stiction::mesh::{Block, BlockElement, Mesh, block, join};
use stiction_fixtures::*;

const TET10: BlockElement = BlockElement::Tet10Five { parity: 0 };

/// A quarter of a ring with radii `r`, of height 10; the middles of edges lie on the arcs.
fn ring(element: BlockElement, cells: [usize; 3], r: [f64; 2]) -> Mesh {
    let (size, origin) = ([r[1] - r[0], FRAC_PI_2, 10.0], [r[0], 0.0, 0.0]);
    let mut mesh = block(&Block { size, cells, origin, grading: [1.0; 3], element }).unwrap();
    mesh.nodes.iter_mut().for_each(|x| *x = [x[0] * x[1].cos(), x[0] * x[1].sin(), x[2]]);
    mesh
}

fn zero(mesh: &Mesh, groups: [&str; 2], component: usize) -> Fix {
    let faces: Vec<u32> = groups.iter().flat_map(|g| mesh.group(g).unwrap().faces.clone()).collect();
    let mut value = [None, None, None];
    value[component] = Some(Field::Constant(0.0));
    Fix { nodes: mesh.face_nodes(&faces), value, ..Fix::default() }
}

/// Lamé 1852: a ring pressed into another that is 0.06 too tight, radii 40, 60, 90, plane stress, one material. The
/// pressure is `δ E (b² - a²) (c² - b²) / (2 b³ (c² - a²))`.
#[test]
fn a_shrink_fit_of_a_few_curved_cells_has_the_pressure_of_lame() {
    let (young, radii, tight) = (210e3, [40.0f64, 60.0, 90.0], 0.06);
    let [a2, b2, c2] = radii.map(|r| r * r);
    let pressure = tight * young * (b2 - a2) * (c2 - b2) / (2.0 * radii[1].powi(3) * (c2 - a2));
    let force = pressure * FRAC_PI_2 * radii[1] * 10.0;
    use BlockElement::{Hex8, Hex20};
    for elements in [[Hex20, Hex20], [Hex20, TET10], [TET10, Hex20], [Hex20, Hex8]] {
        let inner = ring(elements[0], [2, 6, 1], [radii[0], radii[1]]);
        let fine = if elements[1] == Hex8 { [4, 14, 1] } else { [2, 5, 1] };
        let outer = ring(elements[1], fine, [radii[1], radii[2]]);
        let mesh = join(vec![("inner".into(), inner), ("outer".into(), outer)]);
        let materials = [Material {
            name: "steel".into(),
            young,
            poisson: 0.3,
            formulation: Formulation::Full,
            ..Material::default()
        }];
        let material_of_cell = vec![0; mesh.cell_count()];
        let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &material_of_cell };
        let fixes = [
            zero(&mesh, ["inner.y-min", "outer.y-min"], 1),
            zero(&mesh, ["inner.y-max", "outer.y-max"], 0),
            zero(&mesh, ["inner.z-min", "outer.z-min"], 2),
        ];
        let mut model = assemble(&solid, &[], &fixes, 1.0).unwrap();
        let faces = |name: &str| mesh.group(name).unwrap().faces.clone();
        let master = Master {
            faces: faces("outer.x-min"),
            gap: InitialGap::Uniform(-tight),
            search: None,
            slave: Role::On,
            reason: Reason::Asked,
            nodes: None,
        };
        let surface = ContactSurface {
            name: "fit".into(),
            faces: faces("inner.x-max"),
            against: Counterpart::Surface(master),
            friction: SurfaceFriction::None,
            stiffness: None,
            periods: vec![stiction::contact::ALWAYS],
        };
        let (problem, facts) = pose(&mesh, &mut model, &[surface]).unwrap();
        let s = solved(&problem, 1e-9);
        let total: f64 = (0..problem.points()).map(|j| problem.labels.unity_sum[j] * s.lambda[j]).sum();
        let worst = (0..problem.points())
            .map(|j| (s.lambda[j] / problem.labels.area[j] / pressure - 1.0).abs())
            .fold(0.0, f64::max);
        let told = format!("{elements:?}, {} points: {total} of {force}, {worst}", facts[0].points);
        assert!((total / force - 1.0).abs() < 4e-3 && worst < 0.04, "{told}");
    }
}

/// Where the edge of contact lies within a cell makes single errors jump.
const DEPTHS: [f64; 4] = [0.7e-3, 0.85e-3, 1.0e-3, 1.15e-3];

/// A block of steel with a bottom curved like a ball of radius 10 on a rigid plane, pressed down at its top by each of
/// [`DEPTHS`], a quarter: (unknowns, force of the quarter, contact radius over that of Hertz less one).
///
/// Its edges are 10 contact radii long. The radius comes from the second moment of the nodal forces, `2/5 a²` of
/// Hertz's pressure.
fn hertz(element: BlockElement, cells: [usize; 3]) -> [[f64; 3]; 4] {
    // The same map from the unit cube whatever the cells.
    let grading = cells.map(|n| 32f64.powf((n as f64 - 1.0) / n as f64));
    let mut mesh = block(&Block { size: [1.0; 3], cells, origin: [0.0; 3], grading, element }).unwrap();
    let radius = 10.0;
    for x in &mut mesh.nodes {
        let r2 = x[0] * x[0] + x[1] * x[1];
        x[2] += (1.0 - x[2]) * r2 / (radius + (radius * radius - r2).sqrt());
    }
    let (young, poisson) = (210e3, 0.3);
    let case = Case { mesh, young, poisson, loads: Vec::new(), fixes: Vec::new(), surfaces: Vec::new() };
    let case = case.fix("x-min", [Some(0.0), None, None]).fix("y-min", [None, Some(0.0), None]).contact(
        "z-min",
        FLOOR,
        SurfaceFriction::None,
    );
    let pressed = DEPTHS.map(|depth| case.clone().fix("z-max", [None, None, Some(-depth)]).pose());
    // The depth is prescribed: one factorisation of K serves them all.
    let dual = dual_of(&pressed[0].problem, Form::Auto);
    let same = |other: &Posed| {
        let (a, b) = (&pressed[0].problem, &other.problem);
        a.elastic.K.value == b.elastic.K.value && a.contact.B == b.contact.B
    };
    assert!(pressed.iter().all(same));
    pressed.each_ref().map(|posed| {
        let (p, m) = (&posed.problem, posed.problem.points());
        let s = solve(p, &dual, &settings(1e-8), &mut |_| ControlFlow::Continue(()));
        assert_solved(&s);
        let mut lambda = s.lambda.clone();
        lambda[m..].fill(0.0);
        let nodal: Vec<(f64, f64)> = (p.contact.B.transpose_times(&lambda).iter().zip(&posed.model.dofs.free))
            .filter(|(_, dof)| *dof % 3 == 2)
            .map(|(f, &dof)| (-f, case.mesh.nodes[dof as usize / 3][..2].iter().map(|x| x * x).sum()))
            .collect();
        let force: f64 = nodal.iter().map(|node| node.0).sum();
        let a = (3.0 * 4.0 * force * radius * (1.0 - poisson * poisson) / (4.0 * young)).cbrt();
        let found = (2.5 * nodal.iter().map(|(f, r2)| f * r2).sum::<f64>() / force).sqrt();
        [p.unknowns() as f64, force, found / a - 1.0]
    })
}

/// The force for a given approach to 2 %: quadratic tetrahedra need less than a fifth of the unknowns of linear ones. The
/// reference are hexahedra, whose own error is below 0.5 %; Hertz's half space is 7 % softer than the block.
#[test]
fn quadratic_tetrahedra_need_a_fifth_of_the_unknowns_for_hertz() {
    let run = |element, n: usize| hertz(element, [n; 3]);
    let rms = |values: [f64; 4]| (values.iter().map(|v| v * v).sum::<f64>() / 4.0).sqrt();
    let exact = run(BlockElement::Hex8, 16).map(|run| run[1]);
    let error = |runs: &[[f64; 3]; 4]| rms(std::array::from_fn(|i| runs[i][1] / exact[i] - 1.0));
    let (quadratic, linear) = (run(BlockElement::Tet10Six, 6), run(BlockElement::Tet4Six, 21));
    assert!(5.0 * quadratic[0][0] < linear[0][0], "{} {} unknowns", quadratic[0][0], linear[0][0]);
    let errors = [error(&quadratic), error(&linear)];
    println!("{errors:?}");
    assert!(errors[0] < 0.02 && errors[0] < 0.8 * errors[1], "{errors:?}");
    // The contact radius is Hertz's own.
    assert!(rms(quadratic.map(|run| run[2])) < 0.03, "{quadratic:?}");
}

/// The contact radius of a hexahedral mesh against Hertz's closed form.
#[test]
fn curved_quadratic_hexahedra_have_the_contact_radius_of_hertz() {
    let radii = hertz(BlockElement::Hex20, [8, 8, 4]).map(|run| run[2]);
    assert!(radii.iter().all(|error| error.abs() < 0.025), "{radii:?}");
}

/// Faces whose middles lie far from the middle of their edges can leave a corner without area.
#[test]
fn faces_too_distorted_to_carry_a_pressure_are_refused() {
    let mut case = block_of([1.0; 3], [1; 3], BlockElement::Hex20, 1e3, 0.3).fix("z-max", HELD);
    for x in &mut case.mesh.nodes {
        (0..2).filter(|&c| x[c] == 0.5).collect::<Vec<_>>().into_iter().for_each(|c| x[c] = 0.29);
    }
    let error = case.contact("z-min", FLOOR, SurfaceFriction::None).try_pose().err().unwrap().to_string();
    assert!(error.contains("z-min") && error.contains("stands for no area") && error.contains("middles"), "{error}");
}
