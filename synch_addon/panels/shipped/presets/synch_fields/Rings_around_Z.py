# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

synch = bpy.context.active_object.synch

synch.guidance = "AXIS"
synch.guide.axis = "Z"
synch.symmetry = "LINE"
synch.angle = 1.5707963267948966
synch.boundary = "FREE"
