"""What a real camera does to the light that falls on it: named, seeded, physical parameters."""

from datasets.sensor.codec import Chroma, ChromaLoss, JpegLoss, Upsampling
from datasets.sensor.encoding import Encoding, linear_light
from datasets.sensor.exposure import Change, Exposure, Flicker, WhiteBalance
from datasets.sensor.model import SensorModel
from datasets.sensor.mosaic import Bayer, Mosaic
from datasets.sensor.noise import HotPixels, ReadNoise, ShotNoise
from datasets.sensor.optics import Vignetting
from datasets.sensor.shutter import Shutter
from datasets.sensor.stage import Image, Stage, frame_number

__all__ = [
    "Bayer",
    "Change",
    "Chroma",
    "ChromaLoss",
    "Encoding",
    "Exposure",
    "Flicker",
    "HotPixels",
    "Image",
    "JpegLoss",
    "Mosaic",
    "ReadNoise",
    "SensorModel",
    "ShotNoise",
    "Shutter",
    "Stage",
    "Upsampling",
    "Vignetting",
    "WhiteBalance",
    "frame_number",
    "linear_light",
]
