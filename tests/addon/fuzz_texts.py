# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random texts and values that programs often stumble over."""

from .fuzz_cases import mostly, st

# Null characters, halves of characters, ends of lines, formulas, tags, marks of right-to-left text, paths, formats.
_PARTS = [
    "\0",
    "\ud800",
    "\udcff",
    "\n",
    "\r",
    "\u2028",
    "\t",
    "\x1b[2J",
    "=1+1",
    "+1",
    "-1",
    "@a",
    "<script>",
    "&amp;",
]
_PARTS += [
    "\u202e",
    "\u200f",
    "\ufeff",
    "é",
    "e\u0301",
    "😀",
    "..",
    "/",
    "\\",
    "//",
    "~",
    "%s",
    "{stem}",
    "{x!r}",
    "$(a)",
]
_PARTS += ["#", "####", ",", ":", "=", '"', "'", "*", "?", "[", " ", "", "CON", "nul.", "a", "0", "None"]
hostile_texts = mostly(
    st.lists(st.sampled_from(_PARTS), min_size=1, max_size=4).map("".join),
    st.text(max_size=20) | st.builds(lambda part: part * 10_000, st.sampled_from(["x", "é", "\n", "[", "9"])),
)
# Numbers of 5,000 digits and those that no double holds are among them.
numbers = st.integers() | st.floats() | st.sampled_from([0, 1, -1, 10**20, 10**400, int("9" * 4000), 1e300, 5e-324])


def json_values(keys):
    """Values that JSON can hold, whose tables have some of these keys."""
    names = mostly(st.sampled_from(keys), hostile_texts)
    leaves = st.none() | st.booleans() | numbers | hostile_texts
    return st.recursive(
        leaves, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(names, inner, max_size=5), max_leaves=8
    )
