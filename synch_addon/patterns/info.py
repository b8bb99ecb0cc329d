# SPDX-License-Identifier: GPL-3.0-or-later
"""Facts about a mesh and the spacings that it can carry."""

import numpy as np

from ...core.errors import MeshError
from ...core.graphs import components
from ...core.refinement.spacing import COARSE_SHARE, EDGES_PER_PERIOD, automatic_spacing, lines_in_period
from ..blender.meshes import object_mode, read_mesh
from ..jobs.report import versions


def describe(obj):
    """Facts about a mesh object: the dict for the report, and lines to read."""
    try:
        with object_mode(obj):
            given = read_mesh(obj)
    except MeshError as error:
        facts = {"command": "info", "object": obj.name, "status": "refused", "reason": str(error)}
        return facts | {"versions": versions()}, [f"{obj.name}: cannot carry a field: {error}"]
    mesh, polygons = given.mesh, given.polygons
    facts = {
        "command": "info",
        "object": obj.name,
        "status": "ready",
        "vertices": given.vertex_count,
        "loose_vertices": len(given.loose_vertices),
        "edges": len(mesh.edges),
        "faces": len(polygons.starts),
        "triangles": mesh.triangle_count,
        "pieces": len(np.unique(mesh.pieces[mesh.triangles[:, 0]])),
        "boundary_loops": _boundary_loops(mesh),
        "euler_characteristic": given.euler_characteristic,
        "size": np.ptp(mesh.vertices, axis=0).tolist(),
        "area": float(mesh.areas.sum()),
        "edge_length": {
            "shortest": float(mesh.edge_lengths.min()),
            "median": float(np.median(mesh.edge_lengths)),
            "longest": float(mesh.edge_lengths.max()),
        },
        "automatic_spacing": automatic_spacing(mesh, lines_in_period("stripes")),
        "finest_spacing": 2 * float(np.quantile(mesh.edge_lengths, 1 - COARSE_SHARE)),
        "carrier": given.finding_counts,
        "versions": versions(),
    }
    return facts, _lines(facts) + [finding.line for finding in given.findings]


def _boundary_loops(mesh):
    """Number of connected pieces of the boundary."""
    edges = mesh.edges[mesh.boundary_edges]
    return len(np.unique(components(mesh.vertex_count, edges)[edges]))


def _lines(facts):
    lengths = facts["edge_length"]
    return [
        f"{facts['object']}: {facts['vertices']} vertices, {facts['edges']} edges, {facts['faces']} faces "
        f"({facts['triangles']} triangles)",
        f"pieces {facts['pieces']}, boundary loops {facts['boundary_loops']}, Euler characteristic "
        f"{facts['euler_characteristic']}, loose vertices {facts['loose_vertices']}",
        "size {:.4g} x {:.4g} x {:.4g}, area {:.4g}".format(*facts["size"], facts["area"]),
        f"edges {lengths['shortest']:.3g} to {lengths['longest']:.3g}, median {lengths['median']:.3g}",
        f"automatic spacing {facts['automatic_spacing']:.4g} ({EDGES_PER_PERIOD} edges or more to a stripe); "
        f"finest that the edges carry {facts['finest_spacing']:.4g}",
    ]
