//! What the faces of pairs meet, found by all ranks.
//!
//! Rank 0, which has the surfaces, sends each of the others some faces of the slaves that lie together, and of both surfaces what reaches
//! into the box around what these may meet. What a face meets depends on nothing else, and is the same to the last digit whoever finds it.

use std::cell::Cell;

use rustc_hash::FxHashMap;

use super::mortar::{Met, PerNode, Search, meet_some};
use super::pair::{default_search, is_posed};
use super::{ContactSurface, Counterpart, SurfaceFriction};
use crate::fem::face_coordinates;
use crate::mesh::shape::FACE_NODES;
use crate::mesh::v3::{V3, add, scale};
use crate::mesh::{Bounds, Face, Mesh, MeshArrays, Tree, ascending};
use crate::ranks::{Ranks, put, take};

/// What the faces of some surfaces meet, by the numbers of these.
#[derive(Debug, Default)]
pub(crate) struct AllMet(pub(super) FxHashMap<usize, Vec<Met>>);

/// A rank is asked for no fewer faces: what it is sent takes as long as some.
const LEAST: usize = 64;

/// What rounding adds to a length, as a part of it.
const ROUNDING: f64 = 1e-9;

/// The other ranks, as rank 0 has them: they wait until they are asked, or this is dropped.
pub(crate) struct Helpers<'a> {
    ranks: &'a dyn Ranks,
    asked: Cell<bool>,
}

impl<'a> Helpers<'a> {
    /// All others call [`help`].
    pub(crate) fn new(ranks: &'a dyn Ranks) -> Helpers<'a> {
        Helpers { ranks, asked: Cell::new(false) }
    }

    /// How many ranks there are.
    pub(crate) fn ranks(&self) -> usize {
        self.ranks.size()
    }

    /// What the faces of all pairs meet that are large enough to be divided; nothing if they were asked before.
    pub(crate) fn meet(&self, mesh: &Mesh, surfaces: &[ContactSurface]) -> AllMet {
        let size = self.ranks.size();
        let mut all = AllMet::default();
        if size == 1 || self.asked.get() {
            return all;
        }
        let mut jobs: Vec<Vec<u8>> = vec![Vec::new(); size];
        let mut asked: Vec<(usize, Vec<Vec<u32>>)> = Vec::new();
        for (number, surface) in surfaces.iter().enumerate().filter(|(_, surface)| surface.faces.len() >= LEAST * size)
        {
            let Counterpart::Surface(master) = &surface.against else { continue };
            if master.nodes.is_some() || !is_posed(surface, master) {
                continue;
            }
            let length = master.search.unwrap_or_else(|| default_search(mesh, &surface.faces, &master.faces));
            let search = Search { length, averted: surface.friction == SurfaceFriction::Bonded };
            let [own, other] = [&surface.faces, &master.faces].map(|faces| tree(mesh, faces));
            let chunks = chunks(own.things(), size);
            for (chunk, job) in chunks.iter().zip(&mut jobs) {
                let reach = chunk.iter().map(|&k| reach(mesh, surface.faces[k as usize], length));
                let around = reach.fold(Bounds::around([]), |a, b| a.with(&b)).grown(ROUNDING * length);
                let near = [(&own, &surface.faces), (&other, &master.faces)].map(|(tree, faces)| {
                    tree.meeting(&around).into_iter().map(|k| faces[k as usize]).collect::<Vec<u32>>()
                });
                let some: Vec<u32> = chunk.iter().map(|&k| surface.faces[k as usize]).collect();
                put_job(mesh, &some, [&near[0], &near[1]], search, job);
            }
            asked.push((number, chunks));
        }
        if asked.is_empty() {
            return all;
        }
        self.asked.set(true);
        let own = std::mem::take(&mut jobs[0]);
        let others: Vec<usize> = (1..size).collect();
        self.ranks.exchange(jobs.into_iter().enumerate().skip(1).collect(), &[]);
        let own = answer(&own);
        let answers = [vec![own], self.ranks.exchange(Vec::new(), &others)].concat();
        let mut rests: Vec<&[u8]> = answers.iter().map(|answer| &answer[..]).collect();
        for (number, chunks) in asked {
            let faces = &surfaces[number].faces;
            let mut met = vec![Met::default(); faces.len()];
            for (chunk, rest) in chunks.iter().zip(&mut rests) {
                let nodes = |&k: &u32| mesh.faces[faces[k as usize] as usize].nodes().len();
                let found = take_met(&chunk.iter().map(nodes).collect::<Vec<_>>(), rest);
                chunk.iter().zip(found).for_each(|(&k, found)| met[k as usize] = found);
            }
            all.0.insert(number, met);
        }
        all
    }
}

impl Drop for Helpers<'_> {
    fn drop(&mut self) {
        if !self.asked.get() && !std::thread::panicking() {
            self.ranks.exchange((1..self.ranks.size()).map(|rank| (rank, Vec::new())).collect(), &[]);
        }
    }
}

/// Waits for what rank 0 asks for, and finds it.
pub(crate) fn help(ranks: &dyn Ranks) {
    let job = ranks.exchange(Vec::new(), &[0]).swap_remove(0);
    if !job.is_empty() {
        ranks.exchange(vec![(0, answer(&job))], &[]);
    }
}

/// The box of what a face may meet so far along its normal, forwards and backwards.
fn reach(mesh: &Mesh, face: u32, length: f64) -> Bounds {
    let normal = mesh.face_normal(face as usize);
    let of = |&v: &u32| [-length, length].map(|way| add(mesh.nodes[v as usize], scale(way, normal)));
    Bounds::around(mesh.faces[face as usize].nodes().iter().flat_map(of))
}

fn tree(mesh: &Mesh, faces: &[u32]) -> Tree {
    Tree::new(faces.iter().map(|&face| Bounds::around(face_coordinates(mesh, face))).collect())
}

/// So many parts of a list, as long as one another.
fn chunks(list: &[u32], count: usize) -> Vec<Vec<u32>> {
    (0..count).map(|k| list[k * list.len() / count..(k + 1) * list.len() / count].to_vec()).collect()
}

/// Asks what `some` faces of the slave meet; `near` are the faces of slave and master around them.
fn put_job(mesh: &Mesh, some: &[u32], near: [&[u32]; 2], search: Search, to: &mut Vec<u8>) {
    let faces = ascending(near.concat().into_iter().chain(some.iter().copied()));
    let nodes = mesh.face_nodes(&faces);
    // Numbers keep their order: what is summed up by nodes is summed up in the same order.
    let node = |v: u32| nodes.partition_point(|&other| other < v) as u32;
    let place = |list: &[u32]| -> Vec<u32> {
        list.iter().map(|face| faces.partition_point(|other| other < face) as u32).collect()
    };
    put(&[search.length], to);
    put(&[u8::from(search.averted)], to);
    put(&nodes, to);
    put(&nodes.iter().map(|&v| mesh.nodes[v as usize]).collect::<Vec<V3>>(), to);
    let of = |&face: &u32| mesh.faces[face as usize].nodes();
    put(&faces.iter().map(|face| of(face).len() as u8).collect::<Vec<u8>>(), to);
    put(&faces.iter().flat_map(of).map(|&v| node(v)).collect::<Vec<u32>>(), to);
    [some, near[0], near[1]].into_iter().for_each(|list| put(&place(list), to));
}

/// The answer to the jobs of a message.
fn answer(mut jobs: &[u8]) -> Vec<u8> {
    let mut to = Vec::new();
    while !jobs.is_empty() {
        let from = &mut jobs;
        let (length, averted): (Vec<f64>, Vec<u8>) = (take(from), take(from));
        let (numbers, nodes): (Vec<u32>, Vec<V3>) = (take(from), take(from));
        let (counts, of_faces): (Vec<u8>, Vec<u32>) = (take(from), take(from));
        let [some, own, other]: [Vec<u32>; 3] = std::array::from_fn(|_| take(from));
        let mut rest = &of_faces[..];
        let face = |&count: &u8| {
            let (nodes, after) = rest.split_at(count.into());
            rest = after;
            Face::of_nodes(nodes)
        };
        let faces = counts.iter().filter_map(face).collect();
        let (cells, groups, arrays) = (Vec::new(), Vec::new(), MeshArrays::default());
        let mesh = Mesh { nodes, cells, faces, groups, arrays };
        let search = Search { length: length[0], averted: averted[0] == 1 };
        let met = meet_some(&mesh, &some, [&own, &other], search);
        let counts: Vec<usize> = some.iter().map(|&face| mesh.faces[face as usize].nodes().len()).collect();
        put_met(&met, &counts, &numbers, &mut to);
    }
    to
}

/// Numbers of a face that are always there: covered and flat area, distances, normals, middle.
const NUMBERS: usize = 11;

/// What faces with so many nodes meet; `numbers` are those of the nodes in the whole mesh.
fn put_met(met: &[Met], nodes: &[usize], numbers: &[u32], to: &mut Vec<u8>) {
    let (mut words, mut values): (Vec<u32>, Vec<f64>) = Default::default();
    for (met, &n) in met.iter().zip(nodes) {
        let Met { areas, masters, covered, flat, distance, distances, normals, middle, several, averted, places } = met;
        let flags = [*several, *averted, places.is_some()];
        words.push(flags.iter().enumerate().map(|(k, flag)| u32::from(*flag) << k).sum());
        words.push(masters.len() as u32);
        words.extend(masters.iter().map(|(node, _)| numbers[*node as usize]));
        values.extend([*covered, *flat, *distance]);
        values.extend(distances.iter().chain(normals).chain(middle));
        values.extend(&areas[..n]);
        masters.iter().for_each(|(_, of)| values.extend(&of[..n]));
        values.extend(places.iter().flat_map(|places| places.as_flattened()));
    }
    put(&words, to);
    put(&values, to);
}

fn take_met(nodes: &[usize], from: &mut &[u8]) -> Vec<Met> {
    let (words, values): (Vec<u32>, Vec<f64>) = (take(from), take(from));
    let (mut words, mut values) = (&words[..], &values[..]);
    let mut word = |count: usize| {
        let (some, after) = words.split_at(count);
        words = after;
        some
    };
    let mut value = |count: usize| {
        let (some, after) = values.split_at(count);
        values = after;
        some
    };
    let per_node = |of: &[f64]| -> PerNode { std::array::from_fn(|i| of.get(i).copied().unwrap_or(0.0)) };
    let one = |&n: &usize| {
        let head = word(2);
        let is = |k: u32| head[0] >> k & 1 == 1;
        let of_masters = word(head[1] as usize);
        let numbers: Vec<f64> = value(NUMBERS).to_vec();
        let v3 = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
        Met {
            areas: per_node(value(n)),
            masters: of_masters.iter().map(|&node| (node, per_node(value(n)))).collect(),
            covered: numbers[0],
            flat: numbers[1],
            distance: numbers[2],
            distances: [numbers[3], numbers[4]],
            normals: v3(5),
            middle: v3(8),
            several: is(0),
            averted: is(1),
            places: is(2).then(|| {
                let of = value(FACE_NODES * FACE_NODES);
                Box::new(std::array::from_fn(|i| per_node(&of[i * FACE_NODES..(i + 1) * FACE_NODES])))
            }),
        }
    };
    nodes.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::mortar::meet;
    use crate::contact::{ALWAYS, InitialGap, Master, Reason, Role};
    use crate::mesh::{Block, BlockElement, block, join};
    use crate::ranks::threads;

    /// A block on a wider one that it partly hangs over, whose nodes lie on no plane.
    fn pair(elements: [BlockElement; 2], friction: SurfaceFriction) -> (Mesh, ContactSurface) {
        let part = |size: [f64; 3], origin: [f64; 3], cells: [usize; 3], element: BlockElement| {
            block(&Block { size, origin, cells, grading: [1.0; 3], element }).unwrap()
        };
        let above = part([1.0, 1.0, 0.2], [0.0; 3], [15, 16, 1], elements[0]);
        let below = part([1.0, 1.3, 0.3], [0.123, -0.1, -0.3], [11, 9, 1], elements[1]);
        let mut mesh = join(vec![("above".into(), above), ("below".into(), below)]);
        for x in &mut mesh.nodes {
            x[2] += 0.01 * (7.0 * x[0]).sin() * (5.0 * x[1] + 0.3).cos();
        }
        let faces = |name: &str| mesh.group(name).unwrap().faces.clone();
        let (faces, other) = (faces("above.z-min"), faces("below.z-max"));
        let gap = InitialGap::AsMeshed;
        let master =
            Master { faces: other, gap, search: Some(0.1), slave: Role::On, reason: Reason::First, nodes: None };
        let against = Counterpart::Surface(master);
        let surface =
            ContactSurface { name: "c".into(), faces, against, friction, stiffness: None, periods: vec![ALWAYS] };
        (mesh, surface)
    }

    #[test]
    fn what_faces_meet_is_the_same_whoever_finds_it() {
        let (flat, curved) = (BlockElement::Tet4Five { parity: 0 }, BlockElement::Hex20);
        for elements in [[BlockElement::Hex8, flat], [flat, curved], [curved, BlockElement::Tet10Six]] {
            for friction in [SurfaceFriction::None, SurfaceFriction::Bonded] {
                let averted = friction == SurfaceFriction::Bonded;
                let (mesh, surface) = pair(elements, friction);
                let Counterpart::Surface(master) = &surface.against else { panic!("a pair") };
                let alone = meet(&mesh, &surface.faces, &master.faces, Search { length: 0.1, averted });
                assert!(alone.iter().any(|met| met.covered == 0.0) && alone.iter().any(|met| met.places.is_some()));
                let surfaces = [surface];
                for size in [1, 2, 3] {
                    let found = threads(size, |ranks| match ranks.rank() {
                        0 => Some(Helpers::new(&*ranks).meet(&mesh, &surfaces)),
                        _ => {
                            help(&*ranks);
                            None
                        }
                    });
                    let found = found.into_iter().flatten().next().unwrap().0;
                    assert_eq!(found.get(&0), (size > 1).then_some(&alone), "{size}");
                }
            }
        }
    }

    /// Ranks that are not asked go on.
    #[test]
    fn a_pair_with_few_faces_is_met_by_rank_0() {
        let (mesh, surface) = pair([BlockElement::Hex8; 2], SurfaceFriction::None);
        let surfaces = [surface];
        let found = threads(4, |ranks| match ranks.rank() {
            0 => Helpers::new(&*ranks).meet(&mesh, &surfaces).0.len(),
            _ => {
                help(&*ranks);
                0
            }
        });
        assert_eq!(found, [0; 4]);
    }
}
