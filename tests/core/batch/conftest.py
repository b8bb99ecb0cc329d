# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later

import pytest

from synch_fields.core.batch.records import Records


@pytest.fixture
def records(tmp_path, monkeypatch):
    """The records of a batch in the test's folder, which is the current one."""
    monkeypatch.chdir(tmp_path)
    records = Records("batch")
    records.make_folders()
    return records
