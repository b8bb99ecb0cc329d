# SPDX-License-Identifier: GPL-3.0-or-later
"""What the graphics card draws by shaders of our own: patterns, from phases at the corners of triangles, in the colours
of their materials, and dots."""

import math

import gpu
from gpu_extras.batch import batch_for_shader

from ..nodes.stripes import INK_BLUE, WARM_IVORY

_VERTEX = """
void main()
{
  vec4 place = view * vec4(pos, 1.0);
  at = place.xyz;
  phases = phase;
  gl_Position = projection * place;
}
"""
# Edges are soft over one pixel; what is finer than pixels is even.
_FRAGMENT = """
float soft(float inside)
{
  return smoothstep(-0.5, 0.5, inside / max(fwidth(inside), 1e-4));
}

void main()
{
#ifdef QUADS
  vec2 away = abs(sin(phases));
  float line = soft(edge - min(away.x, away.y));
  float finest = 0.5;
#else
  float line = soft(cos(phases.x) - edge);
  float finest = 1.0;
#endif
  vec2 change = fwidth(phases) / (3.14159 * finest);
  line = mix(line, share, clamp(max(change.x, change.y) - 0.5, 0.0, 1.0));
#ifdef COVERS
  vec3 normal = normalize(cross(dFdx(at), dFdy(at)));
  color = vec4(mix(paper, ink, line) * (0.35 + 0.65 * abs(normal.z)), 1.0);
#else
  color = vec4(ink, 0.9 * line);
#endif
}
"""


# Dots are drawn nearer by their radius, so that a slope does not cut them.
_DOT_VERTEX = """
void main()
{
  vec4 place = view * vec4(pos, 1.0);
  vec4 seen = projection * place;
  place.z += size * seen.w / (projection[1][1] * height);
  seen.z = (projection * place).z * seen.w / (projection * place).w;
  gl_Position = seen;
  gl_PointSize = size;
}
"""
_DOT_FRAGMENT = """
void main()
{
  float inside = (0.5 - length(gl_PointCoord - vec2(0.5))) * size;
  float rim = smoothstep(1.0, 2.0, inside);
  color = vec4(mix(vec3(0.0), ink.rgb, rim), ink.a * smoothstep(-0.5, 0.5, inside));
}
"""


class _Shaders:
    """The shaders, each made when it is first used."""

    def __init__(self):
        self._made = {}

    def of(self, of_quads, covers):
        """The shader of a :class:`DrawnPattern`."""
        key = of_quads, covers
        if key not in self._made:
            self._made[key] = _shader(of_quads, covers)
        return self._made[key]

    @property
    def dots(self):
        """The shader of dots."""
        if "dots" not in self._made:
            self._made["dots"] = _dot_shader()
        return self._made["dots"]

    def forget(self):
        """Give all back to the graphics card."""
        self._made.clear()


shaders = _Shaders()


class DrawnPattern:
    """Triangles of a pattern on the graphics card.

    Parameters
    ----------
    places : (3 t, 3) float32 corners of the triangles
    phases : (3 t, 2) float32 radians there
    of_quads : whether there are two phases
    """

    def __init__(self, places, phases, *, of_quads):
        self._of_quads = of_quads
        self._batch = batch_for_shader(shaders.of(of_quads, True), "TRIS", {"pos": places, "phase": phases})

    def draw(self, view, projection, ink=INK_BLUE, paper=WARM_IVORY, share=0.5):
        """Draw into the active framebuffer, hidden by what is nearer.

        Parameters
        ----------
        view, projection : matrices from the object's space to that of the view, and from there to the screen
        ink : (4,) colour of stripes or lines
        paper : (4,) colour between them, None to leave what is below there
        share : of the area that these fill
        """
        shader = shaders.of(self._of_quads, paper is not None)
        gpu.state.blend_set("ALPHA")
        gpu.state.depth_test_set("LESS_EQUAL")
        shader.uniform_float("view", view)
        shader.uniform_float("projection", projection)
        shader.uniform_float("ink", ink[:3])
        if paper is not None:
            shader.uniform_float("paper", paper[:3])
        shader.uniform_float("share", share)
        shader.uniform_float("edge", edge(share, self._of_quads))
        self._batch.draw(shader)
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def edge(share, of_quads):
    """The height at the edge of stripes, or of grid lines, that fill a share of the area.

    A stripe is where the cosine of the phase is above it; a line is where the sine of one of both phases is below it.
    """
    if of_quads:
        return math.sin(math.pi * (1 - math.sqrt(1 - share)) / 2)
    return math.cos(math.pi * share)


def _shader(of_quads, covers):
    between = gpu.types.GPUStageInterfaceInfo("synch_pattern")
    between.smooth("VEC3", "at")
    between.smooth("VEC2", "phases")
    info = gpu.types.GPUShaderCreateInfo()
    for name, chosen in (("QUADS", of_quads), ("COVERS", covers)):
        if chosen:
            info.define(name)
    info.push_constant("MAT4", "view")
    info.push_constant("MAT4", "projection")
    info.push_constant("VEC3", "ink")
    if covers:
        info.push_constant("VEC3", "paper")
    info.push_constant("FLOAT", "share")
    info.push_constant("FLOAT", "edge")
    info.vertex_in(0, "VEC3", "pos")
    info.vertex_in(1, "VEC2", "phase")
    info.vertex_out(between)
    info.fragment_out(0, "VEC4", "color")
    info.vertex_source(_VERTEX)
    info.fragment_source(_FRAGMENT)
    return gpu.shader.create_from_info(info)


def draw_dots(batch, ink, size, view, projection):
    """Draw the points of a batch as round dots of so many pixels into the active framebuffer; matrices as of
    :class:`DrawnPattern`, ``ink`` with its alpha."""
    gpu.state.program_point_size_set(True)
    shader = shaders.dots
    shader.uniform_float("view", view)
    shader.uniform_float("projection", projection)
    shader.uniform_float("ink", ink)
    shader.uniform_float("size", size)
    shader.uniform_float("height", gpu.state.viewport_get()[3])
    batch.draw(shader)
    gpu.state.program_point_size_set(False)


def _dot_shader():
    info = gpu.types.GPUShaderCreateInfo()
    for name in ("view", "projection"):
        info.push_constant("MAT4", name)
    info.push_constant("VEC4", "ink")
    for name in ("size", "height"):
        info.push_constant("FLOAT", name)
    info.vertex_in(0, "VEC3", "pos")
    info.fragment_out(0, "VEC4", "color")
    info.vertex_source(_DOT_VERTEX)
    info.fragment_source(_DOT_FRAGMENT)
    return gpu.shader.create_from_info(info)
