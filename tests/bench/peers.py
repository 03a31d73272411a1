"""The shares of a flock by scipy or networkx, as somebody without `dreams` would ask for them.

peers.py scipy|networkx MANIFEST. Prints one JSON document: the shares, and the processor seconds of reading and solving.
"""

import json
import re
import sys
import time

TRANSITION = re.compile(r'\[\[transition\]\]\nfrom = "([^"]+)"\nto = "([^"]+)"\n(?:frames|clip) = .*\n(?:frames|clip) = .*\nweight = (.*)\n')


def read(path):
    """Every transition of a manifest in the one form that the bench writes: from, to, weight."""
    with open(path) as text:
        return [(start, end, float(weight)) for start, end, weight in TRANSITION.findall(text.read())]


def by_scipy(transitions):
    """The left eigenvector of the chances by ARPACK."""
    import numpy
    from scipy.sparse import csr_matrix, diags
    from scipy.sparse.linalg import eigs

    ids = sorted({start for start, _, _ in transitions})
    number = {name: at for at, name in enumerate(ids)}
    start = [number[one] for one, _, _ in transitions]
    end = [number[other] for _, other, _ in transitions]
    weights = csr_matrix(([weight for _, _, weight in transitions], (start, end)), shape=(len(ids), len(ids)))
    chances = diags(1 / numpy.asarray(weights.sum(axis=1)).ravel()) @ weights
    _, vectors = eigs(chances.T.tocsr(), k=1, which="LR")
    visits = abs(vectors[:, 0].real)
    return dict(zip(ids, (visits / visits.sum()).tolist()))


def by_networkx(transitions):
    """PageRank without a jump; its tolerance is for the mean sheep."""
    import networkx

    graph = networkx.DiGraph()
    graph.add_weighted_edges_from(transitions)
    return networkx.pagerank(graph, alpha=1, tol=1e-16, max_iter=10_000)


def main():
    name, path = sys.argv[1:]
    transitions = read(path)
    read_s = time.process_time()
    visits = {"scipy": by_scipy, "networkx": by_networkx}[name](transitions)
    json.dump({"read_s": read_s, "solve_s": time.process_time() - read_s, "visits": visits}, sys.stdout)


if __name__ == "__main__":
    main()
