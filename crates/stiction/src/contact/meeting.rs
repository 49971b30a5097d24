//! What the faces of pairs meet, found by all ranks.
//!
//! Rank 0, which has the surfaces, gives each rank some faces of slave and master that lie together. Ranks tell one another the boxes around
//! these and around what their faces of the slave may meet, and neighbours send one another the faces that reach into such a box. What a
//! face meets depends on nothing else, and is the same to the last digit whoever finds it.

use std::cell::Cell;

use rustc_hash::FxHashMap;

use super::mortar::{Met, PerNode, Search, meet_some};
use super::pair::{default_search, is_posed};
use super::{ContactSurface, Counterpart, SurfaceFriction};
use crate::fem::face_coordinates;
use crate::mesh::shape::FACE_NODES;
use crate::mesh::v3::{V3, add, scale};
use crate::mesh::{Bounds, Face, Mesh, MeshArrays, Tree, ascending};
use crate::ranks::{Ranks, from_bytes, gather_all, put, take, to_bytes};

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
            let averted = surface.friction == SurfaceFriction::Bonded;
            let [own, other] = [&surface.faces, &master.faces].map(|faces| chunks(tree(mesh, faces).things(), size));
            for ((own, other), job) in own.iter().zip(&other).zip(&mut jobs) {
                let of_slave = own.iter().map(|&k| (k, surface.faces[k as usize]));
                let first = surface.faces.len() as u32;
                let of_master = other.iter().map(|&k| (first + k, master.faces[k as usize]));
                let mut faces = PairFaces::default();
                of_slave.chain(of_master).for_each(|(place, face)| {
                    let nodes = mesh.faces[face as usize].nodes();
                    faces.push(place, nodes, nodes.iter().map(|&v| mesh.nodes[v as usize]));
                });
                Job { search: Search { length, averted }, first, faces }.put(job);
            }
            asked.push((number, own));
        }
        if asked.is_empty() {
            return all;
        }
        self.asked.set(true);
        let own = std::mem::take(&mut jobs[0]);
        let others: Vec<usize> = (1..size).collect();
        self.ranks.exchange(jobs.into_iter().enumerate().skip(1).collect(), &[]);
        let own = answer(self.ranks, &own);
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
        let found = answer(ranks, &job);
        ranks.exchange(vec![(0, found)], &[]);
    }
}

fn tree(mesh: &Mesh, faces: &[u32]) -> Tree {
    Tree::new(faces.iter().map(|&face| Bounds::around(face_coordinates(mesh, face))).collect())
}

/// So many parts of a list, as long as one another.
fn chunks(list: &[u32], count: usize) -> Vec<Vec<u32>> {
    (0..count).map(|k| list[k * list.len() / count..(k + 1) * list.len() / count].to_vec()).collect()
}

/// Faces of a pair, by their places in the lists of slave and master behind one another.
#[derive(Default)]
struct PairFaces {
    places: Vec<u32>,
    counts: Vec<u8>,
    /// Of the nodes of one face after the other: their numbers in the whole mesh, and where they are, length.
    nodes: Vec<u32>,
    at: Vec<V3>,
}

impl PairFaces {
    fn push(&mut self, place: u32, nodes: &[u32], at: impl Iterator<Item = V3>) {
        self.places.push(place);
        self.counts.push(nodes.len() as u8);
        self.nodes.extend(nodes);
        self.at.extend(at);
    }

    fn iter(&self) -> impl Iterator<Item = (u32, &[u32], &[V3])> {
        let mut end = 0;
        self.places.iter().zip(&self.counts).map(move |(&place, &count)| {
            let nodes = end..end + usize::from(count);
            end = nodes.end;
            (place, &self.nodes[nodes.clone()], &self.at[nodes])
        })
    }

    /// The box around those that are `wanted`.
    fn bounds(&self, wanted: impl Fn(u32) -> bool) -> Bounds {
        let of = self.iter().filter(|(place, ..)| wanted(*place)).flat_map(|(_, _, at)| at.iter().copied());
        Bounds::around(of)
    }

    /// Those that reach into a box.
    fn within(&self, around: &Bounds) -> PairFaces {
        let mut some = PairFaces::default();
        let reaches = |at: &[V3]| Bounds::around(at.iter().copied()).meets(around);
        let near = self.iter().filter(|(_, _, at)| reaches(at));
        near.for_each(|(place, nodes, at)| some.push(place, nodes, at.iter().copied()));
        some
    }

    /// Adds others.
    fn append(&mut self, others: PairFaces) {
        self.places.extend(others.places);
        self.counts.extend(others.counts);
        self.nodes.extend(others.nodes);
        self.at.extend(others.at);
    }

    fn put(&self, to: &mut Vec<u8>) {
        put(&self.places, to);
        put(&self.counts, to);
        put(&self.nodes, to);
        put(&self.at, to);
    }

    fn take(from: &mut &[u8]) -> PairFaces {
        PairFaces { places: take(from), counts: take(from), nodes: take(from), at: take(from) }
    }

    /// A mesh of these faces alone, with the place of each and the number of each node in the whole. Faces are in the order of the lists and
    /// nodes in that of the whole: what is added up over them is added up in one order.
    fn mesh(&self) -> (Mesh, Vec<u32>, Vec<u32>) {
        let numbers = ascending(self.nodes.iter().copied());
        let mut nodes = vec![[0.0; 3]; numbers.len()];
        let mut listed: Vec<(u32, Face)> = Vec::new();
        for (place, of_face, at) in self.iter() {
            let own: Vec<u32> = of_face.iter().map(|v| numbers.partition_point(|other| other < v) as u32).collect();
            own.iter().zip(at).for_each(|(&v, &x)| nodes[v as usize] = x);
            listed.extend(Face::of_nodes(&own).map(|face| (place, face)));
        }
        listed.sort_by_key(|(place, _)| *place);
        let (places, faces) = listed.into_iter().unzip();
        let (cells, groups, arrays) = (Vec::new(), Vec::new(), MeshArrays::default());
        (Mesh { nodes, cells, faces, groups, arrays }, places, numbers)
    }
}

/// What a rank is given of a pair; its neighbours add to the faces.
struct Job {
    search: Search,
    /// The place of the first face of the master, behind those of the slave.
    first: u32,
    faces: PairFaces,
}

impl Job {
    fn put(&self, to: &mut Vec<u8>) {
        put(&[self.search.length], to);
        put(&[u8::from(self.search.averted)], to);
        put(&[self.first], to);
        self.faces.put(to);
    }

    fn take(from: &mut &[u8]) -> Job {
        let (length, averted, first): (Vec<f64>, Vec<u8>, Vec<u32>) = (take(from), take(from), take(from));
        let search = Search { length: length[0], averted: averted[0] == 1 };
        Job { search, first: first[0], faces: PairFaces::take(from) }
    }

    /// The places of its faces of the slave, in the order that they were given in.
    fn of_slave(&self) -> Vec<u32> {
        self.faces.places.iter().copied().filter(|&place| place < self.first).collect()
    }

    /// The box of what its faces of the slave may meet, as far along their normals, forwards and backwards, as is searched.
    fn reach(&self) -> Bounds {
        let (mesh, places, _) = self.faces.mesh();
        let length = self.search.length;
        let of = |k: usize| {
            let normal = mesh.face_normal(k);
            let ends = move |x: V3| [-length, length].map(|way| add(x, scale(way, normal)));
            face_coordinates(&mesh, k as u32).into_iter().flat_map(ends)
        };
        let slave = places.partition_point(|&place| place < self.first);
        Bounds::around((0..slave).flat_map(of)).grown(ROUNDING * length)
    }

    /// The boxes of what is looked for, and around the faces of slave and master.
    fn boxes(&self) -> [Bounds; 3] {
        let first = self.first;
        [self.reach(), self.faces.bounds(|place| place < first), self.faces.bounds(|place| place >= first)]
    }
}

/// What the faces of the slaves that this rank is given meet, with the help of its neighbours. All ranks call it.
fn answer(ranks: &dyn Ranks, mut message: &[u8]) -> Vec<u8> {
    let mut jobs = Vec::new();
    while !message.is_empty() {
        jobs.push(Job::take(&mut message));
    }
    let asked: Vec<Vec<u32>> = jobs.iter().map(Job::of_slave).collect();
    let boxes: Vec<V3> = jobs.iter().flat_map(Job::boxes).flat_map(|bounds| [bounds.low, bounds.high]).collect();
    let all: Vec<Vec<[Bounds; 3]>> = gather_all(ranks, to_bytes(&boxes)).iter().map(|boxes| boxes_of(boxes)).collect();
    let own = ranks.rank();
    let looks = |seeker: usize, holder: usize| {
        let mut pairs = all[seeker].iter().zip(&all[holder]);
        pairs.any(|([reach, ..], [_, slave, master])| reach.meets(slave) || reach.meets(master))
    };
    let others = || (0..ranks.size()).filter(|&rank| rank != own);
    let near = |rank: usize| {
        let mut to = Vec::new();
        jobs.iter().zip(&all[rank]).for_each(|(job, [reach, ..])| job.faces.within(reach).put(&mut to));
        to
    };
    let out = others().filter(|&rank| looks(rank, own)).map(|rank| (rank, near(rank))).collect();
    let from: Vec<usize> = others().filter(|&rank| looks(own, rank)).collect();
    for message in ranks.exchange(out, &from) {
        let mut rest = &message[..];
        jobs.iter_mut().for_each(|job| job.faces.append(PairFaces::take(&mut rest)));
    }
    let mut to = Vec::new();
    for (job, asked) in jobs.iter().zip(&asked) {
        let (mesh, places, numbers) = job.faces.mesh();
        let place = |wanted: &u32| places.partition_point(|place| place < wanted) as u32;
        let (some, slave) = (asked.iter().map(place).collect::<Vec<_>>(), place(&job.first));
        let [own, other] = [0..slave, slave..places.len() as u32].map(|faces| faces.collect::<Vec<_>>());
        let met = meet_some(&mesh, &some, [&own, &other], job.search);
        let counts: Vec<usize> = some.iter().map(|&face| mesh.faces[face as usize].nodes().len()).collect();
        put_met(&met, &counts, &numbers, &mut to);
    }
    to
}

fn boxes_of(message: &[u8]) -> Vec<[Bounds; 3]> {
    let corners: Vec<V3> = from_bytes(message);
    let (boxes, _) = corners.as_chunks::<6>();
    let bounds = |corners: &[V3; 6], k: usize| Bounds { low: corners[2 * k], high: corners[2 * k + 1] };
    boxes.iter().map(|corners| [0, 1, 2].map(|k| bounds(corners, k))).collect()
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
