//! A fuzzer of readers: mutates files that are read, and looks for panics, for memory that a file's size does not
//! explain, and for time. Deterministic; shared by a short test and by the long run of the benchmark crate.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use stiction::discrete::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
use stiction::io::case::{MeshSource, MeshSpec};
use stiction::io::fclib_write::{State, compose};
use stiction::io::storage::{Storage, matrix};
use stiction::io::{abaqus, arrays, case, deck, fclib, gmsh, matrix_market, npz, surface, vtu_read};
use stiction::linalg::Csr;

use crate::{counting, mutate};

/// A reader, files it reads, and the ending of further ones.
pub struct Target {
    pub name: &'static str,
    pub ending: &'static str,
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Memory that is free, bytes: what libraries below reserve whatever the size of the file.
    pub free: usize,
    /// Whether the bytes were read; any answer is right that is not a panic.
    pub read: fn(&[u8]) -> bool,
}

/// Every reader is one line.
#[rustfmt::skip]
pub const TARGETS: &[Target] = &[
    Target { name: "fclib", ending: "hdf5", seeds: fclib_files, free: HDF5, read: |b| fclib::parse(b.to_vec()).is_ok() },
    Target { name: "npz", ending: "npz", seeds: npz_files, free: SLACK, read: |b| arrays::parse_npz(b).is_ok() },
    Target { name: "matrix-market", ending: "mtx", seeds: matrix_market_files, free: SLACK, read: |b| matrix_market::named(b, "f").is_ok() },
    Target { name: "gmsh", ending: "msh", seeds: gmsh_files, free: SLACK, read: |b| gmsh::parse(b, "f", 1.0).is_ok() },
    Target { name: "abaqus", ending: "inp", seeds: abaqus_files, free: SLACK, read: |b| abaqus::parse(b, "f", 1.0, &included).is_ok() },
    Target { name: "deck", ending: "inp", seeds: decks, free: TREE, read: |b| deck::parse(b, "f", &included).is_ok_and(|d| d.case(&[]).is_ok()) },
    Target { name: "vtu", ending: "vtu", seeds: vtu_files, free: SLACK, read: |b| vtu_read::parse(b, "f", 1.0).is_ok() },
    Target { name: "stl", ending: "stl", seeds: stl_files, free: SLACK, read: |b| surface::parse_stl(b, "f", 1.0).is_ok() },
    Target { name: "obj", ending: "obj", seeds: obj_files, free: SLACK, read: |b| surface::parse_obj(b, "f", 1.0).is_ok() },
    Target { name: "case", ending: "toml", seeds: case_files, free: TREE, read: |b| str::from_utf8(b).is_ok_and(|t| case::parse(t, "f", &[]).is_ok()) },
    Target { name: "posed", ending: "toml", seeds: posed_files, free: 1 << 26, read: posed },
    Target { name: "storage", ending: "-", seeds: storages, free: SLACK, read: read_storage },
];

/// Memory beyond ten times the file is a finding; below the slack it is not worth a word.
const FACTOR: usize = 10;
const SLACK: usize = 1 << 18;
/// The library for HDF5 may reserve 1.1 MB, in files of 15 kB and of 32 kB alike.
const HDF5: usize = 1 << 21;
/// The tree of a case takes up to 560 times its text, which `case::read` bounds.
const TREE: usize = 1 << 26;
/// So is a file of a few thousand bytes that takes so long.
const SLOW: Duration = Duration::from_secs(2);

/// What a run saw.
#[derive(Debug, Default)]
pub struct Report {
    pub executions: usize,
    /// Mutated files that were still read.
    pub read: usize,
    /// Most memory over the size of the file, where it was above the slack.
    pub memory: f64,
    pub slowest: Duration,
    /// What went wrong, with the file.
    pub findings: Vec<(String, Vec<u8>)>,
}

/// Mutates `seeds` until `enough(executions)`.
pub fn fuzz(target: &Target, seeds: &[Vec<u8>], number: u64, enough: &dyn Fn(usize) -> bool) -> Report {
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ (number + 1).wrapping_mul(0xd134_2543_de82_ef95));
    let mut report = Report::default();
    while !enough(report.executions) {
        let file = match random.below(2) {
            0 => mutated(seeds, &mut random),
            _ => mutate::structured(seeds, &mut random),
        };
        report.executions += 1;
        let start = Instant::now();
        let (ended, memory) = counting::measured(|| catch_unwind(AssertUnwindSafe(|| (target.read)(&file))));
        let (seconds, memory) = (start.elapsed(), memory.peak);
        report.slowest = report.slowest.max(seconds);
        if memory > target.free {
            report.memory = report.memory.max(memory as f64 / file.len().max(1) as f64);
        }
        let what = match ended {
            Err(_) => Some("panic".to_string()),
            Ok(_) if memory > FACTOR * file.len() + target.free => Some(format!("{memory} bytes for {}", file.len())),
            Ok(_) if seconds > SLOW => Some(format!("{seconds:?}")),
            Ok(read) => {
                report.read += usize::from(read);
                None
            }
        };
        report.findings.extend(what.map(|what| (what, file)));
    }
    report
}

/// Xorshift (Marsaglia 2003).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() >> 11) as usize % n.max(1)
    }
}

/// Values that lengths and indices break at.
const EDGES: [u64; 12] =
    [0, 1, 2, 7, 255, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff, 1 << 40, i64::MAX as u64, u64::MAX];
pub(crate) const WORDS: [&str; 12] =
    ["-1", "0", "99999999999", "1e400", "nan", "inf", "-0", "1.5", "4294967296", "18446744073709551615", "", "\n"];
pub(crate) const MOST: usize = 1 << 17;

/// One to four changes of a file.
fn mutated(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut file = seeds[random.below(seeds.len())].clone();
    for _ in 0..=random.below(4) {
        let at = random.below(file.len());
        match random.below(9) {
            0 => file.truncate(at),
            1 if !file.is_empty() => file[at] ^= 1 << random.below(8),
            2 if !file.is_empty() => file[at] = EDGES[random.below(5)] as u8,
            3 | 4 => {
                // A length field, at its natural place more often than not.
                let width = [2, 4, 8][random.below(3)];
                let at = if random.below(4) > 0 { at - at % width } else { at };
                let value = match random.below(3) {
                    0 => file.len() as u64 * random.below(3) as u64,
                    _ => EDGES[random.below(EDGES.len())],
                };
                let end = (at + width).min(file.len());
                file[at.min(end)..end].copy_from_slice(&value.to_le_bytes()[..end - at.min(end)]);
            }
            5 => {
                let other = &seeds[random.below(seeds.len())];
                let from = random.below(other.len());
                let to = (from + 1 + random.below(256)).min(other.len());
                file.splice(at..at, other[from.min(to)..to].iter().copied());
            }
            6 => {
                let end = (at + 1 + random.below(64)).min(file.len());
                file.drain(at.min(end)..end);
            }
            7 => {
                let other = &seeds[random.below(seeds.len())];
                let end = (at + 1 + random.below(256)).min(file.len()).min(other.len());
                file[at.min(end)..end].copy_from_slice(&other[at.min(end)..end]);
            }
            _ => {
                // A word of text, or one put where a number was.
                let end = at + file[at..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
                file.splice(at..end, WORDS[random.below(WORDS.len())].bytes());
            }
        }
        file.truncate(MOST);
    }
    file
}

fn small(points: usize) -> LocalProblem {
    let size = 3 * points;
    let entry = |i: usize, j: usize| (i, j, if i == j { 2.0 } else { 0.1 * (i as f64 - j as f64) });
    let entries: Vec<_> = (0..size).flat_map(|i| (0..size).map(move |j| entry(i, j))).collect();
    let (q, mu) = ((0..size).map(|i| (1.7 * i as f64).sin()).collect(), vec![0.3; points]);
    LocalProblem { dimension: 3, W: Csr::from_triplets(size, size, &entries), q, mu, bilateral: None }
}

fn global() -> GlobalProblem {
    let unit = Csr::from_triplets(3, 3, &[(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0)]);
    let equalities = Some(Equalities { G: Csr::from_triplets(3, 1, &[(2, 0, 1.0)]), b: vec![0.3] });
    let (f, w) = (vec![-1.0, 0.4, 0.2], vec![0.0; 3]);
    GlobalProblem { dimension: 3, M: unit.clone(), H: unit, f, w, mu: vec![0.4], equalities }
}

fn fclib_files() -> Vec<Vec<u8>> {
    let r = Csr::from_triplets(1, 1, &[(0, 0, 1.5)]);
    let v = Csr::from_triplets(6, 1, &[(0, 0, 0.3)]);
    let tied = LocalProblem { bilateral: Some(Bilateral { V: v, R: r, s: vec![0.1] }), ..small(2) };
    let state = |n: usize| State { r: vec![0.5; n], u: vec![0.1; n], ..State::default() };
    let file = |problem, n: usize| compose(&problem, Some(&state(n)), &[state(n)]).expect("a small file");
    vec![
        file(DiscreteProblem::Local(small(1)), 3),
        file(DiscreteProblem::Local(tied), 6),
        file(DiscreteProblem::Global(global()), 3),
    ]
}

fn npz_files() -> Vec<Vec<u8>> {
    let p = small(1);
    let dense = |w: &Csr| npz::Array {
        shape: vec![3, 3],
        data: npz::Data::F64((0..9).map(|k| w.entry(k / 3, k % 3)).collect()),
    };
    fn vectors<'a>(list: &[(&'static str, &'a [f64])]) -> Vec<(&'static str, npz::Array<'a>)> {
        list.iter().map(|&(name, x)| (name, npz::Array::f64(x))).collect()
    }
    let local = vectors(&[("q", &p.q), ("mu", &p.mu)]);
    let g = global();
    let sparse = [
        ("W_data", npz::Array::f64(&p.W.value)),
        ("W_indices", npz::Array::usize(&p.W.column.iter().map(|&c| c as usize).collect::<Vec<_>>())),
        ("W_indptr", npz::Array::usize(&p.W.start)),
        ("W_shape", npz::Array::usize(&[3, 3])),
    ];
    let all = [
        [&[("W", dense(&p.W))], &local[..]].concat(),
        [&sparse[..], &local[..]].concat(),
        [&[("M", dense(&g.M)), ("H", dense(&g.H))][..], &vectors(&[("f", &g.f), ("w", &g.w), ("mu", &g.mu)])].concat(),
        [&[("K", dense(&g.M)), ("B", dense(&g.H))][..], &vectors(&[("f", &g.f), ("gap", &[0.1]), ("mu", &g.mu)])]
            .concat(),
    ];
    let path = std::env::temp_dir().join(format!("stiction-fuzz-{}.npz", std::process::id()));
    let files = all.iter().map(|arrays| {
        npz::write(&path, arrays).expect("a small file");
        std::fs::read(&path).expect("the file just written")
    });
    let files = files.collect();
    let _ = std::fs::remove_file(&path);
    files
}

macro_rules! files {
    ($($path:literal)*) => { vec![$(include_bytes!(concat!("../../../tests/", $path)).to_vec()),*] };
}

fn gmsh_files() -> Vec<Vec<u8>> {
    files!("meshes/bar-22-ascii.msh" "meshes/bar-22-binary.msh" "meshes/bar-41-ascii.msh" "meshes/bar-41-binary.msh"
        "data/fields-22-ascii.msh" "data/fields-22-binary.msh" "data/fields-41-ascii.msh" "data/fields-41-binary.msh"
        "data/curved-wedge15-41.msh" "data/curved-wedge18-22.msh")
}

fn abaqus_files() -> Vec<Vec<u8>> {
    let deck = "*HEADING\na bar\n*PART, NAME=p\n*NODE, NSET=all\n1, 0., 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*INCLUDE, INPUT=more.inp\n\
                *ELEMENT, TYPE=C3D4, ELSET=e\n1, 1, 2, 3, 4\n*NSET, NSET=n, GENERATE\n1, 3, 1\n*SURFACE, NAME=s\ne, S1\n*END PART\n";
    let own = vec![deck.as_bytes().to_vec()];
    [own, files!("data/brick-gmsh.inp" "data/tets-meshio.inp" "data/tets-gmsh.inp" "data/curved-wedge15-gmsh.inp")]
        .concat()
}

/// Complete decks that hold every card that is read.
fn decks() -> Vec<Vec<u8>> {
    files!(
        "data/decks/press.inp" "data/decks/steps.inp" "data/decks/materials.inp" "data/decks/rigid.inp"
        "data/decks/released.inp" "data/decks/revolved.inp" "data/decks/adjusted-set.inp" "data/decks/bolt.inp"
        "data/decks/changed-law.inp" "data/decks/equations.inp" "data/decks/held.inp" "data/decks/kinds-of-pairs.inp"
        "data/decks/lining.inp" "data/decks/nodes.inp" "data/decks/parts.inp" "data/decks/plane-stress.inp"
        "data/decks/printed.inp" "data/decks/prisms.inp" "data/decks/sections-first.inp" "data/decks/spread.inp"
        "data/decks/turned.inp" "data/decks/sector.inp" "data/decks/freed.inp"
    )
}

/// What any `*INCLUDE` names.
fn included(_: &str) -> Result<Vec<u8>, String> {
    Ok(b"5, 1, 1, 1\n".to_vec())
}

fn vtu_files() -> Vec<Vec<u8>> {
    files!(
        "data/brick-meshio-ascii.vtu" "data/brick-meshio-zlib.vtu" "data/brick-vtk-base64.vtu"
        "data/brick-vtk-inline-zlib.vtu" "data/brick-vtk-raw.vtu" "data/brick-pyvista.vtu"
    )
}

/// The faces of a tetrahedron, as text and as bytes.
fn stl_files() -> Vec<Vec<u8>> {
    let corner: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let facet = |face: &[usize; 3]| -> String {
        let vertex = |&k: &usize| format!("vertex {} {} {}\n", corner[k][0], corner[k][1], corner[k][2]);
        let vertices: String = face.iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    let text = format!("solid it\n{}endsolid it\n", faces.iter().map(facet).collect::<String>());
    let mut bytes = vec![b' '; 80];
    bytes.extend(4u32.to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|&k| corner[k]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    vec![text.into_bytes(), bytes]
}

fn obj_files() -> Vec<Vec<u8>> {
    let corners = "# it\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1e0\n";
    let faces = ["f 1 4 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n", "vn 0 0 1\nf 1//1 2//1 3//1\nf -5 -3 -2\n"];
    faces.map(|faces| format!("{corners}{faces}").into_bytes()).to_vec()
}

fn case_files() -> Vec<Vec<u8>> {
    files!("../cases/brick/brick.toml" "../cases/slide/slide.toml" "../cases/rings/rings.toml")
}

fn matrix_market_files() -> Vec<Vec<u8>> {
    let head = "%%MatrixMarket matrix";
    [
        format!("{head} coordinate real general\n% a note\n\n2 2 5\n1 1 1\n1 1 1\n1 2 -1.5\n2 1 -1.5\n2 2 .5\n"),
        format!("{head} coordinate real symmetric\n3 3 3\n1 1 2\n2 1 -15e-1\n3 2 0.5"),
        format!("{head} array real general\n2 3\n2\n-1.5\n-1.5\n0.5\n1\n2\n"),
        format!("{head} array integer skew-symmetric\n3 3\n3\n1\n2\n"),
    ]
    .map(String::into_bytes)
    .to_vec()
}

/// Cases of so few cells that posing one takes a millisecond.
fn posed_files() -> Vec<Vec<u8>> {
    let small = |text: &str| text.replace("[9, 3, 3]", "[2, 1, 1]").into_bytes();
    let bodies = "[mesh.parts.a]\nblock = { size = [2, 2, 1], cells = [2, 1, 1], element = \"hex8\" }\n\
         [mesh.parts.b]\nblock = { size = [1, 2, 1], cells = [1, 1, 1], element = \"tet10\", origin = [0.5, 0, 1.1] }\n\
         [materials.s]\nyoung = 1000\npoisson = 0.3\ndensity = 1e-3\n[[fix]]\non = \"a.z-min\"\nvalue = [0, 0, \"0.1*t\"]\n\
         [[spring]]\non = \"b.z-max\"\nnormal = 1\ntangential = 0.1\n[[load]]\non = \"b.z-max\"\npressure = \"1 + x\"\n\
         [[load]]\ngravity = [0, 0, -9.81]\n[[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\nsearch = 0.5\n\
         friction = { coulomb = \"0.3 + 0.01*x\" }\n[solver]\ntolerance = 1e-8\n";
    vec![small(crate::case_run::CASE), small(&crate::tamper::stepped_case()), bodies.as_bytes().to_vec()]
}

fn posed(bytes: &[u8]) -> bool {
    let case = str::from_utf8(bytes).ok().and_then(|text| case::parse(text, "f", &[]).ok());
    case.is_some_and(|case| few_cells(&case.mesh) && stiction::run::prepare(&case).is_ok())
}

fn few_cells(mesh: &MeshSpec) -> bool {
    let few = |cells: &[usize; 3]| cells.iter().fold(1usize, |all, &n| all.saturating_mul(n)) <= 100;
    match &mesh.source {
        MeshSource::Block(block) => few(&block.cells),
        MeshSource::Ring(ring) => few(&ring.cells),
        MeshSource::File { .. } | MeshSource::Given(_) => false,
        MeshSource::Parts(parts) => parts.len() < 5 && parts.iter().all(|(_, part)| few_cells(part)),
    }
}

/// Kind, order, then three lists behind their lengths; little-endian integers.
fn storages() -> Vec<Vec<u8>> {
    let file = |kind: i32, p: &[i32], i: &[i32]| -> Vec<u8> {
        let head = [kind, 2, 3, p.len() as i32, i.len() as i32];
        head.iter().chain(p).chain(i).flat_map(|x| x.to_le_bytes()).collect()
    };
    vec![
        file(5, &[2, 0, 1, 2, 1, 9], &[0, 0, 1, 1, 1, 9]),
        file(-1, &[0, 1, 2, 4], &[0, 1, 1, 0]),
        file(-2, &[0, 2, 4], &[2, 0, 1, 2]),
    ]
}

fn read_storage(bytes: &[u8]) -> bool {
    let numbers: Vec<i32> = bytes.as_chunks().0.iter().map(|b| i32::from_le_bytes(*b)).collect();
    let [kind, rows, cols, of_p, of_i, lists @ ..] = &numbers[..] else { return false };
    // What the readers have checked before: counts, and orders below the size of the file.
    let count = |x: i32| usize::try_from(x).ok().filter(|&n| n <= bytes.len());
    let (Some(rows), Some(cols)) = (count(*rows), count(*cols)) else { return false };
    let p = &lists[..count(*of_p).unwrap_or(0).min(lists.len())];
    let i = &lists[p.len()..][..count(*of_i).unwrap_or(0).min(lists.len() - p.len())];
    let storage = match kind {
        -1 => Storage::Columns,
        -2 => Storage::Rows,
        n => Storage::Triplets(usize::try_from(*n).unwrap_or(0)),
    };
    let x: Vec<f64> = i.iter().map(|&i| f64::from(i)).collect();
    matrix(storage, rows, cols, p, i, &x).is_ok_and(|a| a.validate("it").is_ok())
}
