# SPDX-License-Identifier: GPL-3.0-or-later
"""How patterns look: presets, samples, the demo and rendered pictures."""
