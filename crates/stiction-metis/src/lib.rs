//! Nested dissection of METIS (Karypis & Kumar 1998) for a program that has signals, threads and a user of its own.
//!
//! `METIS_NodeND` sets handlers for SIGTERM and SIGABRT while it works and leaves them by `longjmp`: a signal that arrives on
//! another thread, as those of the user do, jumps into a stack that is not its own. Here the same code is compiled without
//! them, can be stopped, and holds no more memory than it may. Its orders are those of METIS 5.2.1 on GNU systems with the
//! same seed, on all systems and whatever other threads do. What is changed is listed in the file NOTICE.

use std::ffi::c_void;

/// A graph without loops whose edges are named from both ends.
#[derive(Debug, Clone)]
pub struct Graph {
    /// Neighbours of vertex `v` are `neighbours[start[v]..start[v + 1]]`, ascending.
    pub start: Vec<i32>,
    pub neighbours: Vec<i32>,
    /// What a vertex weighs in the balance of the parts, at least one.
    pub weights: Vec<i32>,
}

/// Choices of METIS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Of the random numbers.
    pub seed: i32,
    /// Separators tried at each level, of which the smallest is taken; at least one.
    pub separators: i32,
    /// Bytes that may be held at a time, the graph and the result not counted.
    pub most_bytes: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options { seed: 1, separators: 1, most_bytes: usize::MAX }
    }
}

/// Why there is no order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// Memory ran out, or more would have been held than may be.
    OutOfMemory,
    /// It was stopped.
    Stopped,
    /// The graph is not one: an edge leads nowhere or is named from one end only, or there are no vertices or too much weight.
    NoGraph,
}

/// `order[k]` is the vertex eliminated as the `k`-th. `stop` is asked every few milliseconds, on this thread; it must not panic
/// (that would end the process).
///
/// # Errors
/// The [`Failure`]; no memory stays behind.
pub fn nested_dissection(mut graph: Graph, options: Options, stop: &dyn Fn() -> bool) -> Result<Vec<i32>, Failure> {
    let n = checked(&graph).ok_or(Failure::NoGraph)?;
    let (mut order, mut place) = (vec![0i32; graph.weights.len()], vec![0i32; graph.weights.len()]);
    let told_to_stop: *const &dyn Fn() -> bool = &stop;
    // SAFETY: the arrays have the lengths C expects (n + 1, start[n], n, n, n) and hold a graph as it expects it, which
    // `checked` has seen. `asked` gets the pointer it is made for, which lives until the call ends.
    let code = unsafe {
        stiction_metis_nested_dissection(
            n,
            graph.start.as_mut_ptr(),
            graph.neighbours.as_mut_ptr(),
            graph.weights.as_mut_ptr(),
            options.seed,
            options.separators.max(1),
            options.most_bytes,
            asked,
            told_to_stop.cast(),
            order.as_mut_ptr(),
            place.as_mut_ptr(),
        )
    };
    match code {
        0 => Ok(order),
        1 => Err(Failure::OutOfMemory),
        2 => Err(Failure::Stopped),
        _ => Err(Failure::NoGraph),
    }
}

/// The number of vertices of what is a graph. METIS looks at nothing: it would read and write anywhere.
fn checked(graph: &Graph) -> Option<i32> {
    let Graph { start, neighbours, weights } = graph;
    let n = i32::try_from(weights.len()).ok().filter(|&n| n > 0 && start.len() == n as usize + 1)?;
    let total = weights.iter().try_fold(0i32, |sum, &w| sum.checked_add(w));
    let spans = start[0] == 0 && usize::try_from(start[n as usize]) == Ok(neighbours.len());
    let ascend = start.windows(2).all(|pair| pair[0] <= pair[1]);
    let within = neighbours.iter().all(|w| (0..n).contains(w));
    if total.is_none() || weights.iter().any(|&w| w < 1) || !(spans && ascend && within) {
        return None;
    }
    // Every edge once from each end: what is named by ascending vertices is met in that order from the other end.
    let mut next: Vec<i32> = start[..n as usize].to_vec();
    for v in 0..n as usize {
        let own = &neighbours[start[v] as usize..start[v + 1] as usize];
        if own.windows(2).any(|pair| pair[0] >= pair[1]) {
            return None;
        }
        for &w in own {
            let at = next[w as usize];
            if w as usize == v || at >= start[w as usize + 1] || neighbours[at as usize] != v as i32 {
                return None;
            }
            next[w as usize] += 1;
        }
    }
    Some(n)
}

/// Asks a `&dyn Fn() -> bool`.
extern "C" fn asked(stop: *const c_void) -> i32 {
    // SAFETY: `nested_dissection` hands this pointer on.
    let stop = unsafe { *stop.cast::<&dyn Fn() -> bool>() };
    i32::from(stop())
}

unsafe extern "C" {
    /// See `c/nested_dissection.c`.
    fn stiction_metis_nested_dissection(
        n: i32,
        start: *mut i32,
        neighbours: *mut i32,
        weights: *mut i32,
        seed: i32,
        separators: i32,
        most_bytes: usize,
        stop: extern "C" fn(*const c_void) -> i32,
        told_to_stop: *const c_void,
        order: *mut i32,
        place: *mut i32,
    ) -> i32;
}

#[cfg(test)]
mod tests;
