"""Triangle meshes for the peers: reading, pieces, the cut to a disk, the disk's boundary on a square.

The cut is the peers' own: the shortest tree of edge paths that joins all boundary loops (Prim over the loops), tree and
cotree for handles (Erickson, Whittlesey 2005), and a path between two far ends where the surface is closed. gimage does
not hand out its disk, and its cut is part of what is compared.
"""
import igl
import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components, dijkstra, minimum_spanning_tree


def read_obj(path):
    """Vertices and triangles of a plain OBJ file, as the benchmark writes it."""
    vertices, faces = [], []
    with open(path) as lines:
        for line in lines:
            kind, *rest = line.split()
            if kind == "v":
                vertices.append([float(x) for x in rest])
            elif kind == "f":
                faces.append([int(x) - 1 for x in rest])
    return np.array(vertices), np.array(faces, np.int64)


def area(V, F):
    sides = V[F[:, 1:]] - V[F[:, :1]]
    return 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)


def pieces(V, F):
    """Each connected piece with its own numbering."""
    n = len(V)
    graph = sp.coo_matrix((np.ones(2 * len(F)), (np.r_[F[:, 0], F[:, 1]], np.r_[F[:, 1], F[:, 2]])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    for k in np.unique(label[F[:, 0]]):
        used, inverse = np.unique(F[label[F[:, 0]] == k], return_inverse=True)
        yield V[used], inverse.reshape(-1, 3).astype(np.int64)


class Edges:
    """The edges of a mesh: their ends, the edge after each corner, and how many faces have each."""

    def __init__(self, V, F):
        halves = np.sort(np.stack([F, np.roll(F, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        self.ends, self.of_corner, self.uses = np.unique(halves, axis=0, return_inverse=True, return_counts=True)
        self.of_corner = self.of_corner.reshape(-1)
        self.length = np.linalg.norm(V[self.ends[:, 0]] - V[self.ends[:, 1]], axis=1)
        self.n = len(V)
        a, b = self.ends.T
        self.graph = sp.coo_matrix((np.r_[self.length, self.length], (np.r_[a, b], np.r_[b, a])), shape=(self.n, self.n)).tocsr()
        # Edge + 1 of two vertices, 0 for none.
        ids = np.arange(1, len(a) + 1)
        self.index = sp.coo_matrix((np.r_[ids, ids], (np.r_[a, b], np.r_[b, a])), shape=(self.n, self.n)).tocsr()

    def paths(self, sources):
        """Distance and predecessor of every vertex from the nearest source."""
        distance, before, _ = dijkstra(self.graph, indices=np.asarray(sources), return_predecessors=True, min_only=True)
        return distance, before

    def walk(self, before, v):
        """The edges and vertices from `v` back to a source."""
        edges, vertices = [], [int(v)]
        while before[v] >= 0:
            edges.append(self.index[v, before[v]] - 1)
            v = before[v]
            vertices.append(int(v))
        return edges, vertices


def cut_edges(V, F):
    """Which edges to cut so that one disk is left."""
    edges = Edges(V, F)
    cut = np.zeros(len(edges.ends), bool)
    a, b = edges.ends[edges.uses == 1].T
    _, label = connected_components(sp.coo_matrix((np.ones(len(a)), (a, b)), shape=(edges.n, edges.n)), directed=False)
    loops = [np.flatnonzero(label == k) for k in np.unique(label[a])] if len(a) else []
    loops.sort(key=len)
    joined = loops.pop().tolist() if loops else far_path(edges, cut)
    todo = loops
    while todo:
        distance, before = edges.paths(joined)
        nearest = min(range(len(todo)), key=lambda k: distance[todo[k]].min())
        loop = todo.pop(nearest)
        path, vertices = edges.walk(before, loop[np.argmin(distance[loop])])
        cut[path] = True
        joined += vertices + loop.tolist()
    holes = len(np.unique(label[a])) if len(a) else 0
    if len(V) - len(edges.ends) + len(F) != 2 - holes:
        cut_handles(edges, F, joined, cut)
    return edges, cut


def far_path(edges, cut):
    """Cuts a closed surface along a path between two vertices that are far apart, found by going there and back."""
    start = 0
    for _ in range(3):
        distance, before = edges.paths([start])
        last, start = start, int(np.argmax(distance))
    distance, before = edges.paths([last])
    path, vertices = edges.walk(before, start)
    cut[path] = True
    return vertices


def cut_handles(edges, F, joined, cut):
    """A shortest-path tree, a dual spanning tree of what it leaves, and a loop for each edge in neither."""
    distance, before = edges.paths(joined)
    tree = cut.copy()
    for v in np.flatnonzero(before >= 0):
        tree[edges.index[v, before[v]] - 1] = True
    order = np.argsort(edges.of_corner, kind="stable")
    of = edges.of_corner[order]
    first = np.flatnonzero(of[1:] == of[:-1])
    edge, left, right = of[first], order[first] // 3, order[first + 1] // 3
    keep = ~tree[edge] & (left != right)
    edge, left, right = edge[keep], left[keep], right[keep]
    weight = distance[edges.ends[edge]].sum(axis=1) + edges.length[edge]
    # The dual tree keeps the longest loops uncut; two faces that share two edges are joined by the longer one.
    best = np.lexsort((weight, np.maximum(left, right), np.minimum(left, right)))
    edge, left, right, weight = edge[best], np.minimum(left, right)[best], np.maximum(left, right)[best], weight[best]
    last = np.r_[(left[1:] != left[:-1]) | (right[1:] != right[:-1]), True]
    faces = len(F)
    dual = sp.coo_matrix((weight.max() + 1 - weight[last], (left[last], right[last])), shape=(faces, faces))
    spanning = minimum_spanning_tree(dual.tocsr()).tocoo()
    in_dual = set(zip(spanning.row.tolist(), spanning.col.tolist()))
    for k in range(len(edge)):
        if last[k] and (left[k], right[k]) in in_dual:
            continue
        cut[edge[k]] = True
        for v in edges.ends[edge[k]]:
            cut[edges.walk(before, v)[0]] = True


def disk(V, F):
    """The piece opened along its cut. Raises where that is no disk."""
    edges, cut = cut_edges(V, F)
    order = np.argsort(edges.of_corner, kind="stable")
    of = edges.of_corner[order]
    k = np.flatnonzero((of[1:] == of[:-1]) & ~cut[of[1:]])
    a, b = order[k], order[k + 1]
    after = lambda corner: corner - corner % 3 + (corner + 1) % 3
    corner = F.reshape(-1)
    same = corner[a] == corner[b]
    from_b, to_b = np.where(same, b, after(b)), np.where(same, after(b), b)
    pairs = np.r_[a, after(a)], np.r_[from_b, to_b]
    graph = sp.coo_matrix((np.ones(len(pairs[0])), pairs), shape=(len(corner), len(corner)))
    count, label = connected_components(graph, directed=False)
    source = np.zeros(count, np.int64)
    source[label] = corner
    V, F = split_chords(V[source], label.reshape(-1, 3).astype(np.int64))
    if len(igl.boundary_loop_all(F)) != 1 or len(V) - len(Edges(V, F).ends) + len(F) != 1:
        raise ValueError("the cut leaves no disk")
    return V, F


def split_chords(V, F):
    """Splits inner edges between two boundary vertices: on a straight side of the square they would be flat."""
    edges = Edges(V, F)
    rim = np.zeros(len(V), bool)
    rim[edges.ends[edges.uses == 1]] = True
    for a, b in edges.ends[(edges.uses == 2) & rim[edges.ends].all(axis=1)]:
        middle = len(V)
        V = np.vstack([V, 0.5 * (V[a] + V[b])])
        faces = np.flatnonzero((F == a).any(axis=1) & (F == b).any(axis=1))
        halves = np.where(F[faces] == a, middle, F[faces])
        F[faces] = np.where(F[faces] == b, middle, F[faces])
        F = np.vstack([F, halves])
    return V, F


def on_square(V, F):
    """The boundary loop and its place on the unit square, by length, corners at the nearest vertices."""
    loop = np.array(igl.boundary_loop_all(F)[0])
    step = np.linalg.norm(V[np.roll(loop, -1)] - V[loop], axis=1)
    at = np.r_[0, np.cumsum(step)] / step.sum()
    corners = [int(np.argmin(np.abs(at[:-1] - k / 4))) for k in range(4)] + [len(loop)]
    if len(set(corners)) < 5:
        raise ValueError("the boundary is too short for a square")
    t = np.interp(at[:-1], at[corners], np.arange(5))
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0.0]])
    return loop, np.stack([np.interp(t, np.arange(5), square[:, k]) for k in range(2)], axis=1)
