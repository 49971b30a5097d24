use std::sync::Arc;
use std::time::Instant;
use stiction::contact::*;
use stiction::dual::*;
use stiction::fem::*;
use stiction::friction::*;
use stiction::mesh::{Block, BlockElement, block};

fn c3(v: [f64; 3]) -> [Field; 3] {
    v.map(Field::Constant)
}

fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: usize = a[1].parse().unwrap();
    let load = a[2].as_str();
    let fr: SurfaceFriction = match a[3].split_once('=') {
        Some(("c", v)) => SurfaceFriction::Coulomb(v.parse().unwrap()),
        Some(("g", v)) => SurfaceFriction::GivenForce(v.parse().unwrap()),
        Some(("s", v)) => SurfaceFriction::GivenStress(v.parse().unwrap()),
        _ => SurfaceFriction::None,
    };
    let form = match a.get(4).map(|s| s.as_str()) {
        Some("dense") => Form::Dense,
        Some("solves") => Form::Solves,
        _ => Form::Auto,
    };
    let t0 = Instant::now();
    let mesh = block(&Block {
        size: [3., 1., 1.],
        cells: [3 * n, n, n],
        origin: [0.; 3],
        grading: [1.; 3],
        element: if a.get(5).map(|s| s == "hex").unwrap_or(false) { BlockElement::Hex8 } else { BlockElement::Tet4Six },
    })
    .unwrap();
    let g = |s: &str| mesh.group(s).unwrap().faces.clone();
    let mats =
        [Material { name: "m".into(), young: 21.19e10, poisson: 0.277, density: 0., formulation: Formulation::Full }];
    let moc = vec![0u32; mesh.cell_count()];
    let solid = Solid { mesh: &mesh, materials: &mats, material_of_cell: &moc };
    let f = |s: &str, f: fn([f64; 3], f64) -> f64| Field::Function { text: s.into(), value: Arc::new(f) };
    let loads = match load {
        "lift" => vec![
            Load::Traction { faces: g("x-max"), value: c3([0., 0., 1e6]) },
            Load::Traction {
                faces: g("z-max"),
                value: [Field::Constant(0.), Field::Constant(0.), f("q", |x, _| -2. / 3. * 1e6 * (3. - x[0]))],
            },
        ],
        "press" => vec![
            Load::Traction { faces: g("x-max"), value: c3([1e6, 5e5, 0.]) },
            Load::Traction { faces: g("z-max"), value: c3([0., 0., -1e6]) },
        ],
        "full" => vec![
            Load::Traction { faces: g("x-max"), value: c3([2e6, 1e6, 0.]) },
            Load::Traction { faces: g("z-max"), value: c3([0., 0., -5e6]) },
        ],
        "full2" => vec![
            Load::Traction { faces: g("x-max"), value: c3([-2e6, 1e6, 3e5]) },
            Load::Traction { faces: g("z-max"), value: c3([0., 3e6, -5e6]) },
        ],
        _ => panic!(),
    };
    let mut nodes: Vec<u32> = g("x-min").iter().flat_map(|&f| mesh.faces[f as usize].nodes().to_vec()).collect();
    nodes.sort();
    nodes.dedup();
    let fixes =
        [Fix { nodes, value: [Some(Field::Constant(0.)), Some(Field::Constant(0.)), Some(Field::Constant(0.))] }];
    let model = assemble(&solid, &loads, &fixes, 1.0).unwrap();
    let t1 = Instant::now();
    let (p, facts) = pose(
        &mesh,
        &model,
        &[ContactSurface {
            name: "z".into(),
            faces: g("z-min"),
            obstacle: Obstacle::Plane { point: [0.; 3], normal: [0., 0., 1.] },
            friction: fr,
        }],
    )
    .unwrap();
    p.validate().unwrap();
    let t2 = Instant::now();
    // reference
    let ch = choose(
        &ContactProblem {
            B: stiction::linalg::Csr::zero(0, p.unknowns()),
            gap: vec![],
            friction: vec![],
            area: vec![],
            slip_reference: vec![],
            pairs: vec![],
            ..p.clone()
        },
        &DualSettings::default(),
    )
    .unwrap();
    let empty = ContactProblem {
        B: stiction::linalg::Csr::zero(0, p.unknowns()),
        gap: vec![],
        friction: vec![],
        area: vec![],
        slip_reference: vec![],
        pairs: vec![],
        ..p.clone()
    };
    let tr0 = Instant::now();
    let d0 = Dual::new(&empty, ch).unwrap();
    let _ = d0.displacement(&empty, &[]);
    let tr = tr0.elapsed().as_secs_f64();
    drop(d0);
    let t3 = Instant::now();
    let choice = choose(&p, &DualSettings { form, memory_limit: None }).unwrap();
    println!(
        "n {} m {} facts pts {} clamped {}  choice {:?} GF {:.1} MB {} pred {:.2}",
        p.unknowns(),
        p.points(),
        facts[0].points,
        facts[0].clamped,
        choice.form,
        choice.flops / 1e9,
        choice.bytes / 1000000,
        choice.seconds
    );
    let t4 = Instant::now();
    let dual = Dual::new(&p, choice).unwrap();
    let t5 = Instant::now();
    let verbose = std::env::var("V").is_ok();
    let s = solve(&p, &dual, &Settings::default(), &mut |q| {
        if verbose {
            println!(
                "  {:?} {} res {:.2e} products {} o/s/s {} {} {}",
                q.phase, q.iteration, q.residual, q.products, q.open, q.stick, q.slip
            );
        }
        std::ops::ControlFlow::Continue(())
    });
    let t6 = Instant::now();
    let cf = coulomb_facts(&p, &dual, &s);
    let t7 = Instant::now();
    let last = s.history.last().unwrap();
    let m = p.points();
    println!(
        "{:?} steps {} restarts {} fp {} products {} worst {:.1e}  o/s/s {} {} {}",
        s.status,
        s.counts.newton_steps,
        s.counts.restarts,
        s.counts.fixed_point_steps,
        s.counts.products,
        s.certificate.worst,
        last.open,
        last.stick,
        last.slip
    );
    if verbose {
        println!("{:?}", s.certificate.measures());
    }
    println!("Fn {:.6} Fx {:.6} {:?}", s.lambda[..m].iter().sum::<f64>(), -s.lambda[m..2 * m].iter().sum::<f64>(), cf);
    println!(
        "assemble {:.3} pose {:.3} | ref factor+solve {:.3} | order {:.3} factor {:.3} newton {:.3} facts {:.3} ratio {:.2}",
        (t1 - t0).as_secs_f64(),
        (t2 - t1).as_secs_f64(),
        tr,
        (t4 - t3).as_secs_f64(),
        (t5 - t4).as_secs_f64(),
        (t6 - t5).as_secs_f64(),
        (t7 - t6).as_secs_f64(),
        (t7 - t3).as_secs_f64() / tr
    );
}
