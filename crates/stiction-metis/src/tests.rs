use std::cell::Cell;

use super::*;

/// Numbers that look random (Marsaglia 2003).
struct Xorshift(u64);

impl Xorshift {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % end
    }
}

/// The graph with these edges, loops left out, and weights from one to three.
fn graph(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Graph {
    let mut of: Vec<Vec<i32>> = vec![Vec::new(); n];
    for (v, w) in edges.into_iter().filter(|(v, w)| v != w) {
        of[v].push(w as i32);
        of[w].push(v as i32);
    }
    let mut start = vec![0];
    let mut neighbours = Vec::new();
    for own in &mut of {
        own.sort_unstable();
        own.dedup();
        neighbours.extend_from_slice(own);
        start.push(neighbours.len() as i32);
    }
    Graph { start, neighbours, weights: (0..n as i32).map(|v| 1 + v % 3).collect() }
}

/// A grid whose nodes know the 26 around them.
fn grid(nx: usize, ny: usize, nz: usize) -> Graph {
    let at = |x: usize, y: usize, z: usize| (z * ny + y) * nx + x;
    let mut edges = Vec::new();
    for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x)))) {
        for (dz, dy, dx) in (0..2).flat_map(|a| (0..2).flat_map(move |b| (0..2).map(move |c| (a, b, c)))) {
            for (u, v) in [((x, y), (x + dx, y + dy)), ((x + dx, y), (x, y + dy))] {
                if u.0.max(v.0) < nx && v.1 < ny && z + dz < nz {
                    edges.push((at(u.0, u.1, z), at(v.0, v.1, z + dz)));
                    edges.push((at(u.0, u.1, z + dz), at(v.0, v.1, z)));
                }
            }
        }
    }
    graph(nx * ny * nz, edges)
}

fn random(n: usize, edges: usize, seed: u64) -> Graph {
    let mut numbers = Xorshift(seed);
    graph(n, (0..edges).map(move |_| (numbers.below(n), numbers.below(n))))
}

fn never() -> bool {
    false
}

/// FNV-1a of the numbers' bytes.
fn fingerprint(order: &[i32]) -> u64 {
    let bytes = order.iter().flat_map(|v| v.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Eight vertices at a time know each other and the next eight, so that they are ordered as one.
fn cliques(n: usize) -> Graph {
    let of = move |v: usize| (0..8).flat_map(move |w| [(v, v / 8 * 8 + w), (v, (v / 8 * 8 + 8 + w) % n)]);
    graph(n, (0..n).flat_map(of))
}

/// Many vertices of few: those are matched over two edges.
fn hubs(n: usize) -> Graph {
    graph(n, (0..n).flat_map(|v| [(v, v % 37), (v, v % 411)]))
}

#[test]
fn orders_are_those_of_metis() {
    // Of METIS_NodeND in METIS 5.2.1 on a GNU system.
    let cases = [
        ("grid", grid(24, 24, 24), 2, 0x9a6a_5f4f_3833_9501),
        ("plate", grid(120, 60, 2), 1, 0x0780_3836_329b_f321),
        ("random", random(3000, 9000, 5), 3, 0x0ffa_4291_feeb_4fd1),
        ("cliques", cliques(6000), 1, 0xba05_8b7e_f151_97cd),
        ("hubs", hubs(20_000), 2, 0xd158_49d7_7b92_f765),
        ("line", graph(5000, (1..5000).map(|v| (v - 1, v))), 2, 0x1695_7a33_16ba_6c71),
        ("points", graph(500, []), 1, 0xe037_3b1c_b515_ba59),
    ];
    for (name, graph, separators, expected) in cases {
        let options = Options { separators, ..Options::default() };
        let order = nested_dissection(graph, options, &never).unwrap();
        assert_eq!(fingerprint(&order), expected, "{name}");
    }
}

#[test]
fn orders_are_the_same_on_many_threads() {
    let graphs = [grid(14, 14, 14), random(2000, 6000, 3)];
    let order = |g: &Graph| nested_dissection(g.clone(), Options::default(), &never).unwrap();
    let alone = graphs.each_ref().map(order);
    std::thread::scope(|scope| {
        for k in 0..4 {
            let (graphs, alone) = (&graphs, &alone);
            scope.spawn(move || (0..6).for_each(|i| assert!(order(&graphs[(i + k) % 2]) == alone[(i + k) % 2])));
        }
    });
}

#[test]
fn it_stops_whenever_it_is_asked_to() {
    let graph = grid(16, 16, 16);
    let asked = Cell::new(0);
    let count = || {
        asked.set(asked.get() + 1);
        false
    };
    let order = nested_dissection(graph.clone(), Options::default(), &count).unwrap();
    let questions = asked.get();
    assert!(questions > 1000, "{questions}");
    for last in (0..questions).step_by(questions / 40) {
        let left = Cell::new(last);
        let stop = || left.replace(left.get().saturating_sub(1)) == 0;
        assert_eq!(nested_dissection(graph.clone(), Options::default(), &stop), Err(Failure::Stopped), "after {last}");
    }
    assert_eq!(nested_dissection(graph, Options::default(), &never), Ok(order));
}

#[test]
fn without_memory_there_is_no_order_and_nothing_worse() {
    let graph = grid(16, 16, 16);
    let order = nested_dissection(graph.clone(), Options::default(), &never).unwrap();
    let with = |most_bytes| nested_dissection(graph.clone(), Options { most_bytes, ..Options::default() }, &never);
    let found: Vec<_> = (0..80).map(|k| with(50_000 * k)).collect();
    let enough = found.iter().position(Result::is_ok).unwrap();
    assert!(enough > 10, "{enough}");
    assert!(found[..enough].iter().all(|f| *f == Err(Failure::OutOfMemory)));
    assert!(found[enough..].iter().all(|f| f.as_ref() == Ok(&order)));
}

#[test]
fn what_is_no_graph_is_refused() {
    let bad = |start: &[i32], neighbours: &[i32], weights: &[i32]| {
        let (start, neighbours, weights) = (start.to_vec(), neighbours.to_vec(), weights.to_vec());
        let found = nested_dissection(Graph { start, neighbours, weights }, Options::default(), &never);
        assert_eq!(found, Err(Failure::NoGraph));
    };
    bad(&[0], &[], &[]);
    bad(&[], &[], &[]);
    bad(&[0, 1], &[0], &[1]); // a loop
    bad(&[0, 1, 1], &[1], &[1, 1]); // named from one end
    bad(&[0, 1, 2], &[2, 0], &[1, 1]); // an edge that leads nowhere
    bad(&[0, 1, 2], &[-1, 0], &[1, 1]);
    bad(&[0, 2, 1], &[1, 0], &[1, 1]);
    bad(&[0, 1, 3], &[1, 0], &[1, 1]);
    bad(&[0, 1, 2], &[1, 0], &[1, 0]);
    bad(&[0, 1, 2], &[1, 0], &[i32::MAX, 1]);
    bad(&[0, 2, 3, 4], &[2, 1, 0, 0], &[1, 1, 1]); // descending
    assert!(
        nested_dissection(
            Graph { start: vec![0, 1, 2], neighbours: vec![1, 0], weights: vec![1, 1] },
            Options::default(),
            &never
        )
        .is_ok()
    );
}
