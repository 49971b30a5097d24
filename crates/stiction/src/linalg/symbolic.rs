use super::{NodeGraph, SymmetricCsr};

/// An elimination order with what a Cholesky factor in that order will cost, known before any arithmetic.
#[derive(Debug, Clone)]
pub struct Plan {
    /// `position[i]` is the place of unknown `i` in the elimination.
    pub position: Vec<u32>,
    /// Inverse of `position`.
    pub unknown: Vec<u32>,
    /// Parent in the elimination tree, by place; `u32::MAX` at a root.
    pub parent: Vec<u32>,
    /// Entries of each column of the factor, by place, diagonal included.
    pub column_count: Vec<u32>,
    /// Number of trailing places that were asked to come last.
    pub trailing: usize,
}

impl Plan {
    /// Entries of the factor.
    pub fn entries(&self) -> f64 {
        self.column_count.iter().map(|&c| f64::from(c)).sum()
    }

    /// Multiplications and additions of the factorisation.
    pub fn flops(&self) -> f64 {
        self.column_count.iter().map(|&c| f64::from(c).powi(2)).sum()
    }

    /// Entries of the largest matrix that is updated at a time: below the columns of one supernode.
    pub fn largest_front(&self) -> f64 {
        self.column_count.iter().map(|&c| f64::from(c).powi(2)).fold(0.0, f64::max)
    }

    /// Entries of the columns that are ancestors of the marked unknowns: what a solve has to touch when both its
    /// right-hand side and the wanted part of its result live on them.
    pub fn path_entries(&self, unknowns: &[u32]) -> f64 {
        let mut seen = vec![false; self.parent.len()];
        let mut entries = 0.0;
        for &i in unknowns {
            let mut place = self.position[i as usize];
            while place != u32::MAX && !seen[place as usize] {
                seen[place as usize] = true;
                entries += f64::from(self.column_count[place as usize]);
                place = self.parent[place as usize];
            }
        }
        entries
    }
}

/// Moves the nodes marked in `is_last` to the end of `order`, keeping both parts in their order.
pub fn last(order: &[u32], is_last: &[bool]) -> Vec<u32> {
    let part = |wanted: bool| order.iter().copied().filter(move |&v| is_last[v as usize] == wanted);
    part(false).chain(part(true)).collect()
}

/// The plan for eliminating the nodes of `graph` in `order`, the final `trailing_nodes` of them in exactly that
/// order. The others are reordered along the elimination tree (an equivalent order that lets columns of equal
/// structure stand side by side).
pub fn plan(graph: &NodeGraph, order: &[u32], trailing_nodes: usize) -> Plan {
    let n = graph.len();
    let (parent, _) = tree_and_counts(graph, order, false);
    let order = postordered(order, &parent, n - trailing_nodes);
    let (parent, weight) = tree_and_counts(graph, &order, true);
    expand(graph, &order, &parent, &weight, trailing_nodes)
}

/// Elimination tree by path compression (Liu 1990) and, if asked for, the number of unknowns in each node's column
/// below the node, by walking the row subtrees.
fn tree_and_counts(graph: &NodeGraph, order: &[u32], counts: bool) -> (Vec<u32>, Vec<u32>) {
    let n = order.len();
    let mut place = vec![0u32; n];
    order.iter().enumerate().for_each(|(k, &v)| place[v as usize] = k as u32);
    let mut parent = vec![u32::MAX; n];
    let mut shortcut = vec![u32::MAX; if counts { 0 } else { n }];
    let mut seen = vec![u32::MAX; if counts { n } else { 0 }];
    let mut weight = vec![0u32; if counts { n } else { 0 }];
    for (k, &v) in order.iter().enumerate() {
        let unknowns = graph.unknowns_of(v as usize).len() as u32;
        if counts {
            seen[k] = k as u32;
        }
        for &w in graph.neighbours_of(v as usize) {
            let mut i = place[w as usize];
            if i >= k as u32 {
                continue;
            }
            if counts {
                while seen[i as usize] != k as u32 {
                    seen[i as usize] = k as u32;
                    weight[i as usize] += unknowns;
                    if parent[i as usize] == u32::MAX {
                        parent[i as usize] = k as u32;
                    }
                    i = parent[i as usize];
                }
            } else {
                loop {
                    let next = std::mem::replace(&mut shortcut[i as usize], k as u32);
                    if next == u32::MAX {
                        parent[i as usize] = k as u32;
                        break;
                    }
                    if next == k as u32 {
                        break;
                    }
                    i = next;
                }
            }
        }
    }
    (parent, weight)
}

/// `order` with its first `count` entries in postorder of the tree; the rest stay where they are.
fn postordered(order: &[u32], parent: &[u32], count: usize) -> Vec<u32> {
    let none = u32::MAX;
    let (mut child, mut sibling) = (vec![none; count], vec![none; count]);
    let mut roots = Vec::new();
    for k in (0..count).rev() {
        let p = parent[k];
        if (p as usize) < count {
            sibling[k] = child[p as usize];
            child[p as usize] = k as u32;
        } else {
            roots.push(k as u32);
        }
    }
    let mut result = Vec::with_capacity(order.len());
    let mut stack = roots; // ascending from its top
    while let Some(&k) = stack.last() {
        let c = std::mem::replace(&mut child[k as usize], none);
        if c == none {
            result.push(order[k as usize]);
            stack.pop();
        } else {
            let mut all = Vec::new();
            let mut c = c;
            while c != none {
                all.push(c);
                c = sibling[c as usize];
            }
            stack.extend(all.into_iter().rev());
        }
    }
    result.extend_from_slice(&order[count..]);
    result
}

fn expand(graph: &NodeGraph, order: &[u32], parent: &[u32], weight: &[u32], trailing_nodes: usize) -> Plan {
    let n = graph.unknowns.len();
    let mut first_place = vec![0u32; order.len() + 1];
    for (k, &v) in order.iter().enumerate() {
        first_place[k + 1] = first_place[k] + graph.unknowns_of(v as usize).len() as u32;
    }
    let mut result = Plan {
        position: vec![0; n],
        unknown: Vec::with_capacity(n),
        parent: vec![u32::MAX; n],
        column_count: vec![0; n],
        trailing: n - first_place[order.len() - trailing_nodes] as usize,
    };
    for (k, &v) in order.iter().enumerate() {
        let unknowns = graph.unknowns_of(v as usize);
        for (c, &i) in unknowns.iter().enumerate() {
            let place = result.unknown.len();
            result.position[i as usize] = place as u32;
            result.unknown.push(i);
            result.column_count[place] = (unknowns.len() - c) as u32 + weight[k];
            result.parent[place] = if c + 1 < unknowns.len() {
                place as u32 + 1
            } else if parent[k] != u32::MAX {
                first_place[parent[k] as usize]
            } else {
                u32::MAX
            };
        }
    }
    result
}

/// The matrix `k` in the order of `plan`, both triangles, with an entry wherever two unknowns of neighbouring nodes
/// meet: as (column starts, rows, values) of its columns.
pub(super) fn permuted(k: &SymmetricCsr, graph: &NodeGraph, plan: &Plan) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let n = k.rows;
    let k = k.full();
    let mut node_of = vec![0u32; n];
    for v in 0..graph.len() {
        graph.unknowns_of(v).iter().for_each(|&i| node_of[i as usize] = v as u32);
    }
    let entries = graph.entries();
    let (mut start, mut rows, mut values) =
        (Vec::with_capacity(n + 1), Vec::with_capacity(entries), Vec::with_capacity(entries));
    start.push(0);
    let mut dense = vec![0.0; n];
    for &i in &plan.unknown {
        let (columns, entries) = k.row(i as usize);
        columns.iter().zip(entries).for_each(|(&j, &a)| dense[j as usize] = a);
        let v = node_of[i as usize] as usize;
        let begin = rows.len();
        for &w in graph.neighbours_of(v).iter().chain([&(v as u32)]) {
            rows.extend(graph.unknowns_of(w as usize).iter().map(|&j| plan.position[j as usize] as usize));
        }
        rows[begin..].sort_unstable();
        values.extend(rows[begin..].iter().map(|&place| dense[plan.unknown[place] as usize]));
        columns.iter().for_each(|&j| dense[j as usize] = 0.0);
        start.push(rows.len());
    }
    (start, rows, values)
}
