"""Random networks and readings for the tests."""

from __future__ import annotations

import numpy as np

from estimation.network import LINEAR, Network, Property, Relation, Unknown


def random_network(
    rng: np.random.Generator,
    materials: int = 5,
    categories: int = 3,
    scale: str = LINEAR,
    unknown: bool = True,
    relation: str | None = None,
    properties: int = 3,
) -> Network:
    """Return a network with random probabilities, means and spreads; properties p0, p1 ... and maybe r."""
    parents = ["material", "category" if categories else "material", None]
    found = []
    for i in range(properties):
        parent = parents[i % 3]
        count = {"material": materials, "category": categories, None: 1}[parent]
        means = rng.uniform(1.0, 10.0, count)
        sds = rng.uniform(0.2, 2.0, count)
        found.append(Property(f"p{i}", parent, "1", scale, tuple(means.tolist()), tuple(sds.tolist())))
    relations = ()
    if relation == "sum":
        relations = (Relation("r", "sum", "1", (("p0", 1.0), ("p1", -2.0))),)
    if relation == "product":
        relations = (Relation("r", "product", "1", (("p0", 1.0), ("p1", 1.0))),)
    if categories:
        table = rng.dirichlet(np.ones(materials), categories)
        conditional = tuple(tuple(row) for row in table.tolist())
        prior = tuple(rng.dirichlet(np.ones(categories)).tolist())
    else:
        conditional, prior = (), tuple(rng.dirichlet(np.ones(materials)).tolist())
    return Network(
        name="random",
        materials=tuple(f"m{i}" for i in range(materials)),
        properties=tuple(found),
        prior=prior,
        categories=tuple(f"c{i}" for i in range(categories)),
        conditional=conditional,
        relations=relations,
        unknown=Unknown(0.07) if unknown else None,
    )
