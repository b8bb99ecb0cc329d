# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's figures: what is kept, the tables of the pages, axes, and the solids that are made for them."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from synch_fields.bench.solid_shapes import ring, wedge
from synch_fields.bench.tables import Column
from synch_fields.core.interpolate_solid import face_numbers
from synch_fields.docs.make import diagrams, dislocations, paper

COLUMNS = (Column("energy", "energy", ".1f"), Column("found", "found", "d"))
PAGE = "# Figure 4\n\n<!-- table small -->\nold | lines\n<!-- end -->\n\ntext\n\n<!-- table other -->\n<!-- end -->\n"


def test_a_table_is_written_between_its_marks():
    text = paper.filled(PAGE, "small", ["| a |", r"| \1 |"])
    assert "old" not in text and "<!-- table small -->\n| a |\n| \\1 |\n<!-- end -->\n\ntext" in text
    assert text.endswith("<!-- table other -->\n<!-- end -->\n")
    with pytest.raises(SystemExit, match="no place for the table 'large'"):
        paper.filled(PAGE, "large", [])


def test_a_figure_is_made_once_and_its_page_written_every_time(tmp_path, monkeypatch):
    made = []

    def make(place):
        made.append(place.picture)
        place.picture.write_bytes(b"")
        rows = [{"label": f"row {k}", "energy": k / 2, "found": np.int64(k).item(), "long": [1]} for k in range(2)]
        return {"small": rows, "other": rows[:1]}

    tables = {"small": (COLUMNS, "thing"), "other": (COLUMNS[:1], "")}
    monkeypatch.setitem(paper.FIGURES, 4, paper.Figure(make, tables))
    page = tmp_path / "figure4.md"
    page.write_text(PAGE)
    options = SimpleNamespace(folder=tmp_path, kept=tmp_path / "kept", meshes=tmp_path, again=False)
    paper.write_page(4, options)
    first = page.read_text()
    assert "| thing | energy | found |\n|---|---|---|\n| row 0 | 0.0 | 0 |\n| row 1 | 0.5 | 1 |\n<!-- end -->" in first
    page.write_text(PAGE)
    paper.write_page(4, options)
    assert page.read_text() == first and made == [tmp_path / "figure4.png"]
    rows = [json.loads(line) for line in (tmp_path / "kept" / "figure4.jsonl").read_text().splitlines()]
    assert rows[0] == {"table": "small", "label": "row 0", "energy": 0.0, "found": 0}
    (tmp_path / "figure4.png").unlink()
    paper.write_page(4, options)
    paper.write_page(4, SimpleNamespace(**{**vars(options), "again": True}))
    assert len(made) == 3 and len((tmp_path / "kept" / "figure4.jsonl").read_text().splitlines()) == 3


@pytest.mark.parametrize("number", paper.FIGURES)
def test_a_page_has_its_picture_and_filled_tables(number):
    folder = paper.Path(paper.synch_fields.__file__).parent / "docs" / "paper"
    text = (folder / f"figure{number}.md").read_text(encoding="utf-8")
    assert f"(figure{number}.png)" in text and (folder / f"figure{number}.png").exists()
    for name in paper.FIGURES[number].tables:
        table = text.split(f"<!-- table {name} -->")[1].split("<!-- end -->")[0]
        assert table.count("\n|") > 2, name
    assert f"(figure{number}.md)" in (folder / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("bounds", [(-13.2, -3.7), (-1.9, 0.4), (0.1, 0.45), (2.0, 3.9)])
def test_axes_have_a_few_round_ticks(bounds):
    found = np.array(diagrams.ticks(*bounds))
    assert 1 <= len(found) <= 9 and (found >= bounds[0]).all() and (found <= bounds[1]).all()
    read = [float(diagrams.label(power)) for power in found]
    np.testing.assert_allclose(read, 10.0**found, rtol=1e-6)


def test_the_wedge_has_the_volume_of_its_mean_thickness_and_the_ring_that_of_a_finer_one():
    shape = wedge(6, 4, 3)
    assert shape.mesh.volumes.sum() == pytest.approx(2.5) and shape.mesh.volumes.min() > 0
    heights = np.ptp(shape.mesh.vertices[:, 2].reshape(-1, 4), axis=1)
    assert heights.min() == pytest.approx(0.6) and heights.max() == pytest.approx(1.4)
    assert shape.low.sum() == shape.high.sum() == 7 * 5
    coarse, fine = (ring(n, 6, 6).mesh.volumes.sum() for n in (48, 96))
    assert coarse == pytest.approx(fine, rel=5e-3)


def test_one_tetrahedron_is_punctured_in_two_faces_in_opposite_senses():
    numbers = face_numbers(dislocations.tetrahedron().edge_phases)
    assert np.abs(numbers).tolist().count(1) == 2 and np.abs(numbers).sum() == 2
