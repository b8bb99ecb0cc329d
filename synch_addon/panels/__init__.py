# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn in the window: sidebar, menus and overlay."""
