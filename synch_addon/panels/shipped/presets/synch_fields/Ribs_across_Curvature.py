# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

synch = bpy.context.active_object.synch

synch.guidance = "CURVATURE_MAX"
synch.symmetry = "LINE"
synch.angle = 0.0
synch.boundary = "FREE"
