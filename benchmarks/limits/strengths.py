"""Which effects are measured, and how strong: overrides of the scenario `paper`."""

from dataclasses import dataclass

Step = tuple[str, tuple[str, ...]]  # strength with its unit, overrides


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect at several strengths.

    Attributes:
        name: of the effect.
        steps: weakest first.
    """

    name: str
    steps: tuple[Step, ...]


def _one(name: str, key: str, unit: str, values: tuple[object, ...], *more: str) -> Effect:
    """An effect whose strength is the value of one key."""
    return Effect(name, tuple((f"{v}{unit}", (f"{key}={_toml(v)}", *more)) for v in values))


def _each(name: str, template: str, unit: str, values: tuple[object, ...], *more: str) -> Effect:
    """An effect whose strength stands for @ in an override."""
    return Effect(
        name, tuple((f"{v}{unit}", (template.replace("@", str(v)), *more)) for v in values)
    )


def _toml(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


_PEOPLE = (
    "points=[{at_s=1.0,x_m=0.6,y_m=-0.9},{at_s=3.5,x_m=1.3,y_m=0.3},{at_s=6.0,x_m=0.6,y_m=0.9}]"
)
_HAND = (
    'surroundings.things=[{shape="hand",color="red",height_m=0.3,from_s=1.0,until_s=@,'
    "points=[{at_s=0.0,x_m=0.78,y_m=0.02,theta_deg=115.0}]}]"
)
_CABLE = (
    'surroundings.things=[{shape="cable",color="black",height_m=0.5,size_m=@,'
    "line_m=[[-0.9,0.1],[-0.4,0.02],[0.0,0.0],[0.4,0.05],[0.9,0.2]],"
    "wander={x_m=0.6,y_m=0.3,reach_m=[0.2,0.3],speed_mps=0.15}}]"
)
_CLUTTER = 'surroundings.clutter={colors=["yellow","red","green","blue"],moving_share=0.2,count=@}'

EFFECTS = (
    Effect("none (`paper`)", (("", ()),)),
    _one("lens blur", "sensor.blur_px", " px", (1.0, 1.5, 2.0)),
    _one("read noise", "sensor.read_noise", " of 255", (6, 12, 18)),
    _one("shot noise, full well", "sensor.full_well_e", " electrons", (4000, 1000, 300)),
    _one("uneven light", "sensor.uneven_light", "", (0.5, 0.7, 0.85)),
    _one("vignetting, cos^n", "sensor.vignetting_power", "", (4, 8, 16)),
    _each("exposure step at 3 s", "sensor.exposure_changes=[{at_s=3.0,factor=@}]", " x",
          (0.7, 0.5, 0.3)),
    _each("exposure drift over 6 s", "sensor.exposure_changes=[{at_s=1.0,factor=@,over_s=6.0}]",
          " x", (0.7, 0.5, 0.3)),
    _each("overexposure step at 3 s", "sensor.exposure_changes=[{at_s=3.0,factor=@}]", " x",
          (1.2, 1.5, 2.0)),
    _each("white balance step at 3 s, red",
          "sensor.white_balance_changes=[{at_s=3.0,red=@,blue=0.8}]", " x, blue 0.8 x",
          (1.1, 1.25, 1.5)),
    _one("flicker, 100 Hz, rolling shutter 20 ms, depth", "sensor.flicker_depth", "",
         (0.2, 0.5, 0.8), "sensor.readout_s=0.02", "sensor.exposure_s=0.004"),
    _one("gamma", "sensor.gamma", "", (1.4, 1.8, 2.2), "sensor.read_noise=0.8"),
    _one("Bayer mosaic, read noise", "sensor.read_noise", " of 255", (1, 3, 6),
         'sensor.bayer="RGGB"'),
    Effect("chroma", (
        ("4:2:2", ('sensor.chroma="422"',)),
        ("4:2:0, nearest", ('sensor.chroma_upsampling="nearest"',)),
        ("4:2:0, 1 px off, as calibrated", ("sensor.chroma_offset_px=[1.0,0.0]",)),
    )),
    _one("JPEG quality", "sensor.jpeg_quality", "", (85, 60, 35)),
    _one("hot pixels", "sensor.hot_pixel_share", " of all", (0.001, 0.003, 0.01)),
    _one("motion blur, exposure", "sensor.exposure_s", " s", (0.01, 0.02, 0.033)),
    _one("rolling shutter, readout", "sensor.readout_s", " s", (0.01, 0.02, 0.033)),
    _each("lens distortion, k1", "camera.distortion=[@,0.02,0.0,0.0,0.0]", "",
          (-0.05, -0.12, -0.2)),
    _one("tag height", "camera.tag_height_m", " m", (0.0, 0.15, 0.2)),
    _each("moving shadow, darkness", "surroundings.shadows=[{radius_m=0.35,softness_m=0.15,"
          f"darkness=@,{_PEOPLE}}}]", "", (0.3, 0.5, 0.7)),
    _each("glare on the way, strength", "surroundings.glares=[{x_m=0.75,y_m=0.0,width_m=0.04,"
          "strength=@}]", " of 255", (60, 150, 400)),
    _each("hand over the way, from 1 s to", _HAND, " s", (1.9, 2.2, 2.6)),
    _each("wandering cable, thickness", _CABLE, " m", (0.004, 0.012, 0.03)),
    _each("clutter in the tags' colours", _CLUTTER, " things", (20, 60, 150)),
    _one("lost frames", "camera.dropped_share", " of all", (0.1, 0.25, 0.5)),
    _one("repeated frames", "camera.repeated_share", " of all", (0.02, 0.05, 0.1)),
    _one("stamp jitter", "camera.stamp_jitter_s", " s", (0.002, 0.005, 0.01)),
)  # fmt: skip
