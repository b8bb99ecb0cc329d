# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes of a quad mesh's faces: all of them quads, fewer irregular vertices, straighter corners."""
