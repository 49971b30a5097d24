//! Reads meshes of each format: megabytes a second, and the most memory beside the mesh that comes out.
//!
//! Usage: `cargo run --release -p stiction-bench --bin readers -- [NODES-PER-EDGE]` (101: a million nodes). A cube of
//! hexahedra and one of tetrahedra are written as text, as other programs do it, and as VTU, and read from disk.
//! Seconds are CPU seconds of all threads for the whole way to a checked mesh with its boundary, the median of three
//! runs; memory is the most that was allocated at a time, the bytes of the file included, over that of the mesh.

use std::error::Error;

use cpu_time::ProcessTime;
use stiction::io::vtu;
use stiction::mesh::{Block, BlockElement, Mesh, block};
use stiction::run::read_mesh;
use stiction_fixtures::counting::{self, Counting};
use stiction_fixtures::written;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const RUNS: usize = 3;
const MEGA: f64 = 1e6;

fn main() -> Result<(), Box<dyn Error>> {
    let nodes: usize = std::env::args().nth(1).map_or(Ok(101), |n| n.parse())?;
    println!("| format | cells | nodes | file MB | CPU seconds | MB/s | memory / mesh |");
    println!("|---|---|---|---|---|---|---|");
    for element in [BlockElement::Hex8, BlockElement::Tet4Six] {
        // sizes that do not end after a few digits
        let size = [std::f64::consts::PI, std::f64::consts::E, std::f64::consts::SQRT_2];
        let cells = [nodes - 1; 3];
        let mesh = block(&Block { size, cells, origin: [-0.3; 3], grading: [1.0; 3], element })?;
        row("msh", &written::msh(&mesh))?;
        row("inp", &written::inp(&mesh))?;
        row("vtu", &grid(&mesh)?)?;
    }
    Ok(())
}

fn row(ending: &str, file: &[u8]) -> Result<(), Box<dyn Error>> {
    let path = std::env::temp_dir().join(format!("stiction-readers-{}.{ending}", std::process::id()));
    std::fs::write(&path, file)?;
    let mut seconds = Vec::new();
    let (mut memory, mut cells, mut nodes) = (0.0, 0, 0);
    for _ in 0..RUNS {
        let start = ProcessTime::now();
        let (read, used) = counting::measured(|| read_mesh(&path, 1.0, &[]));
        seconds.push(start.elapsed().as_secs_f64());
        let (mesh, _) = read?;
        memory = used.peak as f64 / used.kept as f64;
        (cells, nodes) = (mesh.cell_count(), mesh.nodes.len());
    }
    std::fs::remove_file(&path)?;
    seconds.sort_by(f64::total_cmp);
    let (size, median) = (file.len() as f64 / MEGA, seconds[RUNS / 2]);
    println!("| {ending} | {cells} | {nodes} | {size:.0} | {median:.2} | {:.0} | {memory:.2} |", size / median);
    Ok(())
}

fn grid(mesh: &Mesh) -> Result<Vec<u8>, Box<dyn Error>> {
    let path = std::env::temp_dir().join(format!("stiction-readers-{}.vtu", std::process::id()));
    vtu::write(&path, &vtu::Grid::from_mesh(mesh), &[], &[])?;
    let bytes = std::fs::read(&path)?;
    std::fs::remove_file(&path)?;
    Ok(bytes)
}
