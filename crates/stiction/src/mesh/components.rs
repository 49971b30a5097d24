//! Which nodes hang together.

use super::Mesh;

/// For each node the number of its body: nodes connected through cells. Bodies are numbered by their lowest node.
pub fn bodies(mesh: &Mesh) -> Vec<u32> {
    // parents never have a higher number than their children, so one ascending sweep resolves all roots
    let mut parent: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    for (_, nodes) in mesh.cell_iter() {
        // Nearly all cells come after others that have joined their nodes.
        let first = parent[nodes[0] as usize];
        if nodes[1..].iter().all(|&node| parent[node as usize] == first) {
            continue;
        }
        for &node in &nodes[1..] {
            let [a, b] = [root(&mut parent, nodes[0]), root(&mut parent, node)];
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut count = 0;
    let mut body = vec![0; parent.len()];
    for node in 0..parent.len() {
        body[node] = if parent[node] as usize == node {
            count += 1;
            count - 1
        } else {
            body[parent[node] as usize]
        };
    }
    body
}

/// The lowest node known to hang together with `node`; halves the path on the way.
pub(super) fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        let above = parent[parent[node as usize] as usize];
        parent[node as usize] = above;
        node = above;
    }
    node
}
