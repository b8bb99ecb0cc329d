# SPDX-License-Identifier: GPL-3.0-or-later
"""One mesh on many processes: the relaxation on PETSc, each process with its own rows."""
