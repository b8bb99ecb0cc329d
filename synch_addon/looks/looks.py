# SPDX-License-Identifier: GPL-3.0-or-later
"""What the presets look like: each function draws a material around the node group of its pattern.

Lengths are in spacings, so that a look is the same on objects of any size. Irregularities come from noise in the
object's space, which goes with it.
"""

from ..nodes.quads import PROFILES as QUAD_PROFILES
from ..nodes.stripe_profiles import PROFILES as STRIPE_PROFILES

# Where the light of a drawing comes from, in the world: from above, the left and the front.
_DRAWN_LIGHT = (-0.55, -0.5, 0.67)


class _Texture:
    """Noise around an object."""

    def __init__(self, canvas):
        self.canvas = canvas
        (spacing,) = canvas.attribute("synch_spacing", "Fac")
        spacing.socket.node.attribute_type = "OBJECT"
        places = canvas.value("ShaderNodeTexCoord", "Object", "Place")
        values = {0: places, "Scale": canvas.math("DIVIDE", 1.0, spacing)}
        self._places = canvas.value("ShaderNodeVectorMath", "Vector", "in spacings", values, operation="SCALE")

    def noise(self, scale, detail=2.0, distortion=0.0):
        """Noise with a mean of 0, mostly between -1 and 1, that changes `scale` times in a spacing."""
        inputs = {"Vector": self._places, "Scale": scale, "Detail": detail, "Distortion": distortion}
        value = self.canvas.value("ShaderNodeTexNoise", 0, f"noise {scale:g}", inputs, noise_dimensions="3D")
        return (value - 0.5) * 3.0


def _pattern(canvas, group, color, background, width, mean=None, **inputs):
    """The node group of the pattern; its outputs by name, and the colours of lines and between them, which the panel
    changes. ``mean`` is that of a width which varies over the surface."""
    ink, paper = canvas.color("Color", (*color, 1)), canvas.color("Background", (*background, 1))
    pattern = canvas.group(group, 1, {"Color": ink, "Background": paper, "Width": width, **inputs})
    pattern["Factor"].socket.node.inputs["Width"].default_value = width if mean is None else mean
    return pattern, ink, paper


def _varied(canvas, share, color, ratio):
    """A colour; as the share goes from 0 to 1, its red, green and blue are multiplied by the ratios."""
    return canvas.color_mix(share, color, canvas.tinted(color, (*ratio, 1)))


def zebra(canvas, group):
    """Black and white hair, stripes of uneven width with frayed edges."""
    texture = _Texture(canvas)
    fur = texture.noise(9.0, 4.0)
    width = (0.53 + texture.noise(0.35) * 0.17 + fur * 0.035).clamped()
    inputs = {"Profile": STRIPE_PROFILES.index("sine"), "Softness": 0.07}
    pattern, ink, paper = _pattern(canvas, group, (0.010, 0.009, 0.009), (0.86, 0.82, 0.74), width, 0.53, **inputs)
    shade = (0.5 + texture.noise(0.22) * 0.5 + fur * 0.16).clamped()
    light = _varied(canvas, shade, paper, (0.77, 0.67, 0.55))
    dark = _varied(canvas, shade, ink, (3.0, 2.2, 1.6))
    return {
        "Base Color": canvas.color_mix(pattern["Factor"], light, dark),
        "Roughness": 0.62,
        "Sheen Weight": 0.25,
        "Height": fur,
        "Relief": 0.012,
    }


def corduroy(canvas, group):
    """Ribs of velvet, lighter on top."""
    texture = _Texture(canvas)
    pile = texture.noise(7.0, 3.0)
    inputs = {"Profile": STRIPE_PROFILES.index("rounded"), "Softness": 0.3}
    pattern, velvet, valley = _pattern(canvas, group, (0.33, 0.118, 0.045), (0.075, 0.022, 0.010), 0.96, **inputs)
    top = (pattern["Height"] * pattern["Height"]).named("top")
    worn = top * 0.85 + pile * 0.13 + texture.noise(0.3) * 0.09 + (pattern["Random"] - 0.5) * 0.14
    return {
        "Base Color": canvas.color_mix(worn.clamped(), valley, velvet),
        "Roughness": 0.85,
        "Specular IOR Level": 0.2,
        "Sheen Weight": 0.9,
        "Sheen Roughness": 0.35,
        "Sheen Tint": (1.0, 0.72, 0.48, 1),
        "Height": pattern["Height"] + pile * 0.10,
        "Relief": 0.26,
    }


def wood_cut(canvas, group):
    """Ink on paper: lines that swell in the shade and end in the light."""
    texture = _Texture(canvas)
    inputs = {0: canvas.value("ShaderNodeNewGeometry", "Normal", "Surface"), 1: _DRAWN_LIGHT}
    light = canvas.value("ShaderNodeVectorMath", "Value", "light", inputs, operation="DOT_PRODUCT")
    shade = (0.62 - light * 0.62 + texture.noise(0.9) * 0.05 + texture.noise(5.0) * 0.035).named("shade")
    width = shade.maximum(0.0).minimum(0.9)
    inputs = {"Profile": STRIPE_PROFILES.index("square"), "Softness": 0.05}
    pattern, ink, paper = _pattern(canvas, group, (0.014, 0.012, 0.016), (0.90, 0.85, 0.74), width, 0.4, **inputs)
    paper = _varied(canvas, (0.5 + texture.noise(2.5, 5.0) * 0.5).clamped(), paper, (0.89, 0.86, 0.81))
    return {
        "Base Color": canvas.color_mix(pattern["Factor"], paper, ink),
        "Roughness": 0.95,
        "Specular IOR Level": 0.1,
        "Height": pattern["Factor"],
        "Relief": 0.01,
    }


def knit(canvas, group):
    """Columns of stitches: each two loops of yarn that meet in the middle of the stripe."""
    texture = _Texture(canvas)
    inputs = {"Profile": STRIPE_PROFILES.index("rounded"), "Softness": 0.3}
    pattern, yarn, gap = _pattern(canvas, group, (0.065, 0.30, 0.33), (0.006, 0.028, 0.036), 1.0, **inputs)
    across = abs(pattern["Across"]).named("from the middle")
    leg = ((across * 3.14159).sine() * 0.96 + 0.04).root().named("leg")
    row = ((pattern["Along"] * 2.0 + across * 0.85) * 3.14159).named("row")
    loop = abs(row.sine())
    body = (leg * (loop.root() * 0.8 + 0.2)).named("yarn")
    fibre = texture.noise(11.0, 4.0)
    shade = (body * 0.95 + fibre * 0.13 + texture.noise(0.5) * 0.05).clamped()
    return {
        "Base Color": canvas.color_mix(shade, gap, yarn),
        "Roughness": 0.9,
        "Specular IOR Level": 0.15,
        "Sheen Weight": 0.5,
        "Sheen Roughness": 0.5,
        "Sheen Tint": (0.75, 0.95, 1.0, 1),
        "Height": body + fibre * 0.06,
        "Relief": 0.34,
    }


def cane(canvas, group):
    """Strips of rattan that go over and under one another."""
    texture = _Texture(canvas)
    inputs = {"Profile": QUAD_PROFILES.index("weave"), "Softness": 0.04}
    pattern, rattan, hole = _pattern(canvas, group, (0.74, 0.47, 0.20), (0.012, 0.007, 0.004), 0.62, **inputs)
    grain = texture.noise(6.0, 4.0, 1.5)
    tone = (0.5 + texture.noise(0.8) * 0.28 + grain * 0.22).clamped()
    strip = _varied(canvas, tone, rattan, (0.68, 0.53, 0.43))
    depth = (pattern["Height"] * 1.25).clamped()
    lit = canvas.color_mix(depth, canvas.tinted(rattan, (0.135, 0.085, 0.06, 1)), strip)
    return {
        "Base Color": canvas.color_mix(pattern["Factor"], hole, lit),
        "Roughness": 0.38,
        "Coat Weight": 0.25,
        "Coat Roughness": 0.25,
        "Height": pattern["Height"] + grain * 0.015,
        "Relief": 0.14,
    }


def fingerprint(canvas, group):
    """Ink of ridges that break off and swell, with pores along them, on porcelain."""
    texture = _Texture(canvas)
    blotch, grain = texture.noise(0.5), texture.noise(2.6, 3.0)
    width = (0.58 + blotch * 0.13 + grain * 0.13).clamped()
    inputs = {"Profile": STRIPE_PROFILES.index("sine"), "Softness": 0.16}
    pattern, ink, paper = _pattern(canvas, group, (0.006, 0.010, 0.052), (0.86, 0.85, 0.82), width, 0.58, **inputs)
    along = pattern["Along"].ping_pong(0.5)
    pore = (along * along + pattern["Across"] * pattern["Across"] * 0.25).root().named("to the pore")
    closed = ((pore + 0.01 - grain * 0.06) * 24.0).clamped()
    ridge = (pattern["Factor"] * (pattern["Index"] > 0.5).choose(closed, 1.0)).named("ridge")
    density = (1.02 + blotch * 0.05 + texture.noise(9.0, 2.0) * 0.09).clamped()
    return {
        "Base Color": canvas.color_mix(ridge * density, paper, ink),
        "Roughness": 0.34,
        "Coat Weight": 0.4,
        "Coat Roughness": 0.08,
        "Height": ridge,
        "Relief": 0.012,
    }
