#!/usr/bin/env python3
"""Writes ../data/exr/*.exr with OpenImageIO and the OpenEXR project's own library, and exr_values.csv: what the other of
the two reads from each (luminance and chroma: the closed form). Needs numpy, OpenImageIO 3 and OpenEXR 3.3 or later:

    python exr_files.py
"""
import csv
import os

import Imath
import numpy as np
import OpenEXR
import OpenImageIO as oiio

here = os.path.dirname(os.path.abspath(__file__))
folder = os.path.join(here, "..", "data", "exr")
W, H = 17, 40
y, x = np.mgrid[0:H, 0:W].astype(np.float64)
# Smooth, with negatives, a sun and darkness.
red = 0.5 + 0.4 * np.sin(x / 3) * np.cos(y / 5)
green = 0.005 * (x + 1) * (y + 1) - 0.3
blue = np.exp((x - y / 2) / 3)
rgb = np.stack([red, green, blue], axis=-1).astype(np.float32)
rgb[3, 4] = [60000, 6.1e-5, -2]
smooth = rgb.copy()
smooth[3, 4] = smooth[3, 5]
rows = []


def oiio_write(name, pixels, kind, names, **attributes):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    spec.channelnames = names
    tile = attributes.pop("tile", None)
    if tile:
        spec.tile_width, spec.tile_height = tile
    for key, value in attributes.items():
        if key == "chromaticities":
            spec.attribute(key, oiio.TypeDesc("float[8]"), tuple(value))
        elif key == "adoptedNeutral":
            spec.attribute(key, oiio.TypeDesc("float[2]"), tuple(value))
        elif key == "window":
            spec.x, spec.y, spec.full_x, spec.full_y, spec.full_width, spec.full_height = value
        else:
            spec.attribute(key, value)
    path = os.path.join(folder, name + ".exr")
    out = oiio.ImageOutput.create(path)
    assert out.open(path, spec), out.geterror()
    assert out.write_image(pixels), out.geterror()
    out.close()
    return path


def openexr_write(name, channels, **header):
    path = os.path.join(folder, name + ".exr")
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, channels).write(path)
    return path


def record(name, pixels):
    for j in range(H):
        for i in range(W):
            if (i + 3 * j) % 31 == 4 or (i, j) == (4, 3):
                rows.append([name, i, j] + [repr(float(np.float32(v))) for v in pixels[j, i]])


def read_by_openexr(path, names):
    part = OpenEXR.File(path, separate_channels=True).parts[0]
    return np.stack([part.channels[n].pixels.astype(np.float64) for n in names], axis=-1)


def read_by_oiio(path, names):
    image = oiio.ImageInput.open(path)
    pixels = image.read_image("float")
    return np.stack([pixels[:, :, image.spec().channelnames.index(n)] for n in names], axis=-1)


RGB = ["R", "G", "B"]
for name, kind, options in [
    ("half_zip", "half", dict(compression="zip", whiteLuminance=100.0)),
    ("float_piz", "float", dict(compression="piz", chromaticities=[0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329])),
    ("tiled", "half", dict(compression="piz", tile=(16, 16))),
    ("window", "float", dict(compression="none", window=(-3, 5, 0, 0, 20, 20))),
]:
    record(name, read_by_openexr(oiio_write(name, rgb, kind, RGB, **options), RGB))
path = os.path.join(folder, "sizes.exr")
texture = oiio.ImageSpec()
texture.attribute("maketx:fileformatname", "openexr")
texture.tile_width, texture.tile_height = 16, 16
image = oiio.ImageBuf(rgb)
image.specmod().attribute("DateTime", "2021:01:01 00:00:00")
assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, image, path, texture)
record("sizes", read_by_openexr(path, RGB))
record("xyz", read_by_openexr(oiio_write("xyz", rgb, "float", ["X", "Y", "Z"], compression="zips"), ["X", "Y", "Z"]))
ramp = [1, 0, 0, 1, 0, 0, 1 / 3, 1 / 3]
path = oiio_write("xyz_in_rgb", rgb, "half", RGB, compression="rle", chromaticities=ramp, adoptedNeutral=[0.4476, 0.4074])
record("xyz_in_rgb", read_by_openexr(path, RGB))
rgba = np.concatenate([rgb, np.ones((H, W, 1), np.float32)], axis=-1)
record("alpha", read_by_openexr(oiio_write("alpha", rgba, "half", RGB + ["A"], compression="zip"), RGB))

half = [np.ascontiguousarray(smooth[..., k]).astype(np.float16) for k in range(3)]
single = [np.ascontiguousarray(rgb[..., k]) for k in range(3)]
for name, code, planes in [
    ("pxr24", OpenEXR.PXR24_COMPRESSION, single),
    ("b44", OpenEXR.B44_COMPRESSION, half),
    ("b44a", OpenEXR.B44A_COMPRESSION, half),
    ("dwaa", OpenEXR.DWAA_COMPRESSION, half),
    ("dwab", OpenEXR.DWAB_COMPRESSION, half),
]:
    path = openexr_write(name, dict(zip(RGB, planes)), compression=code)
    record(name, read_by_oiio(path, RGB))
path = openexr_write("decreasing", dict(zip(RGB, single)), compression=OpenEXR.ZIPS_COMPRESSION, lineOrder=OpenEXR.DECREASING_Y)
record("decreasing", read_by_oiio(path, RGB))
counts = [(np.abs(p) * 10).astype(np.uint32) for p in single]
openexr_write("whole", dict(zip(RGB, counts)), compression=OpenEXR.ZIP_COMPRESSION)
record("whole", np.stack(counts, axis=-1))  # OpenImageIO takes whole numbers for fractions of the largest

# Two parts.
path = os.path.join(folder, "parts.exr")
header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
parts = [
    OpenEXR.Part({**header, "name": "first"}, dict(zip(RGB, single))),
    OpenEXR.Part({**header, "name": "second"}, {"Z": single[0]}),
]
OpenEXR.File(parts).write(path)
record("parts", read_by_oiio(path, RGB))

# A spectral picture of another program: points out of the order of their names.
nm = [400.0, 550.0, 1000.0]
spectral = {f"S0.{n:f}nm".replace(".", ",").replace("S0,", "S0."): single[k] for k, n in enumerate(nm)}
path = openexr_write("spectral", spectral, compression=OpenEXR.ZIP_COMPRESSION, spectralLayoutVersion="1.0", emissiveUnits="W.m^-2.sr^-1")
record("spectral", read_by_oiio(path, list(spectral)))

# Luminance and chroma. Y as it is; chroma full, then by twos, linear in x and y so that what lies between is known.
w = np.array([0.2126390, 0.7151687, 0.0721923])
EW = 18
yy, xx = np.mgrid[0:H, 0:EW].astype(np.float64)
luminance = (1 + xx + 20 * yy).astype(np.float32)
RY, BY = (0.02 * xx - 0.01 * yy).astype(np.float32), (0.5 - 0.03 * xx + 0.02 * yy).astype(np.float32)


def to_rgb(Y, ry, by):
    R, B = (ry + 1) * Y, (by + 1) * Y
    return np.stack([R, (Y - R * w[0] - B * w[2]) / w[1], B], axis=-1)


# The last column and row have no sample beyond them.
held = lambda a: np.where(xx == EW - 1, np.roll(a, 1, 1), a)
held_rows = lambda a: np.where(yy == H - 1, np.roll(a, 1, 0), a)
for name, every, code in [
    ("chroma", 1, Imath.Compression.ZIP_COMPRESSION),
    ("chroma_zip", 2, Imath.Compression.ZIP_COMPRESSION),
    ("chroma_piz", 2, Imath.Compression.PIZ_COMPRESSION),
    ("chroma_pxr24", 2, Imath.Compression.PXR24_COMPRESSION),
    ("chroma_none", 2, Imath.Compression.NO_COMPRESSION),
]:
    kinds = {"Y": (Imath.PixelType.FLOAT, 1, luminance)}
    for key, plane in [("RY", RY), ("BY", BY)]:
        kinds[key] = (Imath.PixelType.HALF, every, plane[::every, ::every].astype(np.float16))
    header = OpenEXR.Header(EW, H)
    header["compression"] = Imath.Compression(code)
    header["channels"] = {k: Imath.Channel(Imath.PixelType(t), n, n) for k, (t, n, _) in kinds.items()}
    out = OpenEXR.OutputFile(os.path.join(folder, name + ".exr"), header)
    # Two rows at a time, since the module takes rows of samples to lie as far apart as rows of Y.
    for j in range(0, H, 2):
        band = {k: p[j // n : (j + 2) // n] for k, (_, n, p) in kinds.items()}
        out.writePixels({k: np.ascontiguousarray(p).tobytes() for k, p in band.items()}, 2)
    out.close()
    ry, by = (RY, BY) if every == 1 else (held_rows(held(RY)), held_rows(held(BY)))
    record(name, to_rgb(luminance.astype(np.float64), ry.astype(np.float64), by.astype(np.float64)))

with open(os.path.join(here, "exr_values.csv"), "w") as out:
    out.write("# Made by exr_files.py: file, column, row, three components as another program reads them\n")
    csv.writer(out, lineterminator="\n").writerows(rows)
