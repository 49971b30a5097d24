//! Reads a ball of triangles as an obstacle and asks for closest points.
//!
//! Usage: `cargo run --release -p stiction-bench --bin surfaces -- [CUTS]` (360: a million triangles). Seconds are CPU
//! seconds of all threads, the median of three runs, from the bytes of a binary STL or an OBJ file to an obstacle that
//! answers; memory is the most that was allocated at a time beyond the file itself, over the length of the file.

use std::error::Error;
use std::fmt::Write;
use std::sync::Arc;

use cpu_time::ProcessTime;
use stiction::contact::{Obstacle, Side, Triangles};
use stiction::io::surface::{parse_obj, parse_stl};
use stiction_fixtures::counting::{self, Counting};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const RUNS: usize = 3;
const QUERIES: usize = 100_000;

fn main() -> Result<(), Box<dyn Error>> {
    let cuts: usize = std::env::args().nth(1).map_or(Ok(360), |n| n.parse())?;
    let triangles = ball(cuts);
    println!("| format | triangles | file MB | CPU seconds | memory / file | near queries/s | far queries/s |");
    println!("|---|---|---|---|---|---|---|");
    for (name, file) in [("stl", stl(&triangles)), ("obj", obj(&triangles))] {
        row(name, &file)?;
    }
    Ok(())
}

fn row(name: &str, file: &[u8]) -> Result<(), Box<dyn Error>> {
    let (mut seconds, mut memory, mut last) = (Vec::new(), 0, None::<Triangles>);
    for _ in 0..RUNS {
        drop(last.take()); // two at a time are not what is measured
        let start = ProcessTime::now();
        let (surface, used) = counting::measured(|| {
            let raw = if name == "stl" { parse_stl(file, "ball", 1.0) } else { parse_obj(file, "ball", 1.0) };
            Triangles::new(raw?, "ball", Side::Outside, 30.0)
        });
        last = Some(surface?);
        seconds.push(start.elapsed().as_secs_f64());
        memory = used.peak;
    }
    seconds.sort_by(f64::total_cmp);
    let Some(surface) = last else { return Ok(()) };
    let (count, size) = (surface.triangles().len(), file.len() as f64);
    let obstacle = Obstacle::Surface(Arc::new(surface));
    let mut state = 1u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    // Within a hundredth of the surface, as contact points are, and up to twice the radius away.
    let rates = [0.01, 2.0].map(|height| {
        let start = ProcessTime::now();
        let mut sum = 0.0;
        for _ in 0..QUERIES {
            let x: [f64; 3] = std::array::from_fn(|_| noise());
            let radius = x.iter().map(|v| v * v).sum::<f64>().sqrt();
            let at = x.map(|v| v / radius * (1.0 + height * radius));
            let outward = x.map(|v| -v / radius);
            sum += obstacle.distance_facing(at, outward).map_or(0.0, |found| found.0);
        }
        std::hint::black_box(sum);
        QUERIES as f64 / start.elapsed().as_secs_f64()
    });
    println!(
        "| {name} | {count} | {:.0} | {:.2} | {:.1} | {:.0} | {:.0} |",
        size / 1e6,
        seconds[RUNS / 2],
        memory as f64 / size,
        rates[0],
        rates[1]
    );
    Ok(())
}

/// The unit ball as an octahedron whose faces are cut into `n²` triangles and pushed out.
fn ball(n: usize) -> Vec<[[f64; 3]; 3]> {
    let mut triangles = Vec::new();
    for signs in 0..8 {
        let s = [0, 1, 2].map(|b| if signs >> b & 1 == 1 { -1.0 } else { 1.0 });
        let point = |i: usize, j: usize| {
            let x = [s[0] * i as f64, s[1] * j as f64, s[2] * (n - i - j) as f64];
            let l = x.iter().map(|v| v * v).sum::<f64>().sqrt();
            x.map(|v| v / l)
        };
        let flip = s[0] * s[1] * s[2] < 0.0;
        let mut add = |[a, b, c]: [[f64; 3]; 3]| triangles.push(if flip { [a, c, b] } else { [a, b, c] });
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            add([point(i, j), point(i + 1, j), point(i, j + 1)]);
            if i + j + 2 <= n {
                add([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
            }
        }
    }
    triangles
}

fn stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0; 12]);
        t.iter().flatten().for_each(|c| bytes.extend((*c as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Every triangle with its own vertices, as exporters without shared ones write it.
fn obj(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = String::new();
    for t in triangles {
        for [x, y, z] in t {
            writeln!(text, "v {x:.9} {y:.9} {z:.9}").unwrap_or(());
        }
        text.push_str("f -3 -2 -1\n");
    }
    text.into_bytes()
}
