# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A batch on a Dask cluster: the same as on one machine, and nothing is lost or repeated with its workers."""

import os
import signal
import sys

import pytest

from synch_fields.core.batch.cluster import Cluster
from synch_fields.core.batch.run import run_rows
from synch_fields.core.batch.table import entries
from synch_fields.core.errors import SettingError

from .children import ARGUMENTS, begun, rows, told

distributed = pytest.importorskip("distributed", reason="Dask is not installed")


@pytest.fixture(scope="module")
def dask():
    """A cluster of two worker processes."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster


def run(wanted, records, dask, retries=1, progress=told):
    pool = Cluster(dask.scheduler_address, ARGUMENTS, 1)
    try:
        return run_rows(wanted, records, pool, retries, {}, progress)
    finally:
        pool.end()


def test_all_rows_are_done_once_and_poisoned_ones_are_listed(records, tmp_path, dask):
    wanted = rows("write", "die", "write", "refuse", *["write"] * 6)
    assert run(wanted, records, dask) == (0, 8)
    assert [begun(tmp_path).count(row.key) for row in wanted] == [1, 2, 1, 2, *[1] * 6]
    found = list(entries(wanted, records))
    assert "signal 9" in found[1]["reason"] and found[3]["reason"] == "this row is refused"
    assert run(wanted, records, dask) == (8, 0)
    assert len(begun(tmp_path)) == 12


def test_a_worker_that_is_killed_loses_nothing_and_repeats_only_the_row_that_it_had(records, tmp_path, dask):
    wanted = rows(*["write"] * 5, "hang once", *["write"] * 6)
    killed = []

    def kill(*_):
        if not killed and (tmp_path / "5.txt").exists():
            child = next(
                int(line.split()[1])
                for line in (tmp_path / "begun.txt").read_text().splitlines()
                if line.startswith(wanted[5].key)
            )
            with open(f"/proc/{child}/stat") as file:
                killed.append(int(file.read().rpartition(")")[2].split()[1]))
            os.kill(killed[0], signal.SIGKILL)

    assert run(wanted, records, dask, retries=0, progress=kill) == (0, 12)
    assert len(killed) == 1
    assert [begun(tmp_path).count(row.key) for row in wanted] == [*[1] * 5, 2, *[1] * 6]


def test_no_scheduler_and_no_dask_are_one_line(monkeypatch):
    with pytest.raises(SettingError, match="no Dask scheduler answers at nowhere"):
        Cluster("nowhere", ARGUMENTS, 1)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SettingError, match=r"pip install distributed"):
        Cluster("nowhere", ARGUMENTS, 1)
