"""The bonded linear problem of a result folder, solved by pyamg: the parts tied to one another where contact points are.

`problem.npz` holds K, f and the rows B of the jump at the contact points. Tied together B u = 0: the displacements of one
surface follow from those of the other, u = T v, and T' K T v = T' f is solved by smoothed aggregation with the rigid motions
and conjugate gradients to 1e-8. Seconds are CPU seconds of set-up and solve, T' K T not counted.
"""

import json
import sys
import time

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import min_weight_full_bipartite_matching


def own_nodes(weight):
    """A node for each contact point, no two alike, such that the product of the weights is largest."""
    cost = weight.copy()
    cost.data = 1 - np.log(weight.data / weight.data.max())
    point, node = min_weight_full_bipartite_matching(cost)
    return node[np.argsort(point)]


def carriers(weight, node, body, pair_ends):
    """The entries of `weight` whose nodes lie on the side of their pair that most of `node` are on."""
    entry = weight.tocoo()
    keep = np.zeros(entry.nnz, bool)
    begin = 0
    for end in pair_ends:
        own = (entry.row >= begin) & (entry.row < end)
        # Each point touches both sides; its node is one of the side that carries the points, but for a few.
        touched = np.unique(np.stack([entry.row[own], body[entry.col[own]]]), axis=1)[1]
        votes = np.bincount(body[node[begin:end]], minlength=body.max() + 1)
        carries = 2 * votes > np.bincount(touched, minlength=len(votes))
        keep |= own & carries[body[entry.col]]
        begin = end
    return sp.csr_matrix((entry.data[keep], (entry.row[keep], entry.col[keep])), weight.shape)


def tie(B, points, node_of, body_of, pair_ends):
    """T with u = T v wherever B u = 0, and the unknowns v."""
    entry = B.tocoo()
    nodes = node_of.max() + 1
    body = np.zeros(nodes, int)
    body[node_of] = body_of
    weight = sp.csr_matrix((entry.data**2, (entry.row % points, node_of[entry.col])), (points, nodes))
    weight.sum_duplicates()
    weight.eliminate_zeros()
    node = own_nodes(weight)
    try:
        node = own_nodes(carriers(weight, node, body, pair_ends))
    except ValueError:
        pass  # a node that two pairs need: any other will do
    own = np.zeros(nodes, bool)
    own[node] = True
    slave = np.flatnonzero(own[node_of])
    free = np.flatnonzero(~own[node_of])
    # Blocks of three in the order of the points.
    order = np.empty(nodes, int)
    order[node] = np.arange(points)
    slave = slave[np.argsort(order[node_of[slave]], kind="stable")]
    if len(slave) != 3 * points:
        raise ValueError("a contact point on a node that is partly supported")
    rows = np.arange(3 * points).reshape(3, points).T.ravel()
    S, M = B[rows][:, slave].tocsr(), B[rows][:, free].tocsr()
    blocks = np.linalg.inv(S.tobsr((3, 3)).multiply(sp.kron(sp.identity(points), np.ones((3, 3)))).tobsr((3, 3)).data)
    inverse = sp.bsr_matrix((blocks, np.arange(points), np.arange(points + 1))).tocsr()
    # S is nearly block diagonal: middles of edges also see the ends.
    rest = sp.identity(3 * points, format="csr") - inverse @ S
    rest.data[np.abs(rest.data) < 1e-14] = 0
    rest.eliminate_zeros()
    first = inverse @ M
    X, steps = first, 0
    while True:
        new = first + rest @ X
        change = abs(new - X).max()
        X, steps = new, steps + 1
        if change < 1e-12:
            break
        if steps > 200:
            raise ValueError("the tie is not found")
    n = len(node_of)
    T = sp.csr_matrix((np.ones(len(free)), (free, np.arange(len(free)))), (n, len(free)))
    X = X.tocoo()
    T = T - sp.csr_matrix((X.data, (slave[X.row], X.col)), (n, len(free)))
    return T.tocsr(), free


def bonded(path):
    with np.load(path) as data:
        f, rigid, node_of = data["f"], data["rigid"], data["node_of"].astype(int)
        n, points = len(f), len(data["gap"])
        lower = sp.csr_matrix((data["K_lower_value"], data["K_lower_column"].astype(np.int32), data["K_lower_start"]), (n, n))
        B = sp.csr_matrix((data["B_value"], data["B_column"].astype(np.int32), data["B_start"]), (3 * points, n))
        T, free = tie(B, points, node_of, data["body_of"].astype(int), data["pair_ends"])
    K = lower + sp.tril(lower, -1).T
    residual = abs(B @ T).max() / abs(B).max()
    return (T.T @ K @ T).tocsr(), T.T @ f, rigid[free], node_of[free], residual


def whole_nodes(K, f, rigid, node_of):
    """Three unknowns for each node: supported ones are put back, without stiffness to the others."""
    _, node = np.unique(node_of, return_inverse=True)
    count = np.bincount(node)
    place = 3 * node + np.arange(len(node)) - np.concatenate([[0], np.cumsum(count)])[node]
    n = 3 * len(count)
    P = sp.csr_matrix((np.ones(len(place)), (place, np.arange(len(place)))), (n, len(place)))
    missing = np.ones(n)
    missing[place] = 0
    return P @ K @ P.T + sp.diags(missing * K.diagonal().mean()), P @ f, P @ rigid


def main():
    import pyamg

    K, f, rigid, node_of, residual = bonded(sys.argv[1])
    K, f, rigid = whole_nodes(K, f, rigid, node_of)
    K = K.tobsr((3, 3))
    K.sort_indices()
    if not f.any():
        f = K @ np.random.default_rng(1).standard_normal(len(f))
    start = time.process_time()
    hierarchy = pyamg.smoothed_aggregation_solver(K, B=rigid, max_coarse=300)
    setup = time.process_time() - start
    residuals = []
    u = hierarchy.solve(f, tol=1e-8, maxiter=1000, accel="cg", residuals=residuals)
    seconds = time.process_time() - start
    left = np.linalg.norm(f - K @ u) / np.linalg.norm(f)
    print(json.dumps({"unknowns": len(f), "setup": setup, "seconds": seconds, "steps": len(residuals) - 1, "residual": left, "tie": residual}))


main()
