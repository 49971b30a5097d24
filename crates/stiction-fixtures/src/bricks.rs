//! Bricks of one material with loads and contact, posed by hand, and the shortest way to a solution.

use std::ops::ControlFlow;
use std::sync::Arc;

use stiction::Error;
use stiction::contact::{
    Across, Contact, ContactProblem, ContactSurface, CoulombLaw, Friction, Obstacle, SurfaceFacts, SurfaceFriction,
    pose,
};
use stiction::dual::{Dual, DualSettings, Form, choose};
use stiction::fem::{
    FeModel, Field, Fix, Formulation, Load, Material, Solid, assemble, face_coordinates, face_points, full_displacement,
};
use stiction::friction::{Settings, Solution, Status, solve};
use stiction::mesh::{Block, BlockElement, Mesh, block};

pub const FLOOR: Obstacle = Obstacle::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
pub const HELD: [Option<f64>; 3] = [Some(0.0); 3];

/// Everything a contact problem is posed from.
#[derive(Debug, Clone)]
pub struct Case {
    pub mesh: Mesh,
    pub young: f64,
    pub poisson: f64,
    pub loads: Vec<Load>,
    pub fixes: Vec<Fix>,
    pub surfaces: Vec<ContactSurface>,
}

pub struct Posed {
    pub model: FeModel,
    pub problem: ContactProblem,
    pub facts: Vec<SurfaceFacts>,
}

/// A uniform block at the origin without loads, supports or contact.
pub fn block_of(size: [f64; 3], cells: [usize; 3], element: BlockElement, young: f64, poisson: f64) -> Case {
    let mesh = block(&Block { size, cells, origin: [0.0; 3], grading: [1.0; 3], element }).unwrap();
    Case { mesh, young, poisson, loads: Vec::new(), fixes: Vec::new(), surfaces: Vec::new() }
}

impl Case {
    pub fn faces(&self, group: &str) -> Vec<u32> {
        self.mesh.group(group).unwrap().faces.clone()
    }

    pub fn nodes(&self, group: &str) -> Vec<u32> {
        self.mesh.face_nodes(&self.faces(group))
    }

    pub fn traction(mut self, group: &str, value: [f64; 3]) -> Case {
        self.loads.push(Load::Traction { faces: self.faces(group), value: value.map(Field::Constant) });
        self
    }

    /// A traction along z that depends on the place.
    pub fn traction_z(mut self, group: &str, value: fn([f64; 3]) -> f64) -> Case {
        let z = Field::Function { text: "in the test".into(), value: Arc::new(move |x, _| value(x)) };
        let value = [Field::Constant(0.0), Field::Constant(0.0), z];
        self.loads.push(Load::Traction { faces: self.faces(group), value });
        self
    }

    pub fn fix(mut self, group: &str, value: [Option<f64>; 3]) -> Case {
        self.fixes.push(Fix {
            nodes: self.nodes(group),
            value: value.map(|v| v.map(Field::Constant)),
            ..Fix::default()
        });
        self
    }

    pub fn contact(mut self, group: &str, obstacle: Obstacle, friction: SurfaceFriction) -> Case {
        let faces = self.faces(group);
        self.surfaces.push(ContactSurface {
            name: group.into(),
            faces,
            against: obstacle.into(),
            friction,
            stiffness: None,
            periods: vec![stiction::contact::ALWAYS],
        });
        self
    }

    pub fn assemble(&self) -> FeModel {
        let (young, poisson) = (self.young, self.poisson);
        let formulation = Formulation::Full;
        let materials =
            [Material { name: "elastic".into(), young, poisson, density: 0.0, formulation, ..Material::default() }];
        let material_of_cell = vec![0; self.mesh.cell_count()];
        let solid = Solid { mesh: &self.mesh, materials: &materials, material_of_cell: &material_of_cell };
        assemble(&solid, &self.loads, &self.fixes, 1.0).unwrap()
    }

    pub fn try_pose(&self) -> Result<Posed, Error> {
        let mut model = self.assemble();
        let (problem, facts) = pose(&self.mesh, &mut model, &self.surfaces)?;
        problem.validate().unwrap();
        Ok(Posed { model, problem, facts })
    }

    pub fn pose(&self) -> Posed {
        self.try_pose().unwrap()
    }
}

impl Posed {
    /// Displacements of all nodes.
    pub fn full(&self, u: &[f64]) -> Vec<[f64; 3]> {
        full_displacement(&self.model, u).chunks(3).map(|c| [c[0], c[1], c[2]]).collect()
    }
}

/// Coulomb friction with a coefficient along `direction` and one across it.
pub fn orthotropic(along: f64, across: f64, direction: [f64; 3]) -> SurfaceFriction {
    let across = Some(Across { coefficient: Field::Constant(across).into(), direction });
    SurfaceFriction::Law(CoulombLaw { coefficient: Field::Constant(along).into(), across, limit: None, cohesion: None })
}

/// Coulomb friction up to a largest stress.
pub fn limited(coefficient: f64, limit: f64) -> SurfaceFriction {
    SurfaceFriction::Law(CoulombLaw {
        coefficient: Field::Constant(coefficient).into(),
        across: None,
        limit: Some(limit),
        cohesion: None,
    })
}

/// Loads of the brick 3 x 1 x 1 clamped at x = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BrickLoad {
    /// The source paper's: the top pressed less and less towards the end, which is lifted.
    Lift,
    /// The whole top pressed, the end pulled and pushed sideways.
    Press,
}

/// The source paper's brick with `n` cells per unit length on the floor z = 0.
pub fn brick(n: usize, element: BlockElement, load: BrickLoad, friction: SurfaceFriction) -> Case {
    let case = block_of([3.0, 1.0, 1.0], [3 * n, n, n], element, 21.19e10, 0.277);
    let case = case.fix("x-min", HELD).contact("z-min", FLOOR, friction);
    match load {
        BrickLoad::Lift => {
            case.traction("x-max", [0.0, 0.0, 1e6]).traction_z("z-max", |x| -2.0 / 3.0 * 1e6 * (3.0 - x[0]))
        }
        BrickLoad::Press => case.traction("x-max", [1e6, 5e5, 0.0]).traction("z-max", [0.0, 0.0, -1e6]),
    }
}

/// The same problem with other laws at its points.
pub fn with_friction(problem: &ContactProblem, friction: Vec<Friction>) -> ContactProblem {
    let contact = Contact { friction, ..problem.contact.clone() };
    ContactProblem { contact, ..problem.clone() }
}

pub fn dual_of(problem: &ContactProblem, form: Form) -> Dual {
    Dual::new(problem, choose(problem, &DualSettings { form, ..Default::default() }).unwrap()).unwrap()
}

pub fn settings(tolerance: f64) -> Settings {
    Settings { tolerance, ..Settings::default() }
}

/// Whatever the solver ends with.
pub fn attempt(problem: &ContactProblem, settings: &Settings) -> Solution {
    solve(problem, &dual_of(problem, Form::Auto), settings, &mut |_| ControlFlow::Continue(()))
}

/// The certified solution to `tolerance`; anything else fails the test with the history of the solve.
pub fn solved(problem: &ContactProblem, tolerance: f64) -> Solution {
    let solution = attempt(problem, &settings(tolerance));
    assert_solved(&solution);
    solution
}

pub fn assert_solved(solution: &Solution) {
    let told = || {
        let line = |p: &stiction::friction::Progress| {
            format!(
                "{:?} {} {:.2e} open {} stick {} slip {}",
                p.phase, p.iteration, p.residual, p.open, p.stick, p.slip
            )
        };
        solution.history.iter().map(line).collect::<Vec<_>>().join("\n")
    };
    let c = &solution.certificate;
    assert_eq!(solution.status, Status::Solved, "{:?}\n{:?}\n{}", solution.counts, c.measures(), told());
    assert!(c.passed && c.worst <= c.tolerance);
}

/// Sum of the normal forces.
pub fn normal_force(problem: &ContactProblem, lambda: &[f64]) -> f64 {
    lambda[..problem.points()].iter().sum()
}

/// Resultant of friction as a force ON the body in the directions of the two tangents.
pub fn friction_on_body(problem: &ContactProblem, lambda: &[f64]) -> [f64; 2] {
    let m = problem.points();
    [-lambda[m..2 * m].iter().sum::<f64>(), -lambda[2 * m..].iter().sum::<f64>()]
}

pub fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs())
}

/// Largest difference over the largest magnitude.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let size = a.iter().chain(b).fold(0.0, |s: f64, x| s.max(x.abs()));
    let apart = a.iter().zip(b).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs()));
    if apart.is_nan() { f64::INFINITY } else { apart / size.max(f64::MIN_POSITIVE) }
}

/// For each node of the boundary faces `faces` the area it stands for, the integral of its shape function over them. Nodes
/// ascend. Those of corners of quadratic faces vanish or are negative.
pub fn nodal_areas(mesh: &Mesh, faces: &[u32]) -> Vec<(u32, f64)> {
    let mut areas = std::collections::BTreeMap::new();
    for &face in faces {
        for point in face_points(&face_coordinates(mesh, face)) {
            let area = point.area.iter().map(|c| c * c).sum::<f64>().sqrt();
            for (&node, shape) in mesh.faces[face as usize].nodes().iter().zip(point.shape) {
                *areas.entry(node).or_insert(0.0) += shape * area;
            }
        }
    }
    areas.into_iter().collect()
}
